//! Values of all parameters and start states.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::simulator::{SegmentStart, SegmentValues};
use crate::metric::median;
use serde::{Deserialize, Serialize};

/// Values of everything that can be turned, and the start states of all segments.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// Positions of the shared parameters.
    pub shared: Vec<f64>,
    /// Positions of each run's own parameters.
    pub per_run: Vec<Vec<f64>>,
    /// Start states of each segment: modal states, then deviations of the effects' states.
    pub states: Vec<Vec<f64>>,
    /// Whether each segment starts in stick.
    pub stuck: Vec<bool>,
}

impl Point {
    /// The priors' centres and the smoothed start states.
    pub fn centre(hypothesis: &Hypothesis, segments: &[Segment]) -> Self {
        Self {
            shared: hypothesis
                .shared
                .iter()
                .map(|k| k.position(k.prior))
                .collect(),
            per_run: hypothesis
                .per_run
                .iter()
                .map(|run| run.iter().map(|k| k.position(k.prior)).collect())
                .collect(),
            states: segments
                .iter()
                .map(|s| {
                    let mut x = s.state.clone();
                    x.resize(x.len() + hypothesis.extra_states.len(), 0.0);
                    x
                })
                .collect(),
            stuck: segments.iter().map(|s| s.stuck).collect(),
        }
    }

    /// Gives the runs `to` the median of how far the runs `from` lie from what was believed of them, in what is their own:
    /// friction level and offset, but not phases and profiles, which have nothing in common.
    pub fn spread_per_run(&mut self, h: &Hypothesis, from: &[usize], to: &[usize]) {
        let is_common = |k: &Parameter| k.support.is_none() && k.prior_std > 0.0 && !k.is_phase();
        let believed = |k: &Parameter| k.position(k.prior);
        for &run in to {
            for (i, parameter) in h.per_run[run]
                .iter()
                .enumerate()
                .filter(|(_, k)| is_common(k))
            {
                let mut others: Vec<f64> = from
                    .iter()
                    .filter_map(|&r| {
                        let j = h.per_run[r].iter().position(|k| k.name == parameter.name)?;
                        Some(self.per_run[r][j] - believed(&h.per_run[r][j]))
                    })
                    .collect();
                if !others.is_empty() {
                    self.per_run[run][i] = believed(parameter) + median(&mut others);
                }
            }
        }
    }

    /// What the prediction of segment `k`, of run `run`, depends on.
    pub fn values(&self, k: usize, run: usize) -> SegmentValues<'_> {
        SegmentValues {
            shared: &self.shared,
            per_run: &self.per_run[run],
            state: &self.states[k],
            stuck: self.stuck[k],
        }
    }

    /// The point at a share of the way to another.
    pub fn towards(&self, other: &Point, share: f64) -> Point {
        let between = |from: &[f64], to: &[f64]| -> Vec<f64> {
            let both = from.iter().zip(to);
            both.map(|(from, to)| from + share * (to - from)).collect()
        };
        let all = |from: &[Vec<f64>], to: &[Vec<f64>]| -> Vec<Vec<f64>> {
            let both = from.iter().zip(to);
            both.map(|(from, to)| between(from, to)).collect()
        };
        Point {
            shared: between(&self.shared, &other.shared),
            per_run: all(&self.per_run, &other.per_run),
            states: all(&self.states, &other.states),
            stuck: self.stuck.clone(),
        }
    }

    /// The start of segment `k`.
    pub fn start(&self, k: usize) -> SegmentStart {
        SegmentStart {
            state: self.states[k].clone(),
            stuck: self.stuck[k],
        }
    }

    /// Takes the starts of the segments `list` from a point of these alone.
    pub fn take_starts(&mut self, list: &[usize], from: &Point) {
        for (place, &k) in list.iter().enumerate() {
            self.put(k, from.start(place));
        }
    }

    /// Sets the start of segment `k`.
    pub fn put(&mut self, k: usize, start: SegmentStart) {
        self.states[k] = start.state;
        self.stuck[k] = start.stuck;
    }
}
