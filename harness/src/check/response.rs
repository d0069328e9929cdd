//! How a structure without contact answers what drives it, beside what is stated of it.
//!
//! ```text
//! Y/F = d sum_j phi_j^2 / (m_j D_j),   D_j = w_j^2 - w^2 + 2 i z_j w_j w
//! Y/a = -d sum_j s_j / D_j
//! ```
//!
//! with `d` = 1, `i w`, `-w^2` of a displacement, a velocity, an acceleration (of the clamp's, an accelerometer sees 1 more), `phi_j` tip
//! values, `m_j` modal masses, `s_j` clamp shares, and `r_j` more where the sensor looks elsewhere (Ewins, Modal Testing, 2000, eq. 2.14 and 2.58). The measured amplitude over this one, in
//! the median of the lines that are driven, does not depend on where exactly the resonances lie.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use nalgebra::Complex;

use super::finding::{Finding, Severity, digits};
use super::signal::{is_even, line_noise};
use super::thresholds::{
    DRIVEN_LINES, FEWEST_LINES, RESPONSE_FACTOR, RESPONSE_OFF, SEEN_LINE, WINDOWED,
};
use crate::measurement::{BeamKnowledge, Measurand, Run};
use crate::metric::{median, spectrum};

/// Damping ratio where none is stated; the median of lines hardly feels it.
const DAMPING: f64 = 0.02;

/// What drives a structure.
#[derive(Clone, Copy)]
enum Drive {
    Force,
    Clamp,
}

/// The finding on a run that answers its drive by another order of magnitude than what is stated.
pub fn response(run: &Run, beam: &BeamKnowledge) -> Option<Finding> {
    let ratio = ratio(run, beam)?;
    let off = ratio.max(1.0 / ratio);
    if off < RESPONSE_OFF {
        return None;
    }
    let severity = match ratio >= RESPONSE_FACTOR {
        true => Severity::Error,
        false => Severity::Warning,
    };
    let (drive, by, keys) = match run.inputs.external_force.acts() {
        true => ("force", "masses", "external_force_scale, mass_kg"),
        false => (
            "clamp",
            "clamp shares",
            "clamp_acceleration_scale, clamp_shares",
        ),
    };
    Some(Finding::of(
        severity,
        "driven_response",
        &run.name,
        (
            format!("the motion is {} times what was expected", digits(ratio)),
            format!("a response to the recorded {drive} by natural frequencies and {by}"),
            format!(
                "compare units: scale of what was measured, {keys}, natural_frequencies_hz in Hz"
            ),
        ),
    ))
}

/// Measured over stated response; `None` where a contact has a say, nothing or two things drive, or too little is stated.
fn ratio(run: &Run, beam: &BeamKnowledge) -> Option<f64> {
    let [force, clamp] = [&run.inputs.external_force, &run.inputs.clamp_acceleration];
    let (drive, by) = match (force.acts(), clamp.acts()) {
        (true, false) => (Drive::Force, force),
        (false, true) => (Drive::Clamp, clamp),
        _ => return None,
    };
    if run.is_pressed() || !is_even(run) || !is_known(beam, drive) {
        return None;
    }
    let values = by.series.as_ref()?.values.as_slice();
    if windowed(values) < WINDOWED {
        return None;
    }
    // The clamp's acceleration has been taken off what an accelerometer read; here it is believed no more than the rest.
    let read = match (run.measurand, drive) {
        (Measurand::Acceleration, Drive::Clamp) => {
            let both = run.measured.iter().zip(values);
            Cow::Owned(both.map(|(y, a)| y + a).collect())
        }
        _ => Cow::Borrowed(&run.measured),
    };
    let interval = run.sample_interval();
    let (driven, seen) = (spectrum(values, interval), spectrum(&read, interval));
    let noise = line_noise(run);
    // The first lines are of the window and of what is constant.
    let largest = driven.amplitude.iter().skip(3).copied().reduce(f64::max)?;
    let lines = driven.frequency.iter().zip(&driven.amplitude);
    let mut ratios: Vec<f64> = lines
        .zip(&seen.amplitude)
        .skip(3)
        .filter(|((_, u), _)| **u > DRIVEN_LINES * largest)
        .map(|((f, u), y)| {
            let expected = u * receptance(beam, run.measurand, drive, TAU * f);
            (expected, *y)
        })
        // Where neither is seen, both are noise.
        .filter(|(expected, y)| expected.max(*y) > SEEN_LINE * noise)
        .map(|(expected, y)| y.max(noise) / expected.max(noise))
        .filter(|ratio| ratio.is_finite() && *ratio > 0.0)
        .collect();
    (ratios.len() >= FEWEST_LINES).then(|| median(&mut ratios))
}

/// Share of a drive's power that the spectrum's window shows, over the share of a drive of even power.
fn windowed(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let (mut all, mut seen) = (0.0, 0.0);
    for (i, v) in values.iter().enumerate() {
        let power = (v - mean).powi(2);
        all += power;
        seen += power * (PI * (i as f64 + 0.5) / n).sin().powi(4);
    }
    // The mean of sin^4 is 3/8.
    seen / (0.375 * all)
}

/// Whether enough is stated; a free mass with friction answers a force by anything below the stated response.
fn is_known(beam: &BeamKnowledge, drive: Drive) -> bool {
    let modes = beam.natural_frequencies_hz.len();
    let held = beam.natural_frequencies_hz.iter().all(|f| *f > 0.0);
    let sizes = match drive {
        Drive::Force => beam.masses_kg.len() == modes && beam.tip_values.len() == modes,
        Drive::Clamp => beam.clamp_shares.len() == modes,
    };
    modes > 0 && held && sizes
}

/// Amplitude per unit of the drive at an angular frequency (rad/s).
fn receptance(beam: &BeamKnowledge, measurand: Measurand, drive: Drive, w: f64) -> f64 {
    let mode = |(j, f): (usize, &f64)| {
        let own = TAU * f;
        let rate = beam.damping_rates_per_s.get(j).copied();
        let ratio = beam.damping_ratios.get(j).copied();
        let ratio = ratio.unwrap_or(if rate.is_some() { 0.0 } else { DAMPING });
        let damping = 2.0 * ratio * own + rate.unwrap_or(0.0);
        let seen = beam.sensor.ratios.get(j).copied().unwrap_or(1.0);
        let share = match drive {
            Drive::Force => beam.tip_values[j].powi(2) / beam.masses_kg[j],
            Drive::Clamp => -beam.clamp_shares[j],
        };
        Complex::from(seen * share) / Complex::new(own * own - w * w, damping * w)
    };
    let modes = beam.natural_frequencies_hz.iter().enumerate();
    let deflection: Complex<f64> = modes.map(mode).sum();
    let of_sensor = match (measurand, drive) {
        (Measurand::Displacement, _) => deflection,
        (Measurand::Velocity, _) => deflection * Complex::new(0.0, w),
        (Measurand::Acceleration, Drive::Force) => deflection * -(w * w),
        (Measurand::Acceleration, Drive::Clamp) => deflection * -(w * w) + 1.0,
    };
    of_sensor.norm()
}
