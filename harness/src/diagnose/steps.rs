//! The steps of the error ladder: the calibrated model and the path of a selection, fitted to all data and judged.

use super::candidate::Role;
use super::conclude::estimate;
use super::contender::Contender;
use super::hypothesis::Choice;
use super::judge::{self, Care, Judgement};
use super::predictor::Point;
use super::search::{self, Trial};
use super::select::Selection;
use super::session::Session;
use super::shot::Shot;
use super::{whiteness, whole};
use crate::error::Error;

/// Standard deviations by which an effect must differ from nothing beside a model that is down to the noise.
const FAINT: f64 = 3.0;
/// Gain that needs no second look.
const OVERWHELMING: f64 = 300.0;

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

/// Takes back the last effects of the path that, on all shots and with both fits run to their end, gain no more
/// than chance over a model that is down to the noise without them, or can't be told from nothing. Where the gain is not overwhelming, or what gains so much
/// can't be told from nothing, the smaller model is fitted once more from the optimum of the larger one, so that it is not left in a worse minimum.
///
/// # Errors
/// An FMU that can't be run.
pub fn prune(
    session: &Session,
    selection: &mut Selection,
    steps: &mut Vec<Step>,
) -> Result<(), Error> {
    let all = session.fit_shots(1);
    let samples: f64 = all.iter().map(|&k| session.shots[k].count as f64).sum();
    while let Some(last) = selection.path.last() {
        let depth = selection.path.len();
        let below = match depth {
            1 => &selection.calibrated,
            _ => &selection.path[depth - 2],
        };
        if !below.reaches_floor() {
            break;
        }
        let price = 0.5 * (last.size() as f64 - below.size() as f64) * samples.ln();
        let gain = |steps: &[Step]| {
            steps[depth - 1].trial.fit.trimmed - steps[depth].trial.fit.trimmed - price
        };
        let is_doubtful = |steps: &[Step]| {
            gain(steps) < OVERWHELMING || is_faint(session, &steps[depth], &below.choices)
        };
        if gain(steps) > selection.threshold && is_doubtful(steps) {
            let shots = session.copies(&all);
            let h = session.hypothesis(&below.choices)?;
            let start = search::narrowed(&h, &steps[depth].trial.fit.point, &shots);
            let again = search::settled(session, h, &shots, start, whole::last_effort())?;
            if again.fit.trimmed < steps[depth - 1].trial.fit.trimmed {
                steps[depth - 1] = Step::new(session, again, &all, &shots)?;
                for i in (depth - 1).max(1)..=depth {
                    let (below, above) = steps.split_at_mut(i);
                    above[0].rejudge(session, &below[i - 1])?;
                }
            }
        }
        let is_clear =
            gain(steps) >= OVERWHELMING || !is_faint(session, &steps[depth], &below.choices);
        if gain(steps) > selection.threshold && is_clear {
            break;
        }
        let taken_back = selection.path.pop().expect("the path has a last effect");
        if depth == 1 {
            selection.singles.insert(0, taken_back);
        } else {
            selection.pairs.insert(0, taken_back);
        }
        steps.pop();
    }
    Ok(())
}

/// Whether what a step has more than the effects `below` can't be told from nothing: every amplitude that it adds, or every
/// shape constant where it has no amplitude, is known to a third of itself at best ([`FAINT`] standard deviations). A gain
/// that contradicts this comes from a smaller model that was not fitted as well.
pub(super) fn is_faint(session: &Session, step: &Step, below: &[Choice]) -> bool {
    let h = &step.trial.hypothesis;
    let added = h.choices.iter().filter(|c| !below.contains(c));
    let mut strongest = f64::NEG_INFINITY;
    for choice in added {
        let effect = &session.catalogue[choice.effect];
        let role = match effect.find_role(Role::Amplitude) {
            Some(_) => Role::Amplitude,
            None => Role::Shape,
        };
        for p in effect.parameters.iter().filter(|p| p.role == role) {
            if let Some(i) = h.shared_index(&format!("{}.{}", effect.id, p.name)) {
                let estimate = estimate(h, &step.trial.fit, i);
                let deviation = estimate.value.abs() / estimate.std;
                strongest = strongest.max(deviation);
            }
        }
    }
    // Nothing that could be told, such as the nodes of a profile, is not faint.
    (0.0..FAINT).contains(&strongest)
}
