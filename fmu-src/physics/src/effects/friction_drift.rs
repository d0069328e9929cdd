//! Friction that warms up or wears during a run.

use super::series::{EffectSeries, Hooks, MotionSeries, Series};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::Real;
use crate::unit::{ONE, SECOND};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "friction_drift",
    title: "Friction drifts during a run",
    equation: "mu -> mu [1 + a (1 - exp(-t/tau))]",
    description: "The contact warms up or wears: the coefficient of friction, static and kinetic, settles at another \
                  value. t is the simulation time, so a run that starts at t = 0 starts cold; before t = 0 nothing drifts.",
    source: "Blau 2009, Friction Science and Technology, 2nd ed., ch. 8 (run-in)",
    signature: "a slow, monotone change of peaks and mean deflection in each run",
    confounders: "a friction level that differs between runs, belt_friction_profile; a long run or a repeat separates them",
    first_value_reference: 1400,
    parameters: &[
        Parameter {
            name: "change",
            description: "relative change a of the coefficient in the end",
            unit: ONE,
            start: 0.0,
            typical: -0.12,
            min: -0.6,
            max: 0.6,
            role: Role::Amplitude,
        },
        Parameter {
            name: "time_constant",
            description: "time constant tau of the drift",
            unit: SECOND,
            start: 0.3,
            typical: 0.3,
            min: 0.02,
            max: 20.0,
            role: Role::Shape,
        },
    ],
    states: &[],
    build,
};

struct Drift {
    change: Real,
    rate: Real,
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[change, time_constant] = context.values else {
        unreachable!("two parameters on the card")
    };
    if change == 0.0 {
        return Ok(None);
    }
    context.require(0, change >= -1.0, "at least -1")?;
    context.require(1, time_constant > 0.0, "positive")?;
    Ok(Some(Box::new(Drift {
        change,
        rate: 1.0 / time_constant,
    })))
}

impl Effect for Drift {
    fn friction_factor(&self, m: &Motion, _x: &[Real]) -> Real {
        1.0 - self.change * (-self.rate * m.time.max(0.0)).exp_m1()
    }
    fn keeps_limit_constant(&self) -> bool {
        false
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Drift {
    fn hooks(&self) -> Hooks {
        Hooks {
            factor: true,
            ..Hooks::default()
        }
    }

    fn register_count(&self) -> usize {
        1
    }
    fn factor(&self, k: usize, m: &MotionSeries, _x: &[Real], registers: &mut [Series]) -> Real {
        let cold = &mut registers[0];
        if k == 0 {
            cold[0] = (-self.rate * m.start.time).exp();
            return 1.0 + self.change * (1.0 - cold[0]);
        }
        cold[k] = -self.rate * m.unit * cold[k - 1] / k as f64;
        -self.change * cold[k]
    }
    fn until(&self, m: &MotionSeries, _registers: &[Series], _degree: usize, theta: f64) -> f64 {
        if m.start.time >= 0.0 { theta } else { 0.0 }
    }
}
