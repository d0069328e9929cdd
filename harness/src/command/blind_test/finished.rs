//! Campaigns that are finished: each result is a file of its own, whole or not there, so that a
//! blind test that was stopped goes on where it stood.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

use super::answer::Answer;
use super::case::BlindCase;
use crate::command::pack::find_library;
use crate::error::Error;
use crate::output::write_file;
use crate::provenance::Provenance;

/// Name of the file in a campaign's folder.
const FILE: &str = "blind-case.json";

/// A finished campaign, with what its result depends on.
#[derive(Serialize, Deserialize)]
struct Finished {
    key: String,
    case: BlindCase,
}

/// Results of one program.
pub struct Finisher {
    /// Digest of the program and of the model that it packs.
    program: String,
}

impl Finisher {
    /// For the file of the running program; `fmu` is the file given, where it is not this program's own model.
    ///
    /// # Errors
    /// A program that can't be read.
    pub fn new(program: &Path, fmu: Option<&Path>) -> Result<Self, Error> {
        let mut files: Vec<PathBuf> = vec![program.to_owned()];
        if fmu.is_none() {
            files.push(find_library()?);
        }
        let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
        let program = Provenance::of(&files)?.inputs_sha256;
        Ok(Self { program })
    }

    /// What a campaign's result depends on: program, options, campaign, model and answer.
    fn key(&self, answer: &Answer, provenance: &Provenance) -> String {
        let answer = serde_json::to_string(answer).expect("plain data");
        let mut digest = Sha256::new();
        for part in [&self.program, &provenance.inputs_sha256, &answer] {
            digest.update(part);
            digest.update([0]);
        }
        let digest = digest.finalize();
        digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The result that is in `folder`; `None` where it is of another program, campaign or answer,
    /// or is not there.
    pub fn recall(
        &self,
        folder: &Path,
        answer: &Answer,
        provenance: &Provenance,
    ) -> Option<BlindCase> {
        let text = std::fs::read_to_string(folder.join(FILE)).ok()?;
        let found: Finished = serde_json::from_str(&text).ok()?;
        (found.key == self.key(answer, provenance)).then_some(found.case)
    }

    /// Keeps a result in `folder`.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn keep(&self, folder: &Path, answer: &Answer, case: &BlindCase) -> Result<(), Error> {
        let finished = Finished {
            key: self.key(answer, &case.provenance),
            case: case.clone(),
        };
        let text = serde_json::to_string_pretty(&finished).expect("plain data");
        write_file(&folder.join(FILE), text.as_bytes())
    }
}

#[cfg(test)]
mod tests {
    // Parsed the quick way, this number comes back one unit in the last place smaller.
    #[test]
    fn a_number_that_is_read_again_is_the_one_written() {
        let number = 1.052_927_524_775_121_7_f64;
        let written = serde_json::to_string(&number).unwrap();
        let read: f64 = serde_json::from_str(&written).unwrap();
        assert_eq!(read, number);
    }
}
