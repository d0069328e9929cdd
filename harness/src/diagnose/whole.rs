//! Contenders fitted to all shots of the runs fitted, not only to those on which they are compared.

use super::contender::{Contender, FLOOR_COLOUR};
use super::fit::Effort;
use super::predictor::Point;
use super::search::{self, Trial};
use super::session::Session;
use super::shot::Shot;
use super::strain::strain;
use super::whiteness;
use crate::error::Error;

/// Jacobians for the last fit of a model that explains the data.
const REFIT: usize = 40;
/// The same for one that does not: its parameters mean little.
const REFIT_OF_WRONG: usize = 8;
/// Fall of the objective, as a share of it, below which that fit ends: parameters may trade along a narrow
/// valley.
const REFIT_TOLERANCE: f64 = 1e-6;

/// The effort of a last fit of a model that explains the data.
pub fn last_effort() -> Effort {
    Effort {
        tolerance: REFIT_TOLERANCE,
        patience: 2,
        stride: 1,
        robust: false,
        ..search::effort(REFIT)
    }
}

/// A contender fitted to `shots`, which stand at `all` in the session's list.
///
/// # Errors
/// An FMU that can't be run.
pub fn refit(
    session: &Session,
    contender: &Contender,
    all: &[usize],
    shots: &[Shot],
) -> Result<Trial, Error> {
    let h = session.hypothesis(&contender.choices)?;
    let mut start = Point::centre(&h, shots);
    start.shared.clone_from(&contender.trial.fit.point.shared);
    start.own.clone_from(&contender.trial.fit.point.own);
    // Shots that were in the comparison keep the starts found there.
    for (i, &k) in contender.fit.shots.iter().enumerate() {
        if let Some(j) = all.iter().position(|&a| a == k) {
            start.states[j].clone_from(&contender.trial.fit.point.states[i]);
            start.stuck[j] = contender.trial.fit.point.stuck[i];
        }
    }
    if !contender.reaches_floor() {
        return search::settled(session, h, shots, start, search::effort(REFIT_OF_WRONG));
    }
    // Shots that were not compared are far off at first, those of a profile above all: the robust objective leads them in.
    let near = search::settled(session, h, shots, start, search::effort(REFIT))?;
    search::settled(
        session,
        near.hypothesis,
        shots,
        near.fit.point,
        last_effort(),
    )
}

/// Whether a contender that is down to the noise on the shots compared also stands when it is fitted to all: it must neither bend
/// the structure nor leave what is not white. One that does not is marked, so that it no longer counts as down to the noise.
///
/// # Errors
/// An FMU that can't be run.
pub fn stands(session: &Session, contender: &mut Contender) -> Result<bool, Error> {
    if !contender.reaches_floor() {
        return Ok(false);
    }
    if contender.whole.is_none() {
        let all = session.fit_shots(1);
        let shots = session.copies(&all);
        let trial = refit(session, contender, &all, &shots)?;
        let colour = whiteness::colour(session, &shots, &trial)?;
        contender.is_refuted = strain(&trial).is_some() || colour > FLOOR_COLOUR;
        contender.whole = Some(trial);
    }
    Ok(!contender.is_refuted)
}
