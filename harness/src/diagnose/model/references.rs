//! Value references of the FMU's variables that every hypothesis needs.

use crate::diagnose::model::further_sensors::FurtherSensors;
use crate::error::Error;
use crate::fmu::{Fmu, SideFile, Variable};
use crate::measurement::{Campaign, Measurand, Run};
use crate::observer::Structure;
use std::sync::Arc;

/// Value references of the FMU's variables that every hypothesis needs; those that an FMU of another make may lack are `None`
/// there.
pub struct References {
    /// belt_velocity, normal_force.
    pub inputs: [Option<u32>; 2],
    /// external_force, clamp_acceleration: what excites the structure beside the belt.
    pub excitations: [Option<u32>; 2],
    /// The output that the sensor measures ([`output_of`]).
    pub measured: u32,
    /// Whether the sensor's offset is to be added to that output: the FMU adds it to measured_displacement alone.
    pub lacks_offset: bool,
    /// contact_mode (an enumeration, 0 = stick).
    pub contact_mode: Option<u32>,
    /// start.contact (an enumeration).
    pub contact: Option<u32>,
    /// start.effects (an enumeration).
    pub start_effects: Option<u32>,
    /// mode_count (an integer).
    pub mode_count: Option<u32>,
    /// tolerance.
    pub tolerance: Option<u32>,
    /// belt_travel.start and dwell_time.start.
    pub history: [Option<u32>; 2],
    /// What q[j], q_dot[j] in turn are read from.
    pub states: Vec<u32>,
    /// What they are set by before a start.
    pub starts: Vec<u32>,
    /// Displacement of the tip over that of each mode, 1.
    pub tip_values: Vec<f64>,
    /// Whether the displacement follows from something else that is measured.
    pub is_integrated: bool,
    /// What further sensors read.
    pub further: Arc<FurtherSensors>,
}

impl References {
    /// Looks the names up.
    ///
    /// # Errors
    /// A variable that the FMU does not have.
    pub fn new(fmu: &Fmu, structure: &Structure, campaign: &Campaign) -> Result<Self, Error> {
        let modes = structure.modes().len();
        let measurand = campaign.measurand();
        let tip_values: Vec<f64> = structure.modes().iter().map(|m| m.tip_value).collect();
        let one = |name: &str| fmu.variable(name).map(|v| v.reference);
        // A side file says which variables there are; without one all are asked for.
        let if_any = |name: &str| match fmu.side_file() {
            Some(_) => Ok(one(name).ok()),
            None => one(name).map(Some),
        };
        let stated = match fmu.side_file() {
            Some(side) => {
                let needs_level = measurand != Measurand::Displacement && !structure.is_free();
                if needs_level && side.friction_coefficient.is_none() {
                    return Err(side.error(format!(
                        "a measured {} does not show the level of the friction force: state friction_coefficient at the top of the file, to a tenth or so",
                        measurand.name()
                    )));
                }
                let starts = side.starts(2 * modes)?;
                named_inputs(fmu, side, &campaign.runs)?;
                Some(starts)
            }
            None => None,
        };
        let mut states = Vec::new();
        for j in 1..=modes {
            states.push(one(&format!("q[{j}]"))?);
            states.push(one(&format!("q_dot[{j}]"))?);
        }
        Ok(Self {
            inputs: [if_any("belt_velocity")?, if_any("normal_force")?],
            excitations: [one("external_force").ok(), one("clamp_acceleration").ok()],
            measured: output_of(fmu, measurand)?.reference,
            lacks_offset: measurand != Measurand::Displacement
                || fmu.variable("sensor.offset").is_err(),
            contact_mode: if_any("contact_mode")?,
            contact: if_any("start.contact")?,
            start_effects: if_any("start.effects")?,
            mode_count: if_any("mode_count")?,
            tolerance: if_any("tolerance")?,
            history: [if_any("belt_travel.start")?, if_any("dwell_time.start")?],
            starts: stated.unwrap_or_else(|| states.clone()),
            states,
            further: Arc::new(FurtherSensors::new(
                fmu,
                &campaign.further_sensors,
                tip_values.clone(),
            )?),
            tip_values,
            is_integrated: measurand != Measurand::Displacement,
        })
    }

    /// The same names with another output in the place of the one measured.
    pub(crate) fn observing(&self, output: u32) -> Self {
        Self {
            measured: output,
            lacks_offset: false,
            states: self.states.clone(),
            starts: self.starts.clone(),
            tip_values: self.tip_values.clone(),
            further: self.further.clone(),
            ..*self
        }
    }
}

/// That what differs between runs, or within one, is an input of an FMU of another make.
fn named_inputs(fmu: &Fmu, side: &SideFile, runs: &[Run]) -> Result<(), Error> {
    let of = |run: &Run| [run.belt_velocity, run.normal_force];
    for (i, name) in ["belt_velocity", "normal_force"].into_iter().enumerate() {
        let value = |run: &Run| of(run)[i];
        let is_series = |run: &Run| run.inputs.series().any(|(of, _)| of == name);
        let varies = runs
            .iter()
            .any(|run| is_series(run) || value(run) != value(&runs[0]));
        if varies && fmu.variable(name).is_err() {
            return Err(side.error(format!(
                "{name} differs between the runs or within one, and [variables] does not say which input of the FMU that is; add it"
            )));
        }
    }
    Ok(())
}

/// The FMU's output that the sensor measures; that of the tip where the FMU has no sensor.
///
/// # Errors
/// An FMU without either.
pub fn output_of(fmu: &Fmu, measurand: Measurand) -> Result<&Variable, Error> {
    let quantity = measurand.name();
    let measured = fmu.variable(&format!("measured_{quantity}"));
    measured.or_else(|_| fmu.variable(&format!("tip_{quantity}")))
}
