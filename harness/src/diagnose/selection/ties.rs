//! Hypotheses that the data can't tell from the one named.

use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::thresholds::FLOOR_MEDIAN;
pub use crate::diagnose::thresholds::TIE;
use crate::report::percent;

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

/// Other explanations that the summary words one by one, the most probable ones; the table of candidates has all.
const WORDED: usize = 3;

/// What is so of the candidates that are not tied with what was named: which are adequate as well and why they are not named all
/// the same; where none is, which leaves little but not noise, or how far the nearest stays from it.
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
    let others: Vec<&FittedModel> = listed.filter(is_other).collect();
    let error = |c: &FittedModel| c.fit.quantile(0.5);
    let is_small = |c: &&&FittedModel| error(c) <= FLOOR_MEDIAN;
    let (mut adequate, mut coloured): (Vec<&FittedModel>, Vec<&FittedModel>) = others
        .iter()
        .filter(is_small)
        .partition(|c| c.reaches_floor());
    adequate.sort_by(|a, b| b.log_posterior.total_cmp(&a.log_posterior));
    coloured.sort_by(|a, b| error(a).total_cmp(&error(b)));
    if !adequate.is_empty() {
        let mut sentences: Vec<String> = adequate
            .iter()
            .take(WORDED)
            .map(|c| beside(problem, best, c))
            .collect();
        if let Some(more) = adequate.len().checked_sub(WORDED).filter(|&n| n > 0) {
            sentences.push(format!("So do {more} more."));
        }
        return sentences.join(" ");
    }
    let nearest = others.iter().min_by(|a, b| error(a).total_cmp(&error(b)));
    match (coloured.first(), nearest) {
        (Some(least), _) => format!(
            "No other candidate explains the data: {} comes nearest, {:.2} times the noise on the runs fitted, but what it leaves is not white, or it bends the structure{}.",
            name(problem, &least.choices),
            error(least),
            match coloured.len() - 1 {
                0 => String::new(),
                more => format!("; so it is with {more} more"),
            }
        ),
        (None, Some(next)) => format!(
            "No other candidate reaches the noise level: the next, {}, leaves {:.2} times the noise on the runs fitted.",
            name(problem, &next.choices),
            error(next)
        ),
        (None, None) if tied.len() > 1 => String::new(),
        (None, None) => "There was no other candidate to compare.".to_owned(),
    }
}

/// An adequate candidate beside the one named.
fn beside(problem: &Problem, best: &FittedModel, other: &FittedModel) -> String {
    let kept_out = match &other.holdout {
        Some(h) if h.nrmse.is_finite() => {
            format!(", {} on runs kept out", percent(h.nrmse))
        }
        _ => String::new(),
    };
    let nats = best.log_posterior - other.log_posterior;
    let behind = match nats {
        nats if nats >= 0.5 => format!("is {nats:.0} nats less probable"),
        nats if nats > -0.5 => "is as probable".to_owned(),
        nats if nats.is_finite() => {
            format!("is {:.0} nats more probable, too little for a claim", -nats)
        }
        _ => "was not compared on all data".to_owned(),
    };
    let why = match other.size().checked_sub(best.size()).filter(|&n| n > 0) {
        Some(more) => format!("it needs {more} free values more and {behind}"),
        None => format!("it {behind}"),
    };
    format!(
        "{} reaches the noise level as well ({:.2} times on the runs fitted{kept_out}), but {why}.",
        name(problem, &other.choices),
        other.fit.quantile(0.5)
    )
}
