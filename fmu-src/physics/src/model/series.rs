//! Slip as a Taylor series: the equations of [`super`] once more, coefficient by coefficient.

use super::{Enabled, Model};
use crate::beam::MAX_MODES;
use crate::contact::ContactMode;
use crate::effects::series::{MotionSeries, Series, keeps_sign, product};
use crate::effects::{ContactForce, Motion};
use crate::friction::FrictionLaw;
use crate::friction::series::{CoefficientSeries, ExponentialSum};
use crate::integrate::series::RECIPROCAL;
use crate::integrate::taylor::{self, SeriesSystem};
use crate::integrate::{MAX_DEGREE, Segment, State};

/// Most registers that all effects have together.
const MAX_REGISTERS: usize = 16;
/// Most effects with a factor on the friction force.
const MAX_FACTORS: usize = 6;
const NONE: Series = [0.0; MAX_DEGREE + 1];

/// The friction law as a sum of exponentials, if all effects have power series too; gives each effect
/// the place of its registers.
pub(super) fn exponential_sum(
    law: &FrictionLaw,
    effects: &mut [Enabled],
) -> Option<ExponentialSum> {
    let (mut registers, mut factors) = (0, 0);
    for e in effects {
        let series = e.effect.series()?;
        e.first_register = registers;
        registers += series.register_count();
        factors += usize::from(series.has_factor());
    }
    let fits = registers <= MAX_REGISTERS && factors <= MAX_FACTORS;
    law.exponential_sum().filter(|_| fits)
}

/// A stretch of slip as polynomials in theta.
pub struct Slip {
    /// Normalised time up to which they are good to the tolerance.
    pub reach: f64,
    /// The sliding speed sgn(v_r) v_r in m/s.
    pub gap: Series,
}

impl Model {
    /// Whether slip can be expanded in power series.
    pub fn has_series(&self) -> bool {
        self.exponential_sum.is_some()
    }

    /// Expands slip from the time and state at which `segment` starts. `None` where the series does not
    /// hold up to its reach, because a quantity changes its regime there.
    pub fn expand_slip(
        &self,
        mode: ContactMode,
        tolerance: f64,
        scales: &State,
        segment: &mut Segment,
    ) -> Option<Slip> {
        segment.length = self.series_unit;
        let degree = taylor::degree(tolerance);
        if self.effects.is_empty() {
            let mut system = BaseSeries::new(self, mode, segment.start)?;
            taylor::expand(&mut system, degree, segment);
            let reach = taylor::reach(segment, tolerance, scales);
            system.observe(degree, &segment.coefficients[degree]);
            let [force, rate] = system.normal_force;
            (force + rate * reach >= 0.0).then_some(Slip {
                reach,
                gap: system.speed,
            })
        } else {
            let mut system = FullSeries::new(self, mode, segment.start, &segment.coefficients[0])?;
            taylor::expand(&mut system, degree, segment);
            let reach = taylor::reach(segment, tolerance, scales);
            system.observe(degree, &segment.coefficients[degree]);
            system.holds(degree, reach).then_some(Slip {
                reach,
                gap: system.motion.speed,
            })
        }
    }

    /// Coefficients of the given belt velocity and normal force, powers 0 and 1.
    fn given(&self, t: f64) -> [[f64; 2]; 2] {
        let i = &self.inputs;
        let unit = self.series_unit;
        [
            [i.belt_velocity_at(t), i.belt_acceleration * unit],
            [i.normal_force_at(t), i.normal_force_rate * unit],
        ]
    }
}

/// The reference model alone. Signs and factors are folded into the coefficients beforehand, because
/// each power waits for the one before.
struct BaseSeries<'a> {
    model: &'a Model,
    belt_velocity: [f64; 2],
    normal_force: [f64; 2],
    /// Sliding speed per modal velocity.
    row: [f64; MAX_MODES],
    /// Modal acceleration per coefficient of friction and normal force, in m/(s^2 N).
    drive: [f64; MAX_MODES],
    speed: Series,
    friction: CoefficientSeries<'a>,
    /// Coefficient of friction of the power before.
    mu_before: f64,
}

