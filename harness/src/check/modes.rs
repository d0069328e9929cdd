//! Stated natural frequencies against those of the motion.

use std::borrow::Cow;

use super::examined::Examined;
use super::finding::{Finding, Severity, digits};
use super::thresholds::{FREQUENCY_FACTOR, SLIP_FREQUENCY};
use crate::measurement::{BeamKnowledge, Campaign, Measurand};
use crate::metric::{median, spectrum, velocity};

/// Factors between frequencies that are confused: doubled, halved, angular frequencies (rad/s) in
/// place of Hz and back, kHz.
const CONFUSED: [(f64, &str); 6] = [
    (0.5, "they seem to be doubled"),
    (2.0, "they seem to be halved"),
    (
        1.0 / std::f64::consts::TAU,
        "they seem to be angular frequencies, in rad/s",
    ),
    (
        std::f64::consts::TAU,
        "they seem to have been divided by 2 pi",
    ),
    (1e3, "they seem to be in kHz"),
    (1e-3, "they seem to be in mHz"),
];
/// A factor is named if it leaves less than this factor.
const NEAR: f64 = 1.35;

/// The confusion that makes frequencies `ratio` times the stated ones, to a factor of `near`: the factor, and the confusion in words.
pub fn confusion(ratio: f64, near: f64) -> Option<(f64, &'static str)> {
    let fits = |(factor, _): &&(f64, &str)| (1.0 / near..near).contains(&(ratio / factor));
    CONFUSED.iter().find(fits).copied()
}

/// What to do about frequencies that were confused so.
pub fn remedy(near: Option<(f64, &str)>, stated: &[f64]) -> String {
    match near {
        Some((factor, what)) => {
            let list: Vec<String> = stated.iter().map(|f| digits(factor * f)).collect();
            format!(
                "{what}: give natural_frequencies_hz = [{}]",
                list.join(", ")
            )
        }
        None => "check natural_frequencies_hz, and time_scale".to_owned(),
    }
}

/// The finding on natural frequencies, if no motion can have them. Two signs must agree where two
/// modes are stated: the frequency of the motion in slip, and a peak of the spectrum where the
/// second mode should be instead.
pub fn modes(campaign: &Campaign, runs: &[Examined]) -> Option<Finding> {
    let mut ratios: Vec<f64> = runs.iter().filter_map(Examined::frequency_ratio).collect();
    if ratios.is_empty() {
        return None;
    }
    let ratio = median(&mut ratios) / SLIP_FREQUENCY;
    if (1.0 / FREQUENCY_FACTOR..FREQUENCY_FACTOR).contains(&ratio) {
        return None;
    }
    let stated = &campaign.beam.natural_frequencies_hz;
    let near = confusion(ratio, NEAR);
    let higher = second(&campaign.beam);
    let by_spectrum = match (near, higher) {
        (Some((factor, _)), Some(frequency)) => {
            let peak = |f: f64| {
                let mut peaks: Vec<f64> =
                    runs.iter().filter_map(|run| prominence(run, f)).collect();
                median(&mut peaks)
            };
            peak(factor * frequency) > peak(frequency)
        }
        _ => false,
    };
    let severity = if by_spectrum {
        Severity::Error
    } else {
        Severity::Warning
    };
    let remedy = remedy(near, stated);
    let lowest = stated.iter().copied().fold(f64::INFINITY, f64::min);
    Some(Finding {
        severity,
        id: "natural_frequencies",
        runs: runs.iter().map(|run| run.run.name.clone()).collect(),
        measured: format!(
            "in slip the tip swings as a mode of about {} Hz",
            digits(ratio * lowest)
        ),
        stated: format!("natural_frequencies_hz = {stated:?}"),
        remedy,
    })
}

/// The second lowest frequency.
fn second(beam: &BeamKnowledge) -> Option<f64> {
    let mut sorted = beam.natural_frequencies_hz.clone();
    sorted.sort_by(f64::total_cmp);
    sorted.get(1).copied()
}

/// Width of the band around a frequency, and the ratio from one band to the next.
const BAND: f64 = 0.04;
const NEXT: f64 = 1.08;
/// Bands on either side that a peak is compared with.
const NEIGHBOURS: i32 = 6;

/// Largest amplitude of the acceleration within 4 % of a frequency, over the median of the bands
/// beside it.
fn prominence(run: &Examined, frequency: f64) -> Option<f64> {
    let interval = run.run.sample_interval();
    let record = run.run;
    let rate = |values: &[f64]| velocity(&record.time, values, 2);
    let acceleration = match record.measurand {
        Measurand::Displacement => Cow::Owned(rate(&rate(&record.measured))),
        Measurand::Velocity => Cow::Owned(rate(&record.measured)),
        Measurand::Acceleration => Cow::Borrowed(record.measured.as_slice()),
    };
    let spectrum = spectrum(&acceleration, interval);
    let step = *spectrum.frequency.get(1)?;
    let band = |middle: f64| {
        let first = (middle * (1.0 - BAND) / step).ceil() as usize;
        let last = (middle * (1.0 + BAND) / step).floor() as usize;
        let inside = spectrum.amplitude.get(first..=last.max(first))?;
        inside.iter().copied().reduce(f64::max)
    };
    let beside = (-NEIGHBOURS..=NEIGHBOURS).filter(|k| k.abs() > 1);
    let mut beside: Vec<f64> = beside
        .filter_map(|k| band(frequency * NEXT.powi(k)))
        .collect();
    let ratio = band(frequency)? / median(&mut beside);
    ratio.is_finite().then_some(ratio)
}
