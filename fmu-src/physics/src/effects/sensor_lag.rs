//! A measuring chain that is late or band-limited.

use super::series::{EffectSeries, Hooks, Series};
use super::{Card, ContactForce, Context, Effect, Motion, Parameter, Role, StateVariable};
use crate::error::PhysicsError;
use crate::real::{Real, value};
use crate::unit::{METRE, SECOND};

/// Describes the effect.
pub static CARD: Card = Card {
    id: "sensor_lag",
    title: "The measuring chain is slow",
    equation: "tau y' = w - y,  measured displacement = y",
    description: "Sensor or amplifier act as a first-order low-pass on the displacement. The motion itself is unchanged.",
    source: "Doebelin 1990, Measurement Systems, 4th ed., sect. 3.3 (first-order instrument)",
    signature: "the whole waveform is delayed and rounded; the corners of stick come late",
    confounders: "presliding_compliance, frictional_lag; a free vibration without contact shows the sensor alone",
    first_value_reference: 2200,
    parameters: &[Parameter {
        name: "time_constant",
        description: "time constant tau of the measuring chain; 0 means immediate",
        unit: SECOND,
        start: 0.0,
        typical: 2e-4,
        min: 3e-6,
        max: 5e-3,
        role: Role::Shape,
    }],
    states: &[StateVariable {
        name: "reading",
        description: "displacement y as measured",
        unit: METRE,
        nominal: 1e-3,
    }],
    build,
};

struct SensorLag(Real);

fn build(context: &Context) -> Result<Option<Box<dyn Effect>>, PhysicsError> {
    let &[time_constant] = context.values else {
        unreachable!("one parameter on the card")
    };
    if time_constant == 0.0 {
        return Ok(None);
    }
    context.require(0, time_constant >= 1e-7, "zero (off) or at least 1e-7")?;
    Ok(Some(Box::new(SensorLag(time_constant))))
}

impl Effect for SensorLag {
    fn add_rates(&self, m: &Motion, _contact: &ContactForce, x: &[Real], rates: &mut [Real]) {
        rates[0] += (m.sensor_displacement - x[0]) / self.0;
    }
    fn measured_displacement(&self, _reading: Real, _m: &Motion, x: &[Real]) -> Real {
        x[0]
    }
    fn settle(&self, m: &Motion, _contact: &ContactForce, x: &mut [Real]) {
        // A ramp is followed with the delay tau once the start has been forgotten.
        x[0] += m.sensor_displacement - self.0 * m.sensor_velocity;
    }
    fn fastest_rate(&self) -> f64 {
        value(1.0 / self.0)
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        Some(self)
    }
}

impl EffectSeries for SensorLag {
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
