//! A model by the names of the FMU's variables: what a study sets and varies.

use super::Subject;
use crate::beam::{Beam, MAX_MODES, ModalOscillator};
use crate::belt::Inputs;
use crate::effects::user_expression::UserEffect;
use crate::effects::{CATALOGUE, find_parameter};
use crate::error::PhysicsError;
use crate::friction::{Exponential, FrictionLaw, MAX_TABLE, Table};
use crate::integrate::MAX_STATES;
use crate::model::Model;
use crate::parameters::{EffectValues, ModelParameters};
use crate::simulate::{DEFAULT_TOLERANCE, Start, StartContact};

/// Values of the FMU's settable variables, in SI units, by the FMU's names.
///
/// At the start those of the FMU itself; a test holds the two tables against each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Values {
    belt_velocity: f64,
    normal_force: f64,
    external_force: f64,
    clamp_acceleration: f64,
    mode_count: f64,
    modes: [ModalOscillator; MAX_MODES],
    law: f64,
    eq7: Exponential,
    mu_s: f64,
    mu_k: f64,
    stribeck_velocity: f64,
    stribeck_exponent: f64,
    viscous: f64,
    level: f64,
    rows: f64,
    speeds: [f64; MAX_TABLE],
    coefficients: [f64; MAX_TABLE],
    sensor_offset: f64,
    sensor_ratios: [f64; MAX_MODES],
    clamp_shares: [f64; MAX_MODES],
    tolerance: f64,
    contact: f64,
    settle_effects: f64,
    travel: f64,
    dwell: f64,
    q: [f64; MAX_MODES],
    q_dot: [f64; MAX_MODES],
    effects: EffectValues,
    effect_states: Vec<f64>,
    own: Vec<OwnEffect>,
    /// Whether the start state has been given.
    start_is_given: bool,
}

/// An effect that a user wrote, with what switches it on.
#[derive(Debug, Clone, PartialEq)]
struct OwnEffect {
    effect: UserEffect,
    /// For each parameter, whether it is a strength: the effect is off where all of these are 0.
    is_strength: Vec<bool>,
    /// Start values of its states.
    states: Vec<f64>,
}

impl OwnEffect {
    fn is_on(&self) -> bool {
        let mut parameters = self.effect.parameters.iter().zip(&self.is_strength);
        parameters.any(|(p, strength)| *strength && p.value != 0.0)
    }

    fn place(&mut self, name: &str) -> Option<&mut f64> {
        let item = name
            .strip_prefix(self.effect.id.as_str())?
            .strip_prefix('.')?;
        if let Some(state) = item.strip_prefix("state.") {
            let place = self.effect.state_names().position(|name| name == state)?;
            return self.states.get_mut(place);
        }
        let mut parameters = self.effect.parameters.iter_mut();
        parameters.find(|p| p.name == item).map(|p| &mut p.value)
    }
}

impl Default for Values {
    fn default() -> Self {
        let nominal = Beam::default();
        let first = nominal.modes();
        let all = Beam::nominal(MAX_MODES);
        let eq7 = Exponential::default();
        // Dense where eq. (7) falls, rounded as in the FMU's description.
        let share = |row: usize| row as f64 / (MAX_TABLE - 1) as f64;
        let speeds = std::array::from_fn(|row| rounded(0.5 * share(row) * share(row), 1e4));
        let states = CATALOGUE.iter().map(|card| card.states.len()).sum();
        Self {
            belt_velocity: 0.1,
            normal_force: 100.0,
            external_force: 0.0,
            clamp_acceleration: 0.0,
            mode_count: first.len() as f64,
            modes: std::array::from_fn(|j| all.modes()[j]),
            law: 1.0,
            mu_s: eq7.mu_0,
            mu_k: 0.34,
            stribeck_velocity: eq7.v1,
            eq7,
            stribeck_exponent: 1.0,
            viscous: 0.0,
            level: 1.0,
            rows: MAX_TABLE as f64,
            speeds,
            coefficients: speeds.map(|v| rounded(FrictionLaw::default().coefficient(v), 1e6)),
            sensor_offset: 0.0,
            sensor_ratios: [1.0; MAX_MODES],
            clamp_shares: *all.clamp_shares(),
            tolerance: DEFAULT_TOLERANCE,
            contact: 0.0,
            settle_effects: 0.0,
            travel: 0.0,
            dwell: 0.0,
            q: [0.0; MAX_MODES],
            q_dot: [0.0; MAX_MODES],
            effects: EffectValues::default(),
            effect_states: vec![0.0; states],
            own: Vec::new(),
            start_is_given: false,
        }
    }
}

