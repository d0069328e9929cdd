//! Whether a term beyond the catalogue explains the data better than what was found in it.
//!
//! An effect that the catalogue lacks may be imitated down to the noise by one that it has, or by the calibrated model (a
//! quadratic stiffness by a cubic one). Each is a hypothesis as good as the other before the data: likelihoods decide, at the
//! same price for parameters and by the same margin as among the catalogue's effects.

use super::candidate::Role;
use super::contender::{Contender, FLOOR_HELD_OUT, FLOOR_MEDIAN, NULL_GAIN, name};
use super::fit::{Effort, Fitter};
use super::hypothesis::Choice;
use super::predictor::Point;
use super::screen::Screen;
use super::search::{self, BRIEF, THOROUGH, Trial};
use super::select::{Beyond, Selection, Silent};
use super::session::{Session, parallel};
use super::shot::Shot;
use super::steps::{Step, is_faint};
use super::strain::strain;
use super::{terms, whole};
use crate::error::Error;
use crate::watch::Watch;

/// Strength at which the search for a term begins beside a model that explains the data, as a share of the typical one.
const BARELY_ON: f64 = 0.02;
/// Its shape there, as factors on the typical one.
const SHAPES: [f64; 3] = [0.3, 1.0, 3.0];
/// Jacobians for a first look at it, ...
const GLANCE: usize = 2;
/// ... and the fall of the objective there with which it is fitted further.
const PROMISE: f64 = 4.0;
/// Terms instead of an effect that are fitted to their end, the best ones, ...
const FINISHED: usize = 2;
/// ..., and those that are fitted to all shots where they come near: ...
const LAST: usize = 2;
/// ... a gain on the shots compared above which that is worth while for a term instead of an effect, ...
const NEAR_INSTEAD: f64 = -10.0;
/// ... and for a term besides.
const NEAR_BESIDES: f64 = 3.0;

/// Puts a term beyond the catalogue at the end of the path, and of `steps`, if the data ask for it: instead of a single
/// effect, or besides what was found.
///
/// # Errors
/// An FMU that can't be run.
pub fn challenge(
    session: &Session,
    selection: &mut Selection,
    steps: &mut Vec<Step>,
    watch: &dyn Watch,
) -> Result<(), Error> {
    let smooth = terms::smooth(session);
    let is_open = selection.explained && selection.beyond.is_none();
    if !is_open || smooth.is_empty() || watch.stop() {
        return Ok(());
    }
    watch.step("looking beyond the catalogue", 0, 1);
    let screen = Screen::new(session);
    let holder = selection.path.last().unwrap_or(&selection.calibrated);
    let gain = |c: &Contender| holder.score(screen.samples) - c.score(screen.samples);
    let mut near = Vec::new();
    if selection.path.len() == 1 {
        near = instead(&screen, &smooth, &selection.calibrated, watch)?;
        near.retain(|c| gain(c) > NEAR_INSTEAD);
    }
    let mut more = besides(&screen, &smooth, holder)?;
    more.retain(|c| gain(c) > NEAR_BESIDES);
    near.extend(more);
    screen.sort(&mut near);
    near.truncate(LAST);
    let all = session.fit_shots(1);
    let shots = session.copies(&all);
    let wholes = parallel(&near, |c| whole::refit(session, c, &all, &shots))?;
    let ring = Ring {
        session,
        all: &all,
        shots: &shots,
    };
    let mut best: Option<(f64, Contender, Step)> = None;
    for (contender, trial) in near.into_iter().zip(wholes) {
        let defender = steps.last().expect("the calibrated model is a step");
        if let Some((gain, step)) = ring.meet(holder, defender, &contender, trial)?
            && best.as_ref().is_none_or(|b| gain > b.0)
        {
            best = Some((gain, contender, step));
        }
    }
    let Some((gain, contender, step)) = best else {
        return Ok(());
    };
    let rival = match selection.path.last() {
        Some(effect) => name(session, &effect.choices),
        None => "the calibrated model".to_owned(),
    };
    if contender.choices.len() == 1
        && let Some(beaten) = selection.path.pop()
    {
        selection.singles.insert(0, beaten);
        steps.pop();
    }
    selection.path.push(contender);
    steps.push(step);
    selection.beyond = Some(Beyond {
        rival: Some(rival),
        gain,
    });
    Ok(())
}

