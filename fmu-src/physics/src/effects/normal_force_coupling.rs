//! A tip deflection that loads or unloads the contact.

use super::series::{EffectSeries, Hooks, MotionSeries, Series};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::Real;
use crate::unit::PER_METRE;

/// Describes the effect.
pub static CARD: Card = Card {
    id: "normal_force_coupling",
    title: "Deflection loads the contact",
    equation: "F_N -> F_N (1 + k w)",
    description: "The tip does not move parallel to the belt: a deflection along the belt's motion presses it on \
                  (k > 0) or lifts it off (k < 0). Where the force would turn negative the contact is open and carries nothing.",
    source: "Tworzydlo and Becker 1991, Wear 143:175 (coupling of normal and tangential motion)",
    signature: "looks like a stiffness that changes with mu F_N; peaks and troughs shift with the load",
    confounders: "cubic_stiffness, axial_load; a second load or a reversed belt (the sign flips) separates them",
    first_value_reference: 1600,
    parameters: &[Parameter {
        name: "coefficient",
        description: "relative change k of the normal force per metre of deflection",
        unit: PER_METRE,
        start: 0.0,
        typical: 80.0,
        min: -1500.0,
        max: 1500.0,
        role: Role::Amplitude,
    }],
    states: &[],
    build,
};

struct Coupling(Real);

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[coefficient] = context.values else {
        unreachable!("one parameter on the card")
    };
    if coefficient == 0.0 {
        return Ok(None);
    }
    context.require(0, true, "finite")?;
    Ok(Some(Box::new(Coupling(coefficient))))
}

impl Effect for Coupling {
    fn normal_factor(&self, m: &Motion, _x: &[Real]) -> Real {
        1.0 + self.0 * m.displacement
    }
    fn keeps_limit_constant(&self) -> bool {
        false
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Coupling {
    fn hooks(&self) -> Hooks {
        Hooks {
            factor: true,
            ..Hooks::default()
        }
    }

    fn factor(&self, k: usize, m: &MotionSeries, _x: &[Real], _registers: &mut [Series]) -> Real {
        let change = self.0 * m.displacement[k];
        if k == 0 { 1.0 + change } else { change }
    }
}
