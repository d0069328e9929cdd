//! The equations of motion: rates of all states, and what changes at once as the contact changes.

use super::Model;
use crate::beam::MAX_MODES;
use crate::contact::ContactMode;
use crate::effects::{ContactForce, Motion};
use crate::integrate::State;
use crate::real::{Real, ZERO};

impl Model {
    /// Modal accelerations without the friction force, external force and clamp included; returns the tip's acceleration under them.
    #[inline]
    pub(super) fn free_acceleration(
        &self,
        m: &Motion,
        x: &State,
        acceleration: &mut [Real; MAX_MODES],
    ) -> Real {
        let mut force = self.inputs.external_force_at(m.time);
        for e in self.effects.iter() {
            force += e.effect.tip_force(m, self.states(e, x));
        }
        let clamp = self.inputs.clamp_acceleration_at(m.time);
        for j in 0..self.mode_count {
            acceleration[j] = self.gain[j] * force
                - self.damping[j] * x[2 * j + 1]
                - self.stiffness[j] * x[2 * j]
                - self.clamp_participation[j] * clamp;
        }
        if !self.effects.is_empty() {
            for e in self.effects.iter() {
                e.effect.add_modal_acceleration(
                    m,
                    self.states(e, x),
                    &x[..2 * self.mode_count],
                    &mut acceleration[..self.mode_count],
                );
            }
        }
        (0..self.mode_count)
            .map(|j| self.tip_value[j] * acceleration[j])
            .sum()
    }

    /// Rates of all states in a mode. In slip, `mode` fixes the sign of friction even where the
    /// integrator looks slightly beyond v_r = 0.
    #[inline]
    pub fn rates(&self, t: Real, x: &State, mode: ContactMode, rates: &mut State) {
        if self.effects.is_empty() {
            self.base_rates(t, x, mode, rates);
        } else {
            self.evaluate(t, x, mode, rates);
        }
    }

    /// Rates of the reference model alone: the same operations as in `evaluate`, without the hooks.
    #[inline]
    pub(super) fn base_rates(&self, t: Real, x: &State, mode: ContactMode, rates: &mut State) {
        let (mut velocity, mut free) = (ZERO, ZERO);
        let mut acceleration = [ZERO; MAX_MODES];
        let clamp = self.inputs.clamp_acceleration_at(t);
        for j in 0..self.mode_count {
            velocity += self.tip_value[j] * x[2 * j + 1];
            acceleration[j] = -self.damping[j] * x[2 * j + 1]
                - self.stiffness[j] * x[2 * j]
                - self.clamp_participation[j] * clamp;
            free += self.tip_value[j] * acceleration[j];
        }
        // In stick the belt alone says how the tip moves: friction takes up whatever pushes besides.
        let force = if mode == ContactMode::Stuck {
            (self.inputs.belt_acceleration - free) / self.mobility
        } else {
            let sign = mode.sign();
            let speed = sign * (velocity - self.inputs.belt_velocity_at(t));
            let normal = self.inputs.normal_force_at(t);
            let friction = -sign * self.friction.coefficient(speed) * self.level * normal;
            friction + self.inputs.external_force_at(t)
        };
        for j in 0..self.mode_count {
            rates[2 * j] = x[2 * j + 1];
            rates[2 * j + 1] = acceleration[j] + self.gain[j] * force;
        }
    }

    /// Rates, and the friction force on the tip in N.
    pub fn evaluate(
        &self,
        t: Real,
        x: &State,
        mode: ContactMode,
        rates: &mut State,
    ) -> ContactForce {
        let k = self.kinematics(t, x, mode);
        let mut acceleration = [ZERO; MAX_MODES];
        let free = self.free_acceleration(&k.motion, x, &mut acceleration);
        let contact = self.contact_from(&k, free, x, mode);
        for j in 0..self.mode_count {
            rates[2 * j] = x[2 * j + 1];
            rates[2 * j + 1] = acceleration[j] + self.gain[j] * contact.force;
        }
        for e in self.effects.iter().filter(|e| !e.is_mode) {
            let range = e.first_state..e.first_state + e.nominals.len();
            rates[range.clone()].fill(ZERO);
            e.effect
                .add_rates(&k.motion, &contact, &x[range.clone()], &mut rates[range]);
        }
        contact
    }

    /// Removes the relative velocity so that the contact can stick: each mode takes its share
    /// `(phi_j/m_j) / sum(phi^2/m)`, as an impulse at the tip would do.
    pub fn project_on_stick(&self, t: Real, x: &mut State) {
        self.push(-self.relative_velocity(t, x), x);
    }

    /// Changes the tip's velocity by `change` in m/s as an impulse at the tip would do: each mode takes
    /// its share `(phi_j/m_j) / sum(phi^2/m)`.
    pub fn push(&self, change: Real, x: &mut State) {
        for j in 0..self.mode_count {
            x[2 * j + 1] += change * self.gain[j] / self.mobility;
        }
    }

    /// Jumps of the effects' states at the arrival in stick.
    pub fn on_stick(&self, x: &mut State) {
        for e in self.effects.iter() {
            e.effect
                .on_stick(&mut x[e.first_state..e.first_state + e.nominals.len()]);
        }
    }

    /// Jumps of the effects' states at break-away.
    pub fn on_break_away(&self, x: &mut State) {
        for e in self.effects.iter() {
            e.effect
                .on_break_away(&mut x[e.first_state..e.first_state + e.nominals.len()]);
        }
    }

    /// Adds to the effects' states the values that are in equilibrium with the start motion.
    pub fn settle(&self, t: Real, x: &mut State, mode: ContactMode) {
        let k = self.kinematics(t, x, mode);
        let free = self.free_acceleration(&k.motion, x, &mut [ZERO; MAX_MODES]);
        let contact = if self.has_memory {
            // The bristle's own force is what is sought: take the constraint force within capacity.
            let capacity = self.capacity(&k.motion, x);
            let force = self.constraint_force_from(t, free, &k.give);
            // What is no number is passed on and ends the motion; `clamp` would panic.
            let force = if capacity.is_nan() {
                capacity
            } else {
                force.max(-capacity).min(capacity)
            };
            let sliding =
                k.motion.relative_velocity.abs() > 0.01 * (k.motion.belt_velocity.abs() + 1e-6);
            let force = if sliding {
                -mode.sign() * capacity
            } else {
                force
            };
            ContactForce {
                force,
                capacity,
                stuck: false,
            }
        } else {
            self.contact_from(&k, free, x, mode)
        };
        for e in self.effects.iter() {
            let range = e.first_state..e.first_state + e.nominals.len();
            e.effect.settle(&k.motion, &contact, &mut x[range]);
        }
    }
}
