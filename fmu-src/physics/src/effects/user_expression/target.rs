//! Where a user's effect acts.

use super::quantity::{COUNT, GIVEN};

/// What a user's effect acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Factor on the coefficient of friction, static (at v_r = 0) and kinetic.
    FrictionFactor,
    /// Factor on the normal force.
    NormalForceFactor,
    /// Force on the tip in N, positive along w.
    TipForce,
    /// Velocity in m/s added to the belt's; its formula may use t, F_N and v0 only.
    BeltVelocity,
    /// Factor on the natural frequencies; what damping takes stays as it is.
    FrequencyFactor,
    /// Factor on the damping of the modes.
    DampingFactor,
    /// What the sensor makes of the displacement w, in m.
    Measurement,
    /// Acceleration of the clamp in m/s^2, positive along w, which is counted from the clamp; its formula may use t, F_N and
    /// v0 only.
    ClampAcceleration,
}

impl Target {
    /// All targets with their names in files.
    pub const ALL: [(&'static str, Self); 8] = [
        ("friction_factor", Self::FrictionFactor),
        ("normal_force_factor", Self::NormalForceFactor),
        ("tip_force", Self::TipForce),
        ("belt_velocity", Self::BeltVelocity),
        ("frequency_factor", Self::FrequencyFactor),
        ("damping_factor", Self::DampingFactor),
        ("measurement", Self::Measurement),
        ("clamp_acceleration", Self::ClampAcceleration),
    ];

    /// The target of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|t| t.0 == name).map(|t| t.1)
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        let is_it = |t: &&(&str, Self)| t.1 == self;
        Self::ALL.iter().find(is_it).expect("ALL is complete").0
    }

    /// Which quantities its formula may look at.
    pub(super) fn may_use(self) -> [bool; COUNT] {
        match self {
            Self::BeltVelocity | Self::ClampAcceleration => GIVEN,
            _ => [true; COUNT],
        }
    }

    /// Value of the formula that changes nothing, at the displacement `w` in m.
    pub fn neutral(self, w: f64) -> f64 {
        match self {
            Self::FrictionFactor
            | Self::NormalForceFactor
            | Self::FrequencyFactor
            | Self::DampingFactor => 1.0,
            Self::TipForce | Self::BeltVelocity | Self::ClampAcceleration => 0.0,
            Self::Measurement => w,
        }
    }
}
