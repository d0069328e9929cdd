//! The steps of the error ladder: the calibrated model and the path of a selection, fitted to all data and judged.

use super::contender::Contender;
use super::judge::{self, Care, Judgement};
use super::predictor::Point;
use super::search::Trial;
use super::select::Selection;
use super::session::Session;
use super::shot::Shot;
use super::{whiteness, whole};
use crate::error::Error;

/// One step of the ladder, fitted on all shots: the calibrated model, then one effect more each time.
pub struct Step {
    /// Hypothesis and fit.
    pub trial: Trial,
    /// On the runs fitted.
    pub fit: Judgement,
    /// On what was kept out.
    pub holdout: Judgement,
    /// How far from white the residuals of the fit are; below 1 for noise alone.
    pub colour: f64,
}

impl Step {
    /// Judges a trial that was fitted to `shots`, which stand at `all` in the session's list.
    pub(super) fn new(
        session: &Session,
        trial: Trial,
        all: &[usize],
        shots: &[Shot],
    ) -> Result<Step, Error> {
        Ok(Step {
            fit: judge::of_fit(session, all, &trial.fit),
            holdout: judge::held_out(session, &trial, Care::Thorough)?,
            colour: whiteness::colour(session, shots, &trial)?,
            trial,
        })
    }

    /// Judges once more from what a smaller model found of the runs kept out, if that predicts them better: what is their
    /// own, a friction level above all, may have been looked for in vain.
    fn rejudge(&mut self, session: &Session, smaller: &Step) -> Result<(), Error> {
        if self.holdout.quantile(0.5) > smaller.holdout.quantile(0.5) {
            let known = Some((&smaller.trial.hypothesis, &smaller.holdout));
            let again = judge::held_out_from(session, &self.trial, Care::Thorough, known)?;
            if again.quantile(0.5) < self.holdout.quantile(0.5) {
                self.holdout = again;
            }
        }
        Ok(())
    }

    /// Where the knobs stand for a run: as fitted, or as learned on a run that was kept out.
    pub fn point(&self, session: &Session, run: usize) -> &Point {
        if session.held_out[run] {
            &self.holdout.point
        } else {
            &self.trial.fit.point
        }
    }
}

/// Refits the calibrated model and the path on all shots of the runs fitted and judges them.
///
/// # Errors
/// An FMU that can't be run.
pub fn climb(session: &Session, selection: &Selection) -> Result<Vec<Step>, Error> {
    let steps: Vec<&Contender> = std::iter::once(selection.calibration())
        .chain(&selection.path)
        .collect();
    let all = session.fit_shots(1);
    let shots = session.copies(&all);
    let mut steps = super::session::parallel(&steps, |contender| {
        let trial = match &contender.whole {
            // Nothing can have changed since: where friction scatters, no contender is looked at as a whole before.
            Some(trial) => trial.clone(),
            None => whole::refit(session, contender, &all, &shots)?,
        };
        Step::new(session, trial, &all, &shots)
    })?;
    for i in 1..steps.len() {
        let (below, above) = steps.split_at_mut(i);
        above[0].rejudge(session, &below[i - 1])?;
    }
    Ok(steps)
}
