//! What can be observed of a run, and how fast it changes.

use super::Simulation;
use crate::contact::ContactMode;
use crate::effects::ContactForce;
use crate::error::PhysicsError;
use crate::integrate::{MAX_STATES, State};
use crate::model::Model;
use crate::real::{Real, ZERO};

/// What can be observed at the present time, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Tip displacement w in m.
    pub displacement: Real,
    /// Tip velocity w' in m/s.
    pub velocity: Real,
    /// Tip acceleration w'' in m/s^2.
    pub acceleration: Real,
    /// Friction force on the tip in N, positive along the belt's motion.
    pub friction_force: Real,
    /// Relative velocity v_r in m/s.
    pub relative_velocity: Real,
    /// Mode of the contact.
    pub mode: ContactMode,
    /// Displacement in m after the measuring chain.
    pub measured_displacement: Real,
    /// Velocity in m/s where the sensor looks.
    pub measured_velocity: Real,
    /// Acceleration in m/s^2 where the sensor looks.
    pub measured_acceleration: Real,
    /// Place on the belt in m.
    pub belt_travel: Real,
    /// Time since stick began in s.
    pub dwell: Real,
}

impl Outputs {
    /// The observables of a state at time `t` in s.
    pub fn of(model: &Model, t: Real, x: &State, mode: ContactMode) -> Self {
        let mut rates = [ZERO; MAX_STATES];
        let contact: ContactForce = model.evaluate(t, x, mode, &mut rates);
        let motion = model.motion(t, x, mode);
        let of_rates = model.tip(&rates);
        let (_, acceleration) = of_rates;
        Self {
            displacement: motion.displacement,
            velocity: motion.velocity,
            acceleration,
            friction_force: contact.force,
            relative_velocity: motion.relative_velocity,
            mode,
            measured_displacement: model.measured_displacement(t, x, mode),
            measured_velocity: motion.sensor_velocity,
            measured_acceleration: model.sensor(&rates, of_rates).1,
            belt_travel: motion.travel,
            dwell: motion.dwell,
        }
    }
}

impl Simulation {
    /// The observables at the present time.
    pub fn outputs(&self) -> Outputs {
        self.outputs_at(self.time)
    }

    /// The observables at a time within the present segment or next to it.
    fn outputs_at(&self, t: Real) -> Outputs {
        let mut x = [ZERO; MAX_STATES];
        self.segment.state_at(self.segment.theta(t), &mut x);
        Outputs::of(&self.model, t, &x, self.segment_mode)
    }

    /// The rates of the observables at the present time, each per second. The motion's own are exact,
    /// the others central differences on the present segment (1e-6 relative).
    ///
    /// # Errors
    /// As [`Simulation::advance_to`].
    pub fn output_rates(&mut self) -> Result<Outputs, PhysicsError> {
        // A run that has just been placed has no segment yet.
        self.advance_to(self.time)?;
        let step = 1e-3 * self.segment.length;
        let (a, now, b) = (
            self.outputs_at(self.time - step),
            self.outputs(),
            self.outputs_at(self.time + step),
        );
        let rate = |a: Real, b: Real| (b - a) / (2.0 * step);
        Ok(Outputs {
            displacement: now.velocity,
            velocity: now.acceleration,
            acceleration: rate(a.acceleration, b.acceleration),
            friction_force: rate(a.friction_force, b.friction_force),
            relative_velocity: rate(a.relative_velocity, b.relative_velocity),
            mode: now.mode,
            measured_displacement: rate(a.measured_displacement, b.measured_displacement),
            measured_velocity: now.measured_acceleration,
            measured_acceleration: rate(a.measured_acceleration, b.measured_acceleration),
            belt_travel: -now.relative_velocity,
            dwell: rate(a.dwell, b.dwell),
        })
    }

    /// The displacement at the present time as the sensor gives it, in m; cheaper than all outputs.
    pub fn measured_displacement(&self) -> Real {
        self.model
            .measured_displacement(self.time, &self.state(), self.segment_mode)
    }
}
