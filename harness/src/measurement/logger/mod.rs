//! Files of data loggers in the formats that they write, as channels with names, units and times.
//!
//! Each format has a file of its own and knows nothing of the others; `choice` says which channel is what.

mod channel_search;
mod channel_times;
mod channel_values;
mod choice;
mod csv;
mod cursor;
mod hdf5;
mod kind;
mod mat5;
mod names;
mod parquet;
mod role;
mod samples;
mod tdms;
mod uff;
mod wav;

use std::path::{Path, PathBuf};

pub use choice::{Imported, Input, Source, Wanted};

use super::unit::Unit;
use crate::error::Error;

/// A file's content.
#[derive(Debug)]
pub struct Recording {
    /// The file.
    pub path: PathBuf,
    /// Its format, in words.
    pub format: &'static str,
    /// What was recorded, in the file's order.
    pub channels: Vec<Channel>,
    /// Single numbers: sample rates, gains.
    scalars: Vec<(String, f64)>,
    /// What is in the file and is no channel, in words.
    pub remarks: Vec<String>,
}

/// One recorded signal.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Its name, with the groups that it is in before it: `group/name`. The unit is not part of it.
    pub name: String,
    /// As the file has it.
    unit: Option<Unit>,
    /// A unit that no table knows, as the file has it.
    strange_unit: Option<String>,
    /// What it measures where the file says so and gives no unit: a word such as `an acceleration`.
    kind: Option<&'static str>,
    /// Start in s and samples per second, where the file has no times but these.
    pub even: Option<(f64, f64)>,
    /// Samples in the file's unit; NaN where there is none.
    values: Result<Vec<f64>, Trouble>,
}

impl Channel {
    fn new(name: &str, values: Vec<f64>) -> Channel {
        let (name, unit, strange_unit) = names::taken_apart(name);
        Channel {
            name,
            unit,
            strange_unit,
            kind: None,
            even: None,
            values: Ok(values),
        }
    }

    /// States the unit that a property of the file has; a unit in the name goes before it.
    fn with_unit(mut self, text: &str) -> Channel {
        if self.unit.is_none() && self.strange_unit.is_none() {
            (self.unit, self.strange_unit) = names::unit_of(text);
        }
        self
    }

    /// Its unit as the file writes it, or nothing.
    pub fn unit(&self) -> &str {
        let strange = self.strange_unit.as_deref();
        self.unit.map_or(strange.unwrap_or(""), |unit| unit.symbol)
    }

    /// Samples; none where they can't be read.
    pub fn samples(&self) -> &[f64] {
        self.values.as_deref().unwrap_or_default()
    }

    /// Why its samples can't be read, where they can't.
    pub fn problem(&self) -> Option<String> {
        self.values.as_ref().err().map(|t| t.problem.clone())
    }

    /// The name without its groups.
    fn last_name(&self) -> &str {
        self.name.rsplit('/').next().unwrap_or(&self.name)
    }
}

impl Recording {
    /// Single numbers in the file: sample rates, gains.
    pub fn scalars(&self) -> &[(String, f64)] {
        &self.scalars
    }
}

/// Whether a text is a unit known.
pub fn is_unit(text: &str) -> bool {
    names::find(text).is_some()
}

/// What is wrong with a file or one of its channels.
#[derive(Debug, Clone)]
struct Trouble {
    channel: Option<String>,
    problem: String,
    remedy: String,
}

const DAMAGED: &str = "the file is cut off or damaged; copy it again or export it anew";

impl Trouble {
    /// The file does not hold what it says.
    fn damaged(problem: impl Into<String>) -> Trouble {
        Trouble::new(problem, DAMAGED)
    }

    fn new(problem: impl Into<String>, remedy: impl Into<String>) -> Trouble {
        Trouble {
            channel: None,
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    fn of(mut self, channel: &str) -> Trouble {
        self.channel.get_or_insert_with(|| channel.to_owned());
        self
    }

    fn at(self, path: &Path) -> Error {
        Error::LoggerFile {
            path: path.to_owned(),
            channel: self.channel,
            problem: self.problem,
            remedy: self.remedy,
        }
    }
}

/// Channels, single numbers and remarks, as a format's reader returns them.
#[derive(Default)]
struct Found {
    channels: Vec<Channel>,
    scalars: Vec<(String, f64)>,
    remarks: Vec<String>,
}

/// Reads a file in any of the formats known, which is told by its content.
///
/// # Errors
/// [`Error`] with what was read and what to do, where the file is cut off, damaged or of another format.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let bytes = std::fs::read(path).map_err(Error::read(path))?;
    let kind = kind::of(path, &bytes).map_err(|trouble| trouble.at(path))?;
    let found = match kind {
        kind::Kind::Csv => return csv::read(path),
        kind::Kind::Mat5 => mat5::read(&bytes),
        kind::Kind::Hdf5 | kind::Kind::Mat73 => guarded(|| hdf5::read(bytes)),
        kind::Kind::Uff => uff::read(&bytes),
        kind::Kind::Wav => guarded(|| wav::read(&bytes)),
        kind::Kind::Parquet => guarded(|| parquet::read(bytes)),
        kind::Kind::Tdms => tdms::read(&bytes),
    };
    let mut found = found.map_err(|trouble| trouble.at(path))?;
    if found.channels.is_empty() {
        let remarks = match found.remarks.as_slice() {
            [] => String::new(),
            remarks => format!(" ({})", remarks.join("; ")),
        };
        return Err(Trouble::new(
            format!(
                "no channel of numbers in this {} file{remarks}",
                kind.words()
            ),
            "save each channel as an array of numbers",
        )
        .at(path));
    }
    names::make_unlike(&mut found.channels);
    Ok(Recording {
        path: path.to_owned(),
        format: kind.words(),
        channels: found.channels,
        scalars: found.scalars,
        remarks: found.remarks,
    })
}

/// Runs a reader that is not of this project: a panic in it, on a damaged file, is an error like others.
fn guarded(read: impl FnOnce() -> Result<Found, Trouble>) -> Result<Found, Trouble> {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(|_| {}));
    let end = std::panic::catch_unwind(std::panic::AssertUnwindSafe(read));
    std::panic::set_hook(usual);
    end.unwrap_or_else(|_| {
        Err(Trouble::damaged(
            "the content contradicts itself and can't be read",
        ))
    })
}
