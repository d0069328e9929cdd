//! Whether a sensor is AC coupled, by what it reads while the tip sticks.
//!
//! In stick the tip moves with the belt at v_0. A displacement that has passed a high-pass filter then rises at
//!
//! ```text
//! y' = v_0 - r y,   r = 2 pi f
//! ```
//!
//! so that `y' + r y` rests at the belt's speed for the right corner frequency f alone. Where it rests longest, the slope of y' over y in
//! stick gives r. Holds for a first-order filter; a belt whose speed yields in stick could pass for one, but bends the tip.

use super::examined::Examined;
use super::motion::slope_window;
use super::plateau::{Plateau, half_band, plateau};
use super::thresholds::SPEED_OFF;
use crate::measurement::{Measurand, Run};
use crate::metric::{line, median, velocity};
use std::f64::consts::TAU;

/// Highest corner frequency that is looked for, Hz: beyond, little is left of cycles of some ten hertz.
const HIGHEST: f64 = 20.0;
/// Samples that are looked at in a run, and rates that are tried, at most.
const MOST: usize = 2500;
/// Standard deviations by which a rate must differ from zero.
const CERTAIN: f64 = 4.0;
/// Share by which the rates of runs may scatter about their median.
const SCATTER: f64 = 0.25;
/// Share of the belt's speed that the filter must take from the slope: as far as belts deviate.
const LEAST_SHARE: f64 = 0.01;

/// Corner frequency of the filter in Hz, if most of these runs show one and the same.
pub fn corner(runs: &[&Examined]) -> Option<f64> {
    let rates: Vec<f64> = runs.iter().filter_map(|run| rate(run.run)).collect();
    if 2 * rates.len() <= runs.len() {
        return None;
    }
    let middle = median(&mut rates.clone());
    let near = rates.iter().filter(|r| (*r / middle - 1.0).abs() < SCATTER);
    (2 * near.count() > runs.len()).then_some(middle / TAU)
}

/// Rate r in 1/s of a run.
fn rate(run: &Run) -> Option<f64> {
    if run.measurand != Measurand::Displacement || run.belt_velocity == 0.0 {
        return None;
    }
    let (half, noise) = slope_window(run);
    let every = run.measured.len().div_ceil(MOST);
    let thinned = |all: &[f64]| -> Vec<f64> { all.iter().copied().step_by(every).collect() };
    let slopes = thinned(&velocity(&run.time, &run.measured, half));
    let readings = thinned(&run.measured);
    let rests = |rate: f64| {
        let all = slopes.iter().zip(&readings);
        let speed: Vec<f64> = all.map(|(slope, y)| slope + rate * y).collect();
        let is_belt = |p: &Plateau| (p.value / run.belt_velocity - 1.0).abs() < SPEED_OFF;
        plateau(&speed, noise).filter(is_belt)
    };
    let largest = readings.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let range = largest - readings.iter().copied().fold(f64::INFINITY, f64::min);
    // With a rate that is off by half a step, what rests stays within the band.
    let step = half_band(&slopes, noise) / range;
    let count = (TAU * HIGHEST / step).ceil();
    if !(count <= MOST as f64) {
        return None;
    }
    let found = (0..=count as usize).filter_map(|i| rests(step * i as f64));
    let mut best = found.max_by(|a, b| a.share.total_cmp(&b.share))?;
    let (mut rate, mut std) = (0.0, f64::INFINITY);
    // The samples in stick follow from the rate, and the rate from them.
    for _ in 0..3 {
        let on = best.on.iter().enumerate().filter(|(_, on)| **on);
        let points: Vec<(f64, f64)> = on.map(|(k, _)| (readings[k], slopes[k])).collect();
        let (level, slope) = line(&points);
        rate = -slope;
        std = slope_std(&points, (level, slope), half.div_ceil(every));
        best = rests(rate)?;
    }
    let taken = rate * range / run.belt_velocity.abs();
    (rate > CERTAIN * std && taken > LEAST_SHARE).then_some(rate)
}

/// Standard deviation of the slope of a line through points of which neighbours within `half` share their noise.
fn slope_std(points: &[(f64, f64)], (level, slope): (f64, f64), half: usize) -> f64 {
    let n = points.len() as f64;
    let mean = points.iter().map(|p| p.0).sum::<f64>() / n;
    let spread: f64 = points.iter().map(|p| (p.0 - mean).powi(2)).sum();
    let left: f64 = points
        .iter()
        .map(|p| (p.1 - level - slope * p.0).powi(2))
        .sum();
    (left / n / spread * (2 * half + 1) as f64).sqrt()
}
