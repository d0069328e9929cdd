//! The binaries of an archive: that of this build, or one for each platform from a folder that
//! `fmu-src/platforms.sh` has filled. What only debuggers read is left out; it stays in the library packed.

use std::path::{Path, PathBuf};

use super::contents::Entry;
use super::{elf, find_library};
use crate::error::Error;
use crate::file_kind::{Wanted, explain};
use crate::fmu::PLATFORM;

/// A platform: its name in FMI 2.0.5 (section 2.3), the library there, and how files for it begin.
struct Platform {
    name: &'static str,
    library: &'static str,
    suffix: &'static str,
    is_one: fn(&[u8]) -> bool,
}

/// Processor of an ELF file (gABI, e_machine).
fn elf_machine(bytes: &[u8]) -> Option<u16> {
    let low: [u8; 2] = bytes.get(18..20)?.try_into().ok()?;
    bytes
        .starts_with(b"\x7fELF")
        .then(|| u16::from_le_bytes(low))
}

const PLATFORMS: [Platform; 3] = [
    Platform {
        name: "linux64",
        library: "libbeam_fmu.so",
        suffix: ".so",
        is_one: |bytes| elf_machine(bytes) == Some(62),
    },
    Platform {
        name: "aarch64-linux",
        library: "libbeam_fmu.so",
        suffix: ".so",
        is_one: |bytes| elf_machine(bytes) == Some(183),
    },
    Platform {
        name: "win64",
        library: "beam_fmu.dll",
        suffix: ".dll",
        is_one: |bytes| bytes.starts_with(b"MZ"),
    },
];

/// The binaries, each with its platform and the suffix of its name.
pub struct Binaries(Vec<(String, &'static str, Vec<u8>)>);

impl Binaries {
    /// That of this build alone.
    ///
    /// # Errors
    /// No library beside this program.
    pub fn of_this_build() -> Result<Self, Error> {
        let library = find_library()?;
        let bytes = std::fs::read(&library).map_err(Error::read(&library))?;
        let suffix = std::env::consts::DLL_SUFFIX;
        let lean = lean(&library, bytes)?;
        Ok(Self(vec![(PLATFORM.to_owned(), suffix, lean)]))
    }

    /// All that lie in `folder`, as `<platform>/<library>`. This platform's must be among them, because an archive
    /// is tried out before it is written.
    ///
    /// # Errors
    /// A folder that can't be read, a file that is not for its platform, none for this one.
    pub fn of_folder(folder: &Path) -> Result<Self, Error> {
        std::fs::read_dir(folder)
            .map_err(Error::read(folder))
            .map_err(|error| explain(error, folder, Wanted::Binaries))?;
        let mut found = Vec::new();
        for platform in &PLATFORMS {
            let path = folder.join(platform.name).join(platform.library);
            if !path.exists() {
                continue;
            }
            let bytes = std::fs::read(&path).map_err(Error::read(&path))?;
            if !(platform.is_one)(&bytes) {
                return Err(wrong(path, format!("is no library for {}", platform.name)));
            }
            let lean = lean(&path, bytes)?;
            found.push((platform.name.to_owned(), platform.suffix, lean));
        }
        if !found.iter().any(|(name, ..)| name == PLATFORM) {
            let problem = format!("holds no library for this platform, {PLATFORM}");
            return Err(wrong(folder.to_owned(), problem));
        }
        Ok(Self(found))
    }

    /// What each binary needs of the machine that it runs on, one line each.
    ///
    /// # Errors
    /// A library that is damaged.
    pub fn needs(&self) -> Result<Vec<String>, Error> {
        self.0
            .iter()
            .map(|(platform, suffix, bytes)| {
                if !elf::is_elf(bytes) {
                    return Ok(format!("{platform}: needs nothing beside the system's own"));
                }
                let place = || PathBuf::from(format!("the {suffix} for {platform}"));
                let version = elf::glibc(bytes).map_err(|e| damaged(place(), &e))?;
                Ok(match version {
                    Some(version) => format!("{platform}: needs {version} or newer"),
                    None => format!("{platform}: needs no glibc"),
                })
            })
            .collect()
    }

    /// The places of the binaries in the archive of a model with this identifier.
    pub fn entries(&self, identifier: &str) -> Vec<Entry> {
        self.0
            .iter()
            .map(|(platform, suffix, bytes)| {
                let name = format!("binaries/{platform}/{identifier}{suffix}");
                (name, bytes.clone())
            })
            .collect()
    }
}

/// The library without what only debuggers read. Of the platforms packed, only ELF files have it inside.
fn lean(path: &Path, bytes: Vec<u8>) -> Result<Vec<u8>, Error> {
    if !elf::is_elf(&bytes) {
        return Ok(bytes);
    }
    elf::stripped(&bytes).map_err(|e| damaged(path.to_owned(), &e))
}

fn damaged(path: PathBuf, cause: &dyn std::fmt::Display) -> Error {
    wrong(path, format!("is a damaged library ({cause})"))
}

fn wrong(path: PathBuf, problem: String) -> Error {
    Error::Binaries { path, problem }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_is_stripped_and_says_what_it_needs() {
        let whole = std::fs::read(find_library().unwrap()).unwrap();
        let binaries = Binaries::of_this_build().unwrap();
        let [(_, _, packed)] = &binaries.0[..] else {
            panic!("one platform");
        };
        let needs = binaries.needs().unwrap();
        assert!(needs[0].starts_with(PLATFORM), "{needs:?}");
        if elf::is_elf(&whole) {
            // 22 MB with line tables and 6 MB with names alone, if the build made them; 3.9 MB without.
            assert!(packed.len() < whole.len(), "{}", packed.len());
            assert!(packed.len() < 4_500_000, "{}", packed.len());
            assert_eq!(elf::glibc(packed), elf::glibc(&whole));
            let again = elf::stripped(packed).unwrap();
            assert!(again == *packed, "nothing more to leave out");
        }
    }

    #[test]
    fn a_library_in_the_wrong_folder_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("win64");
        std::fs::create_dir(&place).unwrap();
        std::fs::write(place.join("beam_fmu.dll"), b"\x7fELF").unwrap();
        let error = Binaries::of_folder(folder.path()).err().unwrap();
        assert!(error.to_string().contains("is no library for win64"));
        std::fs::write(place.join("beam_fmu.dll"), b"MZ").unwrap();
        let error = Binaries::of_folder(folder.path()).err().unwrap();
        assert!(error.to_string().contains(PLATFORM), "{error}");
    }
}
