//! Event functions, and the mode that follows an event.

use super::{ARRIVAL_BAND, EVENT_FUNCTIONS, FORCE_BAND, Hybrid};
use crate::contact::ContactMode;
use crate::simulate::DEPARTURE_VELOCITY;

/// Relative velocity, over the velocities involved, above which a jump of the belt's velocity ends stick.
const JUMP: f64 = 1e-9;

impl Hybrid {
    /// Static limit in N with its band.
    fn banded_limit(&self) -> f64 {
        let limit = self.model.static_limit(self.time, &self.state);
        limit * (1.0 + FORCE_BAND.0) + FORCE_BAND.1
    }

    /// The event functions: of slip in m/s, of stick in N (two). Those of the other mode are 1.
    pub fn event_functions(&self) -> [f64; EVENT_FUNCTIONS] {
        if self.mode == ContactMode::Stuck {
            let limit = self.banded_limit();
            let force = self.model.constraint_force(self.time, &self.state);
            [1.0, limit - force, limit + force]
        } else {
            let v_r = self.model.relative_velocity(self.time, &self.state);
            [self.mode.sign() * v_r + ARRIVAL_BAND, 1.0, 1.0]
        }
    }

    /// Decides at an event how the motion goes on. True where states have jumped.
    ///
    /// | mode | condition | becomes |
    /// |---|---|---|
    /// | stick | the belt's velocity has jumped | slip in the direction of v_r |
    /// | stick | the constraint force exceeds its limit | slip against the force, v_r = 1e-13 m/s |
    /// | slip | v_r has come back through zero | stick, or slip against the force |
    ///
    /// A law with memory has no stick; its mode is the sign of v_r.
    pub fn update(&mut self) -> bool {
        let jumped = std::mem::take(&mut self.jumped);
        let before = self.state;
        let v_r = self.model.relative_velocity(self.time, &self.state);
        if self.model.has_memory() {
            if self.mode.sign() * v_r <= -0.5 * ARRIVAL_BAND || self.mode == ContactMode::Stuck {
                self.mode = ContactMode::slip_towards(v_r);
            }
        } else if self.mode == ContactMode::Stuck {
            let (_, velocity) = self.model.tip(&self.state);
            if jumped && v_r.abs() > JUMP * (velocity.abs() + 1e-6) {
                self.leave(ContactMode::slip_towards(v_r));
            } else {
                self.model.project_on_stick(self.time, &mut self.state);
                self.follow();
                self.check_hold();
            }
        } else if jumped && v_r.abs() > ARRIVAL_BAND {
            // The new velocity of the belt alone says which way it slips.
            self.mode = ContactMode::slip_towards(v_r);
        } else if self.mode.sign() * v_r <= -0.5 * ARRIVAL_BAND {
            self.arrive();
        }
        self.follow();
        before != self.state
    }

    /// Leaves stick where the force exceeds what friction can hold.
    fn check_hold(&mut self) {
        let force = self.model.constraint_force(self.time, &self.state);
        if force.abs() > self.model.static_limit(self.time, &self.state) {
            self.leave(ContactMode::slip_towards(-force));
            self.depart();
        }
    }

    fn leave(&mut self, mode: ContactMode) {
        self.model.on_break_away(&mut self.state);
        self.mode = mode;
        self.note();
    }

    fn depart(&mut self) {
        self.model
            .push(self.mode.sign() * DEPARTURE_VELOCITY, &mut self.state);
    }

    /// v_r has come back to zero: stick or slip on.
    fn arrive(&mut self) {
        let from = self.mode;
        self.model.project_on_stick(self.time, &mut self.state);
        self.model.stick_since = self.time;
        // The constraint force counts without the term that leads v_r back, which is zero here.
        self.model.inputs.belt_acceleration = self.belt_acceleration;
        self.mode = self.model.mode_at_rest(self.time, &self.state);
        if self.mode == ContactMode::Stuck {
            self.model.on_stick(&mut self.state);
        } else {
            self.depart();
        }
        // An integrator's error can bring slip that has just begun back for a moment: no transition.
        if self.mode != from {
            self.note();
        }
    }

    fn note(&mut self) {
        self.transition_count += 1;
        self.last_transition = self.time;
    }
}
