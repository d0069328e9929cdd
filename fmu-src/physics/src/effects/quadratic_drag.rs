//! Air drag on the moving beam.

use super::series::{EffectSeries, Hooks, MotionSeries, Series, product, sign_until};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::Real;
use crate::unit::NEWTON_SECOND2_PER_METRE2;

/// Describes the effect.
pub static CARD: Card = Card {
    id: "quadratic_drag",
    title: "Air drag",
    equation: "F_tip = -c w' |w'|",
    description: "The moving beam pushes fluid aside: a resistance that grows with the square of the tip's velocity.",
    source: "Nayfeh and Mook 1979, Nonlinear Oscillations, sect. 3.3.3 (quadratic damping)",
    signature: "free vibration decays faster at large amplitude; slip is slowed where it is fastest",
    confounders: "viscous_friction; a free vibration without contact separates them",
    first_value_reference: 1900,
    parameters: &[Parameter {
        name: "coefficient",
        description: "drag coefficient c; the force at 0.3 m/s is 0.09 c",
        unit: NEWTON_SECOND2_PER_METRE2,
        start: 0.0,
        typical: 10.0,
        min: 0.0,
        max: 300.0,
        role: Role::Amplitude,
    }],
    states: &[],
    build,
};

struct Drag(Real);

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[coefficient] = context.values else {
        unreachable!("one parameter on the card")
    };
    if coefficient == 0.0 {
        return Ok(None);
    }
    context.require(0, coefficient > 0.0, "zero (off) or positive")?;
    Ok(Some(Box::new(Drag(coefficient))))
}

impl Effect for Drag {
    fn tip_force(&self, m: &Motion, _x: &[Real]) -> Real {
        -self.0 * m.velocity * m.velocity.abs()
    }
    fn is_linear_in_stick(&self) -> bool {
        false
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Drag {
    fn hooks(&self) -> Hooks {
        Hooks {
            tip_force: true,
            ..Hooks::default()
        }
    }

    fn tip_force(
        &self,
        k: usize,
        m: &MotionSeries,
        _x: &[Real],
        _registers: &mut [Series],
    ) -> Real {
        -self.0 * m.velocity[0].signum() * product(&m.velocity, &m.velocity, k)
    }
    fn until(&self, m: &MotionSeries, _registers: &[Series], degree: usize, theta: f64) -> f64 {
        sign_until(&m.velocity, degree, theta)
    }
}
