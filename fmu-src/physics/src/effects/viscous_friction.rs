//! Friction that rises with the sliding speed.

use super::series::EffectSeries;
use super::{Card, Context, Effect, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::Real;
use crate::unit::SECOND_PER_METRE;

/// Describes the effect.
pub static CARD: Card = Card {
    id: "viscous_friction",
    title: "Friction rises with sliding speed",
    equation: "mu -> mu + c |v_r|",
    description: "A film or the material's own damping adds a share in proportion to the sliding speed to the kinetic \
                  coefficient; a negative c makes friction fall further. The coefficient never falls below zero.",
    source: "Armstrong-Helouvry, Dupont, Canudas de Wit 1994, Automatica 30:1083, sect. 2.1",
    signature: "vibration ends at a lower belt speed, mean deflection grows with v0",
    confounders: "quadratic_drag, a wrong shape of the friction law; a wide range of belt speeds separates them",
    first_value_reference: 2500,
    parameters: &[Parameter {
        name: "coefficient",
        description: "rise c of the coefficient of friction per sliding speed",
        unit: SECOND_PER_METRE,
        start: 0.0,
        typical: 0.2,
        // Friction that falls with the speed is a matter of the law: a calibration keeps off it. A lubricated guide with 204 N s/m over
        // 20 N of dry friction (Janot, Gautier and Brunot 2019) has 4 at a coefficient of friction of 0.4.
        min: 0.0,
        max: 30.0,
        role: Role::Amplitude,
    }],
    states: &[],
    build,
};

struct Viscous(Real);

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[coefficient] = context.values else {
        unreachable!("one parameter on the card")
    };
    if coefficient == 0.0 {
        return Ok(None);
    }
    context.require(0, true, "finite")?;
    Ok(Some(Box::new(Viscous(coefficient))))
}

impl Effect for Viscous {
    fn friction_slope(&self) -> Real {
        self.0
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Viscous {}
