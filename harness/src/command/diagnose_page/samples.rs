//! Every sample of the shots with what was measured there, what the contact did, and what two models say.

use super::views::View;
use crate::diagnose::moment::{Instant, Moment};
use crate::diagnose::session::Session;

/// One sample of a shot.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Index of the run.
    pub run: usize,
    /// Time since the shot began in s.
    pub since_start: f64,
    /// What the contact does.
    pub moment: Moment,
    /// Smoothed tip velocity less belt velocity in m/s.
    pub relative_velocity: f64,
    /// Smoothed displacement in m.
    pub displacement: f64,
    /// Distance that belt and tip have moved against each other since the run began, in m.
    pub travel: f64,
    /// Contact force that the measurement implies, in N.
    pub force: f64,
    /// Measured less predicted displacement in m, before and after.
    pub residual: [f64; 2],
    /// Force less the model's in N, before and after.
    pub unexplained: [f64; 2],
}

/// Samples of all shots that the second model predicts, trusted ones only.
pub fn samples(session: &Session, pair: &[View; 2]) -> Vec<Sample> {
    let mut out = Vec::new();
    for (&index, after) in &pair[1].replays {
        let before = pair[0].replays.get(&index);
        let shot = &session.shots[index];
        let run = &session.campaign.runs[shot.run];
        let motion = &session.smoothings[shot.run].stick_slip;
        let smoothed = &motion.smoothed;
        for k in (0..shot.time.len()).filter(|&k| shot.trusted[k]) {
            let instant = Instant::new(run, motion, shot.time[k] - run.time[0]);
            let slot = instant.slot;
            let force = smoothed.force[slot];
            let both = |value: &dyn Fn(&crate::diagnose::replay::Replay) -> f64| {
                [before.map_or(f64::NAN, value), value(after)]
            };
            out.push(Sample {
                run: shot.run,
                since_start: shot.time[k] - shot.time[0],
                moment: instant.moment,
                relative_velocity: motion.relative_velocity[slot],
                displacement: smoothed.displacement[slot],
                travel: instant.travel,
                force,
                residual: both(&|r| shot.measured[k] - r.displacement[k]),
                unexplained: both(&|r| force - r.force[k]),
            });
        }
    }
    out
}
