//! Friction that varies periodically along the belt.

use super::series::{COSINE_REGISTERS, EffectSeries, Hooks, MotionSeries, Series, cosine};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::{Real, ZERO};
use crate::unit::{METRE, ONE, RADIAN};
use std::f64::consts::{PI, TAU};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "belt_periodic_friction",
    title: "Friction varies periodically along the belt",
    equation: "mu -> mu [1 + a cos(2 pi s/L + p)],  s' = v_belt - w'",
    description: "The belt's surface is not the same everywhere: the coefficient of friction, static and kinetic, \
                  depends on the place s of the belt that the tip stands on. The place is constant in stick.",
    source: "Stelter 1992, sect. 2 (fluctuation of friction along the length of the belt)",
    signature: "peaks and periods modulated at v0/L: fixed in belt travel when the belt speed changes",
    confounders: "normal_force_modulation, base_excitation (fixed in time), static_friction_aging; a second belt \
                  speed separates them",
    first_value_reference: 1200,
    parameters: &[
        Parameter {
            name: "amplitude",
            description: "relative amplitude a of the coefficient of friction",
            unit: ONE,
            start: 0.0,
            typical: 0.08,
            min: 0.0,
            max: 0.6,
            role: Role::Amplitude,
        },
        Parameter {
            name: "wavelength",
            description: "wavelength L along the belt",
            unit: METRE,
            start: 0.02,
            typical: 0.02,
            min: 1e-3,
            max: 0.5,
            role: Role::Shape,
        },
        Parameter {
            name: "phase",
            description: "phase p at s = 0",
            unit: RADIAN,
            start: 0.0,
            typical: 0.0,
            min: -PI,
            max: PI,
            role: Role::Phase,
        },
    ],
    states: &[],
    build,
};

struct Periodic {
    amplitude: Real,
    wave_number: Real,
    phase: Real,
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[amplitude, wavelength, phase] = context.values else {
        unreachable!("three parameters on the card")
    };
    if amplitude == 0.0 {
        return Ok(None);
    }
    context.require(0, amplitude.abs() <= 1.0, "between -1 and 1")?;
    context.require(1, wavelength > 0.0, "positive")?;
    context.require(2, true, "finite")?;
    Ok(Some(Box::new(Periodic {
        amplitude,
        wave_number: TAU / wavelength,
        phase,
    })))
}

impl Effect for Periodic {
    fn friction_factor(&self, m: &Motion, _x: &[Real]) -> Real {
        1.0 + self.amplitude * (self.wave_number * m.travel + self.phase).cos()
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Periodic {
    fn hooks(&self) -> Hooks {
        Hooks {
            factor: true,
            ..Hooks::default()
        }
    }

    fn register_count(&self) -> usize {
        COSINE_REGISTERS
    }
    fn factor(&self, k: usize, m: &MotionSeries, _x: &[Real], registers: &mut [Series]) -> Real {
        let offset = if k == 0 { self.phase } else { ZERO };
        let angle = self.wave_number * m.travel[k] + offset;
        let change = self.amplitude * cosine(k, angle, registers);
        if k == 0 { 1.0 + change } else { change }
    }
}
