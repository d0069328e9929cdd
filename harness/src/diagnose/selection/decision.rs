//! Which hypothesis is believed, and how sure that is.
//!
//! Posterior probability of a hypothesis H on data D: `p(H|D) ~ p(D|H) p(H)`, with the evidence p(D|H) of Laplace's
//! approximation and the prior below. Only adequate hypotheses take part: those that leave no more than noise. Where none
//! does, something else is at work.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::initial_states::NOTICED;
use crate::diagnose::estimation::nesting::widen;
use crate::diagnose::initialisation::multistart::{better_starts, continued};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::variants::{all_variants, library};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::tested::Tested;
use crate::diagnose::thresholds::{CLAIMED, CLOSE, FINALISTS, SEARCHED, SECOND};
use crate::error::Error;
use crate::parallel::parallel;

/// Logarithm of the prior of one hypothesis with so many effects, relative to that of none: one effect is as probable as none,
/// each further one [`SECOND`] times less, all choices of so many kinds alike.
pub(crate) fn log_prior(problem: &Problem, effects: usize) -> f64 {
    let kinds = (all_variants(problem).len() + library(problem).len()).max(1) as f64;
    let of_effect = |k: usize| {
        let rarer = if k > 0 { SECOND } else { 1.0 };
        let choices = (kinds - k as f64).max(1.0) / (k + 1) as f64;
        -(rarer * choices).ln()
    };
    (0..effects).map(of_effect).sum()
}

/// Logarithm of a hypothesis's posterior on the segments compared, up to a constant, nats.
pub(crate) fn log_posterior(problem: &Problem, model: &FittedModel) -> f64 {
    log_prior(problem, model.choices.len()) - model.score()
}

/// The same on all segments of the runs fitted; `None` for a model that was not fitted to them.
pub(crate) fn log_posterior_on_all(problem: &Problem, model: &FittedModel) -> Option<f64> {
    let fitted = model.full_refit.as_ref()?;
    Some(log_prior(problem, model.choices.len()) + fitted.fit.log_evidence)
}

/// Works out the posterior of every model and gives the best adequate one's place; `None` where none is adequate. The
/// best are compared on all segments of the runs fitted; what proves inadequate there falls.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn decide(
    problem: &Problem,
    models: &mut [&mut FittedModel],
) -> Result<Option<usize>, Error> {
    for c in models.iter_mut() {
        c.log_posterior = log_posterior(problem, c);
    }
    loop {
        let Some(best) = best(models, |c| c.reaches_floor()) else {
            return Ok(None);
        };
        if problem.place_is_told() {
            // Friction scatters: fits count with another noise until the search is over.
            return Ok(Some(simplest(models, best)));
        }
        let close = models[best].log_posterior - CLOSE;
        let adequate = (0..models.len()).filter(|&i| models[i].reaches_floor());
        // What was fitted to all segments already is compared on these: a third of them may tell otherwise.
        let (known, mut finalists): (Vec<usize>, Vec<usize>) = adequate
            .filter(|&i| {
                let is_close = models[i].log_posterior > close;
                i == best || is_close || models[i].full_refit.is_some()
            })
            .partition(|&i| i != best && models[i].full_refit.is_some());
        let posterior = |i: &usize| models[*i].log_posterior;
        finalists.sort_by(|a, b| posterior(b).total_cmp(&posterior(a)));
        finalists.truncate(FINALISTS);
        finalists.extend(known);
        // A part of the best may have ended in a worse minimum: what the best is worth beyond it shows from the best's own optimum.
        let parts = (0..models.len()).filter(|&i| models[i].reaches_floor());
        let parts = parts.filter(|i| !finalists.contains(i) && is_part(models[*i], models[best]));
        let parts: Vec<usize> = parts.collect();
        finalists.extend(parts);
        let judged = parallel(&finalists, |&i| {
            let mut model = (*models[i]).clone();
            full_refit::stands(problem, &mut model)?;
            Ok(model)
        })?;
        for (&i, judged) in finalists.iter().zip(judged) {
            *models[i] = judged;
        }
        finalists.retain(|&i| models[i].reaches_floor());
        if finalists.is_empty() {
            continue;
        }
        bring_together(problem, models, &finalists)?;
        finalists.retain(|&i| models[i].reaches_floor());
        if finalists.is_empty() {
            continue;
        }
        // On all segments among those; the others stay as far behind the best of them as they are on the segments compared.
        let on_all = |c: &FittedModel| {
            log_posterior_on_all(problem, c).expect("finalists are fitted to all above")
        };
        let leading = finalists
            .iter()
            .copied()
            .max_by(|&a, &b| on_all(models[a]).total_cmp(&on_all(models[b])))
            .expect("not empty");
        if has_better_part(problem, models, leading) {
            models[leading].is_refuted = true;
            continue;
        }
        let ahead = models[leading].log_posterior;
        let top = on_all(models[leading]);
        for i in 0..models.len() {
            let now = if finalists.contains(&i) {
                on_all(models[i]) - top
            } else if ahead.is_finite() {
                (models[i].log_posterior - ahead).min(0.0)
            } else {
                // The best could not be weighed before: nothing is known of the distance.
                f64::NEG_INFINITY
            };
            models[i].log_posterior = now;
        }
        return Ok(Some(simplest(models, leading)));
    }
}

