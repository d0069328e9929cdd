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
pub fn mean_cycle(
    time: &[f64],
    values: &[f64],
    spans: &[(f64, f64)],
    phases: usize,
) -> Option<Cycle> {
    let cycles = Some(spans.len()).filter(|n| *n >= 2)?;
    let (mut mean, mut square) = (vec![0.0; phases], vec![0.0; phases]);
    for (start, end) in spans {
        for phase in 0..phases {
            let at = start + (end - start) * phase as f64 / phases as f64;
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

/// The whole cycles of a motion from start to end, s, without those that are much smaller than the largest or much
/// longer than `period`: between these the motion was another one.
pub fn whole_cycles(time: &[f64], values: &[f64], period: f64) -> Vec<(f64, f64)> {
    let height = |from: f64, to: f64| {
        let range = time.partition_point(|t| *t < from)..time.partition_point(|t| *t < to);
        let (low, high) = values[range]
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (l.min(*v), h.max(*v))
            });
        high - low
    };
    let starts = cycle_starts(time, values, period);
    let spans: Vec<(f64, f64, f64)> = starts
        .windows(2)
        .map(|w| (w[0], w[1], height(w[0], w[1])))
        .collect();
    let largest = spans.iter().fold(0.0_f64, |m, s| m.max(s.2));
    let alike = |s: &&(f64, f64, f64)| s.2 > 0.5 * largest && s.1 - s.0 < 1.5 * period;
    spans.iter().filter(alike).map(|s| (s.0, s.1)).collect()
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
    fn val_the_mean_cycle_of_a_drifting_motion_is_one_of_its_cycles() {
        let time: Vec<f64> = (0..6000).map(|i| f64::from(i) * 1e-4).collect();
        // The period grows by a tenth over the record.
        let values: Vec<f64> = time
            .iter()
            .map(|t| (TAU * (t - 0.08 * t * t) / 0.03).sin())
            .collect();
        let cycle = mean_cycle(&time, &values, &whole_cycles(&time, &values, 0.031), 100).unwrap();
        assert!(cycle.cycles >= 16);
        for (phase, value) in cycle.mean.iter().enumerate() {
            assert!((value - (TAU * phase as f64 / 100.0).sin()).abs() < 0.03);
        }
        assert!(cycle.std.iter().all(|s| *s < 0.05));
    }

    #[test]
    fn val_cycles_of_a_smaller_motion_are_not_averaged_in() {
        let time: Vec<f64> = (0..6000).map(|i| f64::from(i) * 1e-4).collect();
        let values: Vec<f64> = time
            .iter()
            .map(|t| if *t < 0.3 { wave(*t) } else { 0.1 * wave(*t) })
            .collect();
        let cycles = whole_cycles(&time, &values, 0.03);
        assert!(
            (8..=10).contains(&cycles.len()) && cycles.iter().all(|c| c.1 < 0.33),
            "{cycles:?}"
        );
    }
}
