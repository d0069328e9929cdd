//! `stickslip pack`: writes StickSlipBeam.fmu from the library that was built with this program, with effects of
//! the user's own if they are given.
//!
//! The only place where the harness knows the FMU's crates.

pub mod belt_drive;
mod contents;
mod documentation;
mod elf;
pub mod own_effects;
mod platforms;
pub mod widened;

use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use beam_model_description::{Layout, MODEL_IDENTIFIER, StartValueError};
use clap::Args;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use self::platforms::Binaries;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::output::{print_line, write_file};

/// Name of the file.
pub const FILE_NAME: &str = "StickSlipBeam.fmu";

/// Options of `pack`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// File to write
    #[arg(short, long, value_name = "FILE", default_value = FILE_NAME)]
    output: PathBuf,
    /// Effect of your own to be put in, a TOML file; may be repeated
    #[arg(long = "effect", value_name = "FILE")]
    effects: Vec<PathBuf>,
    /// Folder with a binary for each platform, as fmu-src/platforms.sh fills it; without, that of this build alone
    #[arg(long, value_name = "FOLDER")]
    binaries: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let binaries = match &arguments.binaries {
        Some(folder) => Binaries::of_folder(folder)?,
        None => Binaries::of_this_build()?,
    };
    pack_binaries(&arguments.output, &arguments.effects, &binaries)?;
    print_line(format_args!("Packed {}", arguments.output.display()))?;
    for line in binaries.needs()? {
        print_line(format_args!("    {line}"))?;
    }
    Ok(())
}

/// Writes the FMU with its built-in start values.
///
/// # Errors
/// No library beside this program, or a file that can't be written.
pub fn pack(path: &Path) -> Result<(), Error> {
    pack_with(path, &[])
}

/// Writes the FMU with the users' effects that these files describe.
///
/// # Errors
/// As [`pack`]; an effect that can't be used.
pub fn pack_with(path: &Path, effects: &[PathBuf]) -> Result<(), Error> {
    pack_binaries(path, effects, &Binaries::of_this_build()?)
}

fn pack_binaries(path: &Path, effects: &[PathBuf], binaries: &Binaries) -> Result<(), Error> {
    let layout = own_effects::layout(effects)?;
    let none: [(&str, f64); 0] = [];
    let (xml, starts) = describe(layout, &none).map_err(|e| Error::StartValues {
        problem: e.to_string(),
    })?;
    let mut files = vec![(DESCRIPTION.to_owned(), xml.clone().into_bytes())];
    files.extend(binaries.entries(MODEL_IDENTIFIER));
    files.push((START_VALUES.to_owned(), starts.into_bytes()));
    files.extend(own_effects::files(layout));
    files.extend(contents::fixed());
    contents::follow_description(path, &xml, &mut files)?;
    write_with_results(path, files)
}

/// modelDescription.xml of these variables with other start values, and the file of start values that goes with it.
fn describe(
    layout: &Layout,
    starts: &[(impl AsRef<str>, f64)],
) -> Result<(String, String), StartValueError> {
    let (xml, guid) = layout.xml_with_starts(starts)?;
    let starts = layout.start_values_toml(starts, &guid)?;
    Ok((xml, starts))
}

/// Adds reference results to the files of an FMU of this model, and writes it.
///
/// # Errors
/// As [`write_fmu`].
fn write_with_results(path: &Path, mut files: Vec<contents::Entry>) -> Result<(), Error> {
    let bytes = archive(&files).map_err(|e| Error::Write {
        path: path.to_owned(),
        source: e.into(),
    })?;
    // A model that can't run with its start values (a user's formula, extreme values) is an FMU all the same.
    if let Ok(results) = contents::reference_results(&load_bytes(&bytes)?) {
        files.extend(results);
    }
    write_fmu(path, &files)
}

/// Brings everything that follows from the description up to date, reference results included, and writes an FMU of
/// this model.
///
/// # Errors
/// A description that can't be read; as [`write_fmu`].
pub fn write_changed(path: &Path, xml: &str, mut files: Vec<contents::Entry>) -> Result<(), Error> {
    contents::follow_description(path, xml, &mut files)?;
    write_with_results(path, files)
}

/// Where the description lies in the archive.
pub const DESCRIPTION: &str = "modelDescription.xml";
/// Where an FMU of this project has its start values.
pub const START_VALUES: &str = "resources/start_values.toml";

/// Writes an FMU of these files (path inside the archive, content).
///
/// The same content gives the same bytes: fixed order, fixed time stamps. Before the file appears at `path` it is loaded
/// and instantiated once, so that a library of another build is noticed here and not by the user's master.
///
/// # Errors
/// An FMU that can't be instantiated, or a file that can't be written.
pub fn write_fmu(path: &Path, files: &[(String, Vec<u8>)]) -> Result<(), Error> {
    let bytes = archive(files).map_err(|e| Error::Write {
        path: path.to_owned(),
        source: e.into(),
    })?;
    try_out(&bytes)?;
    write_file(path, &bytes)
}

/// A zip archive of these files. FMI 2.0 and SSP 1.0 want plain zip: deflate, no zip64, forward slashes.
///
/// # Errors
/// None in memory, but for files too large for plain zip.
pub fn archive(files: &[(String, Vec<u8>)]) -> zip::result::ZipResult<Vec<u8>> {
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
        zip.start_file(name.as_str(), options.unix_permissions(permissions))?;
        zip.write_all(bytes)?;
    }
    Ok(zip.finish()?.into_inner())
}

fn try_out(bytes: &[u8]) -> Result<(), Error> {
    load_bytes(bytes)?.instantiate("pack").map(drop)
}

/// The FMU of an archive that no file holds yet.
fn load_bytes(bytes: &[u8]) -> Result<Fmu, Error> {
    let folder = tempfile::tempdir().map_err(Error::write(&std::env::temp_dir()))?;
    let path = folder.path().join(FILE_NAME);
    std::fs::write(&path, bytes).map_err(Error::write(&path))?;
    Fmu::load(&path)
}

/// The FMU's library: cargo puts it into `deps/` beside the program, and beside it.
pub(crate) fn find_library() -> Result<PathBuf, Error> {
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
