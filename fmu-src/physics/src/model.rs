//! Beam + belt + contact + enabled effects: rates, constraint force and static limit at one instant.

#[cfg(not(feature = "tangent"))]
mod bare;
pub mod series;

use crate::beam::{Beam, MAX_MODES, clamp_participation};
use crate::belt::Inputs;
use crate::contact::ContactMode;
use crate::effects::series::Hooks;
use crate::effects::{BeltGive, CATALOGUE, ContactForce, Context, Effect, Motion};
use crate::error::{PhysicsError, require};
use crate::friction::FrictionLaw;
use crate::friction::series::ExponentialSum;
use crate::integrate::{MAX_STATES, Scales, State, row_of};
use crate::parameters::ModelParameters;
use crate::real::{Real, ZERO, is_constant, real, value};
use std::sync::Arc;

/// Rate in 1/s by which steps are measured where the structure is nothing but free masses, which have none of their own:
/// their motion is smooth until friction changes, and the integrators shorten steps as friction asks.
const FREE_RATE: f64 = 100.0;

/// An effect that is on, with the place of its states.
struct Enabled {
    /// Index in the catalogue; users' effects have none.
    card: Option<usize>,
    /// Identifier of a user's effect; empty for those of the catalogue.
    id: String,
    /// Typical magnitude of each of its states.
    nominals: Vec<f64>,
    effect: Box<dyn Effect>,
    first_state: usize,
    /// First of the effect's registers in power series.
    first_register: usize,
    /// What it contributes to power series.
    hooks: Hooks,
    /// States inside the modal block are integrated as modes, not by the effect.
    is_mode: bool,
}

/// The model, ready to be evaluated.
///
/// State: `[q_1, q_1', ..., q_n, q_n', states of the effects]`, of length [`Model::dimension`].
#[derive(Clone)]
pub struct Model {
    beam: Beam,
    stiffness: [Real; MAX_MODES],
    damping: [Real; MAX_MODES],
    tip_value: [Real; MAX_MODES],
    gain: [Real; MAX_MODES],
    mode_count: usize,
    mobility: Real,
    /// States that add to the belt's motion, and what each adds per unit.
    give_rows: Arc<[(usize, BeltGive)]>,
    /// Mobility of the belt in 1/kg.
    give_mobility: Real,
    friction: FrictionLaw,
    /// Slope in s/m of what effects add to the kinetic coefficient of friction.
    friction_slope: Real,
    /// The law again, where slip can be expanded in power series.
    exponential_sum: Option<ExponentialSum>,
    /// Which effects take part in the series, and where.
    users: series::Users,
    /// Series that the effects keep in an expansion.
    registers: usize,
    /// No effect takes part in slip, other than by a mode that it adds.
    plain_slip: bool,
    /// Unit in s of the normalised time of power series.
    series_unit: f64,
    level: Real,
    static_coefficient: Real,
    sensor_offset: Real,
    /// What the clamp's acceleration does to each mode, in the unit of 1/phi.
    clamp_participation: [Real; MAX_MODES],
    /// Mode shapes where the sensor looks; `None` where it looks at the contact.
    sensor_value: Option<[Real; MAX_MODES]>,
    /// Immutable once built, so that copies of a model share them.
    effects: Arc<[Enabled]>,
    dimension: usize,
    has_memory: bool,
    linear_stick: bool,
    constant_limit: bool,
    has_ripple: bool,
    /// Inputs that hold now.
    pub inputs: Inputs,
    /// Constant that makes the belt travel continuous, in m.
    pub travel_offset: Real,
    /// Time in s at which the present stick began.
    pub stick_since: Real,
}

/// Zero for negative values; what is not a number stays so, to be noticed.
fn not_negative(value: Real) -> Real {
    if value < 0.0 { ZERO } else { value }
}

