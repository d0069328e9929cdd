//! Beam + belt + contact + enabled effects: rates, constraint force and static limit at one instant.

#[cfg(not(feature = "tangent"))]
mod bare;
mod contact;
mod energy;
mod kinematics;
mod rates;
pub mod series;

use crate::beam::{Beam, MAX_MODES, clamp_participation};
use crate::belt::Inputs;
use crate::contact::ContactMode;
use crate::effects::series::Hooks;
use crate::effects::{BeltGive, CATALOGUE, Context, Effect};
use crate::error::{PhysicsError, require};
use crate::friction::FrictionLaw;
use crate::friction::series::ExponentialSum;
use crate::integrate::{MAX_STATES, Scales, State};
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

    fn states<'a>(&self, enabled: &Enabled, x: &'a State) -> &'a [Real] {
        &x[enabled.first_state..enabled.first_state + enabled.nominals.len()]
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
}