impl<'a> BaseSeries<'a> {
    fn new(model: &'a Model, mode: ContactMode, t: f64) -> Option<Self> {
        let [mut belt_velocity, normal_force] = model.given(t);
        let sign = mode.sign();
        belt_velocity.iter_mut().for_each(|v| *v *= sign);
        let scale = -sign * model.level;
        Some(Self {
            model,
            belt_velocity,
            normal_force,
            row: model.tip_value.map(|phi| sign * phi),
            drive: model.gain.map(|gain| gain * scale),
            speed: NONE,
            friction: CoefficientSeries::new(model.exponential_sum.as_ref()?),
            mu_before: 0.0,
        })
    }

    /// Works out the sliding speed.
    #[inline]
    fn observe(&mut self, k: usize, x: &State) {
        let mut speed = 0.0;
        for j in 0..self.model.mode_count {
            speed += self.row[j] * x[2 * j + 1];
        }
        if k < 2 {
            speed -= self.belt_velocity[k];
        }
        self.speed[k] = speed;
    }
}

impl SeriesSystem for BaseSeries<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension
    }

    #[inline]
    fn extend(&mut self, k: usize, coefficients: &mut [State; MAX_DEGREE + 1]) {
        let m = self.model;
        let (known, next) = coefficients.split_at_mut(k + 1);
        let (x, next) = (&known[k], &mut next[0]);
        self.observe(k, x);
        let mu = self.friction.next(k, self.speed[k]);
        let [force, rate] = self.normal_force;
        let ramp = rate * self.mu_before;
        self.mu_before = mu;
        let step = m.series_unit * RECIPROCAL[k + 1];
        for j in 0..m.mode_count {
            let (q, v) = (x[2 * j], x[2 * j + 1]);
            let drive = step * self.drive[j];
            let rest = drive * ramp - step * (m.damping[j] * v + m.stiffness[j] * q);
            next[2 * j] = step * v;
            next[2 * j + 1] = drive * force * mu + rest;
        }
    }
}

/// The model with effects.
struct FullSeries<'a> {
    model: &'a Model,
    sign: f64,
    motion: MotionSeries,
    /// Given distance of the belt from its place at the start, powers 0 to 2.
    distance: [f64; 3],
    belt_velocity: [f64; 2],
    friction: CoefficientSeries<'a>,
    /// Speed at which the friction law is evaluated at the start, in m/s.
    first_argument: f64,
    mu: Series,
    factors: [Series; MAX_FACTORS],
    /// Capacity in N with the first factor, the first two, ...
    partial: [Series; MAX_FACTORS + 1],
    factor_count: usize,
    registers: [Series; MAX_REGISTERS],
}

impl<'a> FullSeries<'a> {
    fn new(model: &'a Model, mode: ContactMode, t: f64, x: &State) -> Option<Self> {
        let start = model.motion(t, x, mode);
        let mut motion = MotionSeries::new(model.series_unit, start);
        let [belt_velocity, normal_force] = model.given(t);
        motion.normal_force[..2].copy_from_slice(&normal_force);
        let unit = model.series_unit;
        let given = model.travel_offset + model.inputs.belt_distance_at(t);
        Some(Self {
            model,
            sign: mode.sign(),
            motion,
            distance: [
                given,
                belt_velocity[0] * unit,
                0.5 * belt_velocity[1] * unit,
            ],
            belt_velocity,
            friction: CoefficientSeries::new(model.exponential_sum.as_ref()?),
            first_argument: 0.0,
            mu: NONE,
            factors: [NONE; MAX_FACTORS],
            partial: [NONE; MAX_FACTORS + 1],
            factor_count: 0,
            registers: [NONE; MAX_REGISTERS],
        })
    }

    /// Works out the kinematics; the belt's give is linear in the states.
    fn observe(&mut self, k: usize, x: &State) -> crate::effects::BeltGive {
        let (displacement, velocity) = self.model.tip(x);
        let give = self.model.belt_give(x);
        let m = &mut self.motion;
        let belt = self.belt_velocity.get(k).unwrap_or(&0.0) + give.velocity;
        let distance = self.distance.get(k).unwrap_or(&0.0);
        m.displacement[k] = displacement;
        m.velocity[k] = velocity;
        m.relative_velocity[k] = velocity - belt;
        m.speed[k] = self.sign * m.relative_velocity[k];
        m.travel[k] = distance + give.displacement - displacement;
        give
    }