fn rounded(value: f64, parts: f64) -> f64 {
    (value * parts).round() / parts
}

/// `head[3]tail` as (head, 2, tail).
fn indexed(name: &str) -> Option<(&str, usize, &str)> {
    let (head, rest) = name.split_once('[')?;
    let (index, tail) = rest.split_once(']')?;
    let index: usize = index.parse().ok()?;
    Some((head, index.checked_sub(1)?, tail))
}

impl Values {
    /// Where the value of `name` is kept.
    fn place(&mut self, name: &str) -> Option<&mut f64> {
        if let Some((head, i, tail)) = indexed(name) {
            let found = match (head, tail) {
                ("mode", ".frequency") => self.modes.get_mut(i).map(|m| &mut m.frequency),
                ("mode", ".damping_ratio") => self.modes.get_mut(i).map(|m| &mut m.damping_ratio),
                ("mode", ".damping_rate") => self.modes.get_mut(i).map(|m| &mut m.damping_rate),
                ("mode", ".mass") => self.modes.get_mut(i).map(|m| &mut m.mass),
                ("mode", ".tip_value") => self.modes.get_mut(i).map(|m| &mut m.tip_value),
                ("mode", ".sensor_ratio") => self.sensor_ratios.get_mut(i),
                ("mode", ".clamp_share") => self.clamp_shares.get_mut(i),
                ("q", "") => self.q.get_mut(i),
                ("q_dot", "") => self.q_dot.get_mut(i),
                ("friction.table.velocity", "") => self.speeds.get_mut(i),
                ("friction.table.coefficient", "") => self.coefficients.get_mut(i),
                // The nodes of a profile are parameters of an effect.
                _ => self.effect_place(name),
            };
            return found;
        }
        Some(match name {
            "belt_velocity" => &mut self.belt_velocity,
            "normal_force" => &mut self.normal_force,
            "external_force" => &mut self.external_force,
            "clamp_acceleration" => &mut self.clamp_acceleration,
            "mode_count" => &mut self.mode_count,
            "friction.law" => &mut self.law,
            "friction.mu_0" => &mut self.eq7.mu_0,
            "friction.a1" => &mut self.eq7.a1,
            "friction.v1" => &mut self.eq7.v1,
            "friction.a2" => &mut self.eq7.a2,
            "friction.c2" => &mut self.eq7.c2,
            "friction.mu_s" => &mut self.mu_s,
            "friction.mu_k" => &mut self.mu_k,
            "friction.stribeck_velocity" => &mut self.stribeck_velocity,
            "friction.stribeck_exponent" => &mut self.stribeck_exponent,
            "friction.viscous" => &mut self.viscous,
            "friction.level" => &mut self.level,
            "friction.table.count" => &mut self.rows,
            "sensor.offset" => &mut self.sensor_offset,
            "tolerance" => &mut self.tolerance,
            "start.contact" => &mut self.contact,
            "start.effects" => &mut self.settle_effects,
            "belt_travel.start" => &mut self.travel,
            "dwell_time.start" => &mut self.dwell,
            _ => return self.effect_place(name),
        })
    }

    fn effect_place(&mut self, name: &str) -> Option<&mut f64> {
        let mut first = 0;
        for card in CATALOGUE {
            for (i, state) in card.states.iter().enumerate() {
                if name == format!("{}.state.{}", card.id, state.name) {
                    return self.effect_states.get_mut(first + i);
                }
            }
            first += card.states.len();
        }
        let Ok((card, parameter)) = find_parameter(name) else {
            return self.own.iter_mut().find_map(|own| own.place(name));
        };
        let before: usize = CATALOGUE[..card].iter().map(|c| c.parameters.len()).sum();
        self.effects.as_mut_slice().get_mut(before + parameter)
    }

    /// Adds an effect that a user wrote, under the names `<id>.<parameter>`; `is_strength` says for each parameter whether
    /// its 0 means off.
    pub fn offer(&mut self, effect: UserEffect, is_strength: Vec<bool>) {
        self.own.push(OwnEffect {
            states: vec![0.0; effect.nominals().len()],
            effect,
            is_strength,
        });
    }

