//! Which format a file has: by its first bytes, and by its suffix where those say nothing.

use std::path::Path;

use super::Trouble;

/// The formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Csv,
    Mat5,
    Mat73,
    Hdf5,
    Uff,
    Wav,
    Parquet,
    Tdms,
}

impl Kind {
    pub fn words(self) -> &'static str {
        match self {
            Kind::Csv => "CSV",
            Kind::Mat5 => "MATLAB",
            Kind::Mat73 => "MATLAB 7.3",
            Kind::Hdf5 => "HDF5",
            Kind::Uff => "UFF",
            Kind::Wav => "WAV",
            Kind::Parquet => "Parquet",
            Kind::Tdms => "TDMS",
        }
    }
}

const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";

pub fn of(path: &Path, bytes: &[u8]) -> Result<Kind, Trouble> {
    let suffix = path.extension().unwrap_or_default().to_string_lossy();
    let suffix = suffix.to_lowercase();
    if bytes.is_empty() {
        return Err(Trouble::damaged("the file is empty"));
    }
    let begins = |with: &[u8]| bytes.starts_with(with);
    let is_matlab = begins(b"MATLAB");
    // A user block, as MATLAB writes it, shifts HDF5 by a power of two.
    let places = std::iter::successors(Some(512), |place| Some(2 * place)).take(4);
    if begins(HDF5) || places.clone().any(|at| bytes.get(at..at + 8) == Some(HDF5)) {
        return Ok(if is_matlab || suffix == "mat" {
            Kind::Mat73
        } else {
            Kind::Hdf5
        });
    }
    if is_matlab {
        return match bytes.get(124..128) {
            Some([_, 1, b'I', b'M'] | [1, _, b'M', b'I']) => Ok(Kind::Mat5),
            Some([_, 2, ..] | [2, ..]) => Err(Trouble::damaged(
                "a MATLAB 7.3 file whose HDF5 part is missing",
            )),
            _ => Err(Trouble::damaged("a MATLAB file whose head is not whole")),
        };
    }
    if begins(b"RIFF") && bytes.get(8..12) == Some(b"WAVE") {
        return Ok(Kind::Wav);
    }
    if begins(b"PAR1") {
        return Ok(Kind::Parquet);
    }
    if begins(b"TDSm") {
        return Ok(Kind::Tdms);
    }
    if is_uff(bytes) {
        return Ok(Kind::Uff);
    }
    let known = match suffix.as_str() {
        "h5" | "hdf5" | "hdf" | "he5" => Some("an HDF5"),
        "wav" | "wave" => Some("a WAV"),
        "parquet" => Some("a Parquet"),
        "tdms" => Some("a TDMS"),
        "uff" | "unv" | "u58" => Some("a UFF"),
        _ => None,
    };
    if let Some(known) = known {
        return Err(Trouble::damaged(format!(
            "begins with {}, which no {} file does",
            first_bytes(bytes),
            known.split(' ').next_back().unwrap_or(known)
        )));
    }
    match other(&suffix, bytes) {
        Some((what, remedy)) => Err(Trouble::new(format!("{what} can't be read"), remedy)),
        None => Ok(Kind::Csv),
    }
}

/// Formats that are known and not read: what it is, and what to do.
fn other(suffix: &str, bytes: &[u8]) -> Option<(&'static str, &'static str)> {
    Some(match suffix {
        "mat" => (
            "a file of MATLAB 4",
            "save it with `save -v7` in MATLAB, or by scipy.io.loadmat and savemat in Python",
        ),
        "mf4" | "mdf" => (
            "a measurement file of ASAM (MDF)",
            "convert it with two lines of Python: `from asammdf import MDF` and \
             `MDF(\"run.mf4\").export(\"csv\", filename=\"run.csv\")`",
        ),
        "tdm" => (
            "a TDM file of DIAdem",
            "save it as TDMS, or export it as CSV",
        ),
        "tdms_index" => ("the index of a TDMS file", "give the .tdms file itself"),
        "xls" | "xlsx" | "ods" => (
            "a spreadsheet",
            "save the sheet as CSV, or by two lines of Python: `import pandas` and \
             `pandas.read_excel(\"run.xlsx\").to_csv(\"run.csv\", index=False)`",
        ),
        "npy" | "npz" => (
            "an array of NumPy",
            "convert it with two lines of Python: `import numpy` and \
             `numpy.savetxt(\"run.csv\", numpy.load(\"run.npy\"), delimiter=\",\", header=\"t [s],x [m]\")`",
        ),
        "feather" | "arrow" | "ipc" => (
            "an Arrow file",
            "convert it with two lines of Python: `import pandas` and \
             `pandas.read_feather(\"run.feather\").to_parquet(\"run.parquet\")`",
        ),
        "gz" | "zip" | "bz2" | "xz" | "zst" | "7z" => {
            ("a compressed file", "unpack it and give what is in it")
        }
        _ if bytes.starts_with(b"PK\x03\x04") => (
            "a zip archive or a spreadsheet",
            "unpack it, or save the sheet as CSV",
        ),
        _ => return None,
    })
}

fn first_bytes(bytes: &[u8]) -> String {
    let shown: Vec<String> = bytes.iter().take(4).map(|b| format!("{b:02x}")).collect();
    format!("the bytes {}", shown.join(" "))
}

/// The first line that is not empty reads -1 in six places, the next one the number of a data set.
fn is_uff(bytes: &[u8]) -> bool {
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(400)]).into_owned();
    let mut lines = head.lines().skip_while(|line| line.trim().is_empty());
    let begins = lines.next().is_some_and(|line| line.trim_end() == "    -1");
    begins
        && lines.next().is_none_or(|line| {
            let number: String = line
                .trim()
                .chars()
                .take_while(char::is_ascii_digit)
                .collect();
            number.parse::<u32>().is_ok() || line.trim().is_empty()
        })
}
