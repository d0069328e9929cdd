//! `stickslip system`: beam and belt drive coupled both ways, as an SSP 1.0 archive for system tools.
//!
//! `SystemStructure.ssd` connects the drive's belt velocity with the beam, and the beam's friction force with the
//! drive. A parameter set (.ssv) for each gives the operating point. Why the contact has bristles: docs/adr/0011.

use std::path::{Path, PathBuf};

use clap::Args;

use crate::command::pack::{self, belt_drive};
use crate::command::parameter_set::ssv;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::output::{print_line, write_file};

/// Options of `system`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// File to write
    #[arg(short, long, value_name = "FILE", default_value = "belt_drive.ssp")]
    output: PathBuf,
}

/// Name under which masters look for a component's own values.
const SET: &str = "initialValues";

/// Values of the beam: the bristles' typical ones, and a load at which the motion repeats.
const BEAM: [(&str, f64); 3] = [
    ("normal_force", 60.0),
    ("presliding_compliance.bristle_stiffness", 5e5),
    ("presliding_compliance.bristle_damping", 60.0),
];

/// Values of the drive: the typical ones of the effect that states the same equations.
const DRIVE: [(&str, f64); 4] = [
    ("motor_velocity", 0.1),
    ("mass", 1.5),
    ("stiffness", 2e4),
    ("damping", 50.0),
];

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    write(&arguments.output)?;
    print_line(format_args!("Wrote {}", arguments.output.display()))
}

/// Writes the archive.
///
/// # Errors
/// FMUs that can't be packed, a file that can't be written.
pub fn write(path: &Path) -> Result<(), Error> {
    let structure = include_bytes!("SystemStructure.ssd").to_vec();
    let mut files = vec![("SystemStructure.ssd".to_owned(), structure)];
    let folder = tempfile::tempdir().map_err(Error::write(&std::env::temp_dir()))?;
    let beam = folder.path().join(pack::FILE_NAME);
    pack::pack(&beam)?;
    let drive = folder.path().join(belt_drive::FILE_NAME);
    belt_drive::pack(&drive)?;
    for (name, file, values) in [
        ("beam", &beam, BEAM.as_slice()),
        ("drive", &drive, DRIVE.as_slice()),
    ] {
        let fmu = Fmu::load(file)?;
        for (variable, _) in values {
            fmu.variable(variable)?;
        }
        let values: Vec<(String, f64)> = values
            .iter()
            .map(|(name, value)| ((*name).to_owned(), *value))
            .collect();
        let set = ssv(fmu.description(), SET, &values);
        files.push((format!("resources/{name}.ssv"), set.into_bytes()));
        let bytes = std::fs::read(file).map_err(Error::read(file))?;
        let file_name = file.file_name().unwrap_or_default().to_string_lossy();
        files.push((format!("resources/{file_name}"), bytes));
    }
    let bytes = pack::archive(&files).map_err(|e| Error::Write {
        path: path.to_owned(),
        source: e.into(),
    })?;
    write_file(path, &bytes)
}
