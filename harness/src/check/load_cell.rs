//! The sign of a load cell's readings.

use super::finding::{Finding, Severity, digits};
use crate::measurement::{FurtherRecord, FurtherSensor, Reading, Run};
use crate::metric::standard_deviation;

/// Warnings on load cells that read, on the mean, a friction against the belt's motion by more than what varies and its zero is off: a belt that runs evenly
/// pulls the contact along on the mean, in stick and in slip.
pub fn load_cell(run: &Run, sensors: &[FurtherSensor]) -> Vec<Finding> {
    if !run.sustains_itself() || !run.is_pressed() {
        return Vec::new();
    }
    let read = sensors.iter().zip(&run.further);
    let cells = read.filter(|(sensor, _)| sensor.reading == Reading::FrictionForce);
    let against = |sensor: &FurtherSensor, record: &FurtherRecord| {
        let values: Vec<f64> = record
            .values
            .iter()
            .copied()
            .filter(|y| y.is_finite())
            .collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let off = standard_deviation(&values) + 2.0 * sensor.offset_std.unwrap_or(0.0);
        (mean * run.belt_velocity.signum() < -off).then_some(mean)
    };
    let finding = |(sensor, record): (&FurtherSensor, &Option<FurtherRecord>)| {
        let mean = against(sensor, record.as_ref()?)?;
        Some(Finding::of(
            Severity::Warning,
            "load_cell_sign",
            &run.name,
            (
                format!("'{}' reads {} N on the mean", sensor.name, digits(mean)),
                format!("a belt velocity of {} m/s", digits(run.belt_velocity)),
                format!(
                    "friction pulls along the belt's motion: turn the sign of the scale of '{}', or state how far its zero is off as offset_std",
                    sensor.name
                ),
            ),
        ))
    };
    cells.filter_map(finding).collect()
}
