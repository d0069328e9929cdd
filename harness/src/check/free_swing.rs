//! The frequency of a structure that swings by itself, without contact, beside the natural frequencies stated.

use std::f64::consts::TAU;

use super::finding::{Finding, Severity, digits};
use super::modes::{confusion, remedy};
use super::signal::{is_even, line_noise};
use super::thresholds::{
    FREE_FREQUENCY, FREE_SWINGS, FREQUENCY_FACTOR, OWN_LINE, SEEN_LINE, SWINGS_BAND,
};
use crate::measurement::{Campaign, Measurand, Run};
use crate::metric::{median, spectrum};

/// The finding on natural frequencies of which none is near that of the free swings. A spring that hardens or softens moves the frequency
/// with the amplitude, so that only a confusion which fits every run is an error.
pub fn free_swing(campaign: &Campaign) -> Option<Finding> {
    let stated = &campaign.beam.natural_frequencies_hz;
    let free = campaign.runs.iter().filter(|run| swings_free(run));
    let swings: Vec<(&Run, f64, f64)> = free
        .filter_map(|run| {
            let frequency = frequency(run, stated)?;
            Some((run, frequency, nearest(frequency, stated)?))
        })
        .collect();
    if swings.is_empty() {
        return None;
    }
    let ratio = median(&mut swings.iter().map(|s| s.2).collect::<Vec<f64>>());
    if (1.0 / FREQUENCY_FACTOR..FREQUENCY_FACTOR).contains(&ratio) {
        return None;
    }
    let near = confusion(ratio, FREE_FREQUENCY);
    let fits = |ratio: f64| confusion(ratio, FREE_FREQUENCY).map(|c| c.0) == near.map(|c| c.0);
    let severity = match near.is_some() && swings.iter().all(|s| fits(s.2)) {
        true => Severity::Error,
        false => Severity::Warning,
    };
    let remedy = match near {
        // Nobody states mHz; times in ms make a frequency a thousandth.
        Some((factor, _)) if factor < 0.01 => {
            "times seem to be in ms: give time_scale = 0.001".to_owned()
        }
        near => remedy(near, stated),
    };
    let lowest = swings.iter().map(|s| s.1).fold(f64::INFINITY, f64::min);
    Some(Finding {
        severity,
        id: "natural_frequencies",
        runs: swings.iter().map(|s| s.0.name.clone()).collect(),
        measured: format!(
            "without contact the tip swings at {} Hz, {} times the nearest natural frequency",
            digits(lowest),
            digits(ratio)
        ),
        stated: format!("natural_frequencies_hz = {stated:?}"),
        remedy,
    })
}

/// Whether a run swings without contact and without a drive, and its lines can be told.
fn swings_free(run: &Run) -> bool {
    !run.is_pressed() && run.is_plain() && is_even(run)
}

/// The frequency (Hz) of the displacement's highest line, where one swing rules the record and no stated frequency has a line of its own.
fn frequency(run: &Run, stated: &[f64]) -> Option<f64> {
    let spectrum = spectrum(&run.measured, run.sample_interval());
    let derivatives = match run.measurand {
        Measurand::Displacement => 0,
        Measurand::Velocity => 1,
        Measurand::Acceleration => 2,
    };
    let noise = SEEN_LINE * line_noise(run);
    // As displacements, else a higher mode rules what an accelerometer reads; lines of a few cycles are drift.
    let lines = spectrum.frequency.iter().zip(&spectrum.amplitude);
    let lines: Vec<(f64, f64)> = lines
        .skip(FREE_SWINGS)
        .filter(|(_, amplitude)| **amplitude > noise)
        .map(|(f, amplitude)| (*f, amplitude / (TAU * f).powi(derivatives)))
        .collect();
    let (at, highest) = lines.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let within = |f: f64, of: f64| (1.0 / SWINGS_BAND..SWINGS_BAND).contains(&(f / of));
    let power = |of: &dyn Fn(f64) -> bool| -> f64 {
        let some = lines.iter().filter(|(f, _)| of(*f));
        some.map(|(_, a)| a * a).sum()
    };
    let rules = power(&|f| within(f, at)) > 0.5 * power(&|_| true);
    let lowest = spectrum.frequency.get(FREE_SWINGS)?;
    let shows = |of: f64| {
        let own = lines.iter().filter(|(f, _)| within(*f, of));
        of < *lowest || own.map(|l| l.1).any(|a| a > OWN_LINE * highest)
    };
    (rules && !stated.iter().any(|f| shows(*f))).then_some(at)
}

/// A frequency over the natural frequency that is nearest to it by ratio.
fn nearest(frequency: f64, stated: &[f64]) -> Option<f64> {
    let ratios = stated.iter().filter(|f| **f > 0.0).map(|f| frequency / f);
    ratios.min_by(|a, b| a.ln().abs().total_cmp(&b.ln().abs()))
}
