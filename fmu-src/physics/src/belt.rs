//! What drives the system from outside: the belt's velocity, the normal force, a force on the tip and a clamp that shakes.

use crate::error::{PhysicsError, require};
use crate::real::{Real, ZERO};

/// Share of the size of the terms `x(t)` and `x' t` by which two statements of one line may differ: some units in the last place.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Inputs as linear functions of time from `since` on: `v0(t) = belt_velocity + rate (t - since)`.
///
/// The external force F_ext acts on the tip beside friction and is positive along the belt's motion: each mode
/// gets `phi_j(1) F_ext / m_j` in slip and stick alike, and what stick must hold changes by `-F_ext`.
///
/// The acceleration a of the clamp is positive along the belt's motion. Displacements are relative to the clamp and the belt
/// moves with it, so that each mode gets `-g_j a` with [`crate::beam::clamp_participation`] (Inman 2014, Engineering Vibration,
/// sect. 2.4).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Time in s from which on the inputs hold.
    pub since: Real,
    /// Velocity v0 of the belt in m/s at `since`; zero and negative values are allowed.
    pub belt_velocity: Real,
    /// Its rate in m/s^2.
    pub belt_acceleration: Real,
    /// Normal force F_N in N at `since`, not negative.
    pub normal_force: Real,
    /// Its rate in N/s.
    pub normal_force_rate: Real,
    /// External force F_ext on the tip in N at `since`, positive along the belt's motion.
    pub external_force: Real,
    /// Its rate in N/s.
    pub external_force_rate: Real,
    /// Acceleration a of the clamp in m/s^2 at `since`, positive along the belt's motion.
    pub clamp_acceleration: Real,
    /// Its rate in m/s^3.
    pub clamp_acceleration_rate: Real,
}

impl Inputs {
    /// Constant belt velocity in m/s and normal force in N, no external force, and a clamp at rest.
    pub fn constant(belt_velocity: Real, normal_force: Real) -> Self {
        Self {
            since: ZERO,
            belt_velocity,
            belt_acceleration: ZERO,
            normal_force,
            normal_force_rate: ZERO,
            external_force: ZERO,
            external_force_rate: ZERO,
            clamp_acceleration: ZERO,
            clamp_acceleration_rate: ZERO,
        }
    }

    /// Belt velocity v0(t) in m/s.
    #[inline]
    pub fn belt_velocity_at(&self, t: Real) -> Real {
        self.belt_velocity + self.belt_acceleration * (t - self.since)
    }

    /// Distance in m that the belt has run since `since`.
    #[inline]
    pub fn belt_distance_at(&self, t: Real) -> Real {
        let dt = t - self.since;
        dt * (self.belt_velocity + 0.5 * self.belt_acceleration * dt)
    }

    /// Normal force F_N(t) in N; a ramp that would lift the contact off stays at zero.
    #[inline]
    pub fn normal_force_at(&self, t: Real) -> Real {
        (self.normal_force + self.normal_force_rate * (t - self.since)).max(0.0)
    }

    /// External force F_ext(t) on the tip in N.
    #[inline]
    pub fn external_force_at(&self, t: Real) -> Real {
        self.external_force + self.external_force_rate * (t - self.since)
    }

    /// Acceleration a(t) of the clamp in m/s^2.
    #[inline]
    pub fn clamp_acceleration_at(&self, t: Real) -> Real {
        self.clamp_acceleration + self.clamp_acceleration_rate * (t - self.since)
    }

    /// The same functions of time, stated from `t` in s on.
    pub fn from(&self, t: Real) -> Self {
        Self {
            since: t,
            belt_velocity: self.belt_velocity_at(t),
            normal_force: self.normal_force_at(t),
            external_force: self.external_force_at(t),
            clamp_acceleration: self.clamp_acceleration_at(t),
            ..*self
        }
    }

    /// Value at `since` and rate of each input.
    fn lines(&self) -> [(Real, Real); 4] {
        [
            (self.belt_velocity, self.belt_acceleration),
            (self.normal_force, self.normal_force_rate),
            (self.external_force, self.external_force_rate),
            (self.clamp_acceleration, self.clamp_acceleration_rate),
        ]
    }

    /// Whether these inputs, stated from a later time on, are `later`: constants the same, lines the same
    /// but for the rounding of whoever stated them again.
    pub fn go_on_as(&self, later: &Self) -> bool {
        let now = self.from(later.since).lines();
        let mut both = now.into_iter().zip(later.lines());
        both.all(|((value, rate), (of_later, rate_of_later))| {
            // Of a constant not even rounding may get lost.
            let rounding = match rate == 0.0 {
                true => ZERO,
                false => ROUNDING * (value.abs() + (rate * later.since).abs()),
            };
            rate == rate_of_later && (value - of_later).abs() <= rounding
        })
    }

    /// Whether nothing varies in time.
    pub fn are_steady(&self) -> bool {
        self.lines().iter().all(|(_, rate)| *rate == 0.0)
    }

    /// Checks the values.
    ///
    /// # Errors
    /// A negative normal force, or a value that is not finite.
    pub fn check(&self) -> Result<(), PhysicsError> {
        require(true, "belt_velocity", self.belt_velocity, "m/s", "finite")?;
        require(
            true,
            "belt acceleration",
            self.belt_acceleration,
            "m/s2",
            "finite",
        )?;
        require(
            self.normal_force >= 0.0,
            "normal_force",
            self.normal_force,
            "N",
            "zero or positive",
        )?;
        require(
            true,
            "normal force rate",
            self.normal_force_rate,
            "N/s",
            "finite",
        )?;
        require(true, "external_force", self.external_force, "N", "finite")?;
        require(
            true,
            "external force rate",
            self.external_force_rate,
            "N/s",
            "finite",
        )?;
        require(
            true,
            "clamp_acceleration",
            self.clamp_acceleration,
            "m/s2",
            "finite",
        )?;
        require(
            true,
            "clamp acceleration rate",
            self.clamp_acceleration_rate,
            "m/s3",
            "finite",
        )
    }
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_on_whoever_states_it_again_and_another_value_or_rate_does_not() {
        let line = Inputs {
            since: 0.3,
            normal_force_rate: -41.0,
            external_force: -5.3,
            external_force_rate: 1370.1,
            ..Inputs::constant(0.1, 90.0)
        };
        let later = line.from(7.7);
        assert!(line.go_on_as(&later));
        let again = Inputs {
            external_force: later.external_force + 4e-12,
            ..later
        };
        assert!(line.go_on_as(&again) && again != later);
        let changes: [fn(&mut Inputs); 4] = [
            |i| i.external_force += 1e-6,
            |i| i.external_force_rate = 0.0,
            |i| i.normal_force = 0.0,
            |i| i.belt_velocity += 1e-16,
        ];
        for change in changes {
            let mut other = line.from(1.0);
            change(&mut other);
            assert!(!line.go_on_as(&other), "{other:?}");
        }
    }
}
