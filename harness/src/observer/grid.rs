//! A record with gaps and bad samples on a uniform grid.

use super::error::ObserverError;

/// A uniformly sampled record; NaN where a sample is missing.
#[derive(Debug, Clone, PartialEq)]
pub struct UniformRecord {
    /// Time of the first sample in s.
    pub start: f64,
    /// Sample interval in s.
    pub interval: f64,
    /// What was measured, in m, m/s or m/s^2.
    pub measured: Vec<f64>,
    /// Number of grid points without a usable sample.
    pub missing: usize,
}

/// Farthest a sample may lie off the grid, in intervals.
const OFF_GRID: f64 = 0.25;
/// Largest share of missing samples that the smoother may bridge.
const MISSING: f64 = 0.5;

impl UniformRecord {
    /// Places samples on the grid of their median interval, refined over the whole record.
    ///
    /// `time` in s, `measured` in m, m/s or m/s^2 (NaN where empty); samples with `trusted` false (clipped,
    /// held) count as missing.
    pub fn of(
        time: &[f64],
        measured: &[f64],
        trusted: Option<&[bool]>,
    ) -> Result<Self, ObserverError> {
        let expected = time.len();
        let lengths = [
            ("measured values", measured.len()),
            ("trusted", trusted.map_or(expected, <[bool]>::len)),
        ];
        if let Some((what, found)) = lengths.into_iter().find(|(_, n)| *n != expected) {
            return Err(ObserverError::LengthMismatch {
                what,
                expected,
                found,
            });
        }
        if expected < 2 {
            return Err(ObserverError::TooFewSamples {
                found: expected,
                needed: 2,
            });
        }
        if let Some(i) = (1..expected).find(|i| !(time[*i] > time[i - 1])) {
            return Err(ObserverError::TimeNotRising {
                index: i,
                before_s: time[i - 1],
                after_s: time[i],
            });
        }
        let (start, interval) = grid(time);
        let last = ((time[expected - 1] - start) / interval).round() as usize;
        let mut out = vec![f64::NAN; last + 1];
        for (index, t) in time.iter().enumerate() {
            let at = (t - start) / interval;
            let share = (at - at.round()).abs();
            if share > OFF_GRID {
                return Err(ObserverError::UnevenSampling {
                    index,
                    time_s: *t,
                    share,
                    interval_s: interval,
                });
            }
            if trusted.is_none_or(|trusted| trusted[index]) {
                out[at.round() as usize] = measured[index];
            }
        }
        let missing = out.iter().filter(|y| y.is_nan()).count();
        if missing as f64 > MISSING * out.len() as f64 {
            return Err(ObserverError::TooFewSamples {
                found: out.len() - missing,
                needed: out.len() / 2,
            });
        }
        Ok(Self {
            start,
            interval,
            measured: out,
            missing,
        })
    }

    /// Times of the grid points in s.
    pub fn time(&self) -> Vec<f64> {
        (0..self.measured.len())
            .map(|k| self.start + k as f64 * self.interval)
            .collect()
    }
}

/// Start and interval: least squares of time over the sample numbers that the median interval gives.
fn grid(time: &[f64]) -> (f64, f64) {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
    steps.sort_by(f64::total_cmp);
    let median = steps[steps.len() / 2];
    // Sample by sample, so that an inexact median does not add up.
    let mut number = vec![0.0; time.len()];
    for i in 1..time.len() {
        number[i] = number[i - 1] + ((time[i] - time[i - 1]) / median).round().max(1.0);
    }
    let n = time.len() as f64;
    let (x0, y0) = (number.iter().sum::<f64>() / n, time.iter().sum::<f64>() / n);
    let xx: f64 = number.iter().map(|x| (x - x0).powi(2)).sum();
    let xy: f64 = number
        .iter()
        .zip(time)
        .map(|(x, y)| (x - x0) * (y - y0))
        .sum();
    let interval = xy / xx;
    (y0 - interval * x0, interval)
}
