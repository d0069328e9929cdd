//! Hypotheses that the data can't tell from the one named.

use super::contender::Contender;
use super::select::Selection;

/// Rivals whose score lies within this of the best can't be told from it.
pub const TIE: f64 = 12.0;

/// The others with as many effects as the hypothesis at the end of the path that explain the data as well.
fn alike(selection: &Selection) -> impl Iterator<Item = &Contender> {
    let best = selection.path.last();
    let others = match best {
        Some(best) if best.choices.len() > 1 => &selection.pairs,
        _ => &selection.singles,
    };
    let limit = best.map_or(f64::NEG_INFINITY, |b| b.score(selection.samples) + TIE);
    others
        .iter()
        .filter(move |c| c.score(selection.samples) < limit)
}

/// The hypothesis at the end of the path and those with other effects that explain the data as well.
pub fn rivals(selection: &Selection) -> Vec<&Contender> {
    let Some(best) = selection.path.last() else {
        return Vec::new();
    };
    // What is believed for the break-aways has no rivals among motions that nothing explains.
    let others =
        alike(selection).filter(|c| c.effects() != best.effects() && !selection.by_break_aways);
    std::iter::once(best).chain(others).collect()
}

/// The same effects in other forms that explain the data as well.
pub fn other_forms(selection: &Selection) -> Vec<&Contender> {
    let Some(best) = selection.path.last() else {
        return Vec::new();
    };
    alike(selection)
        .filter(|c| c.effects() == best.effects())
        .collect()
}
