//! Where the tip and the belt are and how fast they move, and what a sensor makes of it.

use super::{Enabled, Model};
use crate::beam::MAX_MODES;
use crate::contact::ContactMode;
use crate::effects::{BeltGive, Motion};
use crate::integrate::{State, row_of};
use crate::real::{Real, ZERO};

/// Kinematics shared by all evaluations at one instant.
pub(super) struct Kinematics {
    pub(super) motion: Motion,
    pub(super) give: BeltGive,
}

impl Model {
    /// Tip displacement w in m and velocity w' in m/s.
    #[inline]
    pub fn tip(&self, x: &State) -> (Real, Real) {
        let (mut w, mut v) = (ZERO, ZERO);
        for j in 0..self.mode_count {
            w += self.tip_value[j] * x[2 * j];
            v += self.tip_value[j] * x[2 * j + 1];
        }
        (w, v)
    }

    /// Displacement in m and velocity in m/s where the sensor looks, from the state and what [`Self::tip`] is in it.
    #[inline]
    pub fn sensor(&self, x: &State, tip: (Real, Real)) -> (Real, Real) {
        let Some(value) = &self.sensor_value else {
            return tip;
        };
        let (mut w, mut v) = (ZERO, ZERO);
        for j in 0..self.mode_count {
            w += value[j] * x[2 * j];
            v += value[j] * x[2 * j + 1];
        }
        (w, v)
    }

    /// Mode shapes where the sensor looks.
    pub fn sensor_values(&self) -> [Real; MAX_MODES] {
        self.sensor_value.unwrap_or(self.tip_value)
    }

    /// What drives that give way add to the belt's motion; linear in their states.
    #[inline]
    pub(crate) fn belt_give(&self, x: &State) -> BeltGive {
        let mut give = BeltGive {
            mobility: self.give_mobility,
            ..BeltGive::default()
        };
        for &(state, row) in self.give_rows.iter() {
            give.add(row.times(x[state]));
        }
        give
    }

    /// Velocity in m/s that effects impose on the belt.
    #[inline]
    pub fn belt_ripple(&self, t: Real) -> Real {
        if !self.has_ripple {
            return ZERO;
        }
        let ripple = |e: &Enabled| e.effect.belt_ripple(t, &self.inputs);
        self.effects.iter().map(ripple).sum()
    }

    /// Whether effects impose a velocity on the belt that varies in time.
    pub fn has_belt_ripple(&self) -> bool {
        self.has_ripple
    }

    /// Its rate in m/s^2, by central differences of fourth order (error below 1e-9 of its amplitude up
    /// to 200 Hz).
    pub(super) fn belt_ripple_rate(&self, t: Real) -> Real {
        const H: f64 = 1e-5;
        if !self.has_ripple {
            return ZERO;
        }
        let slope = |h: f64| (self.belt_ripple(t + h) - self.belt_ripple(t - h)) / (2.0 * h);
        (4.0 * slope(H) - slope(2.0 * H)) / 3.0
    }

    #[inline]
    pub(super) fn kinematics(&self, t: Real, x: &State, mode: ContactMode) -> Kinematics {
        let (displacement, velocity) = self.tip(x);
        let (sensor_displacement, sensor_velocity) = self.sensor(x, (displacement, velocity));
        let give = self.belt_give(x);
        let given_belt_velocity = self.inputs.belt_velocity_at(t);
        let belt_velocity = given_belt_velocity + self.belt_ripple(t) + give.velocity;
        let stuck = mode == ContactMode::Stuck;
        let relative_velocity = if stuck {
            ZERO
        } else {
            velocity - belt_velocity
        };
        Kinematics {
            motion: Motion {
                time: t,
                displacement,
                velocity,
                sensor_displacement,
                sensor_velocity,
                given_belt_velocity,
                belt_velocity,
                relative_velocity,
                speed: relative_velocity * mode.sign(),
                normal_force: self.inputs.normal_force_at(t),
                travel: self.travel_offset + self.inputs.belt_distance_at(t) + give.displacement
                    - displacement,
                dwell: if stuck { t - self.stick_since } else { ZERO },
            },
            give,
        }
    }

    /// The motion at one instant.
    pub fn motion(&self, t: Real, x: &State, mode: ContactMode) -> Motion {
        self.kinematics(t, x, mode).motion
    }

    /// Displacement in m as the sensor gives it.
    pub fn measured_displacement(&self, t: Real, x: &State, mode: ContactMode) -> Real {
        let (mut reading, _) = self.sensor(x, self.tip(x));
        if !self.effects.is_empty() {
            let m = self.motion(t, x, mode);
            for e in self.effects.iter() {
                let own = self.states(e, x);
                reading = e.effect.measured_displacement(reading, &m, own);
            }
        }
        reading + self.sensor_offset
    }

    /// The same as `offset + row x`; `None` where a sensor is not linear.
    pub fn measured_row(&self) -> Option<(State, Real)> {
        let linear = self.effects.iter().all(|e| e.effect.measures_linearly());
        linear.then(|| {
            row_of(self.dimension, |x| {
                self.measured_displacement(ZERO, x, ContactMode::Backward)
            })
        })
    }

    /// Relative velocity v_r in m/s from the state alone.
    #[inline]
    pub fn relative_velocity(&self, t: Real, x: &State) -> Real {
        let (_, velocity) = self.tip(x);
        let give = self.belt_give(x).velocity;
        velocity - self.inputs.belt_velocity_at(t) - self.belt_ripple(t) - give
    }

    /// Relative acceleration v_r' in m/s^2 from the rates alone.
    #[inline]
    pub fn relative_acceleration(&self, t: Real, rates: &State) -> Real {
        // v_r is linear in the state, so its slope is the same functional of the rates.
        self.relative_velocity(t, rates) + self.inputs.belt_velocity_at(t) + self.belt_ripple(t)
            - self.inputs.belt_acceleration
            - self.belt_ripple_rate(t)
    }
}
