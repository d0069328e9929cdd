//! The model with effects, in slip and in stick.

use super::MAX_PARTS;
use super::workspace::Workspace;
use crate::beam::MAX_MODES;
use crate::contact::ContactMode;
use crate::effects::series::{EffectSeries, Series, all_or_nothing, product};
use crate::effects::{BeltGive, ContactForce};
use crate::friction::series::{CoefficientSeries, ExponentialSum};
use crate::integrate::series::RECIPROCAL;
use crate::integrate::taylor::SeriesSystem;
use crate::integrate::{MAX_DEGREE, Segment, State};
use crate::model::{Enabled, Model};
use crate::real::{Real, ZERO};

/// Share of the step that could have been by which one goes on beyond the end of a branch: so little that what the wrong
/// branch does there is far below any tolerance (of a force that jumps, 1e-9 of the step's impulse), and so much that
/// rounding can't put the next step before that end.
const BEYOND: f64 = 1e-9;

/// The expansion of a motion with effects.
pub(super) struct FullSeries<'a> {
    model: &'a Model,
    mode: ContactMode,
    /// Sliding speed per modal velocity.
    row: [Real; MAX_MODES],
    /// Modal acceleration in m/(s^2 N) per friction force, or per capacity where that gives the force.
    drive: [Real; MAX_MODES],
    pub(super) room: &'a mut Workspace,
    /// Given distance of the belt, powers 0 to 2.
    distance: [Real; 3],
    /// External force in N, powers 0 and 1.
    external_force: [Real; 2],
    /// Acceleration of the clamp in m/s^2, powers 0 and 1.
    clamp_acceleration: [Real; 2],
    /// Given belt velocity as it enters the sliding speed.
    belt_velocity: [Real; 2],
    friction: CoefficientSeries<'a>,
    /// Speed at which the friction law is evaluated at the start, in m/s.
    first_argument: Real,
    factor_count: usize,
    /// Series of the effects, as many as there are, looked up once for all powers.
    series: [Option<&'a dyn EffectSeries>; MAX_PARTS],
}

impl<'a> FullSeries<'a> {
    /// The expansion from the time and state at which `segment` starts, in units of its length.
    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    pub(super) fn new(
        model: &'a Model,
        law: &'a ExponentialSum,
        mode: ContactMode,
        segment: &Segment,
        room: &'a mut Workspace,
    ) -> Self {
        let (t, unit) = (segment.start, segment.length);
        room.motion.start = model.motion(t, &segment.coefficients[0], mode);
        room.motion.unit = unit;
        let sign = mode.sign();
        room.motion.sign = sign;
        let [
            belt_velocity,
            normal_force,
            external_force,
            clamp_acceleration,
        ] = model.given(t, unit);
        room.motion.normal_force = normal_force;
        room.motion.given_belt_velocity = belt_velocity;
        room.motion.stuck = mode == ContactMode::Stuck;
        room.keep(model.registers);
        let mut series = [None; MAX_PARTS];
        for (series, enabled) in series.iter_mut().zip(model.effects.iter()) {
            *series = enabled.effect.series();
        }
        let by_capacity = mode != ContactMode::Stuck && !model.has_memory;
        let scale = if by_capacity { -sign } else { 1.0 };
        Self {
            model,
            mode,
            row: model.tip_value.map(|phi| sign * phi),
            drive: model.gain.map(|gain| scale * gain),
            room,
            distance: [
                model.travel_offset + model.inputs.belt_distance_at(t),
                belt_velocity[0] * unit,
                0.5 * belt_velocity[1] * unit,
            ],
            external_force,
            clamp_acceleration,
            belt_velocity: belt_velocity.map(|v| sign * v),
            friction: CoefficientSeries::new(law, model.friction_slope),
            first_argument: ZERO,
            factor_count: 0,
            series,
        }
    }

    /// Effect `i`, which has a series, as all have in a model that has one.
    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    fn part(&self, i: usize) -> (&'a Enabled, &'a dyn EffectSeries) {
        (&self.model.effects[i], self.series[i].expect("looked up"))
    }

    /// Friction capacity in N, in stick the static limit.
    pub(super) fn capacity(&self) -> &Series {
        &self.room.partial[self.factor_count]
    }

