//! Terms beyond the catalogue that are fitted like its effects, to see whether something else explains the data better.
//!
//! Each is one file in the form of a user's effect (`library/`), the simplest of its kind: the next terms of the beam's restoring
//! force and damping, friction that tells directions apart, stiffness and belt speed that pulsate. None is ever named as an
//! effect: where one is needed, the effect is none of the catalogue's, and the term is proposed.

use serde::Deserialize;
use std::collections::BTreeMap;

/// The files.
pub const FILES: [&str; 40] = [
    include_str!("library/ac_coupling.toml"),
    include_str!("library/asymmetric_damping.toml"),
    include_str!("library/asymmetric_stiffness.toml"),
    include_str!("library/clamp_clearance.toml"),
    include_str!("library/constant_force.toml"),
    include_str!("library/contact_resonance.toml"),
    include_str!("library/coupled_mode.toml"),
    include_str!("library/cubic_damping.toml"),
    include_str!("library/damping_by_amplitude.toml"),
    include_str!("library/damping_by_deflection.toml"),
    include_str!("library/dry_damping.toml"),
    include_str!("library/first_mode_drift.toml"),
    include_str!("library/flash_temperature.toml"),
    include_str!("library/frequency_by_amplitude.toml"),
    include_str!("library/friction_by_deflection_squared.toml"),
    include_str!("library/friction_by_direction.toml"),
    include_str!("library/friction_by_load.toml"),
    include_str!("library/friction_by_tip_velocity.toml"),
    include_str!("library/friction_creep.toml"),
    include_str!("library/frictional_heating.toml"),
    include_str!("library/lagging_load.toml"),
    include_str!("library/micro_slip.toml"),
    include_str!("library/pulsating_belt.toml"),
    include_str!("library/pulsating_stiffness.toml"),
    include_str!("library/quadratic_stiffness.toml"),
    include_str!("library/rate_and_state_ageing.toml"),
    include_str!("library/rate_and_state_slip.toml"),
    include_str!("library/runout.toml"),
    include_str!("library/sensor_cubic.toml"),
    include_str!("library/sensor_curvature.toml"),
    include_str!("library/sensor_drift.toml"),
    include_str!("library/sensor_hum.toml"),
    include_str!("library/slip_distance_lag.toml"),
    include_str!("library/softening_by_warming.toml"),
    include_str!("library/stop.toml"),
    include_str!("library/structural_hysteresis.toml"),
    include_str!("library/two_stops.toml"),
    include_str!("library/uneven_belt.toml"),
    include_str!("library/vibration_absorber.toml"),
    include_str!("library/wear.toml"),
];

/// How the identifiers of all of them begin.
const PREFIX: &str = "term_";

/// Whether an effect is one of them.
pub fn is_library_effect(id: &str) -> bool {
    id.starts_with(PREFIX)
}

/// Begin of the identifiers of formulas that stand for the curve of an unknown function.
pub const FORMULA_PREFIX: &str = "term_formula_";

/// What a diagnosis takes from a file.
#[derive(Deserialize)]
pub(crate) struct File {
    pub id: String,
    pub target: String,
    pub expression: String,
    /// What the formula depends on, as `diagnosis.json` names it; empty for a formula in place of a curve.
    #[serde(default)]
    pub argument: String,
    /// The mode, from 1, where it acts on one alone.
    pub mode: Option<usize>,
}

impl File {
    /// The file of an effect of the library.
    pub fn of_library(id: &str) -> Option<Self> {
        Self::among(FILES, id)
    }

    /// The file of an effect among some.
    pub fn among<'a>(files: impl IntoIterator<Item = &'a str>, id: &str) -> Option<Self> {
        let mut read = files
            .into_iter()
            .filter_map(|f| toml::from_str::<Self>(f).ok());
        read.find(|file| file.id == id)
    }

    /// Whether it acts in the contact.
    pub fn is_of_contact(&self) -> bool {
        matches!(self.place(), "friction" | "normal_force")
    }

    /// Where it acts, as `diagnosis.json` names it.
    pub fn place(&self) -> &'static str {
        match self.target.as_str() {
            "friction_factor" => "friction",
            "normal_force_factor" => "normal_force",
            "tip_force" => "tip_force",
            "frequency_factor" => "frequency",
            "damping_factor" => "damping",
            "measurement" => "measurement",
            "belt_velocity" => "belt",
            _ => "clamp",
        }
    }
}

/// The text of the file of an effect among some.
pub(crate) fn text_among<'a>(
    files: impl IntoIterator<Item = &'a str>,
    id: &str,
) -> Option<&'a str> {
    let mut files = files.into_iter();
    files.find(|text| toml::from_str::<File>(text).is_ok_and(|file| file.id == id))
}

/// An effect's file with another identifier, and with these values of its parameters, by name, as the typical ones.
pub fn with_values(text: &str, id: &str, values: &BTreeMap<String, f64>) -> String {
    let mut parameter = None;
    let mut in_parameter = false;
    let line = |line: &str| {
        let (key, value) = line.split_once(" = ").unwrap_or((line, ""));
        match key {
            "[[parameter]]" => in_parameter = true,
            "[[state]]" => in_parameter = false,
            "name" => parameter = values.get(value.trim_matches('"')),
            "id" => return format!("id = \"{id}\"\n"),
            "typical" if in_parameter => {
                if let Some(value) = parameter {
                    return format!("typical = {value:e}\n");
                }
            }
            _ => {}
        }
        format!("{line}\n")
    };
    text.lines().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn a_file_with_other_values_differs_in_these_alone() {
        for text in FILES {
            let table = |text: &str| toml::from_str::<toml::Table>(text).unwrap();
            let mut expected = table(text);
            let mut values = BTreeMap::new();
            let parameters = expected["parameter"].as_array_mut().unwrap();
            for (parameter, value) in parameters.iter_mut().zip(1..) {
                let parameter = parameter.as_table_mut().unwrap();
                let value = 0.5 * f64::from(value);
                values.insert(parameter["name"].as_str().unwrap().to_owned(), value);
                parameter["typical"] = value.into();
            }
            expected["id"] = "proposed_7".into();
            assert_eq!(table(&with_values(text, "proposed_7", &values)), expected);
        }
    }

    #[test]
    fn every_file_has_an_identifier_of_its_own_that_is_known_for_a_term() {
        let ids: BTreeSet<String> = FILES
            .iter()
            .map(|f| toml::from_str::<File>(f).unwrap().id)
            .collect();
        assert_eq!(ids.len(), FILES.len());
        assert!(ids.iter().all(|id| is_library_effect(id)), "{ids:?}");
    }
}
