//! The normal force acts along the beam and softens it.

use super::series::{EffectSeries, Hooks, MotionSeries, Series, State};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::beam::{Beam, MAX_MODES, cantilever_scale, mode_integrals};
use crate::error::PhysicsError;
use crate::real::{Real, ZERO};
use crate::unit::PER_NEWTON;

/// Describes the effect.
pub static CARD: Card = Card {
    id: "axial_load",
    title: "The normal force softens the beam",
    equation: "K_ij -> K_ij - c F_N m w_1^2 G_ij/G_11,  G_ij = integral of phi_i' phi_j' over the length",
    description: "The force that presses the tip on the belt runs along the beam and lowers its bending stiffness, \
                  most in the first mode; the modes become coupled. Holds far below buckling; F_N is the force \
                  given, before any effect.",
    source: "Stelter 1992, eq. (1), terms with F_N; Bokaian 1988, J. Sound Vib. 126:49",
    signature: "f1 and f2 fall with the normal force, mode 1 most",
    confounders: "a wrong stiffness (identical at one load), normal_force_coupling; a second F_N separates them",
    first_value_reference: 800,
    parameters: &[Parameter {
        name: "softening",
        description: "relative loss c of the first mode's stiffness per newton; 1.4e-4 for the nominal beam",
        unit: PER_NEWTON,
        start: 0.0,
        typical: 1.4e-4,
        min: 0.0,
        max: 1e-3,
        role: Role::Amplitude,
    }],
    states: &[],
    build,
};

struct AxialLoad {
    softening: Real,
    /// Acceleration of mode i per displacement of mode j and newton, in 1/(N s^2).
    coupling: [[Real; MAX_MODES]; MAX_MODES],
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[softening] = context.values else {
        unreachable!("one parameter on the card")
    };
    if softening == 0.0 {
        return Ok(None);
    }
    context.require(0, true, "finite")?;
    Ok(Some(Box::new(AxialLoad {
        softening,
        coupling: [[ZERO; MAX_MODES]; MAX_MODES],
    })))
}

impl Effect for AxialLoad {
    fn prepare(&mut self, beam: &Beam) {
        let products = &mode_integrals().slope_product;
        let modes = beam.modes();
        let scale = |j: usize| cantilever_scale(j, modes[j].tip_value);
        // m w_1^2 / G_11 of the eigenfunctions of eq. (6), whatever the scale of the modes given.
        let stiffness = modes[0].mass / scale(0).powi(2) * modes[0].angular_frequency().powi(2)
            / products[0][0];
        for (i, mode) in modes.iter().enumerate() {
            let share = self.softening * stiffness * scale(i) / mode.mass;
            for (j, c) in self.coupling[i].iter_mut().take(modes.len()).enumerate() {
                *c = share * scale(j) * products[i][j];
            }
        }
    }
    fn add_modal_acceleration(
        &self,
        m: &Motion,
        _x: &[Real],
        modes: &[Real],
        acceleration: &mut [Real],
    ) {
        for (row, sum) in self.coupling.iter().zip(acceleration) {
            for (c, displacement) in row.iter().zip(modes.iter().step_by(2)) {
                *sum += m.normal_force * c * displacement;
            }
        }
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for AxialLoad {
    fn hooks(&self) -> Hooks {
        Hooks {
            modal_acceleration: true,
            ..Hooks::default()
        }
    }

    fn add_modal_acceleration(
        &self,
        k: usize,
        m: &MotionSeries,
        _x: &[Real],
        states: &[State],
        _registers: &mut [Series],
        acceleration: &mut [Real],
    ) {
        // The force given is linear in time: two terms of the product are different from zero.
        let modes = acceleration.len();
        for (row, sum) in self.coupling.iter().zip(acceleration) {
            for (j, c) in row[..modes].iter().enumerate() {
                *sum += c * m.normal_force[0] * states[k][2 * j];
                if k > 0 {
                    *sum += c * m.normal_force[1] * states[k - 1][2 * j];
                }
            }
        }
    }
}
