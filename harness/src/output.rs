//! Writing files whole (beside the target first, then renamed, so that nothing is ever left half-written), and printing.

use std::io::Write as _;
use std::path::Path;

use crate::error::Error;

/// Makes a folder and its parents.
pub fn make_folder(path: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(path).map_err(Error::write(path))
}

/// Writes `bytes` to `path`, all or nothing. What is there and is no file (a device, a pipe) is written to, not replaced.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Error> {
    if std::fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir()) {
        return std::fs::write(path, bytes).map_err(Error::write(path));
    }
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

/// Prints to standard output.
///
/// # Errors
/// [`Error::Print`]: a disk that is full, or a reader that has gone.
pub fn print(text: &str) -> Result<(), Error> {
    let mut out = std::io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    written.map_err(|source| Error::Print { source })
}

/// Prints a line to standard output.
///
/// # Errors
/// As [`print`].
pub fn print_line(text: impl std::fmt::Display) -> Result<(), Error> {
    print(&format!("{text}\n"))
}

/// Tells on standard error what is not part of the result. Nobody may be listening there: that is no error.
pub fn tell(text: impl std::fmt::Display) {
    let _ = writeln!(std::io::stderr(), "{text}");
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

    #[cfg(unix)]
    #[test]
    fn what_is_no_file_is_written_to_and_not_replaced() {
        use std::os::unix::fs::FileTypeExt as _;
        // A socket in a folder of its own: as safe to lose as a device is not.
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        assert_eq!(write_file(&socket, b"x").unwrap_err().exit_code(), 4);
        let there = std::fs::metadata(&socket).unwrap();
        assert!(there.file_type().is_socket());
    }

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
