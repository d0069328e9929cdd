//! What an archive holds besides description, binaries and start values: documentation, picture, the
//! parameters' defaults and reference results (FMI 2.0.5, section 2.3).

use std::fmt::Write as _;
use std::path::Path;

use super::documentation;
use crate::command::operating_point::{OperatingPoint, record};
use crate::command::parameter_set::{defaults, ssv};
use crate::error::Error;
use crate::fmu::{Fmu, ModelDescription};

/// A file of the archive: its path there, and its content.
pub type Entry = (String, Vec<u8>);

/// Folder of the reference results, after the layered standard that the standard's own FMUs use.
const RESULTS: &str = "extra/org.fmi-standard.fmi-ls-ref/";
/// Files that follow from the description.
pub const DOCUMENTATION: &str = "documentation/index.html";
const DEFAULTS: &str = "resources/defaults.ssv";
/// Reference results: communication step in s, and number of steps.
const STEPS: (f64, usize) = (1e-3, 200);
/// Their variables.
const OUTPUTS: [&str; 6] = [
    "tip_displacement",
    "tip_velocity",
    "friction_force",
    "relative_velocity",
    "contact_mode",
    "transition_count",
];

/// What is the same in every archive. No `terminalsAndIcons`: that folder is FMI 3.0's, and checkers of FMI 2.0
/// archives refuse its file whichever version it names.
pub fn fixed() -> Vec<Entry> {
    let picture = include_bytes!("model.png").to_vec();
    std::iter::once(("model.png".into(), picture))
        .chain(licenses())
        .collect()
}

/// Under which licences the FMU may be used; license.txt is where the standard has people begin.
pub fn licenses() -> impl Iterator<Item = Entry> {
    let texts: [(&str, &[u8]); 4] = [
        ("license.txt", include_bytes!("license.txt")),
        (
            "license_apache.txt",
            include_bytes!("../../../LICENSE-APACHE"),
        ),
        ("license_mit.txt", include_bytes!("../../../LICENSE-MIT")),
        ("third_party.txt", include_bytes!("third_party.txt")),
    ];
    texts
        .into_iter()
        .map(|(name, text)| (format!("documentation/licenses/{name}"), text.to_vec()))
}

/// Puts what follows from the description into an archive, in place of what was there.
///
/// # Errors
/// A description that can't be read.
pub fn follow_description(path: &Path, xml: &str, files: &mut Vec<Entry>) -> Result<(), Error> {
    let description = ModelDescription::parse(xml).map_err(|problem| Error::FmuDescription {
        path: path.to_owned(),
        problem,
    })?;
    let starts = ssv(&description, "defaults", &defaults(&description));
    files.retain(|(name, _)| {
        name != DOCUMENTATION && name != DEFAULTS && !name.starts_with(RESULTS)
    });
    files.push((
        DOCUMENTATION.into(),
        documentation::index(&description).into_bytes(),
    ));
    files.push((DEFAULTS.into(), starts.into_bytes()));
    Ok(())
}

/// The reference results of an FMU of this model: a run with its start values.
///
/// # Errors
/// An FMU that does not run.
pub fn reference_results(fmu: &Fmu) -> Result<Vec<Entry>, Error> {
    let start = |name: &str| {
        let variable = fmu.variable(name)?;
        Ok(variable.start_number().unwrap_or(0.0))
    };
    let point = OperatingPoint {
        belt_velocity: start("belt_velocity")?,
        normal_force: start("normal_force")?,
        settings: Vec::new(),
        ..OperatingPoint::default()
    };
    let mut instance = fmu.instantiate("reference results")?;
    point.start(fmu, &mut instance)?;
    let run = record(fmu, &mut instance, &OUTPUTS, STEPS.0, STEPS.1)?;
    let mut csv = String::from("\"time\"");
    OUTPUTS.iter().for_each(|name| {
        let _ = write!(csv, ",\"{name}\"");
    });
    csv.push('\n');
    for (i, time) in run.time.iter().enumerate() {
        let _ = write!(csv, "{time}");
        for values in &run.values {
            let _ = write!(csv, ",{}", values[i]);
        }
        csv.push('\n');
    }
    let name = &fmu.description().model_identifier;
    Ok(vec![
        (
            format!("{RESULTS}fmi-ls-manifest.xml"),
            include_bytes!("results_manifest.xml").to_vec(),
        ),
        (format!("{RESULTS}{name}_out.csv"), csv.into_bytes()),
    ])
}
