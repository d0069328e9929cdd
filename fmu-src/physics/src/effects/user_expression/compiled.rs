//! A user's effect, ready to be evaluated: the hooks of an effect, on numbers and on power series.

use super::Target;
use super::formula::Formula;
use super::quantity::{VARIABLE, values, values_with_force, values_with_reading};
use crate::beam::{Beam, MAX_MODES, clamp_participation};
use crate::belt::Inputs;
use crate::effects::series::{EffectSeries, Hooks, MotionSeries, Series, State, product};
use crate::effects::{BeltGive, ContactForce, Effect, Motion};
use crate::error::PhysicsError;
use crate::real::{Real, ZERO, real, value};
use std::ops::Range;

/// A state so many times its nominal magnitude has run away.
const RUNAWAY: f64 = 1e9;

/// A state with its formulas.
#[derive(Debug)]
pub(super) struct CompiledState {
    pub name: String,
    pub unit: String,
    pub nominal: f64,
    pub start: Formula,
    pub rate: Formula,
    pub on_stick: Option<Formula>,
    pub on_break_away: Option<Formula>,
}

impl CompiledState {
    pub fn formulas(&self) -> impl Iterator<Item = &Formula> {
        let jumps = self.on_stick.iter().chain(&self.on_break_away);
        [&self.start, &self.rate].into_iter().chain(jumps)
    }
}

/// A user's effect, ready to be evaluated.
#[derive(Debug)]
pub struct Compiled {
    pub(super) id: String,
    pub(super) target: Target,
    /// Modes on which a factor acts.
    pub(super) modes: Range<usize>,
    pub(super) formula: Formula,
    pub(super) states: Vec<CompiledState>,
    pub(super) constant_in_stick: bool,
    pub(super) constant_in_all_stick: bool,
    pub(super) has_series: bool,
    /// `w_j^2` in 1/s^2 and `2 D_j w_j + d_j` in 1/s of each mode.
    pub(super) stiffness: [Real; MAX_MODES],
    pub(super) damping: [Real; MAX_MODES],
    pub(super) participation: [Real; MAX_MODES],
}

impl Compiled {
    /// Value of the formula.
    pub fn value(&self, m: &Motion, x: &[Real]) -> Real {
        match self.target {
            Target::Measurement => self.measured_displacement(m.sensor_displacement, m, x),
            _ => self.formula.value(&values(m, self.own(x))),
        }
    }

    /// The motion at which formulas look: of a sensor where it looks, of all else that of the tip.
    fn seen(&self, m: &Motion) -> Motion {
        match self.target {
            Target::Measurement => Motion {
                displacement: m.sensor_displacement,
                velocity: m.sensor_velocity,
                ..*m
            },
            _ => *m,
        }
    }

    /// The states that formulas may use, without the belt's travel.
    fn own<'a>(&self, x: &'a [Real]) -> &'a [Real] {
        &x[..self.states.len()]
    }

    fn value_for(&self, target: Target, m: &Motion, x: &[Real], neutral: Real) -> Real {
        if self.target == target {
            self.value(m, x)
        } else {
            neutral
        }
    }

    fn jump(&self, x: &mut [Real], of: impl Fn(&CompiledState) -> Option<&Formula>) {
        let before = values(&Motion::default(), self.own(x));
        for (x, state) in x.iter_mut().zip(&self.states) {
            if let Some(formula) = of(state) {
                *x = formula.value(&before);
            }
        }
    }

    /// What is wrong with a value, at an instant.
    fn wrong(&self, what: &str, m: &Motion) -> PhysicsError {
        PhysicsError::Expression {
            name: self.id.clone(),
            problem: format!(
                "{what} at t = {} s, w = {} m, w_dot = {} m/s, v_r = {} m/s, s = {} m, t_stick = {} s",
                value(m.time),
                value(m.displacement),
                value(m.velocity),
                value(m.relative_velocity),
                value(m.travel),
                value(m.dwell)
            ),
        }
    }
}

