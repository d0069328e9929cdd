//! The model with effects, in slip and in stick.

use super::{MAX_FACTORS, MAX_PARTS, MAX_REGISTERS, NONE};
use crate::beam::MAX_MODES;
use crate::contact::ContactMode;
use crate::effects::series::{EffectSeries, Hooks, MotionSeries, Series, keeps_sign, product};
use crate::effects::{BeltGive, ContactForce, Motion};
use crate::friction::series::{CoefficientSeries, ExponentialSum};
use crate::integrate::series::RECIPROCAL;
use crate::integrate::taylor::SeriesSystem;
use crate::integrate::{MAX_DEGREE, Segment, State};
use crate::model::{Enabled, Model};

/// The expansion of a motion with effects.
pub(super) struct FullSeries<'a> {
    model: &'a Model,
    mode: ContactMode,
    sign: f64,
    pub(super) motion: MotionSeries,
    /// Given distance of the belt, powers 0 to 2.
    distance: [f64; 3],
    belt_velocity: [f64; 2],
    friction: CoefficientSeries<'a>,
    /// Speed at which the friction law is evaluated at the start, in m/s.
    first_argument: f64,
    /// Coefficient of friction; in stick the static one.
    mu: Series,
    /// Friction force on the tip in N.
    pub(super) force: Series,
    factors: [Series; MAX_FACTORS],
    /// Capacity in N without factors, with the first, with the first two, ...
    partial: [Series; MAX_FACTORS + 1],
    factor_count: usize,
    registers: [Series; MAX_REGISTERS],
    /// Effects with their series, as many as there are.
    parts: [Option<Part<'a>>; MAX_PARTS],
    part_count: usize,
}

/// An effect with its series, looked up once for all powers.
#[derive(Clone, Copy)]
struct Part<'a> {
    enabled: &'a Enabled,
    series: &'a dyn EffectSeries,
}

impl<'a> FullSeries<'a> {
    /// The expansion from the time and state at which `segment` starts, in units of its length.
    pub(super) fn new(
        model: &'a Model,
        law: &'a ExponentialSum,
        mode: ContactMode,
        segment: &Segment,
    ) -> Self {
        let (t, unit) = (segment.start, segment.length);
        let start = model.motion(t, &segment.coefficients[0], mode);
        let mut motion = MotionSeries::new(unit, start);
        let [belt_velocity, normal_force] = model.given(t, unit);
        motion.normal_force[..2].copy_from_slice(&normal_force);
        let mut parts = [None; MAX_PARTS];
        for (part, enabled) in parts.iter_mut().zip(model.effects.iter()) {
            let series = enabled.effect.series();
            *part = series.map(|series| Part { enabled, series });
        }
        Self {
            model,
            mode,
            sign: mode.sign(),
            motion,
            distance: [
                model.travel_offset + model.inputs.belt_distance_at(t),
                belt_velocity[0] * unit,
                0.5 * belt_velocity[1] * unit,
            ],
            belt_velocity,
            friction: CoefficientSeries::new(law),
            first_argument: 0.0,
            mu: NONE,
            force: NONE,
            factors: [NONE; MAX_FACTORS],
            partial: [NONE; MAX_FACTORS + 1],
            factor_count: 0,
            registers: [NONE; MAX_REGISTERS],
            parts,
            part_count: model.effects.len(),
        }
    }

