//! Where the sensor looks, as parameters: mode shapes there over those at the tip.

use crate::diagnose::model::parameter::Parameter;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::SensorPlace;

/// Standard deviations from the stated ratio within which it is sought: beyond, the campaign states another sensor.
const REACH: f64 = 6.0;

/// FMU variables with their values.
type Fixed = Vec<(u32, f64)>;

/// What a place of the sensor sets: parameters known as well as the campaign says of the structure's `modes` first modes, and values of
/// those that effects may add. Nothing for a sensor at the tip.
///
/// # Errors
/// An FMU whose sensor is at the tip always.
pub fn sensor_ratios(
    fmu: &Fmu,
    place: &SensorPlace,
    modes: usize,
) -> Result<(Vec<Parameter>, Fixed), Error> {
    let (mut known, mut given) = (Vec::new(), Vec::new());
    if place.is_tip() {
        return Ok((known, given));
    }
    for (j, (&ratio, &std)) in place.ratios.iter().zip(&place.stds).enumerate() {
        let name = format!("mode[{}].sensor_ratio", j + 1);
        let reference = fmu.variable(&name)?.reference;
        if j >= modes {
            given.push((reference, ratio));
            continue;
        }
        known.push(Parameter::linear(name, "1", reference, (ratio, std), REACH));
    }
    Ok((known, given))
}