/// What each state adds to the belt's motion per unit, for those that add something, and the belt's mobility in 1/kg.
fn belt_gives(effects: &[Enabled]) -> (Vec<(usize, BeltGive)>, Real) {
    let (mut rows, mut mobility) = (Vec::new(), ZERO);
    for e in effects.iter() {
        let mut x = [ZERO; MAX_STATES];
        let x = &mut x[..e.nominals.len()];
        let rest = e.effect.belt_give(x);
        mobility += rest.mobility;
        for i in 0..x.len() {
            x[i] = real(1.0);
            let row = BeltGive {
                mobility: ZERO,
                ..e.effect.belt_give(x)
            };
            x[i] = ZERO;
            if row != BeltGive::default() {
                rows.push((e.first_state + i, row));
            }
        }
    }
    (rows, mobility)
}

/// Kinematics shared by all evaluations at one instant.
struct Kinematics {
    motion: Motion,
    give: BeltGive,
}

impl Model {
    /// Builds a model; effects whose parameters mean "off" are left out.
    ///
    /// # Errors
    /// Parameters outside the range in which the equations hold.
    pub fn new(parameters: &ModelParameters, inputs: Inputs) -> Result<Self, PhysicsError> {
        parameters.friction.check()?;
        inputs.check()?;
        let level = parameters.friction_level;
        require(
            level >= 0.0,
            "friction.level",
            level,
            "1",
            "zero or positive",
        )?;
        require(
            true,
            "sensor.offset",
            parameters.sensor_offset,
            "m",
            "finite",
        )?;
        for (j, ratio) in parameters.sensor_ratios.iter().enumerate() {
            let name = format!("mode[{}].sensor_ratio", j + 1);
            require(true, &name, *ratio, "1", "finite")?;
        }
        let mut beam = parameters.beam;
        let mut effects = Vec::new();
        for (card, entry) in CATALOGUE.iter().enumerate() {
            let values = parameters.effects.of(card);
            for (parameter, value) in entry.parameters.iter().zip(values) {
                if !value.is_finite() {
                    let name = format!("{}.{}", entry.id, parameter.name);
                    require(false, &name, *value, parameter.unit.symbol, "finite")?;
                }
            }
            let context = Context::new(entry, values, &beam);
            if let Some(effect) = (entry.build)(&context)? {
                let before = beam.modes().len();
                effect.extend_structure(&mut beam)?;
                let is_mode = beam.modes().len() > before;
                effects.push(Enabled {
                    card: Some(card),
                    id: String::new(),
                    nominals: entry.states.iter().map(|s| s.nominal).collect(),
                    effect,
                    first_state: 2 * before,
                    first_register: 0,
                    hooks: Hooks::default(),
                    is_mode,
                });
            }
        }
        for (i, user) in parameters.user_effects.iter().enumerate() {
            let wrong = |problem: &str| PhysicsError::Expression {
                name: user.id.clone(),
                problem: problem.to_owned(),
            };
            if parameters.user_effects[..i].iter().any(|u| u.id == user.id) {
                return Err(wrong("another effect has the same id"));
            }
            effects.push(Enabled {
                card: None,
                id: user.id.clone(),
                nominals: user.nominals(),
                effect: Box::new(user.compile()?),
                first_state: 0,
                first_register: 0,
                hooks: Hooks::default(),
                is_mode: false,
            });
        }
        for enabled in &mut effects {
            enabled.effect.prepare(&beam);
        }
        let mut dimension = 2 * beam.modes().len();
        for enabled in effects.iter_mut().filter(|e| !e.is_mode) {
            enabled.first_state = dimension;
            dimension += enabled.nominals.len();
            if dimension > MAX_STATES {
                return Err(PhysicsError::StateCount {
                    count: dimension,
                    max: MAX_STATES,
                });
            }
        }
        let (give_rows, give_mobility) = belt_gives(&effects);
        let expandable = series::exponential_sum(&parameters.friction, &mut effects);
        let mut model = Self {
            beam,
            stiffness: [ZERO; MAX_MODES],
            damping: [ZERO; MAX_MODES],
            tip_value: [ZERO; MAX_MODES],
            gain: [ZERO; MAX_MODES],
            mode_count: beam.modes().len(),
            mobility: beam.tip_mobility(),
            give_rows: give_rows.into(),
            give_mobility,
            friction: parameters.friction,
            friction_slope: effects.iter().map(|e| e.effect.friction_slope()).sum(),
            users: expandable
                .as_ref()
                .map_or_else(Default::default, |e| e.users),
            registers: expandable.as_ref().map_or(0, |e| e.registers),
            exponential_sum: expandable.map(|e| e.law),
            plain_slip: effects
                .iter()
                .all(|e| e.effect.series().is_some_and(|s| !s.acts_in_slip())),
            series_unit: 0.0,
            level,
            static_coefficient: parameters.friction.static_coefficient(),
            sensor_offset: parameters.sensor_offset,
            clamp_participation: clamp_participation(&beam),
            sensor_value: None,
            has_memory: effects.iter().any(|e| e.effect.replaces_stick()),
            linear_stick: effects.iter().all(|e| e.effect.is_linear_in_stick()),
            constant_limit: effects.iter().all(|e| e.effect.keeps_limit_constant()),
            has_ripple: effects.iter().any(|e| e.effect.has_belt_ripple()),
            effects: effects.into(),
            dimension,
            inputs,
            travel_offset: ZERO,
            stick_since: ZERO,
        };
        for (j, mode) in beam.modes().iter().enumerate() {
            let w = mode.angular_frequency();
            model.stiffness[j] = w * w;
            model.damping[j] = mode.damping();
            model.tip_value[j] = mode.tip_value;
            model.gain[j] = mode.tip_value / mode.mass;
        }
        let ratios = &parameters.sensor_ratios[..model.mode_count];
        if !ratios.iter().all(|ratio| is_constant(*ratio, 1.0)) {
            let value = |j: usize| model.tip_value[j] * parameters.sensor_ratios[j];
            model.sensor_value = Some(std::array::from_fn(value));
        }
        model.series_unit = 1.0 / model.highest_frequency();
        Ok(model)
    }