    /// Works out the kinematics; the belt's give is linear in the states.
    ///
    /// The sliding speed is what the next power waits for, hence a sum of its own.
    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    pub(super) fn observe(&mut self, k: usize, x: &State) -> BeltGive {
        let model = self.model;
        let mut speed = ZERO;
        for j in 0..model.mode_count {
            speed += self.row[j] * x[2 * j + 1];
        }
        if k < 2 {
            speed -= self.belt_velocity[k];
        }
        let give = model.belt_give(x);
        speed -= self.room.motion.sign * give.velocity;
        if !model.users.ripple.is_empty() {
            if k == 0 {
                self.next_ripple(0);
            }
            speed -= self.room.motion.sign * self.room.ripple[k];
            // Stick must follow its rate.
            if k < MAX_DEGREE {
                self.next_ripple(k + 1);
            }
        }
        let (displacement, velocity) = model.tip(x);
        let (sensor_displacement, sensor_velocity) = model.sensor(x, (displacement, velocity));
        let m = &mut self.room.motion;
        let distance = self.distance.get(k).unwrap_or(&ZERO);
        m.displacement[k] = displacement;
        m.velocity[k] = velocity;
        m.sensor_displacement[k] = sensor_displacement;
        m.sensor_velocity[k] = sensor_velocity;
        m.speed[k] = speed;
        m.travel[k] = distance + give.displacement - displacement;
        give
    }

    /// Coefficient `k` of the velocity that effects impose on the belt.
    fn next_ripple(&mut self, k: usize) {
        let mut sum = ZERO;
        for i in self.model.users.ripple.iter() {
            let (e, series) = self.part(i);
            let registers = &mut self.room.registers[e.first_register..];
            sum += series.ripple(k, &self.room.motion, registers);
        }
        self.room.ripple[k] = sum;
    }

    /// Works out everything of power `k` from the states. Returns what drives the modes by [`Self::drive`],
    /// the friction force or the capacity, in N, and adds the other modal accelerations in m/s^2.
    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    pub(super) fn advance(
        &mut self,
        k: usize,
        states: &[State],
        acceleration: &mut [Real; MAX_MODES],
    ) -> Real {
        let (model, x) = (self.model, &states[k]);
        let give = self.observe(k, x);
        let mut tip_force = self.external_force.get(k).copied().unwrap_or(ZERO);
        for i in model.users.tip_force.iter() {
            let (e, series) = self.part(i);
            let registers = &mut self.room.registers[e.first_register..];
            tip_force += series.tip_force(k, &self.room.motion, model.states(e, x), registers);
        }
        for i in model.users.modal_acceleration.iter() {
            let (e, series) = self.part(i);
            let registers = &mut self.room.registers[e.first_register..];
            let (m, modes) = (&self.room.motion, &mut acceleration[..model.mode_count]);
            let own = model.states(e, x);
            series.add_modal_acceleration(k, m, own, states, registers, modes);
        }
        let clamp = self.clamp_acceleration.get(k).copied().unwrap_or(ZERO);
        for j in 0..model.mode_count {
            acceleration[j] += model.gain[j] * tip_force
                - model.damping[j] * x[2 * j + 1]
                - model.stiffness[j] * x[2 * j]
                - model.clamp_participation[j] * clamp;
        }
        let capacity = self.next_capacity(k, x);
        let (drive, force) = if self.mode == ContactMode::Stuck {
            let mut imposed = if k == 0 {
                model.inputs.belt_acceleration
            } else {
                ZERO
            };
            if !model.users.ripple.is_empty() && k < MAX_DEGREE {
                imposed += self.room.ripple[k + 1] * ((k + 1) as f64 / self.room.motion.unit);
            }
            let mut free = ZERO;
            for j in 0..model.mode_count {
                free += model.tip_value[j] * acceleration[j];
            }
            let force =
                (imposed + give.free_acceleration - free) / (model.mobility + give.mobility);
            (force, force)
        } else if model.has_memory {
            let force = self.memory_force(k, x);
            (force, force)
        } else {
            (capacity, -self.room.motion.sign * capacity)
        };
        self.room.force[k] = force;
        drive
    }

    /// Coefficient of friction in slip, from the speed at which the law is evaluated.
    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    fn next_mu(&mut self, k: usize, x: &State) -> Real {
        let model = self.model;
        let mut argument = self.room.motion.speed[k];
        for i in model.users.lagged_speed.iter() {
            let e = &model.effects[i];
            if let Some(u) = e.effect.lagged_speed(model.states(e, x)) {
                argument = u;
                break;
            }
        }
        if k == 0 {
            self.first_argument = argument;
        }
        self.friction.next(k, argument, &mut self.room.friction)
    }

