//! Libraries in ELF (System V gABI, chapters 4 and 5): what they need of the C library, and the same library without
//! what only debuggers read.

use std::cmp::max;
use std::fmt;

use object::build;
use object::build::elf::{Builder, SectionData};
use object::elf::SHF_ALLOC;
use object::read;
use object::read::elf::ElfFile64;

/// A version of the GNU C library.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Glibc(Vec<u32>);

impl Glibc {
    /// The version in the name of a symbol version, `GLIBC_2.17`.
    fn of_symbol_version(name: &[u8]) -> Option<Self> {
        let numbers = std::str::from_utf8(name).ok()?.strip_prefix("GLIBC_")?;
        let numbers: Result<_, _> = numbers.split('.').map(str::parse).collect();
        numbers.ok().map(Self)
    }
}

impl fmt::Display for Glibc {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let numbers: Vec<String> = self.0.iter().map(u32::to_string).collect();
        write!(f, "glibc {}", numbers.join("."))
    }
}

/// The file begins as ELF files do.
pub fn is_elf(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x7fELF")
}

/// The oldest version of the C library that a library of 64 bits runs with: the latest among the symbol versions that
/// it needs. `None` where it needs none.
///
/// # Errors
/// A file that is damaged.
pub fn glibc(bytes: &[u8]) -> read::Result<Option<Glibc>> {
    let file: ElfFile64 = ElfFile64::parse(bytes)?;
    let (endian, sections) = (file.endian(), file.elf_section_table());
    let Some((mut libraries, link)) = sections.gnu_verneed(endian, bytes)? else {
        return Ok(None);
    };
    let names = sections.strings(endian, bytes, link)?;
    let mut latest = None;
    while let Some((_, mut versions)) = libraries.next()? {
        while let Some(version) = versions.next()? {
            latest = max(
                latest,
                Glibc::of_symbol_version(version.name(endian, names)?),
            );
        }
    }
    Ok(latest)
}

/// The library without line tables and names of inner functions: all that is not loaded into memory, as `strip` does.
/// What is loaded stays where it is, byte by byte.
///
/// # Errors
/// A file that is damaged, or has a form that the writer does not know.
pub fn stripped(bytes: &[u8]) -> build::Result<Vec<u8>> {
    let mut library = Builder::read(bytes)?;
    for section in library.sections.iter_mut() {
        let loaded = section.sh_flags.0 & SHF_ALLOC.0 != 0;
        let names_sections = matches!(section.data, SectionData::SectionString);
        section.delete = !loaded && !names_sections;
    }
    for symbol in library.symbols.iter_mut() {
        symbol.delete = true;
    }
    library.delete_orphans();
    let mut out = Vec::new();
    library.write(&mut out)?;
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_ordered_by_their_numbers() {
        let version = |name: &str| Glibc::of_symbol_version(name.as_bytes());
        assert!(version("GLIBC_2.9") < version("GLIBC_2.17"));
        assert!(version("GLIBC_2.2.5") < version("GLIBC_2.14"));
        assert_eq!(version("GCC_3.0"), None);
        assert_eq!(version("GLIBC_PRIVATE"), None);
        assert_eq!(version("GLIBC_2.17").unwrap().to_string(), "glibc 2.17");
    }

    #[test]
    fn a_damaged_library_is_refused() {
        for length in [4, 20, 63] {
            let mut bytes = b"\x7fELF\x02\x01\x01".to_vec();
            bytes.resize(length, 0xff);
            assert!(stripped(&bytes).is_err());
            assert!(glibc(&bytes).is_err());
        }
    }
}