/// Whether a model has some of the effects of another and no other.
fn is_part(small: &FittedModel, large: &FittedModel) -> bool {
    small.choices.len() < large.choices.len()
        && small.choices.iter().all(|c| large.choices.contains(c))
}

/// Whether a hypothesis that lacks some of a model's effects, fitted to the same data, is more probable than the model itself: what a
/// further effect then does to residuals that are not white is no evidence for it, though the smaller hypothesis is not
/// adequate either. A part that leaves more runs unmet is no better, whatever its evidence: a run that is given up costs little.
fn has_better_part(problem: &Problem, models: &[&mut FittedModel], leading: usize) -> bool {
    let whole = &models[leading];
    let posterior = |c: &FittedModel| log_posterior_on_all(problem, c);
    models
        .iter()
        .filter(|c| is_part(c, whole) && c.unmet_runs <= whole.unmet_runs)
        .any(|c| posterior(c) >= posterior(whole))
}

/// Gives each finalist what the others found, until none gains by it: a smaller hypothesis would else be beaten by itself beside an effect
/// of no strength.
fn bring_together(
    problem: &Problem,
    models: &mut [&mut FittedModel],
    finalists: &[usize],
) -> Result<(), Error> {
    let mut handed_on = vec![f64::NEG_INFINITY; models.len()];
    loop {
        let evidence = |i: usize| models[i].full_refit.as_ref().map(|f| f.fit.log_evidence);
        let mut improved = finalists.to_vec();
        improved.retain(|&i| evidence(i) > Some(handed_on[i] + NOTICED));
        if improved.is_empty() {
            return Ok(());
        }
        for &i in &improved {
            handed_on[i] = evidence(i).expect("finalists are fitted to all");
        }
        refit_from_larger(problem, models, finalists, &improved)?;
        share_starts(problem, models, finalists, &improved)?;
    }
}

/// Fits each finalist again from the optimum of those that extend it, `improved` ones alone, so that none is left in a worse minimum
/// than what is one of its own points but for an effect. What the larger one believes of values along the belt and of curves belongs to its
/// optimum, as its constants do.
fn refit_from_larger(
    problem: &Problem,
    models: &mut [&mut FittedModel],
    finalists: &[usize],
    improved: &[usize],
) -> Result<(), Error> {
    let extends = |large: usize, small: usize| is_part(models[small], models[large]);
    let jobs: Vec<(usize, usize)> = finalists
        .iter()
        .flat_map(|&small| improved.iter().map(move |&large| (small, large)))
        .filter(|&(small, large)| extends(large, small))
        .collect();
    let all = problem.fit_segments(1);
    let segments = problem.copies(&all);
    let again = parallel(&jobs, |&(small, large)| {
        let there = |mine: &Choice| models[large].choices.iter().find(|c| *c == mine).cloned();
        let believed: Vec<Choice> = models[small].choices.iter().filter_map(there).collect();
        let h = problem.hypothesis(&believed)?;
        let larger = models[large].full_refit.as_ref();
        let larger = larger.expect("finalists are fitted to all shots");
        let start = widen(larger, &h, &Point::centre(&h, &segments));
        continued(problem, h, &segments, start, full_refit::last_options())
    })?;
    for ((small, _), fitted) in jobs.into_iter().zip(again) {
        let known = models[small].full_refit.as_ref();
        if known.is_none_or(|known| full_refit::is_better(problem, &all, &fitted, known)) {
            full_refit::put(problem, models[small], &segments, fitted)?;
        }
    }
    Ok(())
}