/// Terms as the only thing that the calibrated model lacks; the best are fitted to their end, the others left out.
fn instead(
    screen: &Screen,
    smooth: &[Choice],
    calibrated: &Contender,
    watch: &dyn Watch,
) -> Result<Vec<Contender>, Error> {
    let jobs: Vec<Vec<Choice>> = smooth.iter().map(|t| vec![t.clone()]).collect();
    let mut found = screen.compete(&jobs, calibrated, BRIEF, &Silent(watch))?;
    screen.polish(&mut found, &Silent(watch))?;
    let to_beat = calibrated.score(screen.samples) - NULL_GAIN;
    found.retain(|c| c.fit.quantile(0.5) <= FLOOR_MEDIAN && c.score(screen.samples) < to_beat);
    found.truncate(FINISHED);
    // Fits that are to compare with one that was run to its end.
    let jobs: Vec<Vec<Choice>> = found.iter().map(|c| c.choices.clone()).collect();
    let again = screen.compete(&jobs, calibrated, THOROUGH, &Silent(watch))?;
    screen.keep_better(&mut found, again);
    parallel(&found, |c| screen.to_its_end(c))
}

/// Each term besides what was found, from there, barely on.
fn besides(
    screen: &Screen,
    smooth: &[Choice],
    holder: &Contender,
) -> Result<Vec<Contender>, Error> {
    let mut starts: Vec<(Vec<Choice>, Point)> = Vec::new();
    for term in smooth {
        let choices: Vec<Choice> = holder.choices.iter().chain([term]).cloned().collect();
        let h = screen.session.hypothesis(&choices)?;
        let centre = Point::centre(&h, &screen.shots);
        let mut start = search::widen(&holder.trial, &h, &centre);
        let card = &screen.session.catalogue[term.effect];
        let knob = |role: Role| {
            let p = &card.parameters[card.find_role(role)?];
            let i = h.shared_index(&format!("{}.{}", card.id, p.name))?;
            Some((i, p.typical))
        };
        if let Some((i, typical)) = knob(Role::Amplitude) {
            start.shared[i] = h.shared[i].position(BARELY_ON * typical);
        }
        match knob(Role::Shape) {
            None => starts.push((choices, start)),
            Some((i, typical)) => {
                for factor in SHAPES {
                    let mut start = start.clone();
                    start.shared[i] = h.shared[i].position(factor * typical);
                    starts.push((choices.clone(), start));
                }
            }
        }
    }
    let glances = parallel(&starts, |(choices, start)| glance(screen, choices, start))?;
    let promising: Vec<Contender> = glances
        .into_iter()
        .filter(|c| c.fit.trimmed < holder.fit.trimmed - PROMISE)
        .collect();
    let further = parallel(&promising, |c| screen.refit_of(c))?;
    let mut found = Vec::new();
    screen.keep_better(&mut found, promising);
    screen.keep_better(&mut found, further);
    Ok(found)
}

/// A term besides a model that is at its optimum, fitted for a moment: what it can gain it gains at once, almost linearly.
fn glance(screen: &Screen, choices: &[Choice], start: &Point) -> Result<Contender, Error> {
    let session = screen.session;
    let hypothesis = session.hypothesis(choices)?;
    let data = session.data(&screen.shots);
    let mut predictor = session.predictor(&hypothesis)?;
    let effort = Effort {
        revive: false,
        ..search::effort(GLANCE)
    };
    let fit = Fitter::new(&mut predictor, &hypothesis, &data, effort).run(start.clone());
    screen.contender(choices.to_vec(), Trial { hypothesis, fit })
}

/// All shots of the runs fitted, on which it is decided.
struct Ring<'a> {
    session: &'a Session<'a>,
    /// Their indices.
    all: &'a [usize],
    /// The shots.
    shots: &'a [Shot],
}

impl Ring<'_> {
    /// The gain of a term over what was found, and its step of the ladder, if it is worth more than chance, predicts what was kept
    /// out, and neither bends the structure nor can't be told from nothing.
    fn meet(
        &self,
        holder: &Contender,
        defender: &Step,
        challenger: &Contender,
        trial: Trial,
    ) -> Result<Option<(f64, Step)>, Error> {
        let session = self.session;
        let samples: f64 = self.shots.iter().map(|s| s.count as f64).sum();
        let price = 0.5 * (challenger.size() as f64 - holder.size() as f64) * samples.ln();
        let gain = |without: f64| without - trial.fit.trimmed - price;
        let mut without = defender.trial.fit.trimmed;
        if gain(without) <= NULL_GAIN || strain(&trial).is_some() {
            return Ok(None);
        }
        if challenger.choices.len() > holder.choices.len() {
            // The smaller model once more, so that it is not left in a worse minimum.
            let h = session.hypothesis(&holder.choices)?;
            let start = search::narrowed(&h, &trial.fit.point, self.shots);
            let again = search::settled(session, h, self.shots, start, whole::last_effort())?;
            without = without.min(again.fit.trimmed);
        }
        let gain = gain(without);
        let step = Step::new(session, trial, self.all, self.shots)?;
        let predicts = step.holdout.quantile(0.5) <= FLOOR_HELD_OUT;
        let is_faint = is_faint(session, &step, &holder.choices);
        let stands = gain > NULL_GAIN && predicts && !is_faint;
        Ok(stands.then_some((gain, step)))
    }
}
