//! Friction at one instant: its limit in stick, the force that keeps v_r = 0, and which mode holds at rest.

use super::Model;
use super::kinematics::Kinematics;
use crate::beam::MAX_MODES;
use crate::contact::ContactMode;
use crate::effects::{BeltGive, ContactForce, Motion};
use crate::integrate::State;
use crate::real::{Real, ZERO};

/// Zero for negative values; what is not a number stays so, to be noticed.
pub(super) fn not_negative(value: Real) -> Real {
    if value < 0.0 { ZERO } else { value }
}

impl Model {
    /// Normal force after all effects, in N; contact can't pull.
    pub(super) fn effective_normal_force(&self, m: &Motion, x: &State) -> Real {
        let mut force = m.normal_force;
        for e in self.effects.iter() {
            force *= e.effect.normal_factor(m, self.states(e, x));
        }
        not_negative(force)
    }

    pub(super) fn friction_factor(&self, m: &Motion, x: &State) -> Real {
        let mut factor = self.level;
        for e in self.effects.iter() {
            factor *= e.effect.friction_factor(m, self.states(e, x));
        }
        not_negative(factor)
    }

    /// Friction capacity mu(|v_r|) F_N in N while sliding.
    pub(super) fn capacity(&self, m: &Motion, x: &State) -> Real {
        let speed = self
            .effects
            .iter()
            .find_map(|e| e.effect.lagged_speed(self.states(e, x)))
            .unwrap_or(m.speed);
        let coefficient = self.friction.coefficient(speed) + self.friction_slope * speed;
        not_negative(coefficient) * self.friction_factor(m, x) * self.effective_normal_force(m, x)
    }

    /// Whether the constraint force follows from the state alone during stick under the present inputs.
    pub fn keeps_force_steady(&self) -> bool {
        self.inputs.external_force_rate == 0.0 && self.inputs.clamp_acceleration_rate == 0.0
    }

    /// Largest friction force in N that stick can carry.
    pub fn static_limit(&self, t: Real, x: &State) -> Real {
        if self.effects.is_empty() {
            return self.static_coefficient * self.level * self.inputs.normal_force_at(t);
        }
        let m = self.kinematics(t, x, ContactMode::Stuck).motion;
        let mut factor = self.friction_factor(&m, x);
        for e in self.effects.iter() {
            factor *= e.effect.static_factor(&m);
        }
        self.static_coefficient * factor * self.effective_normal_force(&m, x)
    }

    /// Force that keeps v_r = 0, from `w'' = v_belt'`:
    /// `F_c = (v0' + x''_free - w''_free) / (sum phi_j^2/m_j + belt mobility)` in N.
    #[inline]
    pub(super) fn constraint_force_from(&self, t: Real, free: Real, give: &BeltGive) -> Real {
        let imposed = self.inputs.belt_acceleration + self.belt_ripple_rate(t);
        (imposed + give.free_acceleration - free) / (self.mobility + give.mobility)
    }

    /// Constraint force F_c in N that would keep the contact sticking.
    pub fn constraint_force(&self, t: Real, x: &State) -> Real {
        let k = self.kinematics(t, x, ContactMode::Stuck);
        let free = self.free_acceleration(&k.motion, x, &mut [ZERO; MAX_MODES]);
        self.constraint_force_from(k.motion.time, free, &k.give)
    }

    pub(super) fn contact_from(
        &self,
        k: &Kinematics,
        free: Real,
        x: &State,
        mode: ContactMode,
    ) -> ContactForce {
        if mode == ContactMode::Stuck {
            return ContactForce {
                force: self.constraint_force_from(k.motion.time, free, &k.give),
                capacity: ZERO,
                stuck: true,
            };
        }
        let capacity = self.capacity(&k.motion, x);
        let force = if self.has_memory {
            self.effects
                .iter()
                .map(|e| {
                    e.effect
                        .memory_force(&k.motion, capacity, self.states(e, x))
                })
                .sum()
        } else {
            -mode.sign() * capacity
        };
        ContactForce {
            force,
            capacity,
            stuck: false,
        }
    }

    /// Whether v_r is zero to rounding.
    pub fn is_at_rest(&self, t: Real, x: &State) -> bool {
        let (_, velocity) = self.tip(x);
        let belt = self.inputs.belt_velocity_at(t);
        self.relative_velocity(t, x).abs() <= 1e-12 * (belt.abs() + velocity.abs() + 1e-6)
    }

    /// Stick or the slip that starts from v_r = 0: stick while |F_c| is within its limit.
    pub fn mode_at_rest(&self, t: Real, x: &State) -> ContactMode {
        let force = self.constraint_force(t, x);
        if force.abs() <= self.static_limit(t, x) {
            ContactMode::Stuck
        } else {
            ContactMode::slip_towards(-force)
        }
    }
}