/// Tries in each finalist the start states of the others, segment by segment, in those of `changed` those that the segment before leads to,
/// and fits it further where that helps: a segment that one fit met and another lost would else be counted as evidence.
pub(crate) fn share_starts(
    problem: &Problem,
    models: &mut [&mut FittedModel],
    finalists: &[usize],
    changed: &[usize],
) -> Result<(), Error> {
    let all = problem.fit_segments(1);
    let segments = problem.copies(&all);
    let fits: Vec<&FittedHypothesis> = finalists
        .iter()
        .map(|&i| {
            models[i]
                .full_refit
                .as_ref()
                .expect("finalists are fitted to all")
        })
        .collect();
    let places: Vec<usize> = (0..fits.len()).collect();
    let again = parallel(&places, |&mine| {
        let others = (0..fits.len()).filter(|&i| i != mine).map(|i| fits[i]);
        let others: Vec<&FittedHypothesis> = others.collect();
        let options = full_refit::last_options();
        let is_changed = changed.contains(&finalists[mine]);
        let start = better_starts(problem, &segments, fits[mine], &others, options, is_changed)?;
        let h = fits[mine].hypothesis.clone();
        start
            .map(|start| continued(problem, h, &segments, start, options))
            .transpose()
    })?;
    for (&i, again) in finalists.iter().zip(again) {
        let known = models[i].full_refit.as_ref();
        let known = known.expect("finalists are fitted to all");
        if let Some(again) = again.filter(|a| full_refit::is_better(problem, &all, a, known)) {
            full_refit::put(problem, models[i], &segments, again)?;
        }
    }
    Ok(())
}

/// The simplest adequate hypothesis that is not [`CLAIMED`] times less probable than the leading one: what is named beyond it
/// must be worth the claim.
fn simplest(models: &[&mut FittedModel], leading: usize) -> usize {
    let enough = models[leading].log_posterior - CLAIMED.ln();
    let effects = |i: &usize| models[*i].choices.len();
    (0..models.len())
        .filter(|i| effects(i) < effects(&leading))
        .filter(|&i| models[i].reaches_floor() && models[i].log_posterior > enough)
        .min_by(|a, b| {
            let posterior = |i: &usize| models[*i].log_posterior;
            effects(a)
                .cmp(&effects(b))
                .then(posterior(b).total_cmp(&posterior(a)))
        })
        .unwrap_or(leading)
}

fn best(models: &[&mut FittedModel], wanted: impl Fn(&FittedModel) -> bool) -> Option<usize> {
    let all = (0..models.len()).filter(|&i| wanted(models[i]));
    all.max_by(|&a, &b| {
        let posterior = |i: usize| models[i].log_posterior;
        posterior(a).total_cmp(&posterior(b))
    })
}

/// Probabilities of models from their posteriors, and of what was tested beside one of them.
pub(crate) fn probabilities(models: &[&FittedModel], tested: &[Tested]) -> (Vec<f64>, Vec<f64>) {
    let fitted = models.iter();
    let mut rows: Vec<(f64, bool)> = fitted
        .map(|c| (c.log_posterior, c.reaches_floor()))
        .collect();
    rows.extend(tested.iter().map(|t| {
        let leader = models.iter().find(|c| c.choices == t.beside());
        leader.map_or((f64::NAN, false), |c| {
            (c.log_posterior + t.log_odds, c.reaches_floor())
        })
    }));
    let mut of_fitted = shares(&rows);
    let of_tested = of_fitted.split_off(models.len());
    (of_fitted, of_tested)
}

/// Probabilities from the logarithms of posteriors up to a constant, and whether each hypothesis is adequate. The adequate
/// ones share all; where none is, all share the little that is left beside something unknown. What was not compared (NaN)
/// has none.
fn shares(rows: &[(f64, bool)]) -> Vec<f64> {
    let any = rows.iter().any(|(_, adequate)| *adequate);
    let counts = |row: &(f64, bool)| row.0.is_finite() && (row.1 || !any);
    let of_those = rows.iter().filter(|row| counts(row)).map(|row| row.0);
    let top = of_those.fold(f64::NEG_INFINITY, f64::max);
    let weight = |row: &(f64, bool)| match counts(row) {
        true => (row.0 - top).exp(),
        false => 0.0,
    };
    let total: f64 = rows.iter().map(weight).sum();
    let known = if any { 1.0 } else { 1.0 - SEARCHED };
    let share = |row| known * weight(row) / total.max(f64::MIN_POSITIVE);
    rows.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adequate_hypotheses_share_all_by_their_posteriors() {
        let odds = 9.0_f64.ln();
        let found = shares(&[
            (5.0 + odds, true),
            (5.0, true),
            (50.0, false),
            (f64::NAN, true),
        ]);
        for (share, expected) in found.iter().zip([0.9, 0.1, 0.0, 0.0]) {
            assert!((share - expected).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn where_none_is_adequate_something_unknown_is_as_probable_as_the_search_is_good() {
        let found = shares(&[(-800.0, false), (-803.0, false)]);
        assert!((found.iter().sum::<f64>() - (1.0 - SEARCHED)).abs() < 1e-12);
        assert!(found[0] > found[1]);
    }
}
