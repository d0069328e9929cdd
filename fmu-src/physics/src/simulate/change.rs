//! Changes at the present time: other inputs, other parameters.

use super::{Simulation, StartContact};
use crate::belt::Inputs;
use crate::contact::{ContactMode, Transition};
use crate::error::PhysicsError;
use crate::integrate::State;
use crate::model::Model;
use crate::real::ZERO;

impl Simulation {
    /// Changes the inputs at the present time.
    ///
    /// # Errors
    /// Inputs outside the range in which the equations hold; the run stays as it was.
    pub fn set_inputs(&mut self, inputs: Inputs) -> Result<(), PhysicsError> {
        let inputs = Inputs {
            since: self.time,
            ..inputs
        };
        inputs.check()?;
        // What lies ahead in the segment is dropped, what has passed is not.
        self.count_energy(self.time);
        let x = self.state();
        let mode = self.segment_mode;
        let travel = self.model.motion(self.time, &x, mode).travel;
        let dwell_began = self.model.stick_since;
        self.keep_stick_system(&inputs);
        self.model.inputs = inputs;
        self.scales = self.model.state_scales();
        self.front_state = x;
        self.model.stick_since = dwell_began;
        let moved = self.model.relative_velocity(self.time, &x);
        let was_stuck = mode == ContactMode::Stuck;
        let still = moved.abs() <= 1e-12 * (inputs.belt_velocity.abs() + moved.abs() + 1e-6);
        let contact = if was_stuck && still {
            StartContact::Stick
        } else {
            StartContact::Slip
        };
        self.place(contact, false, travel)?;
        if self.model.has_memory() && self.front_mode != mode && still {
            // At rest to rounding the law with memory goes on with the sign before.
            self.front_mode = mode;
            self.hold(x)?;
        }
        // Slip goes on; slip out of stick has departed where the belt's new velocity makes it. At rest
        // nothing has departed, or the rest itself would be taken for the end of the slip.
        self.departed |= !was_stuck && !still;
        if was_stuck != (self.front_mode == ContactMode::Stuck) {
            self.note(Transition {
                time: self.time,
                from: mode,
                to: self.front_mode,
            });
        }
        Ok(())
    }

    /// Goes on at the present time with another model, whose state is `x` in its own order: parameters
    /// that change during a run. Counts, energies and the place on the belt go on.
    ///
    /// # Errors
    /// A state with which the new model can't start; the run is then of no use.
    pub fn set_model(&mut self, model: Model, x: State) -> Result<(), PhysicsError> {
        let t = self.time;
        self.count_energy(t);
        let mode = self.segment_mode;
        let travel = self.model.motion(t, &self.state(), mode).travel;
        let now = self.model.inputs;
        let inputs = now.from(t);
        let dwell_began = self.model.stick_since;
        let sticks = mode == ContactMode::Stuck;
        self.model = model;
        self.model.inputs = inputs;
        self.model.travel_offset = ZERO;
        self.model.stick_since = dwell_began;
        self.stick_system = None;
        self.scales = self.model.state_scales();
        self.first_slip_step = 0.05 / self.model.highest_frequency();
        self.front_state = x;
        let contact = if sticks {
            StartContact::Stick
        } else {
            StartContact::Slip
        };
        self.place(contact, false, travel)?;
        self.departed |= !sticks;
        if sticks && self.front_mode != ContactMode::Stuck {
            self.note(Transition {
                time: t,
                from: mode,
                to: self.front_mode,
            });
        }
        Ok(())
    }
}
