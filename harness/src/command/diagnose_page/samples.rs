//! Every sample of the shots with what was measured there, what the contact did, and what two models say.

use super::views::View;
use crate::diagnose::session::Session;
use crate::observer::{Phase, PhaseMode};

/// What the contact does at a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moment {
    /// The tip rests on the belt.
    Stick,
    /// Within [`MARGIN`] of a break-away.
    BreakAway,
    /// Slip, growing faster.
    Accelerating,
    /// Slip, growing slower.
    Decelerating,
    /// Within [`MARGIN`] of coming to rest.
    Arrival,
}

impl Moment {
    /// All, in the order of a cycle.
    pub const ALL: [Moment; 5] = [
        Moment::Stick,
        Moment::BreakAway,
        Moment::Accelerating,
        Moment::Decelerating,
        Moment::Arrival,
    ];

    /// The words for a picture.
    pub fn name(self) -> &'static str {
        match self {
            Moment::Stick => "stick",
            Moment::BreakAway => "break-away",
            Moment::Accelerating => "slip, accelerating",
            Moment::Decelerating => "slip, decelerating",
            Moment::Arrival => "arrival (re-stick)",
        }
    }

    /// Whether the smoothed force can be trusted: it can't follow the jump at a transition.
    pub fn is_steady(self) -> bool {
        !matches!(self, Moment::BreakAway | Moment::Arrival)
    }
}

/// Time about a transition in s that belongs to it.
pub const MARGIN: f64 = 5e-4;

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
            let time = shot.time[k] - run.time[0];
            let slot =
                ((time / smoothed.sample_interval).round() as usize).min(smoothed.force.len() - 1);
            let (force, displacement) = (smoothed.force[slot], smoothed.displacement[slot]);
            let relative_velocity = motion.relative_velocity[slot];
            let both = |value: &dyn Fn(&crate::diagnose::replay::Replay) -> f64| {
                [before.map_or(f64::NAN, value), value(after)]
            };
            out.push(Sample {
                run: shot.run,
                since_start: shot.time[k] - shot.time[0],
                moment: moment(
                    &motion.phases,
                    time,
                    relative_velocity * smoothed.acceleration[slot] > 0.0,
                ),
                relative_velocity,
                displacement,
                travel: run.belt_velocity * time - (displacement - smoothed.displacement[0]),
                force,
                residual: both(&|r| shot.measured[k] - r.displacement[k]),
                unexplained: both(&|r| force - r.force[k]),
            });
        }
    }
    out
}

fn moment(phases: &[Phase], time: f64, speeding_up: bool) -> Moment {
    let at = phases.partition_point(|p| p.start <= time).max(1) - 1;
    let sticks = |i: usize| phases.get(i).is_some_and(|p| p.mode == PhaseMode::Stick);
    let here = &phases[at];
    let (since, left) = (time - here.start, here.end - time);
    let (first, last) = (at == 0, at + 1 == phases.len());
    match sticks(at) {
        true if !last && left < MARGIN => Moment::BreakAway,
        true if !first && since < MARGIN => Moment::Arrival,
        true => Moment::Stick,
        false if !first && sticks(at - 1) && since < MARGIN => Moment::BreakAway,
        false if !last && sticks(at + 1) && left < MARGIN => Moment::Arrival,
        false if speeding_up => Moment::Accelerating,
        false => Moment::Decelerating,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn phase(mode: PhaseMode, start: f64, end: f64) -> Phase {
        Phase {
            mode,
            start,
            end,
            first: 0,
            past: 0,
            certainty: 1.0,
            complete: true,
        }
    }

    #[test]
    fn a_cycle_has_its_moments_in_order() {
        let phases = [
            phase(PhaseMode::Stick, 0.0, 0.01),
            phase(PhaseMode::BackwardSlip, 0.01, 0.02),
            phase(PhaseMode::Stick, 0.02, 0.03),
        ];
        let at = |t, up| moment(&phases, t, up);
        assert_eq!(at(0.005, true), Moment::Stick);
        assert_eq!(at(0.0098, true), Moment::BreakAway);
        assert_eq!(at(0.0102, true), Moment::BreakAway);
        assert_eq!(at(0.012, true), Moment::Accelerating);
        assert_eq!(at(0.017, false), Moment::Decelerating);
        assert_eq!(at(0.0198, false), Moment::Arrival);
        assert_eq!(at(0.0202, false), Moment::Arrival);
        assert_eq!(at(0.0295, false), Moment::Stick);
    }
}
