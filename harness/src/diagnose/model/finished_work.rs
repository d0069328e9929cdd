//! Results of long computations, kept so that nothing is computed twice, and a diagnosis that was stopped goes on where it stood.
//!
//! Every fit of a search depends on its arguments alone. Its result is kept, and written to a file as soon as it is there, under the SHA-256
//! of those arguments; asked again, the same question is answered from there. A search that was stopped, or killed, is therefore
//! resumed by running it again: it takes the same way, and what was finished costs nothing. What belongs to other inputs has
//! other keys and is never found.

use crate::error::Error;
use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest as _, Sha256};
use std::collections::HashMap;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard};

/// Digest of a question.
type Key = [u8; 32];

/// Bytes of answers that are kept in the process: those of some tens of searches. What comes then is in the file alone.
const MOST_KEPT: usize = 1 << 28;

/// Bytes before a record's content: its key, and its length as a little-endian u32.
const HEAD: usize = size_of::<Key>() + size_of::<u32>();

/// What was finished; by default nothing is kept.
#[derive(Debug, Default)]
pub struct FinishedWork {
    store: Option<Store>,
    recalled: AtomicUsize,
}

#[derive(Debug)]
struct Store {
    path: PathBuf,
    /// Digest of what all questions have in common: program, FMU and campaign.
    inputs: String,
    known: Mutex<Known>,
    /// `None` once it could not be written to.
    file: Mutex<Option<File>>,
}

/// Answers at hand.
#[derive(Debug, Default)]
struct Known {
    answers: HashMap<Key, Vec<u8>>,
    /// How long they are together.
    bytes: usize,
}

impl Known {
    fn insert(&mut self, key: Key, answer: Vec<u8>) {
        self.bytes += answer.len();
        let old = self.answers.insert(key, answer);
        self.bytes -= old.map_or(0, |old| old.len());
    }
}

impl FinishedWork {
    /// Reads what is there, and keeps in the same file what will be finished.
    ///
    /// # Errors
    /// A file that can't be made or read.
    pub fn open(path: &Path, inputs: &str) -> Result<Self, Error> {
        let content = match std::fs::read(path) {
            Ok(content) => content,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Vec::new(),
            Err(error) => return Err(Error::read(path)(error)),
        };
        let mut known = Known::default();
        let mut rest = content.as_slice();
        // The last record may have been cut off.
        while let Some((head, after)) = rest.split_at_checked(HEAD) {
            let (key, length) = head.split_at(size_of::<Key>());
            let key: Key = key.try_into().expect("as long as a key");
            let length = u32::from_le_bytes(length.try_into().expect("four bytes")) as usize;
            let Some((content, after)) = after.split_at_checked(length) else {
                break;
            };
            known.insert(key, content.to_vec());
            rest = after;
        }
        let whole = content.len() - rest.len();
        let file = File::options()
            .create(true)
            .append(true)
            .open(path)
            .and_then(|file| file.set_len(whole as u64).map(|()| file))
            .map_err(Error::write(path))?;
        Ok(Self {
            store: Some(Store {
                path: path.to_owned(),
                inputs: inputs.to_owned(),
                known: Mutex::new(known),
                file: Mutex::new(Some(file)),
            }),
            recalled: AtomicUsize::new(0),
        })
    }

    /// The answer to a question: as it was found before, or computed and kept.
    ///
    /// # Errors
    /// Those of the computation.
    pub fn recall<Q: Serialize, A: Serialize + DeserializeOwned>(
        &self,
        question: &Q,
        compute: impl FnOnce() -> Result<A, Error>,
    ) -> Result<A, Error> {
        let Some(store) = &self.store else {
            return compute();
        };
        let question = postcard::to_stdvec(&(&store.inputs, question)).expect("plain data");
        let key: Key = Sha256::digest(&question).into();
        let known = store.known().answers.get(&key).cloned();
        if let Some(answer) = known.and_then(|bytes| postcard::from_bytes(&bytes).ok()) {
            self.recalled.fetch_add(1, Ordering::Relaxed);
            return Ok(answer);
        }
        let answer = compute()?;
        store.keep(key, postcard::to_stdvec(&answer).expect("plain data"));
        Ok(answer)
    }

    /// How many questions were answered from what was there.
    pub fn recalled(&self) -> usize {
        self.recalled.load(Ordering::Relaxed)
    }

    /// Removes the file once all is finished.
    ///
    /// # Errors
    /// A file that can't be removed.
    pub fn remove(&self) -> Result<(), Error> {
        match &self.store {
            Some(store) => std::fs::remove_file(&store.path).map_err(Error::write(&store.path)),
            None => Ok(()),
        }
    }
}

impl Store {
    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(|e| e.into_inner())
    }

    fn keep(&self, key: Key, content: Vec<u8>) {
        let mut file = self.file.lock().unwrap_or_else(|e| e.into_inner());
        let mut record = Vec::with_capacity(HEAD + content.len());
        record.extend_from_slice(&key);
        record.extend_from_slice(&(content.len() as u32).to_le_bytes());
        record.extend_from_slice(&content);
        let mut known = self.known();
        if known.bytes < MOST_KEPT {
            known.insert(key, content);
        }
        drop(known);
        // A full disk must not end a search that could go on without it.
        if file.as_mut().is_some_and(|f| f.write_all(&record).is_err()) {
            *file = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_finished_is_recalled_and_what_was_cut_off_is_computed_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("fits");
        let ask = |inputs: &str, question: u32, answer: f64| {
            let work = FinishedWork::open(&path, inputs).unwrap();
            let found = work.recall(&question, || Ok(answer)).unwrap();
            (found, work.recalled())
        };
        assert_eq!(ask("a", 1, 0.1), (0.1, 0));
        assert_eq!(ask("a", 2, f64::INFINITY), (f64::INFINITY, 0));
        // Other answers show that nothing is computed.
        let work = FinishedWork::open(&path, "c").unwrap();
        assert_eq!(work.recall(&1, || Ok(0.2)).unwrap(), 0.2);
        assert_eq!(work.recall(&1, || Ok(-1.0)).unwrap(), 0.2);
        assert_eq!(ask("a", 1, -1.0), (0.1, 1));
        assert_eq!(ask("a", 2, -1.0), (f64::INFINITY, 1));
        assert_eq!(ask("b", 1, -1.0), (-1.0, 0));
        let content = std::fs::read(&path).unwrap();
        std::fs::write(&path, &content[..content.len() - 3]).unwrap();
        assert_eq!(ask("b", 1, -2.0), (-2.0, 0));
        assert_eq!(ask("b", 1, -3.0), (-2.0, 1));
        assert_eq!(ask("a", 1, -1.0), (0.1, 1));
    }

    #[test]
    fn without_a_file_all_is_computed() {
        let work = FinishedWork::default();
        assert_eq!(work.recall(&1, || Ok(2)).unwrap(), 2);
        assert_eq!(work.recall(&1, || Ok(3)).unwrap(), 3);
        work.remove().unwrap();
    }
}