impl Effect for Compiled {
    fn prepare(&mut self, beam: &Beam) {
        for (j, mode) in beam.modes().iter().enumerate() {
            let w = mode.angular_frequency();
            self.stiffness[j] = w * w;
            self.damping[j] = mode.damping();
        }
        self.participation = clamp_participation(beam);
    }
    fn add_modal_acceleration(
        &self,
        m: &Motion,
        x: &[Real],
        modes: &[Real],
        acceleration: &mut [Real],
    ) {
        let count = self.modes.end.min(acceleration.len());
        match self.target {
            Target::FrequencyFactor => {
                let factor = self.value(m, x);
                for j in self.modes.start..count {
                    acceleration[j] -= (factor * factor - 1.0) * self.stiffness[j] * modes[2 * j];
                }
            }
            Target::DampingFactor => {
                let factor = self.value(m, x);
                for j in self.modes.start..count {
                    acceleration[j] -= (factor - 1.0) * self.damping[j] * modes[2 * j + 1];
                }
            }
            Target::ClampAcceleration => {
                let clamp = self.value(m, x);
                for (sum, share) in acceleration.iter_mut().zip(&self.participation) {
                    *sum -= clamp * share;
                }
            }
            _ => {}
        }
    }
    fn tip_force(&self, m: &Motion, x: &[Real]) -> Real {
        self.value_for(Target::TipForce, m, x, ZERO)
    }
    fn friction_factor(&self, m: &Motion, x: &[Real]) -> Real {
        self.value_for(Target::FrictionFactor, m, x, real(1.0))
    }
    fn normal_factor(&self, m: &Motion, x: &[Real]) -> Real {
        self.value_for(Target::NormalForceFactor, m, x, real(1.0))
    }
    fn belt_ripple(&self, t: Real, inputs: &Inputs) -> Real {
        if self.target != Target::BeltVelocity {
            return ZERO;
        }
        let m = Motion {
            time: t,
            normal_force: inputs.normal_force_at(t),
            given_belt_velocity: inputs.belt_velocity_at(t),
            ..Motion::default()
        };
        self.formula.value(&values(&m, &[]))
    }
    fn has_belt_ripple(&self) -> bool {
        self.target == Target::BeltVelocity
    }
    fn belt_give(&self, x: &[Real]) -> BeltGive {
        let travel = x.get(self.states.len());
        BeltGive {
            displacement: travel.copied().unwrap_or(ZERO),
            ..BeltGive::default()
        }
    }
    fn add_rates(&self, m: &Motion, contact: &ContactForce, x: &[Real], rates: &mut [Real]) {
        if !self.states.is_empty() {
            let variable = values_with_force(&self.seen(m), contact, self.own(x));
            for (rate, state) in rates.iter_mut().zip(&self.states) {
                *rate += state.rate.value(&variable);
            }
        }
        if let Some(rate) = rates.get_mut(self.states.len()) {
            *rate += self.formula.value(&values(m, &[]));
        }
    }
    fn on_stick(&self, x: &mut [Real]) {
        self.jump(x, |state| state.on_stick.as_ref());
    }
    fn on_break_away(&self, x: &mut [Real]) {
        self.jump(x, |state| state.on_break_away.as_ref());
    }
    fn settle(&self, m: &Motion, _contact: &ContactForce, x: &mut [Real]) {
        let variable = values(&self.seen(m), &[]);
        for (x, state) in x.iter_mut().zip(&self.states) {
            *x += state.start.value(&variable);
        }
    }
    fn measured_displacement(&self, reading: Real, m: &Motion, x: &[Real]) -> Real {
        if self.target != Target::Measurement {
            return reading;
        }
        let variable = values_with_reading(&self.seen(m), reading, self.own(x));
        self.formula.value(&variable)
    }
    fn measures_linearly(&self) -> bool {
        self.target != Target::Measurement
    }
    fn is_linear_in_stick(&self) -> bool {
        if !self.states.is_empty() {
            return false;
        }
        // A friction or normal force factor acts on the limit alone.
        match self.target {
            Target::TipForce
            | Target::FrequencyFactor
            | Target::DampingFactor
            | Target::ClampAcceleration => self.constant_in_all_stick,
            Target::BeltVelocity => false,
            _ => true,
        }
    }
    fn keeps_limit_constant(&self) -> bool {
        match self.target {
            Target::FrictionFactor | Target::NormalForceFactor => self.constant_in_stick,
            _ => true,
        }
    }
    fn fault(&self, m: &Motion, x: &[Real]) -> Option<PhysicsError> {
        for (x, state) in x.iter().zip(&self.states) {
            // Negated, so that what is not a number counts too.
            if !(value(*x).abs() <= RUNAWAY * state.nominal) {
                let (name, unit) = (&state.name, &state.unit);
                let what = format!(
                    "state {name} = {:e} {unit} has run away from its nominal {:e} {unit}",
                    value(*x),
                    state.nominal
                );
                return Some(self.wrong(&what, m));
            }
        }
        let force = self.value(m, x);
        (!force.is_finite()).then(|| self.wrong(&format!("the formula gives {}", value(force)), m))
    }
    fn series(&self) -> Option<&dyn EffectSeries> {
        self.has_series.then_some(self)
    }
}

