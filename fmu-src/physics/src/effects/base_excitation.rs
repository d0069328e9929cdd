//! The clamp of the beam shakes.

use super::series::{
    EffectSeries, HARMONIC_REGISTERS, Hooks, MotionSeries, Series, State, harmonic,
};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::beam::{Beam, MAX_MODES, clamp_participation};
use crate::error::PhysicsError;
use crate::real::{Real, ZERO, value};
use crate::unit::{HERTZ, METRE_PER_SECOND2, RADIAN};
use std::f64::consts::TAU;

/// Describes the effect.
pub static CARD: Card = Card {
    id: "base_excitation",
    title: "The clamp shakes",
    equation: "q_j'' = ... - A cos(2 pi f t + p) g_j,  g_j = clamp share / phi_j(1) = 0.783, 0.434, 0.254, ... of a cantilever",
    description: "The clamp moves with a harmonic acceleration (machine vibration), and the beam's inertia pulls \
                  each mode back. Displacements are measured relative to the clamp, and the belt moves with it.",
    source: "Inman 2014, Engineering Vibration, sect. 2.4; modal participation of the eigenfunctions of Stelter 1992, eq. (6)",
    signature: "a line at a fixed frequency, in stick as a force and in slip as a motion, whatever the load",
    confounders: "normal_force_modulation (scales with F_N), belt_periodic_friction (follows v0); a second load and \
                  belt speed separate them",
    first_value_reference: 900,
    parameters: &[
        Parameter {
            name: "amplitude",
            description: "amplitude A of the clamp's acceleration",
            unit: METRE_PER_SECOND2,
            start: 0.0,
            typical: 2.0,
            min: 0.0,
            max: 50.0,
            role: Role::Amplitude,
        },
        Parameter {
            name: "frequency",
            description: "frequency f of the shaking",
            unit: HERTZ,
            start: 25.0,
            typical: 25.0,
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
            min: -std::f64::consts::PI,
            max: std::f64::consts::PI,
            role: Role::Phase,
        },
    ],
    states: &[],
    build,
};

struct Shaking {
    amplitude: Real,
    angular_frequency: Real,
    phase: Real,
    participation: [Real; MAX_MODES],
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[amplitude, frequency, phase] = context.values else {
        unreachable!("three parameters on the card")
    };
    if amplitude == 0.0 {
        return Ok(None);
    }
    context.require(0, true, "finite")?;
    context.require(1, frequency >= 0.0, "zero or positive")?;
    context.require(2, true, "finite")?;
    Ok(Some(Box::new(Shaking {
        amplitude,
        angular_frequency: TAU * frequency,
        phase,
        participation: [ZERO; MAX_MODES],
    })))
}

impl Effect for Shaking {
    fn prepare(&mut self, beam: &Beam) {
        self.participation = clamp_participation(beam);
    }
    fn add_modal_acceleration(
        &self,
        m: &Motion,
        _x: &[Real],
        _modes: &[Real],
        acceleration: &mut [Real],
    ) {
        let clamp = self.amplitude * (self.angular_frequency * m.time + self.phase).cos();
        for (sum, g) in acceleration.iter_mut().zip(&self.participation) {
            *sum -= clamp * g;
        }
    }
    fn fastest_rate(&self) -> f64 {
        value(self.angular_frequency)
    }
    fn is_linear_in_stick(&self) -> bool {
        false
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Shaking {
    fn hooks(&self) -> Hooks {
        Hooks {
            modal_acceleration: true,
            ..Hooks::default()
        }
    }

    fn register_count(&self) -> usize {
        HARMONIC_REGISTERS
    }
    fn add_modal_acceleration(
        &self,
        k: usize,
        m: &MotionSeries,
        _x: &[Real],
        _states: &[State],
        registers: &mut [Series],
        acceleration: &mut [Real],
    ) {
        let angle = self.angular_frequency * m.start.time + self.phase;
        let clamp = self.amplitude * harmonic(k, angle, self.angular_frequency * m.unit, registers);
        for (sum, g) in acceleration.iter_mut().zip(&self.participation) {
            *sum -= clamp * g;
        }
    }
}
