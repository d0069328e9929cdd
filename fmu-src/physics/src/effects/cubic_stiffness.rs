//! A restoring force that grows with the cube of the deflection.

use super::series::{EffectSeries, Hooks, MotionSeries, Series, product};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::Real;
use crate::unit::NEWTON_PER_METRE3;

/// Describes the effect.
pub static CARD: Card = Card {
    id: "cubic_stiffness",
    title: "Stiffness changes with large deflection",
    equation: "F_tip = -k3 w^3",
    description: "Large deflection, a curved clamp or a stop makes the beam harder (k3 > 0) or softer (k3 < 0) as it bends.",
    source: "Nayfeh and Mook 1979, Nonlinear Oscillations, sect. 4.1 (Duffing)",
    signature: "frequency and waveform change with amplitude, whatever the load",
    confounders: "normal_force_coupling, axial_load; a free vibration without contact shows k3 alone",
    first_value_reference: 1300,
    parameters: &[Parameter {
        name: "coefficient",
        description: "coefficient k3 of the tip's restoring force",
        unit: NEWTON_PER_METRE3,
        start: 0.0,
        // 26.3 kN/m times 2 % at 1 mm.
        typical: 5e8,
        min: -1e10,
        max: 1e10,
        role: Role::Amplitude,
    }],
    states: &[],
    build,
};

struct Cubic(Real);

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[coefficient] = context.values else {
        unreachable!("one parameter on the card")
    };
    if coefficient == 0.0 {
        return Ok(None);
    }
    context.require(0, true, "finite")?;
    Ok(Some(Box::new(Cubic(coefficient))))
}

impl Effect for Cubic {
    fn tip_force(&self, m: &Motion, _x: &[Real]) -> Real {
        -self.0 * m.displacement * m.displacement * m.displacement
    }
    fn is_linear_in_stick(&self) -> bool {
        false
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Cubic {
    fn hooks(&self) -> Hooks {
        Hooks {
            tip_force: true,
            ..Hooks::default()
        }
    }

    fn register_count(&self) -> usize {
        1
    }
    fn tip_force(&self, k: usize, m: &MotionSeries, _x: &[Real], registers: &mut [Series]) -> Real {
        let w = &m.displacement;
        let square = &mut registers[0];
        square[k] = product(w, w, k);
        -self.0 * product(square, w, k)
    }
}
