//! What predictions miss, sample by sample, with what the run did at that moment.

use crate::diagnose::data::contact_phase::{ContactPhase, Instant};
use crate::diagnose::explanation::replay::Replay;
use crate::diagnose::model::problem::Problem;
use std::collections::BTreeMap;

/// Median of the absolute value of a normal quantity of standard deviation 1.
pub const NORMAL_MEDIAN: f64 = 0.674_49;

/// What a prediction misses at a sample.
#[derive(Debug, Clone)]
pub struct Miss {
    /// Index of the run.
    pub run: usize,
    /// Index of the segment that was predicted.
    pub segment: usize,
    /// What the contact does.
    pub contact_phase: ContactPhase,
    /// Time since the run began, in s.
    pub time: f64,
    /// Distance that belt and tip have moved against each other since the run began, in m.
    pub travel: f64,
    /// Smoothed tip displacement in m.
    pub displacement: f64,
    /// Smoothed tip velocity less belt velocity in m/s.
    pub relative_velocity: f64,
    /// Absolute error over the noise, so scaled that its median is 1 for noise alone.
    pub size: f64,
}

/// All samples that are trusted and predicted, segment by segment.
pub fn misses(problem: &Problem, replays: &BTreeMap<usize, Replay>) -> Vec<Miss> {
    let mut out = Vec::new();
    for (&index, replay) in replays {
        let segment = &problem.segments[index];
        let run = &problem.campaign.runs[segment.run];
        let motion = &problem.smoothings[segment.run].stick_slip;
        let trusted = (0..segment.time.len()).filter(|&k| segment.trusted[k]);
        for k in trusted.filter(|&k| replay.measured[k].is_finite()) {
            let time = segment.time[k] - run.time[0];
            let instant = Instant::new(&problem.smoothings[segment.run], time);
            let error = (segment.measured[k] - replay.measured[k]).abs();
            out.push(Miss {
                run: segment.run,
                segment: index,
                contact_phase: instant.contact_phase,
                time,
                travel: instant.travel,
                displacement: motion.smoothed.displacement[instant.slot],
                relative_velocity: motion.relative_velocity[instant.slot],
                size: error / problem.noise[segment.run] / NORMAL_MEDIAN,
            });
        }
    }
    out
}
