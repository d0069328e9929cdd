//! Between which displacements the tip moves in each run.

use crate::diagnose::data::usable_run::UsableRun;
use crate::diagnose::model::friction_prior::StartFriction;
use crate::diagnose::model::sensor_zero::SensorZero;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{Campaign, Measurand, Run};
use crate::observer::Structure;

/// Least and largest displacement of the tip in m, run by run: as measured, or smoothed where something else was measured.
///
/// # Errors
/// A run that can't be smoothed.
pub fn displacement_ranges(
    fmu: &Fmu,
    campaign: &Campaign,
    structure: &Structure,
) -> Result<Vec<(f64, f64)>, Error> {
    let runs: Vec<Run> = UsableRun::all(&campaign.runs)
        .into_iter()
        .map(|usable| usable.run)
        .collect();
    let (zero, smoothings) = SensorZero::and_smoothings(
        &runs,
        structure,
        StartFriction::of(fmu)?,
        campaign.uncertainty.zero_std,
    )?;
    let is_read = campaign.measurand() == Measurand::Displacement && campaign.beam.sensor.is_tip();
    let all = campaign.runs.iter().zip(&smoothings).zip(&zero.beliefs);
    let ranges = all.map(|((run, smoothing), (zero, _))| match is_read {
        true => {
            let (low, high) = range(&run.measured);
            (low - zero, high - zero)
        }
        false => range(&smoothing.stick_slip.smoothed.displacement),
    });
    Ok(ranges.collect())
}

fn range(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().filter(|v| v.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(*v), high.max(*v))
    })
}
