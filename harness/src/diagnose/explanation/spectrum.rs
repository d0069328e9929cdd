//! The spectrum of what predictions miss, over that of white noise.

use crate::diagnose::explanation::replay::Replay;
use crate::diagnose::model::problem::Problem;
use crate::metric::{median, spectrum};
use std::collections::BTreeMap;

/// A line in the spectrum of one segment's residual.
#[derive(Debug, Clone, Copy)]
pub struct ResidualLine {
    /// Index of the segment.
    pub segment: usize,
    /// Frequency in Hz.
    pub frequency: f64,
    /// Amplitude over the median one of white noise with the run's standard deviation, 1.
    pub ratio: f64,
}

/// The lines of all segments that were predicted whole.
pub fn over_noise(problem: &Problem, replays: &BTreeMap<usize, Replay>) -> Vec<ResidualLine> {
    let mut out = Vec::new();
    for (&k, replay) in replays {
        let segment = &problem.segments[k];
        let pairs = segment.measured.iter().zip(&replay.measured);
        let residual: Vec<f64> = pairs.map(|(m, p)| m - p).collect();
        if segment.count < segment.time.len() || residual.iter().any(|r| !r.is_finite()) {
            continue;
        }
        let interval = problem.campaign.runs[segment.run].sample_interval();
        let found = spectrum(&residual, interval);
        // Median amplitude that white noise has in this spectrum (Hann window, Rayleigh distribution).
        let white = problem.noise[segment.run]
            * (6.0 / residual.len() as f64 * std::f64::consts::LN_2).sqrt();
        for (f, a) in found.frequency.iter().zip(&found.amplitude).skip(1) {
            out.push(ResidualLine {
                segment: k,
                frequency: *f,
                ratio: a / white,
            });
        }
    }
    out
}

/// Median over the segments of the residual's amplitude at each frequency in Hz, over that of white noise. Frequencies are
/// binned by one over the horizon, so that runs with different sampling meet.
pub fn median_over_noise(problem: &Problem, replays: &BTreeMap<usize, Replay>) -> Vec<(f64, f64)> {
    let mut amplitudes: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for line in over_noise(problem, replays) {
        let bin = (line.frequency * problem.horizon).round() as u32;
        amplitudes.entry(bin).or_default().push(line.ratio);
    }
    amplitudes
        .into_iter()
        .map(|(bin, mut ratios)| (f64::from(bin) / problem.horizon, median(&mut ratios)))
        .collect()
}
