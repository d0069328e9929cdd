//! The level of an error in one interval of a quantity, and how far chance moves it.

use crate::metric::median;
use std::collections::BTreeMap;

/// Segments that an interval needs before its level counts.
pub const LEAST: usize = 4;
/// Samples that it needs: the median of fewer is off by a fifth and more by chance.
const LEAST_SAMPLES: usize = 20;
/// Groups of segments whose medians say how far a level is uncertain.
const GROUPS: usize = 10;

/// The error in one interval of a quantity.
#[derive(Debug, Clone)]
pub struct Level {
    /// Where, as the words of a sentence: `in stick`, `from 50 to 100 Hz`.
    pub place: String,
    /// Middle of the interval, in the unit of the picture; NaN where it has a name only.
    pub middle: f64,
    /// Intervals are compared within a stratum only: runs, where each covers intervals of its own; else 0.
    pub stratum: usize,
    /// Name of the stratum; empty where there is one only.
    pub stratum_name: String,
    /// Median error of the samples over the noise; NaN where the segments are too few.
    pub over_noise: f64,
    /// Segments in it.
    pub segments: usize,
    /// Logarithm of the median error of each group of segments. Samples of one segment err together and are no independent
    /// observations; groups of whole segments are.
    pub groups: Vec<f64>,
}

impl Level {
    /// The level of samples, given by segment.
    pub fn new(place: String, middle: f64, stratum: usize, by_segment: &BySegment) -> Level {
        let count = by_segment.len().min(GROUPS);
        let samples: usize = by_segment.values().map(Vec::len).sum();
        let enough = by_segment.len() >= LEAST && samples >= LEAST_SAMPLES;
        let group = |g: usize| {
            let of = by_segment.values().skip(g).step_by(count);
            median(&mut of.flatten().copied().collect::<Vec<f64>>()).ln()
        };
        let all = || by_segment.values().flatten().copied();
        Level {
            place,
            middle,
            stratum,
            stratum_name: String::new(),
            over_noise: match enough {
                true => median(&mut all().collect::<Vec<f64>>()),
                false => f64::NAN,
            },
            segments: by_segment.len(),
            groups: match enough {
                true => (0..count)
                    .map(group)
                    .filter(|v: &f64| v.is_finite())
                    .collect(),
                false => Vec::new(),
            },
        }
    }

    /// The same with the name of its stratum.
    pub fn within(self, name: &str) -> Level {
        Level {
            stratum_name: name.to_owned(),
            ..self
        }
    }

    /// Whether it counts.
    pub fn is_known(&self) -> bool {
        self.over_noise.is_finite() && self.over_noise > 0.0 && self.groups.len() > 1
    }

    /// Standard error of the level's logarithm.
    pub fn std_of_log(&self) -> f64 {
        let n = self.groups.len() as f64;
        let mean = self.groups.iter().sum::<f64>() / n;
        let squares: f64 = self.groups.iter().map(|v| (v - mean).powi(2)).sum();
        (squares / (n - 1.0) / n).sqrt()
    }
}

/// Sizes of errors over the noise, by segment.
pub type BySegment = BTreeMap<usize, Vec<f64>>;

/// Sorts sizes of errors, each with its segment and interval, into `count` intervals.
pub fn sorted(
    sizes: impl Iterator<Item = (Option<usize>, usize, f64)>,
    count: usize,
) -> Vec<BySegment> {
    let mut out = vec![BySegment::new(); count];
    for (interval, segment, size) in sizes {
        if let Some(i) = interval.filter(|i| *i < count) {
            out[i].entry(segment).or_default().push(size);
        }
    }
    out
}
