//! Sliding friction that follows changes of velocity late.

use super::series::{EffectSeries, Hooks, Series};
use super::{Card, ContactForce, Context, Effect, Motion, Parameter, Role, StateVariable};
use crate::error::PhysicsError;
use crate::real::{Real, ZERO, value};
use crate::unit::{METRE_PER_SECOND, SECOND};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "frictional_lag",
    title: "Sliding friction lags behind the velocity",
    equation: "mu = mu(u),  tau u' = |v_r| - u in slip,  u = 0 in stick and at break-away",
    description: "The contact needs time to adapt to a new sliding speed: the kinetic coefficient is that of an \
                  earlier, smoothed speed u, and friction over v_r becomes a loop.",
    source: "Rabinowicz 1958, Proc. Phys. Soc. 71:668; Hess and Soom 1990, J. Tribology 112:147",
    signature: "a loop of force over v_r whose width grows with acceleration; break-away is gentler",
    confounders: "sensor_lag (acts in free vibration too), a wrong velocity scale of the friction law; a second belt \
                  speed or load separates them",
    first_value_reference: 1500,
    parameters: &[Parameter {
        name: "time_constant",
        description: "time constant tau of the lag; 0 means no lag",
        unit: SECOND,
        start: 0.0,
        typical: 1e-3,
        min: 2e-5,
        max: 0.02,
        role: Role::Shape,
    }],
    states: &[StateVariable {
        name: "speed",
        description: "lagged sliding speed u",
        unit: METRE_PER_SECOND,
        nominal: 1e-1,
    }],
    build,
};

struct Lag(Real);

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[time_constant] = context.values else {
        unreachable!("one parameter on the card")
    };
    if time_constant == 0.0 {
        return Ok(None);
    }
    context.require(0, time_constant >= 1e-7, "zero (off) or at least 1e-7")?;
    Ok(Some(Box::new(Lag(time_constant))))
}

impl Effect for Lag {
    fn lagged_speed(&self, x: &[Real]) -> Option<Real> {
        Some(x[0])
    }
    fn add_rates(&self, m: &Motion, contact: &ContactForce, x: &[Real], rates: &mut [Real]) {
        if !contact.stuck {
            rates[0] += (m.speed - x[0]) / self.0;
        }
    }
    fn on_stick(&self, x: &mut [Real]) {
        x[0] = ZERO;
    }
    fn on_break_away(&self, x: &mut [Real]) {
        x[0] = ZERO;
    }
    fn settle(&self, m: &Motion, _contact: &ContactForce, x: &mut [Real]) {
        x[0] += m.relative_velocity.abs();
    }
    fn fastest_rate(&self) -> f64 {
        value(1.0 / self.0)
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for Lag {
    fn hooks(&self) -> Hooks {
        Hooks {
            rates: true,
            lagged_speed: true,
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
