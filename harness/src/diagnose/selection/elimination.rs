//! Backward elimination: which of the effects that explain most together are needed.
//!
//! Effects are added one after another, each beside those that led by then ([`super::discrepancy`]). One that stood for others at
//! first may have nothing left to do, and what explains most may be all that is missing. Where it comes down to the sensor's
//! noise, each of its effects is left out in turn and the rest fitted again, while that is more probable; what remains
//! is decided as elsewhere. Source: stepwise regression, Efroymson (1960), in Ralston and Wilf, Mathematical Methods for Digital Computers,
//! ch. 17, with posterior probabilities in place of F tests.

use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::decision::{decide, log_posterior};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;

/// What a search had found before it was asked what explains most: fits that count with the sensor's noise.
pub struct Before {
    calibrated: FittedModel,
    singles: Vec<FittedModel>,
    pairs: Vec<FittedModel>,
}

impl Before {
    /// Of a selection.
    pub fn of(selection: &Selection) -> Self {
        Self {
            calibrated: selection.calibrated.clone(),
            singles: selection.singles.clone(),
            pairs: selection.pairs.clone(),
        }
    }
}

/// Whether the last hypothesis of a selection's path, or a part of it, explains the data to the sensor's noise, with which the problem
/// counts; it is then what the selection found, beside what it held `before`.
///
/// # Errors
/// An FMU that can't be run.
pub fn eliminate(
    problem: &Problem,
    selection: &mut Selection,
    before: Before,
    watch: &dyn Watch,
) -> Result<bool, Error> {
    let screen = Screen::new(problem);
    let Some(whole) = selection.path.last() else {
        return Ok(false);
    };
    let mut models = vec![screen.to_its_end(whole)?];
    let mut leader = models[0].clone();
    while leader.choices.len() > 1 && !watch.stop() {
        let parts: Vec<Vec<Choice>> = (0..leader.choices.len())
            .map(|left_out| {
                let mut part = leader.choices.clone();
                part.remove(left_out);
                part
            })
            .collect();
        let parts = parallel(&parts, |part| {
            screen.to_its_end(&screen.reordered(&leader, part)?)
        })?;
        let posterior = |model: &FittedModel| log_posterior(problem, model);
        let best = parts
            .iter()
            .filter(|part| part.reaches_floor())
            .max_by(|a, b| posterior(a).total_cmp(&posterior(b)))
            .cloned();
        models.extend(parts);
        match best {
            Some(best) if !leader.reaches_floor() || posterior(&best) > posterior(&leader) => {
                leader = best;
            }
            _ => break,
        }
    }
    let mut all: Vec<&mut FittedModel> = models.iter_mut().collect();
    let Some(best) = decide(problem, &mut all)? else {
        return Ok(false);
    };
    let best = models.swap_remove(best);
    let path = screen.path_to(best)?;
    let has = |models: &[FittedModel], m: &FittedModel| {
        models.iter().any(|other| other.choices == m.choices)
    };
    models.retain(|m| !has(&path, m));
    let Before {
        mut calibrated,
        mut singles,
        mut pairs,
    } = before;
    // None of those of the search came down to the noise.
    let known = singles.iter_mut().chain(&mut pairs);
    for model in known.chain([&mut calibrated]) {
        model.log_posterior = f64::NEG_INFINITY;
    }
    for list in [&mut singles, &mut pairs] {
        list.retain(|m| !has(&path, m) && !has(&models, m));
    }
    let (new_singles, new_pairs): (Vec<_>, Vec<_>) =
        models.into_iter().partition(|m| m.choices.len() == 1);
    singles.extend(new_singles);
    pairs.extend(new_pairs);
    screen.sort(&mut singles);
    screen.sort(&mut pairs);
    (selection.calibrated, selection.singles, selection.pairs) = (calibrated, singles, pairs);
    selection.judge_candidates(problem)?;
    selection.explained_by(problem, path);
    Ok(true)
}
