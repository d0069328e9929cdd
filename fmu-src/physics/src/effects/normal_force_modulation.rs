//! A pressing force that pulsates at a fixed frequency.

use super::series::{EffectSeries, HARMONIC_REGISTERS, Hooks, MotionSeries, Series, harmonic};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::{Real, value};
use crate::unit::{HERTZ, ONE, RADIAN};
use std::f64::consts::{PI, TAU};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "normal_force_modulation",
    title: "The pressing force pulsates",
    equation: "F_N -> F_N [1 + a cos(2 pi f t + p)]",
    description: "Machine vibration or an eccentric roller makes the normal force pulsate at a fixed frequency.",
    source: "Tolstoi 1967, Wear 10:199 (normal degree of freedom); Stelter 1992, sect. 2 (roller-driven belt)",
    signature: "peaks modulated at a fixed frequency, in proportion to F_N",
    confounders: "belt_periodic_friction (its frequency follows v0), base_excitation (independent of F_N); a second \
                  belt speed and load separate them",
    first_value_reference: 1700,
    parameters: &[
        Parameter {
            name: "amplitude",
            description: "relative amplitude a of the normal force",
            unit: ONE,
            start: 0.0,
            typical: 0.08,
            min: 0.0,
            max: 0.8,
            role: Role::Amplitude,
        },
        Parameter {
            name: "frequency",
            description: "frequency f of the pulsation",
            unit: HERTZ,
            start: 50.0,
            typical: 50.0,
            min: 2.0,
            max: 1000.0,
            role: Role::Shape,
        },
        Parameter {
            name: "phase",
            description: "phase p at t = 0",
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

struct Pulsation {
    amplitude: Real,
    angular_frequency: Real,
    phase: Real,
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[amplitude, frequency, phase] = context.values else {
        unreachable!("three parameters on the card")
    };
    if amplitude == 0.0 {
        return Ok(None);
    }
    context.require(0, amplitude.abs() <= 1.0, "between -1 and 1")?;
    context.require(1, frequency >= 0.0, "zero or positive")?;
    context.require(2, true, "finite")?;
    Ok(Some(Box::new(Pulsation {
        amplitude,
        angular_frequency: TAU * frequency,
        phase,
    })))
}

impl Effect for Pulsation {
    fn normal_factor(&self, m: &Motion, _x: &[Real]) -> Real {
        1.0 + self.amplitude * (self.angular_frequency * m.time + self.phase).cos()
    }
    fn fastest_rate(&self) -> f64 {
        value(self.angular_frequency)
    }
    fn keeps_limit_constant(&self) -> bool {
        false
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Pulsation {
    fn hooks(&self) -> Hooks {
        Hooks {
            factor: true,
            ..Hooks::default()
        }
    }

    fn register_count(&self) -> usize {
        HARMONIC_REGISTERS
    }
    fn factor(&self, k: usize, m: &MotionSeries, _x: &[Real], registers: &mut [Series]) -> Real {
        let angle = self.angular_frequency * m.start.time + self.phase;
        let change =
            self.amplitude * harmonic(k, angle, self.angular_frequency * m.unit, registers);
        if k == 0 { 1.0 + change } else { change }
    }
}
