//! Builds the foreign FMU of `probe.c` with the system's C compiler.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use stickslip::fmu::PLATFORM;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;

const XML: &str = include_str!("modelDescription.xml");

/// A folder with an FMU in it; both go when it is dropped.
pub struct Probe {
    folder: TempDir,
    library: Vec<u8>,
}

impl Probe {
    /// Compiles the library.
    pub fn new() -> Probe {
        let folder = tempfile::tempdir().unwrap();
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/probe/probe.c");
        let library = folder.path().join("probe.so");
        let status = Command::new("cc")
            .args(["-shared", "-fPIC", "-O2", "-o"])
            .arg(&library)
            .arg(source)
            .arg("-lm")
            .status();
        assert!(status.expect("a C compiler named cc").success());
        let library = std::fs::read(library).unwrap();
        Probe { folder, library }
    }

    /// The FMU as it should be.
    pub fn fmu(&self) -> PathBuf {
        self.with_xml(|xml| xml)
    }

    /// The FMU with another description.
    pub fn with_xml(&self, change: impl Fn(String) -> String) -> PathBuf {
        let binary = format!("binaries/{PLATFORM}/probe.so");
        self.zip(&[
            ("modelDescription.xml", change(XML.to_owned()).as_bytes()),
            (&binary, &self.library),
        ])
    }

    /// An FMU of just these files.
    pub fn zip(&self, files: &[(&str, &[u8])]) -> PathBuf {
        let path = self.folder.path().join("probe.fmu");
        let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
        for (name, bytes) in files {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
        path
    }
}