    /// Sets one value, in the variable's unit.
    ///
    /// # Errors
    /// [`PhysicsError::UnknownParameter`].
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), PhysicsError> {
        let place = self
            .place(name)
            .ok_or_else(|| PhysicsError::UnknownParameter { name: name.into() })?;
        *place = value;
        let of_the_start = name.starts_with("q[") || name.starts_with("q_dot[");
        self.start_is_given |= of_the_start || name == "start.contact";
        Ok(())
    }

    /// The value of a name; `None` for names that are not known.
    pub fn get(&self, name: &str) -> Option<f64> {
        // Looking does not change anything, but the way there is the same as for changing.
        self.clone().place(name).map(|place| *place)
    }

    /// What the values describe.
    ///
    /// # Errors
    /// Parameters outside the range in which the equations hold.
    pub fn subject(&self) -> Result<Subject, PhysicsError> {
        let model = self.model()?;
        model.require_springs()?;
        Ok(Subject {
            given: self.start_is_given.then(|| self.start(&model)),
            tolerance: self.tolerance,
            model,
        })
    }

    /// Coefficient of friction at a sliding speed in m/s, effects left out.
    ///
    /// # Errors
    /// A friction table that can't be used.
    pub fn friction_coefficient(&self, speed: f64) -> Result<f64, PhysicsError> {
        Ok(self.level * self.friction_law()?.coefficient(speed))
    }

    fn friction_law(&self) -> Result<FrictionLaw, PhysicsError> {
        Ok(match self.law as i32 {
            2 => FrictionLaw::StelterAsPrinted(self.eq7),
            3 => FrictionLaw::Coulomb {
                mu_s: self.mu_s,
                mu_k: self.mu_k,
            },
            4 => FrictionLaw::Stribeck {
                mu_s: self.mu_s,
                mu_k: self.mu_k,
                velocity: self.stribeck_velocity,
                exponent: self.stribeck_exponent,
                viscous: self.viscous,
            },
            5 => {
                let rows = (self.rows as usize).min(MAX_TABLE);
                FrictionLaw::Table(Table::new(
                    &self.speeds[..rows],
                    &self.coefficients[..rows],
                )?)
            }
            _ => FrictionLaw::Stelter(self.eq7),
        })
    }

    /// Builds the model.
    ///
    /// # Errors
    /// Parameters outside the range in which the equations hold.
    pub fn model(&self) -> Result<Model, PhysicsError> {
        let count = self.mode_count as usize;
        if count > MAX_MODES {
            return Err(PhysicsError::ModeCount {
                count,
                max: MAX_MODES,
            });
        }
        let on = self.own.iter().filter(|own| own.is_on());
        let parameters = ModelParameters {
            beam: Beam::new(&self.modes[..count])?.with_clamp_shares(self.clamp_shares)?,
            friction: self.friction_law()?,
            friction_level: self.level,
            sensor_offset: self.sensor_offset,
            sensor_ratios: self.sensor_ratios,
            effects: self.effects.clone(),
            user_effects: on.map(|own| own.effect.clone()).collect(),
        };
        let inputs = Inputs {
            external_force: self.external_force,
            clamp_acceleration: self.clamp_acceleration,
            ..Inputs::constant(self.belt_velocity, self.normal_force)
        };
        Model::new(&parameters, inputs)
    }

    /// The start that the values describe, as the FMU takes it.
    fn start(&self, model: &Model) -> Start {
        let mut state = [0.0; MAX_STATES];
        for j in 0..self.mode_count as usize {
            state[2 * j] = self.q[j];
            state[2 * j + 1] = self.q_dot[j];
        }
        let mut before = 0;
        for (card, entry) in CATALOGUE.iter().enumerate() {
            if let Some((first, count)) = model.effect_states(card) {
                state[first..first + count]
                    .copy_from_slice(&self.effect_states[before..before + count]);
            }
            before += entry.states.len();
        }
        for own in &self.own {
            if let Some((first, count)) = model.user_states(&own.effect.id) {
                state[first..first + count].copy_from_slice(&own.states);
            }
        }
        Start {
            time: 0.0,
            state,
            contact: match self.contact as i32 {
                1 => StartContact::Stick,
                2 => StartContact::Slip,
                _ => StartContact::Automatic,
            },
            belt_travel: self.travel,
            dwell: self.dwell,
            settled: self.settle_effects == 1.0,
        }
    }
}
