//! Every sample of the segments with what was measured there, what the contact did, and what two models say.

use super::views::View;
use crate::diagnose::data::contact_phase::{ContactPhase, Instant};
use crate::diagnose::model::problem::Problem;

/// One sample of a segment.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Index of the run.
    pub run: usize,
    /// Time since the segment began in s.
    pub since_start: f64,
    /// What the contact does.
    pub contact_phase: ContactPhase,
    /// Smoothed tip velocity less belt velocity in m/s.
    pub relative_velocity: f64,
    /// Smoothed displacement in m.
    pub displacement: f64,
    /// Distance that belt and tip have moved against each other since the run began, in m.
    pub travel: f64,
    /// Contact force that the measurement implies, in N.
    pub force: f64,
    /// Measured less predicted, in m or m/s, before and after.
    pub residual: [f64; 2],
    /// Force less the model's in N, before and after.
    pub unexplained: [f64; 2],
}

/// Samples of all segments that the second model predicts, trusted ones only.
pub fn samples(problem: &Problem, pair: &[View; 2]) -> Vec<Sample> {
    let mut out = Vec::new();
    for (&index, after) in &pair[1].replays {
        let before = pair[0].replays.get(&index);
        let segment = &problem.segments[index];
        let run = &problem.campaign.runs[segment.run];
        let motion = &problem.smoothings[segment.run].stick_slip;
        let smoothed = &motion.smoothed;
        for k in (0..segment.time.len()).filter(|&k| segment.trusted[k]) {
            let instant = Instant::new(
                &problem.smoothings[segment.run],
                segment.time[k] - run.time[0],
            );
            let slot = instant.slot;
            let force = smoothed.force[slot];
            let both = |value: &dyn Fn(&crate::diagnose::explanation::replay::Replay) -> f64| {
                [before.map_or(f64::NAN, value), value(after)]
            };
            out.push(Sample {
                run: segment.run,
                since_start: segment.time[k] - segment.time[0],
                contact_phase: instant.contact_phase,
                relative_velocity: motion.relative_velocity[slot],
                displacement: smoothed.displacement[slot],
                travel: instant.travel,
                force,
                residual: both(&|r| segment.measured[k] - r.measured[k]),
                unexplained: both(&|r| force - r.force[k]),
            });
        }
    }
    out
}