    /// Coefficient `k` of the friction capacity in N.
    fn capacity(&mut self, k: usize, x: &State) -> f64 {
        let model = self.model;
        let argument = model
            .effects
            .iter()
            .find_map(|e| e.effect.lagged_speed(model.states(e, x)))
            .unwrap_or(self.motion.speed[k]);
        if k == 0 {
            self.first_argument = argument;
        }
        let mut mu = self.friction.next(k, argument);
        let effects = model.effects.iter().filter_map(with_series);
        for (_, series) in effects.clone() {
            mu += series.friction_term(argument);
        }
        self.mu[k] = mu;
        let force = &self.motion.normal_force;
        let before = if k == 0 { 0.0 } else { self.mu[k - 1] };
        self.partial[0][k] = model.level * (force[0] * mu + force[1] * before);
        self.factor_count = 0;
        for (e, series) in effects.filter(|(_, s)| s.has_factor()) {
            let i = self.factor_count;
            let registers = &mut self.registers[e.first_register..];
            self.factors[i][k] = series.factor(k, &self.motion, registers);
            self.partial[i + 1][k] = product(&self.partial[i], &self.factors[i], k);
            self.factor_count += 1;
        }
        self.partial[self.factor_count][k]
    }

    fn friction_force(&mut self, k: usize, x: &State) -> ContactForce {
        let capacity = self.capacity(k, x);
        let model = self.model;
        let mut force = -self.sign * capacity;
        if model.has_memory {
            force = 0.0;
            for (e, series) in model.effects.iter().filter_map(with_series) {
                force += series.memory_force(
                    k,
                    &self.motion,
                    &self.partial[self.factor_count],
                    model.states(e, x),
                    &mut self.registers[e.first_register..],
                );
            }
        }
        ContactForce {
            force,
            capacity,
            stuck: false,
        }
    }

    /// Whether no factor changes its sign and every effect's expressions hold up to `theta`.
    fn holds(&self, degree: usize, theta: f64) -> bool {
        let below = degree - 1;
        let keeps = |f: &Series| f[0] >= 0.0 && keeps_sign(f, below, theta);
        self.first_argument >= -1e-12
            && keeps(&self.motion.normal_force)
            && keeps(&self.mu)
            && self.factors[..self.factor_count].iter().all(keeps)
            && self
                .model
                .effects
                .iter()
                .filter_map(with_series)
                .all(|(e, s)| {
                    s.holds(
                        &self.motion,
                        &self.registers[e.first_register..],
                        below,
                        theta,
                    )
                })
    }
}

/// An effect with its series.
fn with_series(e: &Enabled) -> Option<(&Enabled, &dyn crate::effects::series::EffectSeries)> {
    Some((e, e.effect.series()?))
}

impl SeriesSystem for FullSeries<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension
    }

    fn extend(&mut self, k: usize, coefficients: &mut [State; MAX_DEGREE + 1]) {
        let model = self.model;
        let (known, next) = coefficients.split_at_mut(k + 1);
        let (x, next) = (&known[k], &mut next[0]);
        let give = self.observe(k, x);
        let contact = self.friction_force(k, x);
        let effects = model.effects.iter().filter_map(with_series);
        let mut acceleration = [0.0; MAX_MODES];
        let mut force = contact.force;
        for (e, series) in effects.clone() {
            let registers = &mut self.registers[e.first_register..];
            force += series.tip_force(k, &self.motion, registers);
            series.add_modal_acceleration(k, &self.motion, known, registers, &mut acceleration);
        }
        let step = model.series_unit * RECIPROCAL[k + 1];
        for j in 0..model.mode_count {
            let (q, v) = (x[2 * j], x[2 * j + 1]);
            next[2 * j] = step * v;
            next[2 * j + 1] = step
                * (acceleration[j] + model.gain[j] * force
                    - model.damping[j] * v
                    - model.stiffness[j] * q);
        }
        let m = &self.motion;
        let at_k = Motion {
            displacement: m.displacement[k],
            velocity: m.velocity[k],
            belt_velocity: m.velocity[k] - m.relative_velocity[k],
            relative_velocity: m.relative_velocity[k],
            speed: m.speed[k],
            travel: m.travel[k],
            normal_force: m.normal_force[k],
            ..Motion::default()
        };
        let _ = give;
        for (e, series) in effects.filter(|(e, _)| !e.is_mode) {
            let range = e.first_state..e.first_state + e.states.len();
            let registers = &mut self.registers[e.first_register..];
            let rates = &mut next[range.clone()];
            rates.fill(0.0);
            series.add_rates(k, &at_k, &contact, &x[range], registers, rates);
            rates.iter_mut().for_each(|r| *r *= step);
        }
    }
}
