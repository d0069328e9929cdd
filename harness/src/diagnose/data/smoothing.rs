//! A run as the smoother has it, and what the smoother is given of it.

use crate::diagnose::data::driven_motion::BeltPath;
use crate::measurement::{Measurand, Run};
use crate::observer::{Settings, StickSlip};

/// A run, smoothed, with its segments.
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

/// What the smoother is told of a run. Beside a force that jumps it finds the noise of a displacement, but not the much smaller one
/// of a velocity or an acceleration, which the differences of the record show.
pub fn smoother_settings(run: &Run) -> Settings {
    let known = Some(run.noise.std).filter(|std| *std > 0.0);
    Settings {
        measurand: run.measurand,
        noise_std: match run.measurand {
            Measurand::Displacement => None,
            Measurand::Velocity | Measurand::Acceleration => known,
        },
        ..Settings::default()
    }
}
