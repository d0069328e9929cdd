//! Where a result comes from: version, date, command line and a digest of the inputs, for every report and JSON.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use time::OffsetDateTime;

use crate::error::Error;
use crate::fmu::{Fmu, SideFile};
use crate::measurement::Campaign;

thread_local! {
    /// The command line that this thread's work stands for, where it is not the process's own.
    static STANDS_FOR: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Does work on behalf of a command line, the program's name first: results of this thread name it
/// in place of the process's own. For programs that call the library.
pub fn on_behalf_of<R>(line: Option<Vec<String>>, work: impl FnOnce() -> R) -> R {
    /// Puts back what was, also where the work panics.
    struct Before(Option<Vec<String>>);
    impl Drop for Before {
        fn drop(&mut self) {
            STANDS_FOR.set(self.0.take());
        }
    }
    let _before = Before(STANDS_FOR.replace(line));
    work()
}

/// The command line that this thread works on behalf of, for threads that it starts.
pub fn stands_for() -> Option<Vec<String>> {
    STANDS_FOR.with_borrow(Clone::clone)
}

/// What is needed to say which result this is, and to make it anew.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// When the result was written: UTC, as in 2026-01-31T12:00:00Z. `SOURCE_DATE_EPOCH` (s since 1970) fixes it.
    pub date: String,
    /// The command line.
    pub command_line: String,
    /// Digest of all inputs, in hexadecimal: SHA-256 of their digests one after another.
    pub inputs_sha256: String,
    /// The files read.
    pub inputs: Vec<Input>,
}

/// One file that was read.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Input {
    /// Its path as given.
    pub file: PathBuf,
    /// Size, bytes.
    pub bytes: usize,
    /// SHA-256 in hexadecimal.
    pub sha256: String,
    /// How it was read, where it is not plain comma-separated values in SI units.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub understood: Option<String>,
}

/// A result with its provenance as one more key.
#[derive(Serialize)]
struct Stamped<'a, T> {
    #[serde(flatten)]
    result: &'a T,
    provenance: &'a Provenance,
}

impl Provenance {
    /// Of a result that rests on these files.
    ///
    /// # Errors
    /// A file that can't be read.
    pub fn of(files: &[&Path]) -> Result<Provenance, Error> {
        let inputs = files
            .iter()
            .map(|file| {
                let content = std::fs::read(file).map_err(Error::read(file))?;
                Ok(Input {
                    file: file.to_path_buf(),
                    bytes: content.len(),
                    sha256: hexadecimal(&Sha256::digest(&content)),
                    understood: None,
                })
            })
            .collect::<Result<Vec<_>, Error>>()?;
        let mut all = Sha256::new();
        for input in &inputs {
            all.update(&input.sha256);
        }
        Ok(Provenance {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            date: date(),
            command_line: match stands_for() {
                Some(line) => command_line(line.into_iter()),
                None => command_line(std::env::args()),
            },
            inputs_sha256: hexadecimal(&all.finalize()),
            inputs,
        })
    }

    /// Of a result that rests on a campaign's runs and on an FMU, if that is a file of its own; the FMU of this program is
    /// known by the version. The campaign's own file is among the inputs where it has its usual name.
    ///
    /// # Errors
    /// A file that can't be read.
    pub fn of_campaign(campaign: &Campaign, fmu: Option<&Fmu>) -> Result<Provenance, Error> {
        let toml = campaign.folder.join("campaign.toml");
        let runs = campaign.runs.iter().map(|run| run.file.as_path());
        let side = fmu.and_then(Fmu::side_file).map(SideFile::path);
        let of_fmu = fmu.map(Fmu::path).into_iter().chain(side);
        let optional = std::iter::once(toml.as_path()).chain(of_fmu);
        let optional = optional.filter(|f| f.is_file());
        let of_sensors = campaign.runs.iter().flat_map(|run| &run.further_files);
        let others = optional.chain(of_sensors.map(PathBuf::as_path));
        let mut provenance = Provenance::of(&runs.chain(others).collect::<Vec<_>>())?;
        // The runs come first.
        for (input, run) in provenance.inputs.iter_mut().zip(&campaign.runs) {
            input.understood.clone_from(&run.understood);
        }
        Ok(provenance)
    }

