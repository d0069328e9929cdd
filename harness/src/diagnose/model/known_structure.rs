//! The structure as a campaign gives it.

use crate::error::Error;
use crate::fmu::{Fmu, SideFile};
use crate::measurement::BeamKnowledge;
use crate::observer::{Mode, Structure};

/// The structure as a campaign gives it, with the FMU's start values for what is left out.
///
/// # Errors
/// Modal data that no structure can have; an FMU of another make without its side file.
pub fn structure(fmu: &Fmu, beam: &BeamKnowledge) -> Result<Structure, Error> {
    let start = |name: String| -> Result<f64, Error> {
        Ok(fmu.variable(&name)?.start_number().unwrap_or(f64::NAN))
    };
    const STATE: &str = "q[1]";
    if fmu.side_file().is_none() && fmu.variable(STATE).is_err() {
        return Err(Error::NoSideFile {
            path: fmu.path().to_owned(),
            name: STATE,
            side: SideFile::place(fmu.path()),
        });
    }
    let is_stated = [
        &beam.natural_frequencies_hz,
        &beam.damping_ratios,
        &beam.masses_kg,
        &beam.tip_values,
    ]
    .iter()
    .all(|list| !list.is_empty());
    if let (Some(side), false) = (fmu.side_file(), is_stated) {
        return Err(side.error(
            "the FMU has its own parameters and does not state the structure: give natural_frequencies_hz, damping_ratios, masses_kg and tip_values in [structure] of campaign.toml",
        ));
    }
    let count = if beam.natural_frequencies_hz.is_empty() {
        start("mode_count".into())? as usize
    } else {
        beam.natural_frequencies_hz.len()
    };
    let mut modes = Vec::new();
    for j in 0..count {
        let of = |list: &[f64], item: &str| match list.get(j) {
            Some(value) => Ok(*value),
            None => start(format!("mode[{}].{item}", j + 1)),
        };
        modes.push(Mode {
            frequency_hz: of(&beam.natural_frequencies_hz, "frequency")?,
            damping_ratio: of(&beam.damping_ratios, "damping_ratio")?,
            // An FMU without the parameter has no such damper.
            damping_rate: of(&beam.damping_rates_per_s, "damping_rate").unwrap_or(0.0),
            mass_kg: match beam.masses_kg.len() {
                1 => beam.masses_kg[0],
                _ => of(&beam.masses_kg, "mass")?,
            },
            tip_value: of(&beam.tip_values, "tip_value")?,
            sensor_ratio: beam.sensor.ratios.get(j).copied().unwrap_or(1.0),
            // An FMU that does not say it may be a mass on a spring.
            clamp_share: of(&beam.clamp_shares, "clamp_share").unwrap_or(1.0 / count as f64),
        });
    }
    Structure::new(modes).map_err(|source| Error::Observer {
        run: "[beam]".into(),
        source,
    })
}
