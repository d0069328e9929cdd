//! The campaign.toml of imported runs.

use std::fmt::Write as _;
use std::path::Path;

use crate::measurement::Measurand;
use crate::measurement::logger::{Imported, Input};

/// A run with the file it comes from.
pub struct Entry<'a> {
    /// Name of its CSV, without suffix.
    pub name: &'a str,
    /// Where it was imported from.
    pub file: &'a Path,
    /// What was imported.
    pub run: &'a Imported,
}

const UNKNOWN_BEAM: &str = "\
[beam]                                # what is known of the structure; any part may be left out
# natural_frequencies_hz = [80.0, 510.0]  # of each mode, Hz; 0 is a mass that slides freely
# natural_frequencies_std_hz = 0.5        # how well they are known, Hz; one number or one for each
# damping_ratios = [0.001, 0.001]         # shares of critical damping
# damping_rates_per_s = [0.0, 0.0]        # viscous damping over mass beside them, 1/s
# mass_kg = 0.4                           # modal mass, the same for all; or masses_kg = [0.4, 0.4]
# mass_std_kg = 0.02                      # how well it is known, kg
# tip_values = [2.0, -2.0]                # mode shapes at the tip
";

/// The file's text.
pub fn text(name: &str, beam: Option<&str>, runs: &[Entry]) -> String {
    let mut text = format!(
        "name = {}\n\n{}",
        quoted(name),
        beam.unwrap_or(UNKNOWN_BEAM)
    );
    for Entry { name, file, run } in runs {
        let source = file
            .file_name()
            .unwrap_or(file.as_os_str())
            .to_string_lossy();
        let source: String = source.chars().filter(|c| !c.is_control()).collect();
        let understood: String = run.understood.chars().filter(|c| !c.is_control()).collect();
        let _ = write!(
            text,
            "\n[[run]]\n# imported from {source}: {understood}\nfile = {}\n",
            quoted(&format!("{name}.csv"))
        );
        if run.measurand != Measurand::Displacement {
            let (key, column) = (run.measurand.column_key(), run.measurand.usual_column());
            let _ = writeln!(text, "{key} = \"{column}\"");
        }
        for (input, value_key, column_key, column) in [
            (
                Some(&run.belt_velocity),
                "belt_velocity_m_per_s",
                "belt_velocity_column",
                "belt_velocity_m_per_s",
            ),
            (
                Some(&run.normal_force),
                "normal_force_n",
                "normal_force_column",
                "normal_force_n",
            ),
            (
                run.external_force.as_ref(),
                "external_force_n",
                "external_force_column",
                "external_force_n",
            ),
            (
                run.clamp_acceleration.as_ref(),
                "clamp_acceleration_m_per_s2",
                "clamp_acceleration_column",
                "clamp_acceleration_m_per_s2",
            ),
        ] {
            let _ = match input {
                Some(Input::Constant(value)) => writeln!(text, "{value_key} = {value:?}"),
                Some(Input::Series(_)) => writeln!(text, "{column_key} = \"{column}\""),
                None => Ok(()),
            };
        }
    }
    text
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
