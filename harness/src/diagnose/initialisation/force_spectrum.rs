//! The friction force that a characteristic alone does not explain, and what it repeats with.
//!
//! In slip, away from transitions, the smoothed force of every run is compared with one free
//! characteristic over relative velocity (the median of `|F|/F_N` in bins of `|v_r|`, with a level of its
//! own for each run; no law is assumed). What remains is searched for what repeats in time or along the
//! belt: per run r, least squares of the rest on `m`, `m cos u` and `m sin u` with m the expected force and
//! `u = 2 pi f t` or `2 pi s/L`; the gains in likelihood, added up over the runs, make the spectrum; the
//! strongest line is taken away before the next is looked for (Lomb-Scargle, Scargle 1982, with the level refitted as in Cumming 1999).

use crate::diagnose::initialisation::free_characteristic::slip_samples;
use crate::diagnose::initialisation::wave_fit::{AtWave, WaveFits};
use crate::diagnose::model::periodic::{Argument, Line, Question};
use crate::diagnose::model::problem::Problem;
use crate::smoothing::SlipSample;
use std::f64::consts::TAU;

/// Samples of a run that a spectrum uses at most.
const MOST_SAMPLES: usize = 1500;

/// Step of a spectrum in units of the reciprocal of the record's length.
const FINE: f64 = 0.2;
/// Steps of a spectrum at most.
const MOST_WAVES: f64 = 6000.0;

/// The strongest lines of what remains, with amplitude relative to the expected force and a phase for
/// each run.
pub fn lines(problem: &Problem, argument: Argument, range: (f64, f64), most: usize) -> Vec<Line> {
    let question = (argument, range, most);
    let known = |spectra: &[(Question, Vec<Line>)]| {
        let same = spectra.iter().find(|s| s.0 == question)?;
        Some(same.1.clone())
    };
    let spectra = || problem.spectra.0.lock().unwrap_or_else(|e| e.into_inner());
    if let Some(lines) = known(&spectra()) {
        return lines;
    }
    let found = find_lines(problem, argument, range, most);
    spectra().push((question, found.clone()));
    found
}

fn find_lines(problem: &Problem, argument: Argument, range: (f64, f64), most: usize) -> Vec<Line> {
    let place = |s: &SlipSample| match argument {
        Argument::Time => s.time,
        Argument::Travel => s.travel,
    };
    let (low, high) = match argument {
        Argument::Time => range,
        Argument::Travel => (range.1.recip(), range.0.recip()),
    };
    // A long record would need a spectrum as fine as it is long: its beginning is enough for a start.
    let longest = FINE * MOST_WAVES / (high - low);
    let runs: Vec<Vec<SlipSample>> = slip_samples(problem)
        .into_iter()
        .map(|mut samples| {
            let first = samples.first().map_or(0.0, place);
            samples.retain(|s| place(s) - first <= longest);
            let every = samples.len().div_ceil(MOST_SAMPLES).max(1);
            samples.into_iter().step_by(every).collect()
        })
        .collect();
    let extent = runs
        .iter()
        .filter_map(|samples| Some(place(samples.last()?) - place(samples.first()?)))
        .fold(0.0, f64::max);
    if extent <= 0.0 {
        return Vec::new();
    }
    let fine = FINE / extent;
    let low = low.max(0.3 / extent);
    let mut rests: Vec<Vec<f64>> = runs
        .iter()
        .map(|samples| samples.iter().map(rest).collect())
        .collect();
    let mut found = Vec::new();
    for _ in 0..most {
        let mut best: Option<(f64, Vec<Option<AtWave>>)> = None;
        let mut most_gain = 0.0;
        let mut sweeps: Vec<WaveFits> = runs
            .iter()
            .zip(&rests)
            .map(|(samples, rest)| WaveFits::new(samples, rest, place, fine))
            .collect();
        let mut step = 0;
        loop {
            let wave = low + fine * step as f64;
            if wave >= high {
                break;
            }
            let fits: Vec<Option<AtWave>> = sweeps
                .iter_mut()
                .map(|sweep| sweep.at(wave, step))
                .collect();
            let gain: f64 = fits.iter().flatten().map(|f| f.gain).sum();
            if gain > most_gain {
                most_gain = gain;
                best = Some((wave, fits));
            }
            step += 1;
        }
        let Some((wave, fits)) = best else { break };
        let (mut weight, mut mean) = (0.0, 0.0);
        let mut phase = vec![0.0; runs.len()];
        for (r, fit) in fits.iter().enumerate() {
            let Some(fit) = fit else { continue };
            weight += runs[r].len() as f64;
            mean += runs[r].len() as f64 * fit.amplitude;
            phase[r] = fit.phase;
            // What this line explains is taken away, or its neighbours would be the next lines.
            for (s, rest) in runs[r].iter().zip(&mut rests[r]) {
                *rest -= s.expected * fit.amplitude * (TAU * wave * place(s) + fit.phase).cos();
            }
        }
        found.push(Line {
            value: match argument {
                Argument::Time => wave,
                Argument::Travel => wave.recip(),
            },
            amplitude: mean / weight,
            phase,
            gain: most_gain,
        });
    }
    found
}

/// What the characteristic leaves; single samples far off (a missed transition) must not rule.
fn rest(s: &SlipSample) -> f64 {
    let limit = 0.5 * s.expected.abs();
    (s.force - s.expected).clamp(-limit, limit)
}
