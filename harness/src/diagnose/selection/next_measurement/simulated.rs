//! A run that has not been measured, as a fitted model has it.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::data::white_noise::gaussian;
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::simulator::{Samples, SegmentValues, Simulator};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::error::Error;
use crate::measurement::{Measurand, Role, Run, Sampling};

/// Periods of the lowest mode until the transient has died down far enough.
const TRANSIENT: f64 = 10.0;
/// Distance in m at which a simulated motion is given up, beyond any beam's, ...
const FAR: f64 = 0.1;
/// ... speed in m/s: that of such a motion at 80 Hz, ...
const FAST: f64 = 50.0;
/// ... and acceleration in m/s^2, likewise.
const SUDDEN: f64 = 25e3;

/// The first run that a model was fitted to, with which it simulates.
fn origin(problem: &Problem) -> usize {
    problem.held_out.iter().position(|h| !h).unwrap_or(0)
}

/// A run as a model has it at a belt velocity in m/s and a normal force in N: from rest, without its transient, as long as those
/// measured and with the sensor's noise; `None` if the motion can't be simulated.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn simulated(
    problem: &Problem,
    truth: &FittedModel,
    (velocity, force): (f64, f64),
) -> Result<Option<Run>, Error> {
    let r = origin(problem);
    let measured = &problem.campaign.runs[r];
    let far = match measured.measurand {
        Measurand::Displacement => FAR,
        Measurand::Velocity => FAST,
        Measurand::Acceleration => SUDDEN,
    };
    let belt = velocity.copysign(measured.belt_velocity);
    let mut runs = problem.campaign.runs.clone();
    runs[r] = Run {
        belt_velocity: belt,
        normal_force: force,
        measured: vec![-far, far],
        further: Vec::new(),
        ..measured.clone()
    };
    let modes = structure(problem.fmu, &problem.campaign.beam)?;
    let lowest = modes.modes().iter().map(|m| m.frequency_hz);
    let transient = TRANSIENT / lowest.fold(f64::INFINITY, f64::min);
    let h = measured.sample_interval();
    let skipped = (transient / h).round() as usize;
    let count = skipped + measured.time.len();
    let hypothesis = &truth.fitted.hypothesis;
    let mut state = vec![0.0; 2 * hypothesis.modes + hypothesis.extra_states.len()];
    state[1] = belt / modes.modes()[0].tip_value;
    let segment = Segment {
        run: r,
        first: 0,
        time: (0..count)
            .map(|k| measured.time[0] + h * k as f64)
            .collect(),
        measured: vec![0.0; count],
        trusted: vec![true; count],
        count,
        further: Vec::new(),
        stuck: !hypothesis.has_memory,
        dwell: 0.0,
        travel: 0.0,
        travel_end: 0.0,
        belt_distance: 0.0,
        state,
    };
    let mut predictor = Predictor::new(
        problem.fmu,
        &problem.references,
        &runs,
        hypothesis,
        &problem.work,
    )?;
    let point = &truth.fitted.fit.point;
    let mut out = Vec::new();
    let values = SegmentValues {
        shared: &point.shared,
        per_run: &point.per_run[r],
        state: &segment.state,
        stuck: segment.stuck,
    };
    let done = predictor.predict(&segment, values, Samples::of(count, 1), &mut out);
    if !matches!(done, Ok(true)) {
        return Ok(None);
    }
    let mut random = fastrand::Rng::with_seed(1);
    let noise = problem.noise[r];
    let time: Vec<f64> = (0..count - skipped).map(|k| h * k as f64).collect();
    Ok(Some(Run {
        name: "simulated".into(),
        role: Some(Role::Holdout),
        sampling: Sampling::of(&time),
        time,
        measured: out[skipped..]
            .iter()
            .map(|y| y + noise * gaussian(&mut random))
            .collect(),
        faults: Vec::new(),
        ..runs.swap_remove(r)
    }))
}
