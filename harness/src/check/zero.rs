//! Whether a displacement counts from the rest of the tip, by the static balance.
//!
//! A belt that runs drags the tip along: the mean deflection is that of the mean friction. Readings whose mean balances less friction
//! than any dry contact has count from elsewhere: the sensor was zeroed while the belt ran, an amplifier is AC coupled, or the mean of
//! the record was taken off.

use super::examined::Examined;
use super::finding::{Finding, Severity, digits};
use super::high_pass;
use super::thresholds::LOWEST_FRICTION;

/// The finding, if most runs on a running belt say so.
pub fn zero(runs: &[Examined]) -> Option<Finding> {
    let means: Vec<(&Examined, f64)> = runs
        .iter()
        .filter(|run| run.run.belt_velocity != 0.0 && run.run.normal_force > 0.0)
        .filter(|run| !run.run.inputs.is_excited())
        .filter_map(|run| Some((run, run.mean_friction()? * run.run.belt_velocity.signum())))
        .collect();
    let low = means.iter().filter(|(_, mean)| *mean < LOWEST_FRICTION);
    let low: Vec<&(&Examined, f64)> = low.collect();
    if 2 * low.len() <= means.len() {
        return None;
    }
    let examined: Vec<&Examined> = low.iter().map(|(run, _)| *run).collect();
    if let Some(corner) = high_pass::corner(&examined) {
        return Some(filtered(&examined, corner));
    }
    let of = |pick: fn(f64, f64) -> f64| low.iter().map(|(_, mean)| *mean).reduce(pick);
    let (least, most) = (of(f64::min)?, of(f64::max)?);
    Some(Finding {
        severity: Severity::Warning,
        id: "zero",
        runs: low.iter().map(|(run, _)| run.run.name.clone()).collect(),
        measured: format!(
            "a mean deflection that balances a friction coefficient of {} to {}",
            digits(least),
            digits(most)
        ),
        stated: "a displacement from the rest of the tip, which a running belt drags along".into(),
        remedy: "take off the reading of the tip at rest without contact, not the mean of the run; diagnose and try take such a zero as unknown, and with it the mean friction".into(),
    })
}

/// The finding on an AC-coupled sensor with this corner frequency in Hz.
fn filtered(runs: &[&Examined], corner: f64) -> Finding {
    let corner = digits(corner);
    Finding {
        severity: Severity::Warning,
        id: "high_pass",
        runs: runs.iter().map(|run| run.run.name.clone()).collect(),
        measured: format!(
            "in stick the reading rises more slowly the higher it is, as after a high pass at {corner} Hz, and its mean dies away"
        ),
        stated: "a displacement from the rest of the tip, which moves with the belt in stick"
            .into(),
        remedy: format!(
            "couple sensor and recorder to DC, or state high_pass_hz = {corner} under [sensor], by the data sheet where it says more"
        ),
    }
}
