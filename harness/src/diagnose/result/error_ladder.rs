//! The steps of the error ladder: the calibrated model and the path of a selection, fitted to all data and judged.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::Care;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::fitted_model::{FittedModel, is_met, name};
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::outcome::{Contradiction, Selection};
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::diagnose::validation::{residual_whiteness, segment_errors};
use crate::error::Error;

/// One step of the ladder, fitted on all segments: the calibrated model, then one effect more each time.
pub struct Step {
    /// Hypothesis and fit.
    pub fitted: FittedHypothesis,
    /// On the runs fitted.
    pub fit: SegmentErrors,
    /// On what was kept out.
    pub holdout: SegmentErrors,
    /// How far from white the residuals of the fit are; below 1 for noise alone.
    pub spectral_ratio: f64,
}

impl Step {
    /// Judges a fit that was fitted to `segments`, which stand at `all` in the problem's list.
    pub(crate) fn new(
        problem: &Problem,
        fitted: FittedHypothesis,
        all: &[usize],
        segments: &[Segment],
    ) -> Result<Step, Error> {
        Ok(Step {
            fit: segment_errors::of_fit(problem, all, &fitted.fit),
            holdout: segment_errors::held_out(problem, &fitted, Care::Thorough)?,
            spectral_ratio: residual_whiteness::spectral_ratio(problem, segments, &fitted)?,
            fitted,
        })
    }

    /// Judges once more from what a smaller model found of the runs kept out, if that predicts them better: what is their
    /// own, a friction level above all, may have been looked for in vain.
    fn rejudge(&mut self, problem: &Problem, smaller: &Step) -> Result<(), Error> {
        let is_worse = |mine: &SegmentErrors, other: &SegmentErrors| {
            let unmet = mine.unmet_runs.len().cmp(&other.unmet_runs.len());
            let median = mine.quantile(0.5).total_cmp(&other.quantile(0.5));
            unmet.then(median).is_gt()
        };
        if is_worse(&self.holdout, &smaller.holdout) {
            let known = Some((&smaller.fitted.hypothesis, &smaller.holdout));
            let again =
                segment_errors::held_out_from(problem, &self.fitted, Care::Thorough, known)?;
            if is_worse(&self.holdout, &again) {
                self.holdout = again;
            }
        }
        Ok(())
    }

    /// Where the parameters stand for a run: as fitted, or as learned on a run that was kept out.
    pub fn point(&self, problem: &Problem, run: usize) -> &Point {
        if problem.held_out[run] {
            &self.holdout.point
        } else {
            &self.fitted.fit.point
        }
    }
}

/// Whether what a selection names, or that nothing is missing, does not hold on the runs kept out: its error there is not down to the noise,
/// nor do other constants bring it down. `None` where it holds, where it explains nothing, and where no run was kept out.
///
/// # Errors
/// An FMU that can't be run.
pub fn contradiction(
    problem: &Problem,
    selection: &Selection,
) -> Result<Option<Contradiction>, Error> {
    let out = problem.held_out.iter().zip(&problem.campaign.runs);
    let runs: Vec<String> = out
        .filter(|(is_out, _)| **is_out)
        .map(|(_, run)| run.name.clone())
        .collect();
    if !selection.explained || runs.is_empty() {
        return Ok(None);
    }
    let named = selection.path.last().unwrap_or(&selection.calibrated);
    let fitted = named.full_refit.as_ref().unwrap_or(&named.fitted);
    if is_met(&segment_errors::held_out(problem, fitted, Care::Thorough)?) {
        return Ok(None);
    }
    // What is their own may have been looked for in vain: as the report judges.
    let steps = climb(problem, selection)?;
    let step = steps.last().expect("the calibrated model at least");
    let judged = &step.holdout;
    if is_met(judged) || full_refit::meets_runs_kept_out(problem, &step.fitted, judged)? {
        return Ok(None);
    }
    Ok(Some(Contradiction {
        answer: match named.choices.is_empty() {
            true => "nothing is missing".to_owned(),
            false => name(problem, &named.choices),
        },
        runs,
        error: judged.over_noise_words(problem),
    }))
}

/// Refits the calibrated model and the path on all segments of the runs fitted and judges them.
///
/// # Errors
/// An FMU that can't be run.
pub fn climb(problem: &Problem, selection: &Selection) -> Result<Vec<Step>, Error> {
    let steps: Vec<&FittedModel> = std::iter::once(selection.calibration())
        .chain(&selection.path)
        .collect();
    let all = problem.fit_segments(1);
    let segments = problem.copies(&all);
    let mut steps = crate::parallel::parallel(&steps, |model| {
        let fitted = match &model.full_refit {
            // Nothing can have changed since: where friction scatters, no model is looked at as a whole before.
            Some(fitted) => fitted.clone(),
            None => full_refit::refit(problem, model, &all, &segments)?,
        };
        Step::new(problem, fitted, &all, &segments)
    })?;
    for i in 1..steps.len() {
        let (below, above) = steps.split_at_mut(i);
        above[0].rejudge(problem, &below[i - 1])?;
    }
    Ok(steps)
}
