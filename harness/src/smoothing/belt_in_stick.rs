//! The belt's speed as the stick phases of a smoothed run show it.

use crate::measurement::Measurand;
use crate::metric::{StickVelocity, measured_stick_velocity, plateau, quantile, stick_velocity};
use crate::observer::{Smoothed, Structure};

/// The belt's velocity from the stick phases, which are found in the smoothed motion `plain` without trusting the `stated` one in m/s.
///
/// `signal` is what was measured, in the unit of `measurand`. `None` where too little sticks, and of an acceleration, which shows no
/// speed but by its mean over whole cycles.
pub fn belt_in_stick(
    structure: &Structure,
    plain: &Smoothed,
    (measurand, signal): (Measurand, &[f64]),
    stated: f64,
) -> Option<StickVelocity> {
    let std = quantile(&plain.velocity_std, 0.5);
    let sticks = plateau(&plain.velocity, std, stated)?;
    match measurand {
        // What is measured is the motion of another point.
        _ if !structure.is_collocated() => measured_stick_velocity(&plain.velocity, &sticks),
        Measurand::Displacement => {
            let time = |k: usize| k as f64 * plain.sample_interval;
            let time: Vec<f64> = (0..signal.len()).map(time).collect();
            stick_velocity(&time, signal, &sticks)
        }
        Measurand::Velocity => measured_stick_velocity(signal, &sticks),
        Measurand::Acceleration => None,
    }
}