/// Registers beside those of the formulas: the formula's value, and its square or product.
const OWN_REGISTERS: usize = 2;

impl Compiled {
    /// Coefficient `k` of the formula's value, kept in the first register.
    fn next_value(&self, k: usize, variable: &[Real; VARIABLE], registers: &mut [Series]) -> Real {
        let (own, rest) = registers.split_at_mut(OWN_REGISTERS);
        own[0][k] = self.formula.next(k, variable, rest);
        own[0][k]
    }
}

impl EffectSeries for Compiled {
    fn acts_in_slip(&self) -> bool {
        self.target != Target::Measurement || !self.states.is_empty()
    }
    fn hooks(&self) -> Hooks {
        let is = |targets: &[Target]| targets.contains(&self.target);
        Hooks {
            modal_acceleration: is(&[
                Target::FrequencyFactor,
                Target::DampingFactor,
                Target::ClampAcceleration,
            ]),
            tip_force: is(&[Target::TipForce]),
            factor: is(&[Target::FrictionFactor, Target::NormalForceFactor]),
            ripple: is(&[Target::BeltVelocity]),
            rates: !self.states.is_empty() || is(&[Target::BeltVelocity]),
            ..Hooks::default()
        }
    }
    fn register_count(&self) -> usize {
        let rates = self.states.iter().map(|s| s.rate.register_count());
        OWN_REGISTERS + self.formula.register_count() + rates.sum::<usize>()
    }
    fn add_modal_acceleration(
        &self,
        k: usize,
        m: &MotionSeries,
        x: &[Real],
        states: &[State],
        registers: &mut [Series],
        acceleration: &mut [Real],
    ) {
        let factor = self.next_value(k, &values(&m.power(k), self.own(x)), registers);
        if self.target == Target::ClampAcceleration {
            for (sum, share) in acceleration.iter_mut().zip(&self.participation) {
                *sum -= factor * share;
            }
            return;
        }
        let is_frequency = self.target == Target::FrequencyFactor;
        let change = match is_frequency {
            true => product(&registers[0], &registers[0], k),
            false => factor,
        };
        registers[1][k] = if k == 0 { change - 1.0 } else { change };
        let count = self.modes.end.min(acceleration.len());
        for j in self.modes.start..count {
            let (of, scale) = match is_frequency {
                true => (2 * j, self.stiffness[j]),
                false => (2 * j + 1, self.damping[j]),
            };
            let mut sum = ZERO;
            for i in 0..=k {
                sum += registers[1][i] * states[k - i][of];
            }
            acceleration[j] -= scale * sum;
        }
    }
    fn tip_force(&self, k: usize, m: &MotionSeries, x: &[Real], registers: &mut [Series]) -> Real {
        self.next_value(k, &values(&m.power(k), self.own(x)), registers)
    }
    fn factor(&self, k: usize, m: &MotionSeries, x: &[Real], registers: &mut [Series]) -> Real {
        self.next_value(k, &values(&m.power(k), self.own(x)), registers)
    }
    fn ripple(&self, k: usize, m: &MotionSeries, registers: &mut [Series]) -> Real {
        self.next_value(k, &values(&m.power(k), &[]), registers)
    }
    fn add_rates(
        &self,
        k: usize,
        motion: &Motion,
        contact: &ContactForce,
        x: &[Real],
        registers: &mut [Series],
        rates: &mut [Real],
    ) {
        if self.target == Target::BeltVelocity {
            rates[self.states.len()] += registers[0][k];
        }
        let mut variable = values_with_force(&self.seen(motion), contact, self.own(x));
        if k > 0 {
            // Whether it sticks is a constant.
            variable[super::quantity::STICK] = ZERO;
        }
        let mut rest = &mut registers[OWN_REGISTERS + self.formula.register_count()..];
        for (rate, state) in rates.iter_mut().zip(&self.states) {
            *rate += state.rate.next(k, &variable, rest);
            rest = &mut rest[state.rate.register_count()..];
        }
    }
    fn until(&self, _m: &MotionSeries, registers: &[Series], degree: usize, theta: f64) -> f64 {
        let mut rest = &registers[OWN_REGISTERS..];
        let acts = self.target != Target::Measurement;
        let mut end = match acts {
            true => self.formula.until(rest, degree, theta),
            false => theta,
        };
        rest = &rest[self.formula.register_count()..];
        for state in &self.states {
            let (own, others) = rest.split_at(state.rate.register_count());
            rest = others;
            // Rates are worked out up to the power before.
            end = end.min(state.rate.until(own, degree.saturating_sub(1), theta));
        }
        end
    }
}
