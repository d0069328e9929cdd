//! The contact of tip and belt: its mode and the transitions between modes.

use crate::real::Real;

/// Mode of the contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactMode {
    /// Slip with v_r < 0: the tip lags behind the belt.
    Backward,
    /// Stick: v_r = 0, friction is a constraint force.
    Stuck,
    /// Slip with v_r > 0: the tip overtakes the belt.
    Forward,
}

impl ContactMode {
    /// -1, 0 or +1: the sign of the relative velocity.
    #[inline]
    pub fn sign(self) -> f64 {
        match self {
            Self::Backward => -1.0,
            Self::Stuck => 0.0,
            Self::Forward => 1.0,
        }
    }

    /// The slip mode of a relative velocity (or of the motion that it is about to take).
    pub fn slip_towards(velocity: impl Into<f64>) -> Self {
        if velocity.into() < 0.0 {
            Self::Backward
        } else {
            Self::Forward
        }
    }
}

/// A transition: the mode that was left, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition {
    /// Time in s.
    pub time: Real,
    /// Mode left.
    pub from: ContactMode,
    /// Mode entered.
    pub to: ContactMode,
}
