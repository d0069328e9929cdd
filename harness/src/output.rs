//! Writing files whole: beside the target first, then renamed, so that nothing is ever left half-written.

use std::io::Write as _;
use std::path::Path;

use crate::error::Error;

/// Makes a folder and its parents.
pub fn make_folder(path: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(path).map_err(Error::write(path))
}

/// Writes `bytes` to `path`, all or nothing.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let attempt = || {
        // The temporary file removes itself if anything below fails.
        let mut file = tempfile::Builder::new()
            .prefix(".stickslip-")
            .tempfile_in(folder)?;
        file.write_all(bytes)?;
        make_readable(file.as_file())?;
        file.persist(path).map_err(|e| e.error).map(drop)
    };
    attempt().map_err(Error::write(path))
}

/// Temporary files are private to their user; results are for everyone the folder lets in.
#[cfg(unix)]
fn make_readable(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn make_readable(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::write_file;

    #[test]
    fn a_folder_that_cannot_be_written_is_named_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        write_file(&file, b"x").unwrap();
        let inside_a_file = file.join("report.html");
        let error = write_file(&inside_a_file, b"y").unwrap_err();
        assert!(error.to_string().contains("report.html"), "{error}");
        assert_eq!(error.exit_code(), 4);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
