//! Asperities that deform elastically before gross slip: the LuGre bristle.

use super::series::{EffectSeries, Hooks, MotionSeries, Series, product, quotient};
use super::{Card, ContactForce, Context, Effect, Motion, Parameter, Role, StateVariable};
use crate::error::PhysicsError;
use crate::real::{Real, ZERO};
use crate::unit::{METRE, NEWTON_PER_METRE, NEWTON_SECOND_PER_METRE};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "presliding_compliance",
    title: "Presliding compliance (LuGre bristle)",
    equation: "z' = v_r - sigma0 |v_r| z / (mu(|v_r|) F_N),  F = -(sigma0 z + sigma1 z')",
    description: "The contact's asperities act as bristles that bend before they slide: sticking is elastic with \
                  some damping, and break-away is smooth. Replaces the rigid stick/slip automaton.",
    source: "Canudas de Wit, Olsson, Astrom, Lischinsky 1995, IEEE TAC 40:419, eqs. (3)-(5)",
    signature: "tip slower than the belt while it 'sticks'; smooth break-away; ringing is damped in stick",
    confounders: "belt_drive_compliance, sensor_lag, third_mode; two loads separate them",
    first_value_reference: 2100,
    parameters: &[
        Parameter {
            name: "bristle_stiffness",
            description: "bristle stiffness sigma0; 0 means rigid sticking",
            unit: NEWTON_PER_METRE,
            start: 0.0,
            typical: 5e5,
            min: 5e4,
            max: 2e7,
            role: Role::Shape,
        },
        Parameter {
            name: "bristle_damping",
            description: "bristle damping sigma1",
            unit: NEWTON_SECOND_PER_METRE,
            start: 0.0,
            typical: 60.0,
            min: 0.0,
            max: 1e3,
            role: Role::Shape,
        },
    ],
    states: &[StateVariable {
        name: "deflection",
        description: "bristle deflection z",
        unit: METRE,
        nominal: 1e-4,
    }],
    build,
};

struct Bristle {
    stiffness: Real,
    damping: Real,
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[stiffness, damping] = context.values else {
        unreachable!("two parameters on the card")
    };
    if stiffness == 0.0 {
        return Ok(None);
    }
    context.require(0, stiffness > 0.0, "zero (off) or positive")?;
    context.require(1, damping >= 0.0, "zero or positive")?;
    Ok(Some(Box::new(Bristle { stiffness, damping })))
}

impl Bristle {
    fn deflection_rate(&self, m: &Motion, capacity: Real, z: Real) -> Real {
        // Without capacity (normal force 0) nothing holds the bristles.
        if capacity > 0.0 {
            m.relative_velocity - self.stiffness * m.speed * z / capacity
        } else {
            ZERO
        }
    }
}

impl Effect for Bristle {
    fn replaces_stick(&self) -> bool {
        true
    }
    fn memory_force(&self, m: &Motion, capacity: Real, x: &[Real]) -> Real {
        if capacity > 0.0 {
            -(self.stiffness * x[0] + self.damping * self.deflection_rate(m, capacity, x[0]))
        } else {
            ZERO
        }
    }
    fn add_rates(&self, m: &Motion, contact: &ContactForce, x: &[Real], rates: &mut [Real]) {
        rates[0] += self.deflection_rate(m, contact.capacity, x[0]);
    }
    fn settle(&self, _m: &Motion, contact: &ContactForce, x: &mut [Real]) {
        x[0] -= contact.force / self.stiffness;
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Bristle {
    fn hooks(&self) -> Hooks {
        Hooks {
            memory_force: true,
            rates: true,
            ..Hooks::default()
        }
    }

    fn register_count(&self) -> usize {
        4
    }
    fn memory_force(
        &self,
        k: usize,
        m: &MotionSeries,
        capacity: &Series,
        x: &[Real],
        registers: &mut [Series],
    ) -> Real {
        let [z, worn, ratio, rate, ..] = registers else {
            unreachable!("four registers declared")
        };
        z[k] = x[0];
        worn[k] = product(&m.speed, z, k);
        ratio[k] = quotient(worn[k], capacity, ratio, k);
        rate[k] = m.relative_velocity(k) - self.stiffness * ratio[k];
        -(self.stiffness * z[k] + self.damping * rate[k])
    }
    fn add_rates(
        &self,
        k: usize,
        _motion: &Motion,
        _contact: &ContactForce,
        _x: &[Real],
        registers: &mut [Series],
        rates: &mut [Real],
    ) {
        rates[0] += registers[3][k];
    }
    fn until(&self, _m: &MotionSeries, registers: &[Series], _degree: usize, theta: f64) -> f64 {
        // Without capacity nothing holds the bristles.
        let holds = registers[2][0].is_finite();
        if holds { theta } else { 0.0 }
    }
}
