//! The reference model's motion and that with an effect, from the same state on the reference model's cycle.

use crate::command::operating_point::{OperatingPoint, record};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::fmu::effect_card::{EffectCard, Role};
use crate::metric::{amplitude, cycle_starts, period, stick_fraction};

/// Communication step, s: 200 to a cycle of 10 ms.
const STEP: f64 = 5e-5;
/// Time that the start is given to die away, s, and time that the numbers are taken from.
const SETTLE: f64 = 1.5;
const KEPT: f64 = 0.5;
/// Cycles of the reference model that the pictures show.
const CYCLES: f64 = 3.0;
/// Share of the belt velocity below which the tip counts as resting on the belt; bristles creep.
const AT_REST: f64 = 0.01;
/// What is recorded.
const OUTPUTS: [&str; 3] = [
    "measured_displacement",
    "friction_force",
    "relative_velocity",
];

/// A motion from a state on the reference model's cycle.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Time since the state, s.
    pub time: Vec<f64>,
    /// What the sensor shows, m.
    pub displacement: Vec<f64>,
    /// Friction force on the tip, N.
    pub force: Vec<f64>,
    /// Tip velocity less belt velocity, m/s.
    pub relative_velocity: Vec<f64>,
    /// Once settled: time from cycle to cycle, s; NaN without one.
    pub period: f64,
    /// Once settled: amplitude, m.
    pub amplitude: f64,
    /// Once settled: share of the time in which the tip rests on the belt.
    pub stick_share: f64,
}

/// Whether an FMU has what the pictures need.
pub fn can_be_shown(fmu: &Fmu) -> bool {
    OUTPUTS.iter().all(|name| fmu.variable(name).is_ok())
}

/// The values that switch an effect on at its typical strength; a profile's values follow one wave, as equal ones would be none.
pub fn typical(card: &EffectCard) -> Vec<(String, f64)> {
    let value = |(i, p): (usize, &crate::fmu::effect_card::EffectParameter)| {
        let wave = (std::f64::consts::TAU * i as f64 / 8.0).sin();
        let value = match p.role {
            Role::Node => p.typical * wave,
            Role::Phase => p.start,
            _ => p.typical,
        };
        (format!("{}.{}", card.id, p.name), value)
    };
    card.parameters.iter().enumerate().map(value).collect()
}

/// Steps until the start has died away, and in all.
fn steps() -> (usize, usize) {
    let to = |time: f64| (time / STEP).round() as usize;
    (to(SETTLE), to(SETTLE + KEPT))
}

/// The motion at an operating point, from the state that it gives.
///
/// # Errors
/// A start value that the FMU refuses, or a motion that it can't go on with.
pub fn motion(fmu: &Fmu, point: &OperatingPoint) -> Result<Motion, Error> {
    let mut instance = fmu.instantiate("effect")?;
    point.start(fmu, &mut instance)?;
    let (first, all) = steps();
    let record = record(fmu, &mut instance, &OUTPUTS, STEP, all)?;
    let [displacement, force, relative_velocity] =
        [0, 1, 2].map(|k: usize| record.values[k].clone());
    let rest = AT_REST * point.belt_velocity.abs();
    let late = &relative_velocity[first..];
    let sticks: Vec<bool> = late.iter().map(|v| v.abs() < rest).collect();
    Ok(Motion {
        period: period(&displacement[first..], STEP).map_or(f64::NAN, |p| p.seconds),
        amplitude: amplitude(&displacement[first..]),
        stick_share: stick_fraction(&record.time[first..], &sticks),
        time: record.time,
        displacement,
        force,
        relative_velocity,
    })
}

/// Start values of the state in which a cycle of the settled motion begins, rising through its mean; empty where the FMU has no
/// modal coordinates or the motion no cycle.
///
/// # Errors
/// As for [`motion`].
pub fn state_on_the_cycle(fmu: &Fmu, point: &OperatingPoint) -> Result<Vec<(String, f64)>, Error> {
    let has = |name: &String| fmu.variable(name).is_ok();
    let coordinates = (1..).map(|j| [format!("q[{j}]"), format!("q_dot[{j}]")]);
    let mut names: Vec<String> = coordinates
        .take_while(|pair| pair.iter().all(has))
        .flatten()
        .collect();
    let starts = |name: &str| match name {
        "dwell_time" => "dwell_time.start".to_owned(),
        name => name.to_owned(),
    };
    names.extend(
        ["dwell_time".to_owned()]
            .into_iter()
            .filter(|n| has(n) && has(&starts(n))),
    );
    let outputs: Vec<&str> = OUTPUTS[..1]
        .iter()
        .copied()
        .chain(names.iter().map(String::as_str))
        .collect();
    let mut instance = fmu.instantiate("reference")?;
    point.start(fmu, &mut instance)?;
    let (first, all) = steps();
    let record = record(fmu, &mut instance, &outputs, STEP, all)?;
    let (time, displacement) = (&record.time[first..], &record.values[0][first..]);
    let begins = period(displacement, STEP)
        .and_then(|p| cycle_starts(time, displacement, p.seconds).first().copied());
    let Some(begin) = begins else {
        return Ok(Vec::new());
    };
    let at = time.partition_point(|t| *t < begin) + first;
    let values = names.iter().zip(&record.values[1..]);
    Ok(values.map(|(n, v)| (starts(n), v[at])).collect())
}

impl Motion {
    /// The time that the pictures show, s: some cycles of this motion.
    pub fn shown(&self) -> f64 {
        let cycle = if self.period.is_finite() {
            self.period
        } else {
            KEPT / CYCLES
        };
        CYCLES * cycle
    }

    /// Largest difference of the displacement from another motion's in as long a time, over that motion's amplitude.
    pub fn apart(&self, other: &Motion, end: f64) -> f64 {
        let pairs = self.displacement.iter().zip(&other.displacement);
        let shown = pairs.zip(&self.time).take_while(|(_, t)| **t <= end);
        let largest = shown.map(|((a, b), _)| (a - b).abs()).fold(0.0, f64::max);
        largest / other.amplitude
    }

    /// Up to a time, s.
    pub fn until(mut self, end: f64) -> Motion {
        let count = self.time.partition_point(|t| *t <= end);
        self.time.truncate(count);
        self.displacement.truncate(count);
        self.force.truncate(count);
        self.relative_velocity.truncate(count);
        self
    }
}
