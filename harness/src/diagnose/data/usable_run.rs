//! What a diagnosis takes of a measured run.
//!
//! It compares motions, with a noise that is white and of known size. So of each run it is asked
//! first whether the tip moves; a record is made as noisy as a sensor makes it at least; and of a
//! long one no more is taken than is learned from.

use crate::diagnose::data::white_noise::gaussian;
use crate::measurement::{LEAST_NOISE, Run};
use crate::metric::standard_deviation;

/// A motion is one if its standard deviation is at least this many times that of the noise: what
/// models differ by is a small part of the motion.
const LEAST_MOTION: f64 = 3.0;

/// Samples of a run that are used, from its start: several times those of the segments that are
/// fitted. The smoother's time and memory grow with them, and so do those of forecasts.
const MOST_SAMPLES: usize = 200_000;

/// A run as it is used, and what must be said of it.
pub struct UsableRun {
    /// The run.
    pub run: Run,
    /// Whether the tip moves in it. Steady slip is a measurement too, beside others that move.
    pub moves: bool,
    /// Remarks for the reader.
    pub remarks: Vec<String>,
}

impl UsableRun {
    /// What is used of each run of a campaign.
    pub fn all(runs: &[Run]) -> Vec<Self> {
        let spread = |run: &Run| standard_deviation(&run.measured);
        // One sensor measures all runs, so that all have the noise of the same range.
        let largest = runs.iter().map(spread).fold(0.0, f64::max);
        let of_runs = runs.iter().zip(0..);
        let of_runs = of_runs.map(|(run, seed)| Self::of(run, LEAST_NOISE * largest, seed));
        of_runs.collect()
    }

    /// What is used of a run, with a noise of `least` at least, in the unit of what is measured.
    fn of(measured: &Run, least: f64, seed: u64) -> Self {
        let mut remarks = Vec::new();
        let mut run = measured.beginning(MOST_SAMPLES);
        if run.time.len() < measured.time.len() {
            remarks.push(format!(
                "{}: {} samples over {:.1} s; the first {} of them, {:.1} s, were used.",
                run.name,
                measured.time.len(),
                measured.duration(),
                run.time.len(),
                run.duration()
            ));
        }
        let spread = standard_deviation(&run.measured);
        let unit = run.measurand.unit();
        if run.noise.std < least {
            remarks.push(format!(
                "{}: a noise of {:.1e} {unit} is less than any sensor's, as in a simulation; white noise of {least:.1e} {unit} was put on, so that what a model leaves can be compared with it.",
                run.name, run.noise.std
            ));
            let more = (least * least - run.noise.std.powi(2)).sqrt();
            let mut random = fastrand::Rng::with_seed(seed);
            for y in &mut run.measured {
                *y += more * gaussian(&mut random);
            }
            run.noise.std = least;
        }
        Self {
            moves: spread > LEAST_MOTION * measured.noise.std,
            run,
            remarks,
        }
    }
}
