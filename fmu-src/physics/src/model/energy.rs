//! Energy that the model holds, takes in and loses.

use super::Model;
use crate::integrate::State;
use crate::real::Real;

impl Model {
    /// Stored energy of the structure in J: `sum m_j (q_j'^2 + w_j^2 q_j^2) / 2`.
    pub fn stored_energy(&self, x: &State) -> Real {
        self.beam
            .modes()
            .iter()
            .enumerate()
            .map(|(j, m)| {
                0.5 * m.mass * (x[2 * j + 1].powi(2) + self.stiffness[j] * x[2 * j].powi(2))
            })
            .sum()
    }

    /// Power in W that comes in beside friction: `F_ext w' - a sum m_j g_j q_j'`, of the external force and of the inertia that the
    /// clamp's acceleration a stands for.
    pub fn external_power(&self, t: Real, x: &State, tip_velocity: Real) -> Real {
        let modes = self.beam.modes().iter().enumerate();
        let momentum: Real = modes
            .map(|(j, m)| m.mass * self.clamp_participation[j] * x[2 * j + 1])
            .sum();
        self.inputs.external_force_at(t) * tip_velocity
            - self.inputs.clamp_acceleration_at(t) * momentum
    }

    /// Power in W that structural damping takes: `sum (2 D_j w_j + d_j) m_j q_j'^2`.
    pub fn structural_dissipation(&self, x: &State) -> Real {
        self.beam
            .modes()
            .iter()
            .enumerate()
            .map(|(j, m)| self.damping[j] * m.mass * x[2 * j + 1].powi(2))
            .sum()
    }
}
