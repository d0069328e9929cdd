//! How much was computed.

use cpu_time::ProcessTime;
use serde::Serialize;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts of what costs time, added up over all threads.
#[derive(Debug, Default)]
pub struct Work {
    motions: AtomicU64,
    sensitivities: AtomicU64,
    fits: AtomicU64,
}

/// Counts at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Counts {
    /// Motions of a segment that were predicted.
    pub motions: u64,
    /// Derivatives of a segment's motion, one for each quantity that it was differentiated by.
    pub sensitivities: u64,
    /// Fits of a hypothesis from one start.
    pub fits: u64,
    /// Processor time in s of all threads since the program began.
    pub processor_s: f64,
}

impl Work {
    /// Counts one motion of a segment.
    pub fn motion(&self) {
        self.motions.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts so many derivatives of a segment.
    pub fn sensitivities(&self, count: usize) {
        self.sensitivities
            .fetch_add(count as u64, Ordering::Relaxed);
    }

    /// Counts one fit.
    pub fn fit(&self) {
        self.fits.fetch_add(1, Ordering::Relaxed);
    }

    /// What was counted so far.
    pub fn counts(&self) -> Counts {
        Counts {
            motions: self.motions.load(Ordering::Relaxed),
            sensitivities: self.sensitivities.load(Ordering::Relaxed),
            fits: self.fits.load(Ordering::Relaxed),
            processor_s: ProcessTime::now().as_duration().as_secs_f64(),
        }
    }
}
