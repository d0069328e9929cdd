//! Room for the series of one step, kept from step to step: clearing 8 kB anew took as long as a fifth of the step.

use super::{MAX_FACTORS, NONE};
use crate::effects::Motion;
use crate::effects::series::{MotionSeries, Series};
use crate::friction::series::CoefficientRoom;

/// Series of one step. Of each, the powers worked out so far are valid; those above are left over from other steps.
#[derive(Clone)]
pub struct Workspace {
    pub(super) motion: MotionSeries,
    pub(super) friction: CoefficientRoom,
    /// Coefficient of friction; in stick the static one.
    pub(super) mu: Series,
    /// Friction force on the tip in N.
    pub(super) force: Series,
    pub(super) factors: [Series; MAX_FACTORS],
    /// Capacity in N without factors, with the first, with the first two, ...
    pub(super) partial: [Series; MAX_FACTORS + 1],
    /// What effects keep; grows with the first step of a model that needs more.
    pub(super) registers: Vec<Series>,
    /// Velocity that effects impose on the belt, in m/s, known one power ahead.
    pub(super) ripple: Series,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            motion: MotionSeries::new(1.0, Motion::default()),
            friction: CoefficientRoom::default(),
            mu: NONE,
            force: NONE,
            factors: [NONE; MAX_FACTORS],
            partial: [NONE; MAX_FACTORS + 1],
            registers: Vec::new(),
            ripple: NONE,
        }
    }
}

impl Workspace {
    /// Makes room for `count` registers.
    pub(super) fn keep(&mut self, count: usize) {
        if self.registers.len() < count {
            self.registers.resize(count, NONE);
        }
    }

    /// The sliding speed sgn(v_r) v_r in m/s of the stretch of slip expanded last, up to the degree of its segment.
    pub fn sliding_speed(&self) -> &Series {
        &self.motion.speed
    }
}
