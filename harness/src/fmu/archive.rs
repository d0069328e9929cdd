//! Unpacks a .fmu into a temporary folder and checks what must be in it.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use zip::ZipArchive;

use super::description::ModelDescription;
use super::parse_description::{Problem, parse};
use crate::error::Error;

/// FMI 2.0's name of the platform this program was built for.
pub(crate) const PLATFORM: &str = fmi_rs::fmi2::PLATFORM;

/// Unpacks `path`. The folder goes when the value is dropped.
pub(crate) fn unpack(path: &Path) -> Result<TempDir, Error> {
    let broken = |reason: String| Error::FmuArchive {
        path: path.to_owned(),
        reason,
    };
    let file = File::open(path).map_err(Error::read(path))?;
    if file.metadata().map_err(Error::read(path))?.is_dir() {
        return Err(broken("it is a folder".into()));
    }
    let mut archive = ZipArchive::new(file).map_err(|e| broken(e.to_string()))?;
    let folder = tempfile::Builder::new()
        .prefix("stickslip-fmu-")
        .tempdir()
        .map_err(Error::write(&std::env::temp_dir()))?;
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).map_err(|e| broken(e.to_string()))?;
        // An entry that points outside the folder is an attack or an accident; either way not a usable FMU.
        let inside = entry
            .enclosed_name()
            .ok_or_else(|| broken(format!("entry {i} has an unsafe path")))?;
        let target = folder.path().join(inside);
        if entry.is_dir() {
            fs::create_dir_all(&target).map_err(Error::write(&target))?;
            continue;
        }
        if let Some(parent) = target.parent() {
            fs::create_dir_all(parent).map_err(Error::write(parent))?;
        }
        let mut out = File::create(&target).map_err(Error::write(&target))?;
        io::copy(&mut entry, &mut out).map_err(|e| {
            broken(format!(
                "{}: {e}",
                target.file_name().unwrap_or_default().display()
            ))
        })?;
    }
    Ok(folder)
}

/// Name of the description inside the archive.
pub(crate) const DESCRIPTION: &str = "modelDescription.xml";

/// Every file below an unpacked FMU's folder, sorted by path but for the description, which comes first.
pub(crate) fn files(folder: &Path) -> Result<Vec<(String, Vec<u8>)>, Error> {
    let mut files = Vec::new();
    let mut folders = vec![(String::new(), folder.to_owned())];
    while let Some((prefix, folder)) = folders.pop() {
        for entry in fs::read_dir(&folder).map_err(Error::read(&folder))? {
            let path = entry.map_err(Error::read(&folder))?.path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let name = format!("{prefix}{name}");
            if path.is_dir() {
                folders.push((format!("{name}/"), path));
            } else {
                files.push((name, fs::read(&path).map_err(Error::read(&path))?));
            }
        }
    }
    files.sort_by(|a, b| (a.0 != DESCRIPTION, &a.0).cmp(&(b.0 != DESCRIPTION, &b.0)));
    Ok(files)
}

/// Reads the description in an unpacked FMU and returns it with its text.
pub(crate) fn describe(path: &Path, folder: &Path) -> Result<(ModelDescription, String), Error> {
    let broken = |problem: String| Error::FmuDescription {
        path: path.to_owned(),
        problem,
    };
    let xml = fs::read_to_string(folder.join(DESCRIPTION))
        .map_err(|_| broken("missing or not UTF-8 text; this is not an FMU".into()))?;
    let description = parse(&xml).map_err(|problem| match problem {
        Problem::Broken(what) => broken(what),
        Problem::NotCoSimulation => Error::NotCoSimulation {
            path: path.to_owned(),
        },
    })?;
    Ok((description, xml))
}

fn library(model_identifier: &str) -> String {
    format!("{model_identifier}{}", std::env::consts::DLL_SUFFIX)
}

/// Where the library for this platform lies in an unpacked FMU.
pub(crate) fn binary(folder: &Path, model_identifier: &str) -> PathBuf {
    let library = library(model_identifier);
    folder.join("binaries").join(PLATFORM).join(library)
}

/// Checks that there is a library for this platform.
pub(crate) fn check_binary(
    path: &Path,
    folder: &Path,
    model_identifier: &str,
) -> Result<(), Error> {
    if binary(folder, model_identifier).is_file() {
        return Ok(());
    }
    let binaries = folder.join("binaries");
    let mut present: Vec<String> = fs::read_dir(&binaries)
        .map(|entries| {
            entries
                .flatten()
                .map(|e| e.file_name().to_string_lossy().into_owned())
                .collect()
        })
        .unwrap_or_default();
    present.sort();
    Err(Error::FmuPlatform {
        path: path.to_owned(),
        platform: PLATFORM,
        library: library(model_identifier),
        present,
    })
}
