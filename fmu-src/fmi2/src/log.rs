//! Messages to the master's logger.

use crate::status::{Fault, Status};
use crate::types::{CallbackFunctions, Text};
use beam_model_description::LOG_CATEGORIES;
use std::ffi::{CStr, CString, c_void};

/// The logger of one instance.
///
/// Refusals and failures are always reported; remarks and events only while debug logging is on and
/// their category is among those asked for (FMI 2.0.5, section 2.1.5).
pub struct Log {
    callbacks: CallbackFunctions,
    instance_name: CString,
    on: bool,
    /// Categories asked for; empty means all.
    categories: Vec<CString>,
}

impl Log {
    /// A log with all categories.
    pub fn new(callbacks: CallbackFunctions, instance_name: CString, on: bool) -> Self {
        Self {
            callbacks,
            instance_name,
            on,
            categories: Vec::new(),
        }
    }

    /// Switches debug logging.
    ///
    /// # Errors
    /// An unknown category; nothing is changed then.
    pub fn set(&mut self, on: bool, categories: Vec<CString>) -> Result<(), Fault> {
        for category in &categories {
            let known = LOG_CATEGORIES
                .iter()
                .any(|(name, _)| name.as_bytes() == category.as_bytes());
            if !known && category.as_c_str() != c"logAll" {
                return Err(Fault::UnknownCategory {
                    category: category.to_string_lossy().into_owned(),
                });
            }
        }
        self.on = on;
        self.categories = categories;
        Ok(())
    }

    fn wants(&self, category: &CStr) -> bool {
        self.on
            && (self.categories.is_empty()
                || self
                    .categories
                    .iter()
                    .any(|c| c.as_c_str() == category || c.as_c_str() == c"logAll"))
    }

    /// Whether messages with this status reach the master.
    pub fn is_heard(&self, status: Status) -> bool {
        self.callbacks.logger.is_some()
            && (matches!(status, Status::Discard | Status::Error | Status::Fatal)
                || self.wants(status.category()))
    }

    /// Hands a message to the master.
    pub fn message(&self, status: Status, text: &str) {
        if !self.is_heard(status) {
            return;
        }
        let Some(logger) = self.callbacks.logger else {
            return;
        };
        // A C string ends at its first zero byte.
        let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
        let environment: *mut c_void = self.callbacks.environment;
        let category: Text = status.category().as_ptr();
        // SAFETY: the master guarantees a callable logger (FMI 2.0.5, section 2.1.5); all strings are
        // terminated by zero and outlive the call; the format "%s" takes exactly the one argument, so
        // that a '%' in the message is harmless.
        unsafe {
            logger(
                environment,
                self.instance_name.as_ptr(),
                status.code(),
                category,
                c"%s".as_ptr(),
                text.as_ptr(),
            );
        }
    }
}