    /// The JSON text of a result, with this as its key `provenance`.
    pub fn json(&self, result: &impl Serialize) -> String {
        let stamped = Stamped {
            result,
            provenance: self,
        };
        serde_json::to_string_pretty(&stamped).expect("numbers and texts have a JSON form")
    }

    /// The lines for a report's foot: name and value.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = vec![
            ("Made by", format!("stickslip {}", self.version)),
            ("Date", self.date.clone()),
            ("Command", self.command_line.clone()),
            ("Inputs, SHA-256", self.inputs_sha256.clone()),
        ];
        let file = |i: &Input| {
            let understood = i.understood.iter().map(|how| format!(", {how}"));
            let understood: String = understood.collect();
            (
                "Input",
                format!(
                    "{} ({} bytes) {}{understood}",
                    i.file.display(),
                    i.bytes,
                    i.sha256
                ),
            )
        };
        lines.extend(self.inputs.iter().map(file));
        lines
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

/// Now, or the time that the build environment fixes for results that can be repeated bit by bit.
fn date() -> String {
    let fixed = std::env::var("SOURCE_DATE_EPOCH")
        .ok()
        .and_then(|seconds| seconds.parse().ok())
        .and_then(|seconds| OffsetDateTime::from_unix_timestamp(seconds).ok());
    let now = fixed.unwrap_or_else(OffsetDateTime::now_utc);
    let (hour, minute, second) = now.to_hms();
    format!("{}T{hour:02}:{minute:02}:{second:02}Z", now.date())
}

/// The command line as a shell would take it; the program by its name alone.
fn command_line(arguments: impl Iterator<Item = String>) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,@+%".contains(c);
    let quoted = |text: String| {
        if !text.is_empty() && text.chars().all(plain) {
            text
        } else {
            format!("'{}'", text.replace('\'', r"'\''"))
        }
    };
    std::iter::once("stickslip".to_owned())
        .chain(arguments.skip(1).map(quoted))
        .collect::<Vec<_>>()
        .join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_digests_are_those_of_the_standard() {
        // FIPS 180-4's example: SHA-256 of "abc".
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("run.csv");
        std::fs::write(&file, "abc").unwrap();
        let found = Provenance::of(&[&file]).unwrap();
        let digest = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(found.inputs[0].sha256, digest);
        assert_eq!(found.inputs[0].bytes, 3);
        std::fs::write(&file, "abd").unwrap();
        let other = Provenance::of(&[&file]).unwrap();
        assert_ne!(found.inputs_sha256, other.inputs_sha256);
    }

    #[test]
    fn a_command_line_can_be_given_to_a_shell() {
        let line = [
            "/usr/bin/stickslip",
            "compare",
            "my rig",
            "--fmu",
            "it's.fmu",
            "",
        ];
        assert_eq!(
            command_line(line.iter().map(|a| (*a).to_owned())),
            r"stickslip compare 'my rig' --fmu 'it'\''s.fmu' ''"
        );
    }

    #[test]
    fn a_result_names_the_command_line_that_it_stands_for() {
        let line = ["stickslip", "check", "my rig"].map(str::to_owned);
        let said = || Provenance::of(&[]).unwrap().command_line;
        let own = said();
        assert_eq!(
            on_behalf_of(Some(line.to_vec()), said),
            "stickslip check 'my rig'"
        );
        assert_eq!(said(), own);
    }

    #[test]
    fn a_result_keeps_its_keys_and_gains_one() {
        let provenance = Provenance::of(&[]).unwrap();
        let text = provenance.json(&serde_json::json!({ "runs": [1.5, null] }));
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["runs"], serde_json::json!([1.5, null]));
        assert_eq!(value["provenance"]["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!(value["provenance"]["date"].as_str().unwrap().len(), 20);
    }
}
