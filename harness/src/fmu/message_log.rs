//! Keeps the last messages of an FMU, to quote them in errors.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard};

/// A few messages are enough to explain a failure; an FMU that logs every step must not fill the memory.
const KEPT: usize = 8;

/// The last messages of one instance.
#[derive(Debug, Default)]
pub(crate) struct MessageLog(Mutex<VecDeque<String>>);

impl MessageLog {
    fn lock(&self) -> MutexGuard<'_, VecDeque<String>> {
        self.0
            .lock()
            .unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    pub(crate) fn push(&self, message: &str) {
        let mut messages = self.lock();
        if messages.len() == KEPT {
            messages.pop_front();
        }
        messages.push_back(message.trim_end().to_owned());
    }

    /// All messages, joined, and forgotten.
    pub(crate) fn take(&self) -> String {
        self.lock().drain(..).collect::<Vec<_>>().join("; ")
    }
}
