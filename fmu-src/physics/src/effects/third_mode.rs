//! A bending mode beyond those retained.

use super::series::EffectSeries;
use super::{Card, ContactForce, Context, Effect, Motion, Parameter, Role, StateVariable};
use crate::beam::{Beam, ModalOscillator};
use crate::error::PhysicsError;
use crate::real::{Real, ZERO};
use crate::unit::{HERTZ, METRE, METRE_PER_SECOND, ONE};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "third_mode",
    title: "A further bending mode",
    equation: "q3'' + 2 D3 w3 q3' + w3^2 q3 = p phi3(1) F / m,  w_tip = ... + phi3(1) q3",
    description: "The beam bends in one more mode than the model retains: every transition makes it ring at \
                  its own frequency, and the tip is a little softer.",
    source: "Stelter 1992, eqs. (2), (3), Figure 3",
    signature: "ringing at f3 after each transition; a small quasi-static deflection",
    confounders: "presliding_compliance (both act above the second mode): a tap without contact shows f3",
    first_value_reference: 2400,
    parameters: &[
        Parameter {
            name: "frequency",
            description: "natural frequency of the mode; 0 means the mode is absent",
            unit: HERTZ,
            start: 0.0,
            typical: 1404.0,
            min: 700.0,
            max: 3000.0,
            role: Role::Shape,
        },
        Parameter {
            name: "damping_ratio",
            description: "damping ratio of the mode",
            unit: ONE,
            start: 0.001,
            typical: 0.002,
            min: 1e-5,
            max: 0.03,
            role: Role::Shape,
        },
        Parameter {
            name: "participation",
            description: "participation phi3(1)^2 / m3 of the mode over that of the first one; 1 for a cantilever",
            unit: ONE,
            start: 1.0,
            typical: 1.0,
            min: 0.5,
            max: 2.0,
            role: Role::Shape,
        },
    ],
    states: &[
        StateVariable {
            name: "displacement",
            description: "modal displacement q3",
            unit: METRE,
            nominal: 1e-6,
        },
        StateVariable {
            name: "velocity",
            description: "modal velocity q3'",
            unit: METRE_PER_SECOND,
            nominal: 1e-2,
        },
    ],
    build,
};

struct ThirdMode(ModalOscillator);

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[frequency, damping_ratio, participation] = context.values else {
        unreachable!("three parameters on the card")
    };
    if frequency == 0.0 {
        return Ok(None);
    }
    context.require(0, frequency > 0.0, "zero (off) or positive")?;
    context.require(1, damping_ratio >= 0.0, "zero or positive")?;
    context.require(2, participation > 0.0, "positive")?;
    let modes = context.beam.modes();
    // Eigenfunctions of a cantilever alternate in sign at the tip and share the modal mass. Contact and tip see nothing of
    // either but phi^2 / m.
    let tip_value = if modes.len().is_multiple_of(2) {
        modes[0].tip_value.abs()
    } else {
        -modes[0].tip_value.abs()
    };
    Ok(Some(Box::new(ThirdMode(ModalOscillator {
        frequency,
        damping_ratio,
        damping_rate: ZERO,
        mass: modes[0].mass / participation,
        tip_value,
    }))))
}

impl Effect for ThirdMode {
    fn extend_structure(&self, beam: &mut Beam) -> Result<(), PhysicsError> {
        beam.push(self.0)
    }
    fn settle(&self, _m: &Motion, contact: &ContactForce, x: &mut [Real]) {
        x[0] +=
            self.0.tip_value * contact.force / (self.0.mass * self.0.angular_frequency().powi(2));
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for ThirdMode {
    fn acts_in_slip(&self) -> bool {
        false
    }
}
