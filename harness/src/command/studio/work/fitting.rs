//! A fit from where the page stands, told iteration by iteration.

use std::collections::BTreeSet;

use super::{Bench, Finding, default_name, keep, settled};
use crate::command::studio::desk::Desk;
use crate::command::studio::ladder::Origin;
use crate::command::studio::model::{Draft, draft as draft_of};
use crate::command::studio::preview::Predicted;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{Care, FitOptions};
use crate::diagnose::estimation::fitter::{Fitter, Listener};
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::parameter::Kind;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::segment_errors::{held_out, of_fit};
use crate::error::Error;

/// Iterations at most.
const ITERATIONS: usize = 25;
/// Standard deviation of the belief in a parameter that is held, over its usual step.
const HELD: f64 = 1e-6;

/// Hears of iterations and passes them on.
struct Teller<'a> {
    desk: &'a Desk,
    problem: &'a Problem<'a>,
    hypothesis: &'a Hypothesis,
    /// Indices of the segments fitted.
    indices: &'a [usize],
    draft: &'a Draft,
}

impl Listener for Teller<'_> {
    fn goes_on(&self, point: &Point, mean_square: &[f64]) -> bool {
        let error = error_of(self.problem, self.indices, mean_square);
        let draft = merged(self.draft, &draft_of(self.problem, self.hypothesis, point));
        self.desk.progress(|p| {
            p.errors.push(error);
            p.words = format!("iteration {}, error {:.3} %", p.errors.len(), 100.0 * error);
            p.share = Some(p.errors.len() as f64 / ITERATIONS as f64);
            p.draft = Some(draft);
        });
        !self.desk.is_cancelled()
    }
}

/// Error (1) of the runs fitted.
fn error_of(problem: &Problem, indices: &[usize], mean_square: &[f64]) -> f64 {
    let fit = crate::diagnose::estimation::fit::Fit::unfitted(
        Point {
            shared: Vec::new(),
            per_run: Vec::new(),
            states: Vec::new(),
            stuck: Vec::new(),
        },
        mean_square.to_vec(),
    );
    of_fit(problem, indices, &fit).nrmse
}

/// Fits a draft and keeps what is reached as a rung; a fit that is stopped keeps where it stands.
///
/// # Errors
/// A draft that is none of this FMU's, or an FMU that can't be run.
pub fn fit(
    bench: &Bench,
    draft: &Draft,
    base: u64,
    free: Option<Vec<String>>,
) -> Result<Finding, Error> {
    let (desk, problem) = (bench.desk, bench.problem);
    desk.progress(|p| p.words = "finding where segments start".into());
    let from = settled(bench, draft, base)?;
    let free: Option<BTreeSet<String>> = free.map(|names| names.into_iter().collect());
    let (h, whole) = match &free {
        Some(free) => held(&from.hypothesis, &from.point, free),
        None => (from.hypothesis.clone(), from.point.clone()),
    };
    let indices = problem.fit_segments(1);
    let segments = problem.copies(&indices);
    let pick = |point: &Point| Point {
        shared: point.shared.clone(),
        per_run: point.per_run.clone(),
        states: indices.iter().map(|&k| point.states[k].clone()).collect(),
        stuck: indices.iter().map(|&k| point.stuck[k]).collect(),
    };
    let start = pick(&whole);
    let data = problem.data(&segments);
    let mut predictor = problem.predictor(&h)?;
    let teller = Teller {
        desk,
        problem,
        hypothesis: &h,
        indices: &indices,
        draft,
    };
    let of_start: Vec<f64> = indices.iter().map(|&k| from.mean_square[k]).collect();
    teller.goes_on(&start, &of_start);
    let options = FitOptions {
        patience: 2,
        ..FitOptions::search(ITERATIONS)
    };
    let fitter = Fitter::new(&mut predictor, &h, &data, options);
    let fit = fitter.told_to(&teller).run(start);
    drop(predictor);
    let stopped = desk.is_cancelled();
    let mut reached = whole;
    reached.shared.clone_from(&fit.point.shared);
    reached.per_run.clone_from(&fit.point.per_run);
    for (i, &k) in indices.iter().enumerate() {
        reached.states[k].clone_from(&fit.point.states[i]);
        reached.stuck[k] = fit.point.stuck[i];
    }
    // What the runs kept out have of their own is learned from half of each, while all else stands.
    if problem.held_out.contains(&true) && !stopped {
        desk.progress(|p| p.words = "what the runs kept out have of their own".into());
        let fitted = FittedHypothesis {
            hypothesis: h.clone(),
            fit,
        };
        let judged = held_out(problem, &fitted, Care::Brief)?;
        for run in (0..problem.held_out.len()).filter(|&r| problem.held_out[r]) {
            reached.per_run[run].clone_from(&judged.point.per_run[run]);
        }
    }
    let result = merged(draft, &draft_of(problem, &h, &reached));
    let reached = Predicted {
        hypothesis: h,
        point: reached,
        mean_square: Vec::new(),
        errors: from.errors,
    };
    let name = format!("fit of {}", default_name(&result));
    let found = keep(bench, &result, base, (Origin::Fit, name), Some(&reached))?;
    Ok(match found {
        Finding::Rung { id, note } if stopped => Finding::Rung {
            id,
            note: format!("Stopped before its end; this is where it stood. {note}"),
        },
        found => found,
    })
}

/// A draft with the values of another.
fn merged(draft: &Draft, found: &Draft) -> Draft {
    let mut out = draft.clone();
    out.effects.extend(found.effects.clone());
    out.shared.extend(found.shared.clone());
    for (run, values) in &found.own {
        let own = out.own.entry(run.clone()).or_default();
        own.extend(values.clone());
    }
    out
}

/// The hypothesis at a point with all held but the parameters named: what all runs share becomes constant, and what can't (scales
/// of inputs, constants of sensors, a run's own) is believed to be where it stands.
fn held(h: &Hypothesis, point: &Point, free: &BTreeSet<String>) -> (Hypothesis, Point) {
    let (mut out, mut at) = (h.clone(), point.clone());
    (out.shared, at.shared) = (Vec::new(), Vec::new());
    for (i, (parameter, &position)) in h.shared.iter().zip(&point.shared).enumerate() {
        let mut parameter = parameter.clone();
        let scale = h.input_scales.iter().position(|s| *s == Some(i));
        if !free.contains(&parameter.name) {
            // What the FMU does not have can't be set there.
            if scale.is_none() && !matches!(parameter.kind, Kind::Sensor(..)) {
                out.fixed.extend(parameter.settings(position));
                continue;
            }
            parameter.prior = parameter.value(position);
            parameter.prior_std = HELD * parameter.step;
        }
        if let Some(scale) = scale {
            out.input_scales[scale] = Some(out.shared.len());
        }
        out.shared.push(parameter);
        at.shared.push(position);
    }
    for (parameters, positions) in out.per_run.iter_mut().zip(&point.per_run) {
        for (parameter, &position) in parameters.iter_mut().zip(positions) {
            if !free.contains(&parameter.name) && parameter.prior_std > 0.0 {
                parameter.prior = parameter.value(position);
                parameter.prior_std = HELD * parameter.step;
            }
        }
    }
    (out, at)
}
