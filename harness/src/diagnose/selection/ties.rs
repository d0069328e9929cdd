//! Hypotheses that the data can't tell from the one named.

use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::select::Selection;
use crate::diagnose::thresholds::FLOOR_MEDIAN;
pub use crate::diagnose::thresholds::TIE;

/// The others with as many effects as the hypothesis at the end of the path that explain the data as well.
fn alike(selection: &Selection) -> impl Iterator<Item = &FittedModel> {
    let best = selection.path.last();
    let others = match best {
        Some(best) if best.choices.len() > 1 => &selection.pairs,
        _ => &selection.singles,
    };
    let limit = best.map_or(f64::INFINITY, |b| b.log_posterior - TIE);
    others
        .iter()
        .filter(move |c| c.reaches_floor() && c.log_posterior > limit)
}

/// The hypothesis at the end of the path and those with other effects that explain the data as well.
pub fn rivals(selection: &Selection) -> Vec<&FittedModel> {
    let Some(best) = selection.path.last() else {
        return Vec::new();
    };
    // What is believed for the break-aways has no rivals among motions that nothing explains.
    let others =
        alike(selection).filter(|c| c.effects() != best.effects() && !selection.by_break_aways);
    std::iter::once(best).chain(others).collect()
}

/// The same effects in other forms that explain the data as well.
pub fn other_forms(selection: &Selection) -> Vec<&FittedModel> {
    let Some(best) = selection.path.last() else {
        return Vec::new();
    };
    alike(selection)
        .filter(|c| c.effects() == best.effects())
        .collect()
}

/// What is so of the candidates that are not tied with what was named: that some come down to the noise as well and why they
/// are not named all the same, or how far the nearest stays from it.
pub fn others(problem: &Problem, selection: &Selection) -> String {
    let Some(best) = selection.path.last() else {
        return String::new();
    };
    if selection.by_hand {
        return "No other effect was tried.".to_owned();
    }
    let (named, tied) = (best.effects(), rivals(selection));
    // What holds all that is named, and more, is no other explanation.
    let is_other = |c: &&FittedModel| {
        !named.iter().all(|e| c.effects().contains(e))
            && !tied.iter().any(|t| t.effects() == c.effects())
    };
    let listed = selection.singles.iter().chain(selection.listed_pairs());
    let mut others: Vec<&FittedModel> = listed.filter(is_other).collect();
    let error = |c: &FittedModel| c.fit.quantile(0.5);
    others.sort_by(|a, b| error(a).total_cmp(&error(b)));
    let as_well: Vec<String> = others
        .iter()
        .take_while(|c| error(c) <= FLOOR_MEDIAN)
        .map(|c| beside(problem, best, c))
        .collect();
    match (as_well.is_empty(), others.first()) {
        (false, _) => as_well.join(" "),
        (true, Some(next)) => format!(
            "No other candidate comes down to the noise: the next, {}, leaves {:.2} times the noise on the runs fitted.",
            name(problem, &next.choices),
            error(next)
        ),
        (true, None) if tied.len() > 1 => String::new(),
        (true, None) => "There was no other candidate to compare.".to_owned(),
    }
}

/// A candidate that comes down to the noise too, beside the one named.
fn beside(problem: &Problem, best: &FittedModel, other: &FittedModel) -> String {
    let kept_out = match &other.holdout {
        Some(h) if h.nrmse.is_finite() => {
            format!(", {:.2} % on runs kept out", 100.0 * h.nrmse)
        }
        _ => String::new(),
    };
    let behind = other.score() - best.score();
    let more = other.size() as isize - best.size() as isize;
    let why = match (other.reaches_floor(), more > 0) {
        (false, _) => "what it leaves is not noise, or it bends the structure".to_owned(),
        (true, true) => format!(
            "it needs {more} free values more; with their price it stands {behind:.0} behind in gain"
        ),
        (true, false) => format!("it stands {behind:.0} behind in gain"),
    };
    format!(
        "{} comes down to the noise as well ({:.2} times on the runs fitted{kept_out}), but {why}.",
        name(problem, &other.choices),
        other.fit.quantile(0.5)
    )
}