    /// Number of states.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// The structure with the modes that effects add.
    pub fn beam(&self) -> &Beam {
        &self.beam
    }

    /// Whether a friction law with memory replaces the rigid stick/slip automaton.
    pub fn has_memory(&self) -> bool {
        self.has_memory
    }

    /// Whether stick obeys a linear equation with constant coefficients under the present inputs.
    pub fn is_linear_in_stick(&self) -> bool {
        let i = &self.inputs;
        let steady = i.normal_force_rate == 0.0 && i.external_force_rate == 0.0;
        let stands = i.clamp_acceleration_rate == 0.0;
        self.linear_stick && stands && (steady || self.effects.is_empty())
    }

    /// Whether the static limit is constant during stick under the present inputs.
    pub fn keeps_limit_constant(&self) -> bool {
        self.constant_limit && self.inputs.normal_force_rate == 0.0
    }

    /// First state and number of states of the effect with index `card`, if it is on.
    pub fn effect_states(&self, card: usize) -> Option<(usize, usize)> {
        self.effects
            .iter()
            .find(|e| e.card == Some(card))
            .map(|e| (e.first_state, e.nominals.len()))
    }

    /// First state and number of states of the user's effect `id`, if it is on.
    pub fn user_states(&self, id: &str) -> Option<(usize, usize)> {
        self.effects
            .iter()
            .find(|e| e.card.is_none() && e.id == id)
            .map(|e| (e.first_state, e.nominals.len()))
    }

    /// Tip displacement w in m and velocity w' in m/s.
    #[inline]
    pub fn tip(&self, x: &State) -> (Real, Real) {
        let (mut w, mut v) = (ZERO, ZERO);
        for j in 0..self.mode_count {
            w += self.tip_value[j] * x[2 * j];
            v += self.tip_value[j] * x[2 * j + 1];
        }
        (w, v)
    }

