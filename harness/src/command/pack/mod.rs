//! `stickslip pack`: writes StickSlipBeam.fmu from the library that was built with this program.
//!
//! The only place where the harness knows the FMU's crates.

mod documentation;

use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::error::Error;
use crate::fmu::{Fmu, ModelDescription, PLATFORM};
use crate::output::write_file;

/// Name of the file.
pub const FILE_NAME: &str = "StickSlipBeam.fmu";

/// Options of `pack`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// File to write
    #[arg(short, long, value_name = "FILE", default_value = FILE_NAME)]
    output: PathBuf,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    pack(&arguments.output)?;
    println!("Packed {}", arguments.output.display());
    Ok(())
}

/// Writes the FMU with its built-in start values.
pub fn pack(path: &Path) -> Result<(), Error> {
    write_fmu(path, beam_model_description::xml(), &[])
}

/// Writes an FMU with this description and these further files (path inside the archive, content).
///
/// The same content gives the same bytes: fixed order, fixed time stamps. Before the file appears at `path` it is loaded
/// and instantiated once, so that a library of another build is noticed here and not by the user's master.
pub fn write_fmu(path: &Path, xml: &str, resources: &[(&str, &[u8])]) -> Result<(), Error> {
    let library = find_library()?;
    let library = std::fs::read(&library).map_err(Error::read(&library))?;
    let binary = format!(
        "binaries/{PLATFORM}/{}{}",
        beam_model_description::MODEL_IDENTIFIER,
        std::env::consts::DLL_SUFFIX
    );
    let description = ModelDescription::parse(xml).map_err(|problem| Error::FmuDescription {
        path: path.to_owned(),
        problem,
    })?;
    let index = documentation::index(&description);
    let mut files: Vec<(&str, &[u8])> = vec![
        ("modelDescription.xml", xml.as_bytes()),
        (&binary, &library),
        ("documentation/index.html", index.as_bytes()),
        (
            "documentation/licenses/license.txt",
            include_bytes!("license.txt"),
        ),
    ];
    files.extend(resources);
    let bytes = archive(&files).map_err(|e| Error::Write {
        path: path.to_owned(),
        source: e.into(),
    })?;
    try_out(&bytes)?;
    write_file(path, &bytes)
}

/// FMI 2.0 wants plain zip: deflate, no zip64, forward slashes.
fn archive(files: &[(&str, &[u8])]) -> zip::result::ZipResult<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    for (name, bytes) in files {
        let permissions = if name.starts_with("binaries/") {
            0o755
        } else {
            0o644
        };
        zip.start_file(*name, options.unix_permissions(permissions))?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn try_out(bytes: &[u8]) -> Result<(), Error> {
    let folder = tempfile::tempdir().map_err(Error::write(&std::env::temp_dir()))?;
    let path = folder.path().join(FILE_NAME);
    std::fs::write(&path, bytes).map_err(Error::write(&path))?;
    Fmu::load(&path)?.instantiate("pack").map(drop)
}

/// The FMU's library: cargo puts it into `deps/` beside the program, and beside it.
fn find_library() -> Result<PathBuf, Error> {
    let name = format!(
        "{}beam_fmu{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    );
    let program = std::env::current_exe().map_err(Error::read(Path::new("the running program")))?;
    let folder = program.parent().unwrap_or(Path::new("."));
    // deps/ first: it is written by every build, the copy beside the program only by builds of the whole.
    let places = [folder.join("deps").join(&name), folder.join(&name)];
    let missing = || Error::NoBinaryToPack {
        library: name,
        searched: program.clone(),
    };
    places.into_iter().find(|p| p.is_file()).ok_or_else(missing)
}
