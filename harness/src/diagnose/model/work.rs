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
    samples: AtomicU64,
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
    /// Counts one motion over so many samples of a segment.
    pub fn motion(&self, samples: usize) {
        self.motions.fetch_add(1, Ordering::Relaxed);
        self.samples.fetch_add(samples as u64, Ordering::Relaxed);
    }

    /// Counts so many derivatives over so many samples of a segment.
    pub fn sensitivities(&self, count: usize, samples: usize) {
        let (count, samples) = (count as u64, samples as u64);
        self.sensitivities.fetch_add(count, Ordering::Relaxed);
        self.samples.fetch_add(count * samples, Ordering::Relaxed);
    }

    /// Counts one fit.
    pub fn fit(&self) {
        self.fits.fetch_add(1, Ordering::Relaxed);
    }

    /// Samples of all motions and derivatives so far: a window costs less than a segment.
    pub fn samples(&self) -> u64 {
        self.samples.load(Ordering::Relaxed)
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