    /// Displacement in m and velocity in m/s where the sensor looks, from the state and what [`Self::tip`] is in it.
    #[inline]
    pub fn sensor(&self, x: &State, tip: (Real, Real)) -> (Real, Real) {
        let Some(value) = &self.sensor_value else {
            return tip;
        };
        let (mut w, mut v) = (ZERO, ZERO);
        for j in 0..self.mode_count {
            w += value[j] * x[2 * j];
            v += value[j] * x[2 * j + 1];
        }
        (w, v)
    }

    /// Mode shapes where the sensor looks.
    pub fn sensor_values(&self) -> [Real; MAX_MODES] {
        self.sensor_value.unwrap_or(self.tip_value)
    }

    fn states<'a>(&self, enabled: &Enabled, x: &'a State) -> &'a [Real] {
        &x[enabled.first_state..enabled.first_state + enabled.nominals.len()]
    }

    /// What drives that give way add to the belt's motion; linear in their states.
    #[inline]
    pub(crate) fn belt_give(&self, x: &State) -> BeltGive {
        let mut give = BeltGive {
            mobility: self.give_mobility,
            ..BeltGive::default()
        };
        for &(state, row) in self.give_rows.iter() {
            give.add(row.times(x[state]));
        }
        give
    }

    /// Velocity in m/s that effects impose on the belt.
    #[inline]
    pub fn belt_ripple(&self, t: Real) -> Real {
        if !self.has_ripple {
            return ZERO;
        }
        let ripple = |e: &Enabled| e.effect.belt_ripple(t, &self.inputs);
        self.effects.iter().map(ripple).sum()
    }

    /// Whether effects impose a velocity on the belt that varies in time.
    pub fn has_belt_ripple(&self) -> bool {
        self.has_ripple
    }

    /// Its rate in m/s^2, by central differences of fourth order (error below 1e-9 of its amplitude up
    /// to 200 Hz).
    fn belt_ripple_rate(&self, t: Real) -> Real {
        const H: f64 = 1e-5;
        if !self.has_ripple {
            return ZERO;
        }
        let slope = |h: f64| (self.belt_ripple(t + h) - self.belt_ripple(t - h)) / (2.0 * h);
        (4.0 * slope(H) - slope(2.0 * H)) / 3.0
    }

    /// The first effect that can't be evaluated at this instant.
    pub fn fault(&self, t: Real, x: &State, mode: ContactMode) -> Option<PhysicsError> {
        if self.effects.is_empty() {
            return None;
        }
        let m = self.motion(t, x, mode);
        self.effects
            .iter()
            .find_map(|e| e.effect.fault(&m, self.states(e, x)))
    }

    #[inline]
    fn kinematics(&self, t: Real, x: &State, mode: ContactMode) -> Kinematics {
        let (displacement, velocity) = self.tip(x);
        let (sensor_displacement, sensor_velocity) = self.sensor(x, (displacement, velocity));
        let give = self.belt_give(x);
        let given_belt_velocity = self.inputs.belt_velocity_at(t);
        let belt_velocity = given_belt_velocity + self.belt_ripple(t) + give.velocity;
        let stuck = mode == ContactMode::Stuck;
        let relative_velocity = if stuck {
            ZERO
        } else {
            velocity - belt_velocity
        };
        Kinematics {
            motion: Motion {
                time: t,
                displacement,
                velocity,
                sensor_displacement,
                sensor_velocity,
                given_belt_velocity,
                belt_velocity,
                relative_velocity,
                speed: relative_velocity * mode.sign(),
                normal_force: self.inputs.normal_force_at(t),
                travel: self.travel_offset + self.inputs.belt_distance_at(t) + give.displacement
                    - displacement,
                dwell: if stuck { t - self.stick_since } else { ZERO },
            },
            give,
        }
    }

    /// The motion at one instant.
    pub fn motion(&self, t: Real, x: &State, mode: ContactMode) -> Motion {
        self.kinematics(t, x, mode).motion
    }

    /// Normal force after all effects, in N; contact can't pull.
    fn effective_normal_force(&self, m: &Motion, x: &State) -> Real {
        let mut force = m.normal_force;
        for e in self.effects.iter() {
            force *= e.effect.normal_factor(m, self.states(e, x));
        }
        not_negative(force)
    }

    fn friction_factor(&self, m: &Motion, x: &State) -> Real {
        let mut factor = self.level;
        for e in self.effects.iter() {
            factor *= e.effect.friction_factor(m, self.states(e, x));
        }
        not_negative(factor)
    }

    /// Friction capacity mu(|v_r|) F_N in N while sliding.
    fn capacity(&self, m: &Motion, x: &State) -> Real {
        let speed = self
            .effects
            .iter()
            .find_map(|e| e.effect.lagged_speed(self.states(e, x)))
            .unwrap_or(m.speed);
        let coefficient = self.friction.coefficient(speed) + self.friction_slope * speed;
        not_negative(coefficient) * self.friction_factor(m, x) * self.effective_normal_force(m, x)
    }

    /// Whether the constraint force follows from the state alone during stick under the present inputs.
    pub fn keeps_force_steady(&self) -> bool {
        self.inputs.external_force_rate == 0.0 && self.inputs.clamp_acceleration_rate == 0.0
    }

    /// Largest friction force in N that stick can carry.
    pub fn static_limit(&self, t: Real, x: &State) -> Real {
        if self.effects.is_empty() {
            return self.static_coefficient * self.level * self.inputs.normal_force_at(t);
        }
        let m = self.kinematics(t, x, ContactMode::Stuck).motion;
        let mut factor = self.friction_factor(&m, x);
        for e in self.effects.iter() {
            factor *= e.effect.static_factor(&m);
        }
        self.static_coefficient * factor * self.effective_normal_force(&m, x)
    }

    /// Modal accelerations without the friction force, external force and clamp included; returns the tip's acceleration under them.
    #[inline]
    fn free_acceleration(
        &self,
        m: &Motion,
        x: &State,
        acceleration: &mut [Real; MAX_MODES],
    ) -> Real {
        let mut force = self.inputs.external_force_at(m.time);
        for e in self.effects.iter() {
            force += e.effect.tip_force(m, self.states(e, x));
        }
        let clamp = self.inputs.clamp_acceleration_at(m.time);
        for j in 0..self.mode_count {
            acceleration[j] = self.gain[j] * force
                - self.damping[j] * x[2 * j + 1]
                - self.stiffness[j] * x[2 * j]
                - self.clamp_participation[j] * clamp;
        }
        if !self.effects.is_empty() {
            for e in self.effects.iter() {
                e.effect.add_modal_acceleration(
                    m,
                    self.states(e, x),
                    &x[..2 * self.mode_count],
                    &mut acceleration[..self.mode_count],
                );
            }
        }
        (0..self.mode_count)
            .map(|j| self.tip_value[j] * acceleration[j])
            .sum()
    }

    /// Force that keeps v_r = 0, from `w'' = v_belt'`:
    /// `F_c = (v0' + x''_free - w''_free) / (sum phi_j^2/m_j + belt mobility)` in N.
    #[inline]
    fn constraint_force_from(&self, t: Real, free: Real, give: &BeltGive) -> Real {
        let imposed = self.inputs.belt_acceleration + self.belt_ripple_rate(t);
        (imposed + give.free_acceleration - free) / (self.mobility + give.mobility)
    }

    /// Constraint force F_c in N that would keep the contact sticking.
    pub fn constraint_force(&self, t: Real, x: &State) -> Real {
        let k = self.kinematics(t, x, ContactMode::Stuck);
        let free = self.free_acceleration(&k.motion, x, &mut [ZERO; MAX_MODES]);
        self.constraint_force_from(k.motion.time, free, &k.give)
    }

    fn contact_from(
        &self,
        k: &Kinematics,
        free: Real,
        x: &State,
        mode: ContactMode,
    ) -> ContactForce {
        if mode == ContactMode::Stuck {
            return ContactForce {
                force: self.constraint_force_from(k.motion.time, free, &k.give),
                capacity: ZERO,
                stuck: true,
            };
        }
        let capacity = self.capacity(&k.motion, x);
        let force = if self.has_memory {
            self.effects
                .iter()
                .map(|e| {
                    e.effect
                        .memory_force(&k.motion, capacity, self.states(e, x))
                })
                .sum()
        } else {
            -mode.sign() * capacity
        };
        ContactForce {
            force,
            capacity,
            stuck: false,
        }
    }

    /// Whether v_r is zero to rounding.
    pub fn is_at_rest(&self, t: Real, x: &State) -> bool {
        let (_, velocity) = self.tip(x);
        let belt = self.inputs.belt_velocity_at(t);
        self.relative_velocity(t, x).abs() <= 1e-12 * (belt.abs() + velocity.abs() + 1e-6)
    }

    /// Stick or the slip that starts from v_r = 0: stick while |F_c| is within its limit.
    pub fn mode_at_rest(&self, t: Real, x: &State) -> ContactMode {
        let force = self.constraint_force(t, x);
        if force.abs() <= self.static_limit(t, x) {
            ContactMode::Stuck
        } else {
            ContactMode::slip_towards(-force)
        }
    }

    /// Rates of all states in a mode. In slip, `mode` fixes the sign of friction even where the
    /// integrator looks slightly beyond v_r = 0.
    #[inline]
    pub fn rates(&self, t: Real, x: &State, mode: ContactMode, rates: &mut State) {
        if self.effects.is_empty() {
            self.base_rates(t, x, mode, rates);
        } else {
            self.evaluate(t, x, mode, rates);
        }
    }

    /// Rates of the reference model alone: the same operations as in `evaluate`, without the hooks.
    #[inline]
    fn base_rates(&self, t: Real, x: &State, mode: ContactMode, rates: &mut State) {
        let (mut velocity, mut free) = (ZERO, ZERO);
        let mut acceleration = [ZERO; MAX_MODES];
        let clamp = self.inputs.clamp_acceleration_at(t);
        for j in 0..self.mode_count {
            velocity += self.tip_value[j] * x[2 * j + 1];
            acceleration[j] = -self.damping[j] * x[2 * j + 1]
                - self.stiffness[j] * x[2 * j]
                - self.clamp_participation[j] * clamp;
            free += self.tip_value[j] * acceleration[j];
        }
        // In stick the belt alone says how the tip moves: friction takes up whatever pushes besides.
        let force = if mode == ContactMode::Stuck {
            (self.inputs.belt_acceleration - free) / self.mobility
        } else {
            let sign = mode.sign();
            let speed = sign * (velocity - self.inputs.belt_velocity_at(t));
            let normal = self.inputs.normal_force_at(t);
            let friction = -sign * self.friction.coefficient(speed) * self.level * normal;
            friction + self.inputs.external_force_at(t)
        };
        for j in 0..self.mode_count {
            rates[2 * j] = x[2 * j + 1];
            rates[2 * j + 1] = acceleration[j] + self.gain[j] * force;
        }
    }

    /// Rates, and the friction force on the tip in N.
    pub fn evaluate(
        &self,
        t: Real,
        x: &State,
        mode: ContactMode,
        rates: &mut State,
    ) -> ContactForce {
        let k = self.kinematics(t, x, mode);
        let mut acceleration = [ZERO; MAX_MODES];
        let free = self.free_acceleration(&k.motion, x, &mut acceleration);
        let contact = self.contact_from(&k, free, x, mode);
        for j in 0..self.mode_count {
            rates[2 * j] = x[2 * j + 1];
            rates[2 * j + 1] = acceleration[j] + self.gain[j] * contact.force;
        }
        for e in self.effects.iter().filter(|e| !e.is_mode) {
            let range = e.first_state..e.first_state + e.nominals.len();
            rates[range.clone()].fill(ZERO);
            e.effect
                .add_rates(&k.motion, &contact, &x[range.clone()], &mut rates[range]);
        }
        contact
    }

    /// Removes the relative velocity so that the contact can stick: each mode takes its share
    /// `(phi_j/m_j) / sum(phi^2/m)`, as an impulse at the tip would do.
    pub fn project_on_stick(&self, t: Real, x: &mut State) {
        self.push(-self.relative_velocity(t, x), x);
    }

    /// Changes the tip's velocity by `change` in m/s as an impulse at the tip would do: each mode takes
    /// its share `(phi_j/m_j) / sum(phi^2/m)`.
    pub fn push(&self, change: Real, x: &mut State) {
        for j in 0..self.mode_count {
            x[2 * j + 1] += change * self.gain[j] / self.mobility;
        }
    }

    /// Jumps of the effects' states at the arrival in stick.
    pub fn on_stick(&self, x: &mut State) {
        for e in self.effects.iter() {
            e.effect
                .on_stick(&mut x[e.first_state..e.first_state + e.nominals.len()]);
        }
    }

    /// Jumps of the effects' states at break-away.
    pub fn on_break_away(&self, x: &mut State) {
        for e in self.effects.iter() {
            e.effect
                .on_break_away(&mut x[e.first_state..e.first_state + e.nominals.len()]);
        }
    }

    /// Adds to the effects' states the values that are in equilibrium with the start motion.
    pub fn settle(&self, t: Real, x: &mut State, mode: ContactMode) {
        let k = self.kinematics(t, x, mode);
        let free = self.free_acceleration(&k.motion, x, &mut [ZERO; MAX_MODES]);
        let contact = if self.has_memory {
            // The bristle's own force is what is sought: take the constraint force within capacity.
            let capacity = self.capacity(&k.motion, x);
            let force = self.constraint_force_from(t, free, &k.give);
            // What is no number is passed on and ends the motion; `clamp` would panic.
            let force = if capacity.is_nan() {
                capacity
            } else {
                force.max(-capacity).min(capacity)
            };
            let sliding =
                k.motion.relative_velocity.abs() > 0.01 * (k.motion.belt_velocity.abs() + 1e-6);
            let force = if sliding {
                -mode.sign() * capacity
            } else {
                force
            };
            ContactForce {
                force,
                capacity,
                stuck: false,
            }
        } else {
            self.contact_from(&k, free, x, mode)
        };
        for e in self.effects.iter() {
            let range = e.first_state..e.first_state + e.nominals.len();
            e.effect.settle(&k.motion, &contact, &mut x[range]);
        }
    }

    /// Displacement in m as the sensor gives it.
    pub fn measured_displacement(&self, t: Real, x: &State, mode: ContactMode) -> Real {
        let (mut reading, _) = self.sensor(x, self.tip(x));
        if !self.effects.is_empty() {
            let m = self.motion(t, x, mode);
            for e in self.effects.iter() {
                let own = self.states(e, x);
                reading = e.effect.measured_displacement(reading, &m, own);
            }
        }
        reading + self.sensor_offset
    }

    /// The same as `offset + row x`; `None` where a sensor is not linear.
    pub fn measured_row(&self) -> Option<(State, Real)> {
        let linear = self.effects.iter().all(|e| e.effect.measures_linearly());
        linear.then(|| {
            row_of(self.dimension, |x| {
                self.measured_displacement(ZERO, x, ContactMode::Backward)
            })
        })
    }

    /// Relative velocity v_r in m/s from the state alone.
    #[inline]
    pub fn relative_velocity(&self, t: Real, x: &State) -> Real {
        let (_, velocity) = self.tip(x);
        let give = self.belt_give(x).velocity;
        velocity - self.inputs.belt_velocity_at(t) - self.belt_ripple(t) - give
    }

    /// Relative acceleration v_r' in m/s^2 from the rates alone.
    #[inline]
    pub fn relative_acceleration(&self, t: Real, rates: &State) -> Real {
        // v_r is linear in the state, so its slope is the same functional of the rates.
        self.relative_velocity(t, rates) + self.inputs.belt_velocity_at(t) + self.belt_ripple(t)
            - self.inputs.belt_acceleration
            - self.belt_ripple_rate(t)
    }

    /// Magnitudes below which errors of the states do not matter, for the integrator's error norm.
    pub fn state_scales(&self) -> Scales {
        let mut scales = [1e-9; MAX_STATES];
        let force = (self.static_coefficient * self.level * self.inputs.normal_force).max(1e-3);
        for j in 0..self.mode_count {
            let mut stiffness = value(self.stiffness[j]);
            if stiffness == 0.0 {
                // A free mass has no deflection: what it covers while the fastest motion goes by.
                stiffness = self.highest_frequency().powi(2);
            }
            let deflection = (value(self.gain[j]) * value(force) / stiffness).abs();
            let deflection = deflection.max(1e-12);
            scales[2 * j] = deflection;
            scales[2 * j + 1] = deflection * stiffness.sqrt();
        }
        for e in self.effects.iter().filter(|e| !e.is_mode) {
            for (i, nominal) in e.nominals.iter().enumerate() {
                scales[e.first_state + i] = nominal * 1e-2;
            }
        }
        scales
    }

    /// Highest natural angular frequency in rad/s, or rate in 1/s of an effect where that is higher, [`FREE_RATE`] where nothing has
    /// any; or the highest rate at which a mode is damped.
    pub fn highest_frequency(&self) -> f64 {
        let highest = self.stiffness[..self.mode_count]
            .iter()
            .fold(0.0, |a: f64, k| a.max(value(*k)));
        let highest = self
            .effects
            .iter()
            .fold(highest.sqrt(), |a, e| a.max(e.effect.fastest_rate()));
        let highest = if highest > 0.0 { highest } else { FREE_RATE };
        let damping = self.damping[..self.mode_count].iter();
        damping.fold(highest, |a, d| a.max(value(*d)))
    }

    /// Whether every mode has a spring: a structure that carries a static force, as parameter studies need.
    ///
    /// # Errors
    /// [`PhysicsError::OutOfRange`] with the first mode that slides freely.
    pub fn require_springs(&self) -> Result<(), PhysicsError> {
        for (j, mode) in self.beam.modes().iter().enumerate() {
            require(
                mode.frequency > 0.0,
                &format!("mode[{}].frequency", j + 1),
                mode.frequency,
                "Hz",
                "positive in a parameter study, which counts from the static deflection (simulate runs free masses)",
            )?;
        }
        Ok(())
    }

    /// Stored energy of the structure in J: `sum m_j (q_j'^2 + w_j^2 q_j^2) / 2`.
    pub fn stored_energy(&self, x: &State) -> Real {
        self.beam
            .modes()
            .iter()
            .enumerate()
            .map(|(j, m)| {
                0.5 * m.mass * (x[2 * j + 1].powi(2) + self.stiffness[j] * x[2 * j].powi(2))
            })
            .sum()
    }

    /// Power in W that comes in beside friction: `F_ext w' - a sum m_j g_j q_j'`, of the external force and of the inertia that the
    /// clamp's acceleration a stands for.
    pub fn external_power(&self, t: Real, x: &State, tip_velocity: Real) -> Real {
        let modes = self.beam.modes().iter().enumerate();
        let momentum: Real = modes
            .map(|(j, m)| m.mass * self.clamp_participation[j] * x[2 * j + 1])
            .sum();
        self.inputs.external_force_at(t) * tip_velocity
            - self.inputs.clamp_acceleration_at(t) * momentum
    }

    /// Power in W that structural damping takes: `sum (2 D_j w_j + d_j) m_j q_j'^2`.
    pub fn structural_dissipation(&self, x: &State) -> Real {
        self.beam
            .modes()
            .iter()
            .enumerate()
            .map(|(j, m)| self.damping[j] * m.mass * x[2 * j + 1].powi(2))
            .sum()
    }
}
