//! Which effect would help most: the score test of every effect beside the model on the page.

use std::sync::atomic::{AtomicUsize, Ordering};

use serde::Serialize;

use super::{Bench, Finding, as_fitted, settled};
use crate::command::studio::model::{Draft, draft as draft_of};
use crate::diagnose::initialisation::score_test::{At, is_testable, look};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::variants::variants;
use crate::error::Error;
use crate::parallel::parallel;

/// Segments that are looked at, spread over the runs fitted: enough for a ranking in about a second.
const SEGMENTS: usize = 12;

/// An effect beside the model.
#[derive(Debug, Clone, Serialize)]
pub struct Score {
    /// Identifier.
    pub id: String,
    /// Expected gain in evidence, nats.
    pub gain: f64,
    /// Expected fall of the negative logarithm of the likelihood, nats.
    pub fall: f64,
    /// The model with it switched on where a fit can begin, for what repeats: at its strongest line, with a phase in each run.
    pub start: Option<Draft>,
}

/// Tests every effect that is off.
///
/// # Errors
/// A draft that is none of this FMU's, or an FMU that can't be run.
pub fn score(bench: &Bench, draft: &Draft, base: u64) -> Result<Finding, Error> {
    let (desk, problem) = (bench.desk, bench.problem);
    let mut fitted = as_fitted(&settled(bench, draft, base)?);
    let all = problem.fit_segments(1);
    let every = all.len().div_ceil(SEGMENTS).max(1);
    let indices: Vec<usize> = all.into_iter().step_by(every).collect();
    let segments = problem.copies(&indices);
    fitted.fit = fitted.fit.of_segments(&indices);
    let own = &fitted.hypothesis.choices;
    let jobs: Vec<Choice> = (0..problem.catalogue.len())
        .filter(|&e| is_testable(problem, e) && own.iter().all(|c| c.effect != e))
        .flat_map(|effect| variants(problem, effect).into_iter().take(1))
        .collect();
    let at = At::new(problem, &segments, &fitted)?;
    let done = AtomicUsize::new(0);
    let scores = parallel(&jobs, |choice| {
        if desk.is_cancelled() {
            return Ok(None);
        }
        let choices: Vec<Choice> = own.iter().cloned().chain([choice.clone()]).collect();
        let found = look(problem, &choices, &at)?.and_then(|lead| lead.promise);
        let card = &problem.catalogue[choice.effect];
        let id = &card.id;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        desk.progress(|p| {
            p.share = Some(done as f64 / jobs.len() as f64);
            p.words = format!("{done} of {}: {id}", jobs.len());
        });
        let Some(found) = found.filter(|f| f.gain.is_finite() && f.leaves_trace()) else {
            return Ok(None);
        };
        let start = match card.repeats() && found.gain > 0.0 {
            true => Some(draft_of(
                problem,
                &problem.hypothesis(&choices)?,
                &found.start,
            )),
            false => None,
        };
        Ok(Some(Score {
            id: id.clone(),
            gain: found.gain,
            fall: found.fall,
            start,
        }))
    })?;
    let mut scores: Vec<Score> = scores.into_iter().flatten().collect();
    scores.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let stopped = if desk.is_cancelled() {
        "Stopped before its end. "
    } else {
        ""
    };
    Ok(Finding::Scores {
        scores,
        note: format!(
            "{stopped}Expected gain in evidence, nats, to first order from {} segments, all calibration free. It is exact beside a \
             model at its optimum and near the noise; far from it it ranks.",
            segments.len()
        ),
    })
}
