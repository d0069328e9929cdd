//! Cycles: where they start, and their average.

use super::resample::interpolate;

/// The average cycle of a motion.
#[derive(Debug, Clone)]
pub struct Cycle {
    /// Mean over the cycles at even phases 0, 1/n, ... (n - 1)/n, in the unit of the signal.
    pub mean: Vec<f64>,
    /// Standard deviation over the cycles at each phase.
    pub std: Vec<f64>,
    /// How many cycles were averaged.
    pub cycles: usize,
}

/// Times (s) at which the motion, smoothed over an eighth of `period` (s), rises through its mean.
///
/// After a start the motion must first fall below a quarter of its spread under the mean, so ripple starts no cycle.
pub fn cycle_starts(time: &[f64], values: &[f64], period: f64) -> Vec<f64> {
    let n = time.len();
    let interval = (time[n - 1] - time[0]) / (n - 1) as f64;
    let smooth = moving_mean(values, ((period / 16.0 / interval) as usize).max(1));
    let mean = smooth.iter().sum::<f64>() / n as f64;
    let spread = (smooth.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n as f64).sqrt();
    let (mut starts, mut armed) = (Vec::new(), false);
    for i in 1..n {
        let (before, after) = (smooth[i - 1] - mean, smooth[i] - mean);
        armed |= before < -0.25 * spread;
        if armed && before < 0.0 && after >= 0.0 {
            starts.push(time[i - 1] + (time[i] - time[i - 1]) * before / (before - after));
            armed = false;
        }
    }
    starts
}

/// Mean over `half_width` samples on either side, fewer at the ends.
fn moving_mean(values: &[f64], half_width: usize) -> Vec<f64> {
    let n = values.len();
    let mut sums = vec![0.0; n + 1];
    for i in 0..n {
        sums[i + 1] = sums[i] + values[i];
    }
    (0..n)
        .map(|i| {
            let (low, high) = (i.saturating_sub(half_width), (i + half_width + 1).min(n));
            (sums[high] - sums[low]) / (high - low) as f64
        })
        .collect()
}

/// Averages the cycles between `starts` over `phases` even phases. `None` with fewer than two whole cycles.
///
/// Each cycle is stretched to unit length, so slow drift of the period does not blur the mean.
pub fn mean_cycle(time: &[f64], values: &[f64], starts: &[f64], phases: usize) -> Option<Cycle> {
    let cycles = starts.len().checked_sub(1).filter(|n| *n >= 2)?;
    let (mut mean, mut square) = (vec![0.0; phases], vec![0.0; phases]);
    for span in starts.windows(2) {
        for phase in 0..phases {
            let at = span[0] + (span[1] - span[0]) * phase as f64 / phases as f64;
            let v = interpolate(time, values, at);
            mean[phase] += v / cycles as f64;
            square[phase] += v * v / cycles as f64;
        }
    }
    let std = mean
        .iter()
        .zip(&square)
        .map(|(m, s)| (s - m * m).max(0.0).sqrt())
        .collect();
    Some(Cycle { mean, std, cycles })
}

impl Cycle {
    /// This cycle turned so that it fits `other` best, both with the same number of phases.
    pub fn turned_to(&self, other: &Cycle) -> Cycle {
        let n = self.mean.len();
        let distance = |shift: usize| -> f64 {
            (0..n)
                .map(|i| (self.mean[(i + shift) % n] - other.mean[i]).powi(2))
                .sum()
        };
        let best = (0..n)
            .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
            .unwrap_or(0);
        let turn = |v: &[f64]| (0..n).map(|i| v[(i + best) % n]).collect();
        Cycle {
            mean: turn(&self.mean),
            std: turn(&self.std),
            cycles: self.cycles,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn wave(t: f64) -> f64 {
        (TAU * t / 0.03).sin() + 0.3 * (TAU * t / 0.015).cos() + 0.1 * (TAU * 510.0 * t).sin()
    }

    #[test]
    fn val_one_start_per_cycle_despite_ripple() {
        let time: Vec<f64> = (0..6000).map(|i| f64::from(i) * 1e-4).collect();
        let values: Vec<f64> = time.iter().map(|t| wave(*t)).collect();
        let starts = cycle_starts(&time, &values, 0.03);
        assert!((18..=20).contains(&starts.len()), "{}", starts.len());
        for pair in starts.windows(2) {
            assert!((pair[1] - pair[0] - 0.03).abs() < 2e-3);
        }
    }

    #[test]
    fn val_a_shifted_motion_has_the_same_turned_cycle() {
        let time: Vec<f64> = (0..6000).map(|i| f64::from(i) * 1e-4).collect();
        let cycle = |shift: f64| {
            let values: Vec<f64> = time
                .iter()
                .map(|t| (TAU * (t + shift) / 0.03).sin())
                .collect();
            let starts: Vec<f64> = (0..19).map(|k| 0.03 * f64::from(k)).collect();
            mean_cycle(&time, &values, &starts, 100).unwrap()
        };
        let (a, b) = (cycle(0.0), cycle(0.0123));
        let worst = a
            .mean
            .iter()
            .zip(&b.turned_to(&a).mean)
            .map(|(x, y)| (x - y).abs())
            .fold(0.0, f64::max);
        assert!(worst < 0.02, "{worst}");
    }
}
