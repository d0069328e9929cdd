//! Builds foreign FMUs with the system's C compiler: `probe.c`, and `mass_on_belt.c` with its side file.
#![allow(dead_code)]

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use stickslip::fmu::PLATFORM;
use tempfile::TempDir;
use zip::write::SimpleFileOptions;

/// A folder with an FMU in it; both go when it is dropped.
pub struct Foreign {
    name: &'static str,
    folder: TempDir,
    xml: String,
    library: Vec<u8>,
}

impl Foreign {
    /// Compiles the library of `<name>.c`.
    pub fn new(name: &'static str) -> Foreign {
        let folder = tempfile::tempdir().unwrap();
        let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/foreign");
        let library = folder.path().join("library.so");
        let status = Command::new("cc")
            .args(["-shared", "-fPIC", "-O2", "-o"])
            .arg(&library)
            .arg(sources.join(format!("{name}.c")))
            .arg("-lm")
            .status();
        assert!(status.expect("a C compiler named cc").success());
        let library = std::fs::read(library).unwrap();
        let xml = std::fs::read_to_string(sources.join(format!("{name}.xml"))).unwrap();
        Foreign {
            name,
            folder,
            xml,
            library,
        }
    }

    /// The FMU as it should be.
    pub fn fmu(&self) -> PathBuf {
        self.with_xml(|xml| xml)
    }

    /// The FMU with another description.
    pub fn with_xml(&self, change: impl Fn(String) -> String) -> PathBuf {
        let binary = format!("binaries/{PLATFORM}/{}.so", self.name);
        self.zip(&[
            ("modelDescription.xml", change(self.xml.clone()).as_bytes()),
            (&binary, &self.library),
        ])
    }

    /// An FMU of just these files.
    pub fn zip(&self, files: &[(&str, &[u8])]) -> PathBuf {
        let path = self.folder.path().join(format!("{}.fmu", self.name));
        let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
        for (name, bytes) in files {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
        path
    }
}
