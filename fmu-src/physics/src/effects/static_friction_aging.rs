//! Static friction that grows with the time of stationary contact.

use super::series::{EffectSeries, Hooks, MotionSeries, Series};
use super::{Card, Context, Effect, Motion, Parameter, Role};
use crate::error::PhysicsError;
use crate::real::Real;
use crate::unit::{ONE, SECOND};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "static_friction_aging",
    title: "Static friction grows with dwell time",
    equation: "mu_0 -> mu_0 [1 + b (1 - exp(-t_stick/tau))], or with form = 1: mu_0 [1 + b ln(1 + t_stick/tau)]",
    description: "Contacts creep and strengthen while they rest, so break-away needs more force the longer the \
                  tip has stuck.",
    source: "Rabinowicz 1958, Proc. Phys. Soc. 71:668; Dieterich 1979 (log form)",
    signature: "higher break-away force after long sticks; belt speed changes the jump",
    confounders: "belt_periodic_friction, belt_friction_profile (they tie long sticks to places of high friction)",
    first_value_reference: 2300,
    parameters: &[
        Parameter {
            name: "gain",
            description: "relative growth b of the static coefficient",
            unit: ONE,
            start: 0.0,
            typical: 0.15,
            min: 0.0,
            max: 1.0,
            role: Role::Amplitude,
        },
        Parameter {
            name: "time_constant",
            description: "time constant tau of the growth",
            unit: SECOND,
            start: 0.01,
            typical: 0.01,
            min: 3e-4,
            max: 0.3,
            role: Role::Shape,
        },
        Parameter {
            name: "form",
            description: "0 = saturating exponential, 1 = logarithm",
            unit: ONE,
            start: 0.0,
            typical: 0.0,
            min: 0.0,
            max: 1.0,
            role: Role::Setting,
        },
    ],
    states: &[],
    build,
};

struct Aging {
    gain: Real,
    time_constant: Real,
    logarithmic: bool,
}

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[gain, time_constant, form] = context.values else {
        unreachable!("three parameters on the card")
    };
    if gain == 0.0 {
        return Ok(None);
    }
    context.require(0, gain > -1.0, "above -1")?;
    context.require(1, time_constant > 0.0, "positive")?;
    context.require(
        2,
        form == 0.0 || form == 1.0,
        "0 (exponential) or 1 (logarithm)",
    )?;
    Ok(Some(Box::new(Aging {
        gain,
        time_constant,
        logarithmic: form == 1.0,
    })))
}

impl Effect for Aging {
    fn static_factor(&self, m: &Motion) -> Real {
        let x = m.dwell / self.time_constant;
        1.0 + self.gain
            * if self.logarithmic {
                x.ln_1p()
            } else {
                -(-x).exp_m1()
            }
    }
    fn keeps_limit_constant(&self) -> bool {
        false
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Aging {
    fn hooks(&self) -> Hooks {
        Hooks {
            static_factor: true,
            ..Hooks::default()
        }
    }

    fn acts_in_slip(&self) -> bool {
        false
    }

    fn register_count(&self) -> usize {
        1
    }
    fn static_factor(&self, k: usize, m: &MotionSeries, registers: &mut [Series]) -> Real {
        let x = m.start.dwell / self.time_constant;
        let rate = m.unit / self.time_constant;
        let growth = &mut registers[0];
        // Of exp(-x), and of ln(1 + x), whose coefficients are those of a geometric series over k.
        growth[k] = match (k, self.logarithmic) {
            (0, false) => (-x).exp(),
            (_, false) => -rate * growth[k - 1] / k as f64,
            (0, true) => return 1.0 + self.gain * x.ln_1p(),
            (1, true) => rate / (1.0 + x),
            (_, true) => -growth[k - 1] * rate / (1.0 + x),
        };
        match (k, self.logarithmic) {
            (0, _) => 1.0 + self.gain * (1.0 - growth[0]),
            (_, false) => -self.gain * growth[k],
            (_, true) => self.gain * growth[k] / k as f64,
        }
    }
}
