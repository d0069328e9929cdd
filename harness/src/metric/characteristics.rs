//! The metrics of one motion, together.

use super::{
    StickDetection, amplitude, detect_stick, harmonics, measured_stick, period, resample,
    resting_stick, stick_fraction,
};
use crate::measurement::Measurand;

/// How many harmonics are reported.
pub const HARMONICS: usize = 5;

/// What characterises one motion of the tip.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Characteristics {
    /// Cycle period, s, of the whole record or else of its second half; `None` if it does not oscillate.
    pub period: Option<f64>,
    /// Autocorrelation at the period, 1.
    pub regularity: Option<f64>,
    /// Peak amplitude, in the unit of what is measured (m, m/s or m/s^2).
    pub amplitude: f64,
    /// Share of time in stick, 1; NaN where stick does not show.
    pub stick_fraction: f64,
    /// Amplitudes at 1, 2, ... times the cycle frequency, in the same unit; empty without period.
    pub harmonics: Vec<f64>,
}

/// Characterises a record of a displacement, velocity or acceleration: `time` in s, `values` and the standard deviation `noise` of their
/// noise (0 for a model) in that unit, `belt_velocity` in m/s, NaN where
/// stick does not show. An amplitude within five standard deviations of the noise is no oscillation.
pub fn characteristics(
    time: &[f64],
    (measurand, values): (Measurand, &[f64]),
    belt_velocity: f64,
    noise: f64,
) -> Characteristics {
    let interval = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
    let amplitude = amplitude(values);
    let moves = amplitude > 5.0 * noise;
    let even = resample(time, values, interval);
    let found = if moves {
        // A motion that jumps from one attractor to another has no period as a whole; where it ends up counts.
        period(&even, interval).or_else(|| period(&even[even.len() / 2..], interval))
    } else {
        None
    };
    let stick = stick_of(time, (measurand, values), belt_velocity, noise);
    Characteristics {
        period: found.map(|p| p.seconds),
        regularity: found.map(|p| p.regularity),
        amplitude,
        stick_fraction: match belt_velocity.is_nan() {
            true => f64::NAN,
            false => stick_fraction(time, &stick.sticks),
        },
        harmonics: found
            .map(|p| harmonics(time, values, 1.0 / p.seconds, HARMONICS))
            .unwrap_or_default(),
    }
}

/// Stick and slip of a record, by what it holds.
pub fn stick_of(
    time: &[f64],
    (measurand, values): (Measurand, &[f64]),
    belt_velocity: f64,
    noise: f64,
) -> StickDetection {
    match measurand {
        Measurand::Displacement => detect_stick(time, values, belt_velocity, noise),
        Measurand::Velocity => measured_stick(values, belt_velocity, noise),
        Measurand::Acceleration => resting_stick(time, values, belt_velocity, noise),
    }
}