    /// Coefficient `k` of the capacity in N.
    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    fn next_capacity(&mut self, k: usize, x: &State) -> Real {
        let model = self.model;
        let stuck = self.mode == ContactMode::Stuck;
        let mu = match (stuck, k) {
            (false, _) => self.next_mu(k, x),
            (true, 0) => model.static_coefficient,
            (true, _) => ZERO,
        };
        self.room.mu[k] = mu;
        let before = if k == 0 { ZERO } else { self.room.mu[k - 1] };
        let [force, rate] = self.room.motion.normal_force.map(|n| model.level * n);
        let mut capacity = force * mu + rate * before;
        self.room.partial[0][k] = capacity;
        let mut count = 0;
        let factors = if stuck {
            &model.users.any_factor
        } else {
            &model.users.factor
        };
        for i in factors.iter() {
            let (e, series) = self.part(i);
            let room = &mut *self.room;
            let registers = &mut room.registers[e.first_register..];
            room.factors[count][k] = if e.hooks.factor {
                series.factor(k, &room.motion, model.states(e, x), registers)
            } else {
                series.static_factor(k, &room.motion, registers)
            };
            capacity = product(&room.partial[count], &room.factors[count], k);
            count += 1;
            room.partial[count][k] = capacity;
        }
        self.factor_count = count;
        capacity
    }

    fn memory_force(&mut self, k: usize, x: &State) -> Real {
        let model = self.model;
        let mut force = ZERO;
        for i in model.users.memory_force.iter() {
            let (e, series) = self.part(i);
            let room = &mut *self.room;
            force += series.memory_force(
                k,
                &room.motion,
                &room.partial[self.factor_count],
                model.states(e, x),
                &mut room.registers[e.first_register..],
            );
        }
        force
    }

    /// Normalised time, as far as `degree` tells, up to which a step may go that could go to `theta`: just beyond the first branch of an
    /// effect's expressions that ends. `None` where a factor changes its sign or an expression does not hold at all.
    pub(super) fn until(&self, degree: usize, theta: f64) -> Option<f64> {
        let keeps = |f: &Series| f[0] >= 0.0 && all_or_nothing(f, degree, theta) > 0.0;
        let room = &*self.room;
        let [force, rate] = room.motion.normal_force;
        // Friction laws are continued by constants below v = 0.
        let holds = self.first_argument >= -1e-12
            && force >= 0.0
            && force + rate * theta >= 0.0
            && keeps(&room.mu)
            && room.factors[..self.factor_count].iter().all(keeps);
        if !holds {
            return None;
        }
        let end = (0..self.model.effects.len()).fold(theta, |end, i| {
            let (enabled, series) = self.part(i);
            let registers = &room.registers[enabled.first_register..];
            end.min(series.until(&room.motion, registers, degree, theta))
        });
        if end >= theta {
            return Some(theta);
        }
        (end > 0.0).then(|| (end + BEYOND * theta).min(theta))
    }
}

impl SeriesSystem for FullSeries<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension
    }

    #[cfg_attr(feature = "tangent", inline(always))]
    #[cfg_attr(not(feature = "tangent"), inline)]
    fn extend(&mut self, k: usize, coefficients: &mut [State; MAX_DEGREE + 1]) {
        let model = self.model;
        let (known, next) = coefficients.split_at_mut(k + 1);
        let mut acceleration = [ZERO; MAX_MODES];
        let drive = self.advance(k, known, &mut acceleration);
        let (x, next) = (&known[k], &mut next[0]);
        let step = self.room.motion.unit * RECIPROCAL[k + 1];
        for j in 0..model.mode_count {
            next[2 * j] = step * x[2 * j + 1];
            next[2 * j + 1] = step * self.drive[j] * drive + step * acceleration[j];
        }
        if !model.users.rates.is_empty() {
            self.add_rates(k, x, next, step);
        }
    }
}

impl FullSeries<'_> {
    /// Coefficients of power `k + 1` of the effects' states.
    fn add_rates(&mut self, k: usize, x: &State, next: &mut State, step: f64) {
        let m = &self.room.motion;
        let motion = m.power(k);
        let contact = ContactForce {
            force: self.room.force[k],
            capacity: self.capacity()[k],
            stuck: self.mode == ContactMode::Stuck,
        };
        for i in self.model.users.rates.iter() {
            let (e, series) = self.part(i);
            let range = e.first_state..e.first_state + e.nominals.len();
            let registers = &mut self.room.registers[e.first_register..];
            let rates = &mut next[range.clone()];
            rates.fill(ZERO);
            series.add_rates(k, &motion, &contact, &x[range], registers, rates);
            rates.iter_mut().for_each(|r| *r *= step);
        }
    }
}
