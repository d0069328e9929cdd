//! A belt drive that gives way under the friction force.

use super::series::{EffectSeries, Hooks, Series};
use super::{
    BeltGive, Card, ContactForce, Context, Effect, Motion, Parameter, Role, StateVariable,
};
use crate::error::PhysicsError;
use crate::real::{Real, value};
use crate::unit::{KILOGRAM, METRE, METRE_PER_SECOND, NEWTON_PER_METRE, NEWTON_SECOND_PER_METRE};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "belt_drive_compliance",
    title: "The belt's drive gives way",
    equation: "M x'' + c x' + k x = -F,  belt velocity v0 + x'",
    description: "Belt and drive have mass, stiffness and damping: the friction force slows the belt in stick and \
                  lets it spring back after break-away.",
    source: "Popp and Stelter 1990, Phil. Trans. R. Soc. A 332:89 (two-mass system)",
    signature: "the slope of the tip in stick differs from v0 and recovers after each slip",
    confounders: "presliding_compliance, sensor_lag; a light load makes the slope error vanish",
    first_value_reference: 1000,
    parameters: &[
        Parameter {
            name: "mass",
            description: "mass M of the moving belt and drive; 0 means a rigid drive",
            unit: KILOGRAM,
            start: 0.0,
            typical: 1.5,
            min: 0.05,
            max: 30.0,
            role: Role::Shape,
        },
        Parameter {
            name: "stiffness",
            description: "stiffness k of the drive",
            unit: NEWTON_PER_METRE,
            start: 0.0,
            typical: 2e4,
            min: 300.0,
            max: 2e6,
            role: Role::Shape,
        },
        Parameter {
            name: "damping",
            description: "damping c of the drive",
            unit: NEWTON_SECOND_PER_METRE,
            start: 0.0,
            typical: 50.0,
            min: 0.0,
            max: 3e3,
            role: Role::Shape,
        },
    ],
    states: &[
        StateVariable {
            name: "displacement",
            description: "displacement x of the belt",
            unit: METRE,
            nominal: 1e-3,
        },
        StateVariable {
            name: "velocity",
            description: "velocity x' of the belt",
            unit: METRE_PER_SECOND,
            nominal: 3e-2,
        },
    ],
    build,
};

struct Drive {
    /// 1/mass in 1/kg.
    mobility: Real,
    /// Over the mass, in 1/s^2.
    stiffness: Real,
    /// Over the mass, in 1/s.
    damping: Real,
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[mass, stiffness, damping] = context.values else {
        unreachable!("three parameters on the card")
    };
    if mass == 0.0 {
        return Ok(None);
    }
    context.require(0, mass > 0.0, "zero (off) or positive")?;
    context.require(1, stiffness >= 0.0, "zero or positive")?;
    context.require(2, damping >= 0.0, "zero or positive")?;
    Ok(Some(Box::new(Drive {
        mobility: 1.0 / mass,
        stiffness: stiffness / mass,
        damping: damping / mass,
    })))
}

impl Effect for Drive {
    fn belt_give(&self, x: &[Real]) -> BeltGive {
        BeltGive {
            displacement: x[0],
            velocity: x[1],
            free_acceleration: -(self.damping * x[1] + self.stiffness * x[0]),
            mobility: self.mobility,
        }
    }
    fn add_rates(&self, _m: &Motion, contact: &ContactForce, x: &[Real], rates: &mut [Real]) {
        rates[0] += x[1];
        rates[1] -= self.mobility * contact.force + self.damping * x[1] + self.stiffness * x[0];
    }
    fn fastest_rate(&self) -> f64 {
        value(self.stiffness.sqrt() + self.damping)
    }
    fn settle(&self, _m: &Motion, contact: &ContactForce, x: &mut [Real]) {
        if self.stiffness > 0.0 {
            x[0] -= self.mobility * contact.force / self.stiffness;
        }
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Drive {
    fn hooks(&self) -> Hooks {
        Hooks {
            rates: true,
            ..Hooks::default()
        }
    }

    fn add_rates(
        &self,
        _k: usize,
        motion: &Motion,
        contact: &ContactForce,
        x: &[Real],
        _registers: &mut [Series],
        rates: &mut [Real],
    ) {
        Effect::add_rates(self, motion, contact, x, rates);
    }
}