    /// Effect `i` if it uses a hook.
    #[inline]
    fn part(&self, i: usize, uses: impl Fn(&Hooks) -> bool) -> Option<Part<'a>> {
        self.parts[i].filter(|part| uses(&part.enabled.hooks))
    }

    /// Friction capacity in N, in stick the static limit.
    pub(super) fn capacity(&self) -> &Series {
        &self.partial[self.factor_count]
    }

    /// Works out the kinematics; the belt's give is linear in the states.
    pub(super) fn observe(&mut self, k: usize, x: &State) -> BeltGive {
        let (displacement, velocity) = self.model.tip(x);
        let mut give = BeltGive::default();
        for i in 0..self.part_count {
            if let Some(Part { enabled: e, .. }) = self.part(i, |h| h.belt_give) {
                give.add(e.effect.belt_give(self.model.states(e, x)));
            }
        }
        let m = &mut self.motion;
        let belt = self.belt_velocity.get(k).unwrap_or(&0.0) + give.velocity;
        let distance = self.distance.get(k).unwrap_or(&0.0);
        m.displacement[k] = displacement;
        m.velocity[k] = velocity;
        if self.mode != ContactMode::Stuck {
            m.relative_velocity[k] = velocity - belt;
            m.speed[k] = self.sign * m.relative_velocity[k];
        }
        m.travel[k] = distance + give.displacement - displacement;
        give
    }

    /// Works out everything of power `k` from the states; adds the modal accelerations in m/s^2.
    #[inline]
    pub(super) fn advance(
        &mut self,
        k: usize,
        states: &[State],
        acceleration: &mut [f64; MAX_MODES],
    ) {
        let (model, x) = (self.model, &states[k]);
        let give = self.observe(k, x);
        let mut tip_force = 0.0;
        for i in 0..self.part_count {
            let Some(Part { enabled: e, series }) =
                self.part(i, |h| h.tip_force || h.modal_acceleration)
            else {
                continue;
            };
            let registers = &mut self.registers[e.first_register..];
            if e.hooks.tip_force {
                tip_force += series.tip_force(k, &self.motion, registers);
            }
            if e.hooks.modal_acceleration {
                series.add_modal_acceleration(k, &self.motion, states, registers, acceleration);
            }
        }
        let mut free = 0.0;
        for j in 0..model.mode_count {
            acceleration[j] += model.gain[j] * tip_force
                - model.damping[j] * x[2 * j + 1]
                - model.stiffness[j] * x[2 * j];
            free += model.tip_value[j] * acceleration[j];
        }
        let capacity = self.next_capacity(k, x);
        self.force[k] = if self.mode == ContactMode::Stuck {
            let imposed = if k == 0 {
                model.inputs.belt_acceleration
            } else {
                0.0
            };
            (imposed + give.free_acceleration - free) / (model.mobility + give.mobility)
        } else if model.has_memory {
            self.memory_force(k, x)
        } else {
            -self.sign * capacity
        };
        for j in 0..model.mode_count {
            acceleration[j] += model.gain[j] * self.force[k];
        }
    }

    /// Coefficient of friction in slip, from the speed at which the law is evaluated.
    fn next_mu(&mut self, k: usize, x: &State) -> f64 {
        let model = self.model;
        let mut argument = self.motion.speed[k];
        for i in 0..self.part_count {
            let lagged = self.part(i, |h| h.lagged_speed).map(|part| part.enabled);
            if let Some(u) = lagged.and_then(|e| e.effect.lagged_speed(model.states(e, x))) {
                argument = u;
                break;
            }
        }
        if k == 0 {
            self.first_argument = argument;
        }
        let mut added = 0.0;
        for i in 0..self.part_count {
            if let Some(part) = self.part(i, |h| h.friction_term) {
                added += part.series.friction_term(argument);
            }
        }
        self.friction.next(k, argument) + added
    }

    /// Coefficient `k` of the capacity in N.
    fn next_capacity(&mut self, k: usize, x: &State) -> f64 {
        let model = self.model;
        let stuck = self.mode == ContactMode::Stuck;
        self.mu[k] = match (stuck, k) {
            (false, _) => self.next_mu(k, x),
            (true, 0) => model.static_coefficient,
            (true, _) => 0.0,
        };
        let force = &self.motion.normal_force;
        let before = if k == 0 { 0.0 } else { self.mu[k - 1] };
        self.partial[0][k] = model.level * (force[0] * self.mu[k] + force[1] * before);
        self.factor_count = 0;
        for i in 0..self.part_count {
            let Some(Part { enabled: e, series }) = self.part(i, |h| h.factor || h.static_factor)
            else {
                continue;
            };
            let registers = &mut self.registers[e.first_register..];
            if e.hooks.factor {
                let factor = series.factor(k, &self.motion, registers);
                self.multiply(k, factor);
            } else if stuck && e.hooks.static_factor {
                let factor = series.static_factor(k, &self.motion, registers);
                self.multiply(k, factor);
            }
        }
        self.capacity()[k]
    }

    /// Multiplies the capacity by a factor of which coefficient `k` is given.
    fn multiply(&mut self, k: usize, factor: f64) {
        let i = self.factor_count;
        self.factors[i][k] = factor;
        self.partial[i + 1][k] = product(&self.partial[i], &self.factors[i], k);
        self.factor_count += 1;
    }

    fn memory_force(&mut self, k: usize, x: &State) -> f64 {
        let model = self.model;
        let mut force = 0.0;
        for i in 0..self.part_count {
            let Some(Part { enabled: e, series }) = self.part(i, |h| h.memory_force) else {
                continue;
            };
            force += series.memory_force(
                k,
                &self.motion,
                &self.partial[self.factor_count],
                model.states(e, x),
                &mut self.registers[e.first_register..],
            );
        }
        force
    }

    /// Whether no factor changes its sign and every effect's expressions hold up to `theta`, as far as
    /// `degree` tells.
    pub(super) fn holds(&self, degree: usize, theta: f64) -> bool {
        let keeps = |f: &Series| f[0] >= 0.0 && keeps_sign(f, degree, theta);
        // Friction laws are continued by constants below v = 0.
        self.first_argument >= -1e-12
            && keeps(&self.motion.normal_force)
            && keeps(&self.mu)
            && self.factors[..self.factor_count].iter().all(keeps)
            && self.parts[..self.part_count].iter().flatten().all(|part| {
                let registers = &self.registers[part.enabled.first_register..];
                part.series.holds(&self.motion, registers, degree, theta)
            })
    }
}

impl SeriesSystem for FullSeries<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension
    }

    fn extend(&mut self, k: usize, coefficients: &mut [State; MAX_DEGREE + 1]) {
        let model = self.model;
        let (known, next) = coefficients.split_at_mut(k + 1);
        let (x, next) = (&known[k], &mut next[0]);
        let mut acceleration = [0.0; MAX_MODES];
        self.advance(k, known, &mut acceleration);
        let step = self.motion.unit * RECIPROCAL[k + 1];
        for j in 0..model.mode_count {
            next[2 * j] = step * x[2 * j + 1];
            next[2 * j + 1] = step * acceleration[j];
        }
        let m = &self.motion;
        let motion = Motion {
            displacement: m.displacement[k],
            velocity: m.velocity[k],
            relative_velocity: m.relative_velocity[k],
            speed: m.speed[k],
            ..Motion::default()
        };
        let contact = ContactForce {
            force: self.force[k],
            capacity: self.capacity()[k],
            stuck: self.mode == ContactMode::Stuck,
        };
        for i in 0..self.part_count {
            let Some(Part { enabled: e, series }) = self.part(i, |h| h.rates) else {
                continue;
            };
            let range = e.first_state..e.first_state + e.states.len();
            let registers = &mut self.registers[e.first_register..];
            let rates = &mut next[range.clone()];
            rates.fill(0.0);
            series.add_rates(k, &motion, &contact, &x[range], registers, rates);
            rates.iter_mut().for_each(|r| *r *= step);
        }
    }
}
