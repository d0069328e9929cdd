//! A run as the smoother has it.

use super::belt_path::BeltPath;
use super::prepared::Prepared;
use crate::error::Error;
use crate::measurement::Run;
use crate::observer::{StickSlip, StickSlipSettings, Structure, smooth_stick_slip};

/// A run, smoothed.
pub struct Smoothing {
    /// Motion and force.
    pub stick_slip: StickSlip,
    /// Median time in s from break-away to break-away; NaN without stick-slip.
    pub cycle: f64,
    /// Time in s of the run's first sample, from which the phases count.
    pub first_time: f64,
    /// How far the belt has run.
    pub belt_path: BeltPath,
}

/// What was measured on a uniform grid, in m, m/s or m/s^2: NaN where a sample is missing or not to be trusted; smoothers bridge them.
pub fn trusted_signal(run: &Run) -> Vec<f64> {
    let trusted = run.trusted();
    let h = run.sample_interval();
    let mut signal = Vec::with_capacity(run.time.len());
    for k in 0..run.time.len() {
        let slot = ((run.time[k] - run.time[0]) / h).round() as usize;
        while signal.len() < slot {
            signal.push(f64::NAN);
        }
        if signal.len() == slot {
            signal.push(if trusted[k] {
                run.measured[k]
            } else {
                f64::NAN
            });
        }
    }
    signal
}

/// Effort for a diagnosis, which fits start states to the motion anyway: rounds of phases, and expectation-maximisation steps.
const ROUNDS: usize = 2;
/// See [`ROUNDS`].
const ITERATIONS: usize = 4;

/// Estimates motion and phases of a run with the linear structure as known. `friction` is the expected coefficient (1) over the
/// relative speed in m/s, which sets the level of force and deflection where a velocity or an acceleration leaves it open; `zero` is
/// what the sensor reads of a tip at rest, in its unit.
///
/// # Errors
/// Sampling too slow for the modes and whatever else the smoother refuses.
pub fn smooth_run(
    run: &Run,
    structure: &Structure,
    friction: &dyn Fn(f64) -> f64,
    zero: f64,
) -> Result<Smoothing, Error> {
    let even = (run.sample_interval(), trusted_signal(run));
    let prepared = Prepared::of(run, structure, friction, even, zero);
    let settings = StickSlipSettings {
        rounds: ROUNDS,
        iterations: ITERATIONS,
        ..prepared.settings().clone()
    };
    let found = smooth_stick_slip(
        structure,
        prepared.interval(),
        prepared.signal(),
        prepared.belt(),
        &settings,
    );
    let stick_slip = found.map_err(|source| Error::Observer {
        run: run.name.clone(),
        source,
    })?;
    Ok(prepared.complete(stick_slip))
}
