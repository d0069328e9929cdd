//! What the contact does at an instant: stick, break-away, slip, arrival.

use crate::observer::{Phase, PhaseMode};
use crate::smoothing::Smoothing;

/// What the contact does at a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactPhase {
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

impl ContactPhase {
    /// All, in the order of a cycle.
    pub const ALL: [ContactPhase; 5] = [
        ContactPhase::Stick,
        ContactPhase::BreakAway,
        ContactPhase::Accelerating,
        ContactPhase::Decelerating,
        ContactPhase::Arrival,
    ];

    /// The words for a picture.
    pub fn name(self) -> &'static str {
        match self {
            ContactPhase::Stick => "stick",
            ContactPhase::BreakAway => "break-away",
            ContactPhase::Accelerating => "slip, accelerating",
            ContactPhase::Decelerating => "slip, decelerating",
            ContactPhase::Arrival => "arrival (re-stick)",
        }
    }

    /// Whether the smoothed force can be trusted: it can't follow the jump at a transition.
    pub fn is_steady(self) -> bool {
        !matches!(self, ContactPhase::BreakAway | ContactPhase::Arrival)
    }
}

/// Time about a transition in s that belongs to it.
pub const MARGIN: f64 = 5e-4;

/// Where a run is at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Instant {
    /// Place in the smoothed motion.
    pub slot: usize,
    /// What the contact does.
    pub contact_phase: ContactPhase,
    /// Distance that belt and tip have moved against each other since the run began, in m.
    pub travel: f64,
}

impl Instant {
    /// `time` in s since the run began, by its smoothed motion.
    pub fn new(smoothing: &Smoothing, time: f64) -> Self {
        let motion = &smoothing.stick_slip;
        let smoothed = &motion.smoothed;
        let slot =
            ((time / smoothed.sample_interval).round() as usize).min(smoothed.force.len() - 1);
        let speeding_up = motion.relative_velocity[slot] * smoothed.acceleration[slot] > 0.0;
        let moved = smoothed.displacement[slot] - smoothed.displacement[0];
        Self {
            slot,
            contact_phase: contact_phase(&motion.phases, time, speeding_up),
            travel: smoothing.belt_path.at(time) - moved,
        }
    }
}

/// What the contact does at `time` in s since the run began; `speeding_up` tells the two halves of slip apart.
fn contact_phase(phases: &[Phase], time: f64, speeding_up: bool) -> ContactPhase {
    let at = phases.partition_point(|p| p.start <= time).max(1) - 1;
    let sticks = |i: usize| phases.get(i).is_some_and(|p| p.mode == PhaseMode::Stick);
    let here = &phases[at];
    let (since, left) = (time - here.start, here.end - time);
    let (first, last) = (at == 0, at + 1 == phases.len());
    match sticks(at) {
        true if !last && left < MARGIN => ContactPhase::BreakAway,
        true if !first && since < MARGIN => ContactPhase::Arrival,
        true => ContactPhase::Stick,
        false if !first && sticks(at - 1) && since < MARGIN => ContactPhase::BreakAway,
        false if !last && sticks(at + 1) && left < MARGIN => ContactPhase::Arrival,
        false if speeding_up => ContactPhase::Accelerating,
        false => ContactPhase::Decelerating,
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
        let at = |t, up| contact_phase(&phases, t, up);
        assert_eq!(at(0.005, true), ContactPhase::Stick);
        assert_eq!(at(0.0098, true), ContactPhase::BreakAway);
        assert_eq!(at(0.0102, true), ContactPhase::BreakAway);
        assert_eq!(at(0.012, true), ContactPhase::Accelerating);
        assert_eq!(at(0.017, false), ContactPhase::Decelerating);
        assert_eq!(at(0.0198, false), ContactPhase::Arrival);
        assert_eq!(at(0.0202, false), ContactPhase::Arrival);
        assert_eq!(at(0.0295, false), ContactPhase::Stick);
    }
}
