//! Folders that are written whole: beside their place first, then renamed.

use std::path::Path;

use crate::error::Error;
use crate::output::{make_folder, write_file};

/// A folder that can be written: it is not there, or is empty.
///
/// # Errors
/// [`Error::NotEmpty`] with what is there.
pub fn must_be_free(folder: &Path) -> Result<(), Error> {
    let not_empty = |found: String| {
        Err(Error::NotEmpty {
            path: folder.to_owned(),
            found,
        })
    };
    if !folder.exists() {
        return Ok(());
    }
    if !folder.is_dir() {
        return not_empty("a file of this name".into());
    }
    let mut entries = std::fs::read_dir(folder).map_err(Error::read(folder))?;
    match entries.next() {
        None => Ok(()),
        Some(Err(error)) => Err(Error::read(folder)(error)),
        Some(Ok(entry)) => not_empty(format!("'{}' in it", entry.file_name().display())),
    }
}

/// Writes files into a new folder, all or nothing: `accept` looks at the whole before it gets its name.
///
/// # Errors
/// What [`must_be_free`] or `accept` finds, or a failed write.
pub fn write(
    folder: &Path,
    files: &[(String, Vec<u8>)],
    accept: impl FnOnce(&Path) -> Result<(), Error>,
) -> Result<(), Error> {
    must_be_free(folder)?;
    let above = folder
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    make_folder(above)?;
    // Removes itself if anything below fails.
    let beside = tempfile::Builder::new()
        .prefix(".stickslip-")
        .tempdir_in(above)
        .map_err(Error::write(folder))?;
    let whole = beside.path().join("campaign");
    make_folder(&whole)?;
    for (name, bytes) in files {
        write_file(&whole.join(name), bytes)?;
    }
    accept(&whole)?;
    if folder.is_dir() {
        std::fs::remove_dir(folder).map_err(Error::write(folder))?;
    }
    std::fs::rename(&whole, folder).map_err(Error::write(folder))
}
