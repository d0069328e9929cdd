//! How evenly a run was sampled, and which samples are missing.

use std::ops::Range;

/// Sampling of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Sampling {
    /// Median interval, s.
    pub interval: f64,
    /// Standard deviation of the intervals, gaps left out, as a share of the median, 1.
    pub jitter: f64,
    /// Where samples are missing.
    pub gaps: Vec<Gap>,
    samples: usize,
}

/// Missing samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Gap {
    /// Index of the last sample before it.
    pub after: usize,
    /// Number of samples that would fit into it.
    pub missing: usize,
}

/// An interval is a gap from this many median intervals on: nearer to two samples than to one.
const GAP_FROM: f64 = 1.5;

impl Sampling {
    /// Of strictly increasing times, at least two.
    pub fn of(time: &[f64]) -> Sampling {
        let mut intervals: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).collect();
        let middle = intervals.len() / 2;
        let interval = *intervals
            .clone()
            .select_nth_unstable_by(middle, f64::total_cmp)
            .1;
        let gaps = intervals
            .iter()
            .enumerate()
            .filter(|(_, dt)| **dt > GAP_FROM * interval)
            .map(|(after, dt)| Gap {
                after,
                missing: (dt / interval).round() as usize - 1,
            })
            .collect();
        intervals.retain(|dt| *dt <= GAP_FROM * interval);
        let mean = intervals.iter().sum::<f64>() / intervals.len() as f64;
        let sum: f64 = intervals.iter().map(|dt| (dt - mean).powi(2)).sum();
        Sampling {
            interval,
            jitter: (sum / intervals.len() as f64).sqrt() / interval,
            gaps,
            samples: time.len(),
        }
    }

    /// Index ranges of samples without a gap inside.
    pub fn unbroken(&self) -> Vec<Range<usize>> {
        let starts = std::iter::once(0).chain(self.gaps.iter().map(|g| g.after + 1));
        let ends = self
            .gaps
            .iter()
            .map(|g| g.after + 1)
            .chain(std::iter::once(self.samples));
        starts.zip(ends).map(|(start, end)| start..end).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_gaps_are_counted_in_missing_samples() {
        let time: Vec<f64> = (0..100)
            .filter(|i| !(40..43).contains(i))
            .map(|i| f64::from(i) * 1e-4)
            .collect();
        let sampling = Sampling::of(&time);
        assert!((sampling.interval - 1e-4).abs() < 1e-12);
        assert_eq!(
            sampling.gaps,
            [Gap {
                after: 39,
                missing: 3
            }]
        );
        assert_eq!(sampling.unbroken(), [0..40, 40..97]);
        assert!(sampling.jitter < 1e-9);
    }

    #[test]
    fn val_jitter_is_the_relative_scatter_of_the_intervals() {
        // Intervals 1.05, 0.9, 1.05, ...: standard deviation 0.0707, median 1.05.
        let time: Vec<f64> = (0..999)
            .map(|i| f64::from(i) + [0.0, 0.05, -0.05][i as usize % 3])
            .collect();
        let sampling = Sampling::of(&time);
        assert!(
            (sampling.jitter - 0.0707 / 1.05).abs() < 1e-4,
            "{}",
            sampling.jitter
        );
        assert!(sampling.gaps.is_empty());
    }
}
