//! A run that has not been measured, as a fitted model has it.

use crate::diagnose::contender::Contender;
use crate::diagnose::hypothesis::structure;
use crate::diagnose::null::gaussian;
use crate::diagnose::predictor::Predictor;
use crate::diagnose::session::Session;
use crate::diagnose::shot::Shot;
use crate::error::Error;
use crate::measurement::{Role, Run, Sampling};

/// Periods of the lowest mode until the transient has died down far enough.
const TRANSIENT: f64 = 10.0;
/// Distance in m at which a simulated motion is given up, beyond any beam's.
const FAR: f64 = 0.1;

/// The first run that a contender was fitted to, with which it simulates.
fn origin(session: &Session) -> usize {
    session.held_out.iter().position(|h| !h).unwrap_or(0)
}

/// A run as a contender has it at a belt velocity in m/s and a normal force in N: from rest, without its transient, as long as those
/// measured and with the sensor's noise; `None` if the motion can't be simulated.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(super) fn simulated(
    session: &Session,
    truth: &Contender,
    (velocity, force): (f64, f64),
) -> Result<Option<Run>, Error> {
    let r = origin(session);
    let measured = &session.campaign.runs[r];
    let belt = velocity.copysign(measured.belt_velocity);
    let mut runs = session.campaign.runs.clone();
    runs[r] = Run {
        belt_velocity: belt,
        normal_force: force,
        displacement: vec![-FAR, FAR],
        ..measured.clone()
    };
    let modes = structure(session.fmu, &session.campaign.beam)?;
    let lowest = modes.modes().iter().map(|m| m.frequency_hz);
    let transient = TRANSIENT / lowest.fold(f64::INFINITY, f64::min);
    let h = measured.sample_interval();
    let skipped = (transient / h).round() as usize;
    let count = skipped + measured.time.len();
    let hypothesis = &truth.trial.hypothesis;
    let mut state = vec![0.0; 2 * hypothesis.modes + hypothesis.extra_states.len()];
    state[1] = belt / modes.modes()[0].tip_value;
    let shot = Shot {
        run: r,
        first: 0,
        time: (0..count)
            .map(|k| measured.time[0] + h * k as f64)
            .collect(),
        measured: vec![0.0; count],
        trusted: vec![true; count],
        count,
        stuck: !hypothesis.has_memory,
        dwell: 0.0,
        travel: 0.0,
        travel_end: 0.0,
        state,
    };
    let mut predictor = Predictor::new(session.fmu, &session.references, &runs, hypothesis)?;
    let point = &truth.trial.fit.point;
    let mut out = Vec::new();
    let done = predictor.predict(
        &shot,
        &point.shared,
        &point.own[r],
        &shot.state,
        shot.stuck,
        count,
        1,
        &mut out,
    );
    if !matches!(done, Ok(true)) {
        return Ok(None);
    }
    let mut random = fastrand::Rng::with_seed(1);
    let noise = session.noise[r];
    let time: Vec<f64> = (0..count - skipped).map(|k| h * k as f64).collect();
    Ok(Some(Run {
        name: "simulated".into(),
        role: Some(Role::Holdout),
        sampling: Sampling::of(&time),
        time,
        displacement: out[skipped..]
            .iter()
            .map(|y| y + noise * gaussian(&mut random))
            .collect(),
        faults: Vec::new(),
        ..runs.swap_remove(r)
    }))
}
