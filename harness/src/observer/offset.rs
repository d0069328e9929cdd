//! Offset and drift of the sensor, as far as the record tells them from the force.
//!
//! A constant sensor offset `o` looks like a constant force `o / compliance`: no filter can tell
//! them apart. Two things help: friction opposes slip equally in both directions, so the mean of
//! the forces in forward and backward slip at equal speed is the offset's; and a slow trend of the
//! displacement is drift of the sensor or slow change of friction, which is reported, not decided.

use super::characteristic::{Bin, NormalForce};
use super::structure::Structure;

/// A value with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard deviation.
    pub std: f64,
}

impl Estimate {
    /// Whether the value differs from zero by more than three standard deviations.
    pub fn is_significant(&self) -> bool {
        self.value.abs() > 3.0 * self.std
    }
}

/// Number of parts of the record whose means give the drift.
const PARTS: usize = 12;

/// Least number of samples in forward slip for [`offset_from_symmetry`].
const FORWARD_SAMPLES: usize = 100;
/// Least number of speeds common to both directions.
const OVERLAP: usize = 3;

/// Drift of the displacement in m/s: slope of a line through the means of equal parts of the record
/// (NaN samples left out). `None` for records that are too short.
///
/// Slow change of friction (warming, wear) has the same effect.
pub fn drift(displacement: &[f64], sample_interval: f64) -> Option<Estimate> {
    let length = displacement.len() / PARTS;
    if length < 8 {
        return None;
    }
    let means: Vec<(f64, f64)> = displacement
        .chunks_exact(length)
        .enumerate()
        .filter_map(|(i, part)| {
            let known: Vec<f64> = part.iter().copied().filter(|y| !y.is_nan()).collect();
            let time = (i as f64 + 0.5) * length as f64 * sample_interval;
            (2 * known.len() > length)
                .then(|| (time, known.iter().sum::<f64>() / known.len() as f64))
        })
        .collect();
    let n = means.len() as f64;
    if means.len() < 4 {
        return None;
    }
    let (x0, y0) = means
        .iter()
        .fold((0.0, 0.0), |(x, y), m| (x + m.0 / n, y + m.1 / n));
    let xx: f64 = means.iter().map(|m| (m.0 - x0).powi(2)).sum();
    let value = means.iter().map(|m| (m.0 - x0) * (m.1 - y0)).sum::<f64>() / xx;
    let rest: f64 = means
        .iter()
        .map(|m| (m.1 - y0 - value * (m.0 - x0)).powi(2))
        .sum();
    Some(Estimate {
        value,
        std: (rest / (n - 2.0) / xx).sqrt(),
    })
}

/// Sensor offset in m from slip in both directions; `None` where the speeds do not overlap.
///
/// `bins` of [`super::friction_characteristic`] from a record smoothed without that offset; the
/// normal force is taken as constant (its first value).
pub fn offset_from_symmetry(
    structure: &Structure,
    bins: &[Bin],
    normal_force: NormalForce,
) -> Option<Estimate> {
    let forward: Vec<&Bin> = bins.iter().filter(|b| b.relative_velocity > 0.0).collect();
    let backward: Vec<&Bin> = bins.iter().filter(|b| b.relative_velocity < 0.0).collect();
    if forward.iter().map(|b| b.count).sum::<usize>() < FORWARD_SAMPLES {
        return None;
    }
    let (mut sum, mut weight) = (0.0, 0.0);
    let mut found = Vec::new();
    for bin in forward {
        let speed = bin.relative_velocity;
        // Straight between the two backward bins on either side of this speed.
        let at = backward.windows(2).find(|pair| {
            (-pair[1].relative_velocity..=-pair[0].relative_velocity).contains(&speed)
        });
        let Some(pair) = at else { continue };
        let (v0, v1) = (-pair[0].relative_velocity, -pair[1].relative_velocity);
        let share = (speed - v0) / (v1 - v0);
        let other = pair[0].mu + share * (pair[1].mu - pair[0].mu);
        let error = bin
            .mu_error
            .hypot(pair[0].mu_error.max(pair[1].mu_error))
            .max(1e-4);
        // F is -mu N forward and +mu N backward; the offset adds to both.
        let half = 0.5 * (other - bin.mu);
        found.push((half, error));
        sum += half / error.powi(2);
        weight += error.powi(-2);
    }
    if found.len() < OVERLAP {
        return None;
    }
    let mean = sum / weight;
    // Where the speeds disagree more than their errors, the disagreement counts.
    let disagreement: f64 = found
        .iter()
        .map(|(half, e)| ((half - mean) / (0.5 * e)).powi(2))
        .sum();
    let widen = (disagreement / (found.len() - 1) as f64).sqrt().max(1.0);
    let scale = normal_force.at(0) * structure.sensor_compliance();
    Some(Estimate {
        value: scale * mean,
        std: scale.abs() * 0.5 * widen / weight.sqrt(),
    })
}
