//! Between which displacements the tip moves in each run.

use crate::diagnose::data::usable_run::UsableRun;
use crate::diagnose::model::friction_prior::StartFriction;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::{Campaign, Measurand, Run};
use crate::observer::Structure;
use crate::parallel::parallel;
use crate::smoothing::smooth_run;

/// Least and largest displacement of the tip in m, run by run: as measured, or smoothed where something else was measured.
///
/// # Errors
/// A run that can't be smoothed.
pub fn displacement_ranges(
    fmu: &Fmu,
    campaign: &Campaign,
    structure: &Structure,
) -> Result<Vec<(f64, f64)>, Error> {
    match campaign.measurand() {
        Measurand::Displacement if campaign.beam.sensor.is_tip() => {
            Ok(campaign.runs.iter().map(|r| range(&r.measured)).collect())
        }
        _ => {
            let friction = StartFriction::of(fmu)?;
            let runs: Vec<Run> = UsableRun::all(&campaign.runs)
                .into_iter()
                .map(|usable| usable.run)
                .collect();
            parallel(&runs, |run| {
                let smoothing = smooth_run(run, structure, &|v| friction.at(v))?;
                Ok(range(&smoothing.stick_slip.smoothed.displacement))
            })
        }
    }
}

fn range(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().filter(|v| v.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(*v), high.max(*v))
    })
}
