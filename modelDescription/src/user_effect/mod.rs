//! Effects that users write: one TOML file each, read and checked here for those who pack an FMU and
//! for the FMU that finds it among its resources.
//!
//! ```toml
//! id = "direction"
//! title = "Friction depends on the direction of motion"
//! target = "friction_factor"          # or normal_force_factor, tip_force, belt_velocity, frequency_factor, damping_factor,
//!                                     # measurement, clamp_acceleration
//! expression = "1 + a*tanh(w_dot/v)"
//!
//! [[parameter]]
//! name = "a"
//! unit = "1"
//! min = -0.5
//! max = 0.5
//! typical = 0.1
//!
//! [[parameter]]
//! name = "v"
//! unit = "m/s"
//! min = 0.001
//! max = 0.2
//! typical = 0.02
//! role = "shape"                      # default: "amplitude", whose 0 means off
//! ```
//!
//! An effect may have a memory, states with rates of their own, and curves through nodes whose values are parameters:
//!
//! ```toml
//! expression = "1 - a*T + table(v_abs, g)"
//!
//! [[state]]
//! name = "T"
//! unit = "K"
//! nominal = 10.0                      # typical magnitude, for the integrator's error
//! start = 0.0                         # default; a number or a formula over the motion at the start
//! rate = "h*abs(F*v_r) - T/tau"       # per s; F is the friction force, stick is 1 in stick
//! on_stick = "T"                      # what it becomes at the arrival in stick, and on_break_away; default: it stays
//!
//! [[table]]
//! name = "g"
//! unit = "1"
//! at = [0.0, 0.05, 0.1, 0.2]          # places of the nodes; a natural cubic spline goes through them
//! min = -0.5                          # of the values at the nodes, parameters g_1, g_2, ...
//! max = 0.5
//! typical = 0.05
//! ```

mod dimension;
mod error;
mod file;

use dimension::{Dimension, Named};
pub use error::UserEffectError;

use beam_physics::effects::user_expression::{
    QUANTITIES, RATE_QUANTITIES, TRAVEL, Target, UserEffect, UserParameter, UserState, UserTable,
};
use beam_physics::effects::{ContactForce, Effect, Motion, Role};
use beam_physics::error::PhysicsError;

/// A parameter of a user's effect.
#[derive(Debug, Clone, PartialEq)]
pub struct UserEffectParameter {
    /// Name in the formula.
    pub name: String,
    /// What it is.
    pub description: String,
    /// Symbol of its unit.
    pub unit: String,
    /// A value as met in practice, in `unit` as all values.
    pub typical: f64,
    /// Smallest plausible value.
    pub min: f64,
    /// Largest plausible value.
    pub max: f64,
    /// How it enters.
    pub role: Role,
}

impl UserEffectParameter {
    /// Start value: 0 for strengths and phases, else the typical value.
    pub fn start(&self) -> f64 {
        match self.role {
            Role::Amplitude | Role::Phase | Role::Node => 0.0,
            Role::Shape | Role::Setting => self.typical,
        }
    }
}

/// A state of a user's effect: [`UserState`] with what it is.
#[derive(Debug, Clone, PartialEq)]
pub struct UserEffectState {
    /// Name, unit and formulas.
    pub state: UserState,
    /// What it is.
    pub description: String,
}

/// A user's effect as its file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct UserCard {
    /// Identifier.
    pub id: String,
    /// Title in a few words.
    pub title: String,
    /// What happens physically.
    pub description: String,
    /// Where it comes from.
    pub source: String,
    /// How it shows in a measured tip displacement.
    pub signature: String,
    /// Effects that look alike.
    pub confounders: String,
    /// The kind of physics, for people who look for one.
    pub family: String,
    /// What the formula depends on, as `unknown.argument` of a diagnosis names it.
    pub argument: String,
    /// What the formula acts on.
    pub target: Target,
    /// The mode on which a factor acts, counted from 1; all without.
    pub mode: Option<usize>,
    /// The formula.
    pub expression: String,
    /// Its parameters, then the values at the nodes of its tables.
    pub parameters: Vec<UserEffectParameter>,
    /// Its states.
    pub states: Vec<UserEffectState>,
    /// Its tables.
    pub tables: Vec<UserTable>,
    /// The file, as written.
    pub text: String,
}

impl UserCard {
    /// Checks that the formula can be compiled, and that it does nothing where the effect is off.
    fn check_formula(&self, line: usize) -> Result<(), UserEffectError> {
        let wrong = |error: PhysicsError| UserEffectError::Expression {
            line,
            problem: match error {
                PhysicsError::Expression { problem, .. } => problem,
                other => other.to_string(),
            },
        };
        let typical: Vec<f64> = self.parameters.iter().map(|p| p.typical).collect();
        self.with_values(&typical).compile().map_err(wrong)?;
        if !self.parameters.iter().any(|p| p.role == Role::Amplitude) {
            return Err(UserEffectError::NoAmplitude { line });
        }
        let off_effect = self.at_start();
        let off = off_effect.compile().map_err(wrong)?;
        let example = match self.target {
            Target::TipForce => "a*w",
            Target::BeltVelocity | Target::ClampAcceleration => "a*v0",
            Target::Measurement => "w + a*w^2",
            _ => "1 + a*w",
        };
        for motion in probes() {
            let neutral = self.target.neutral(motion.displacement);
            let mut states = vec![0.0; off_effect.nominals().len()];
            off.settle(&motion, &NO_FORCE, &mut states);
            let value = off.value(&motion, &states);
            // What can't be evaluated here may never occur; the run tells.
            if value.is_finite() && (value - neutral).abs() > 1e-12 {
                return Err(UserEffectError::NeverOff {
                    line,
                    value,
                    neutral,
                    example,
                });
            }
        }
        Ok(())
    }

    /// Checks that the units of all formulas fit together.
    fn check_units(&self, line: usize) -> Result<(), UserEffectError> {
        // `1` is also what people write who don't care: it may stand for any unit, as a number in the formula may.
        let declared = |unit: &str| Dimension::of(unit).filter(|_| !["1", "-"].contains(&unit));
        let of_states = self
            .states
            .iter()
            .map(|s| (s.state.name.as_str(), declared(&s.state.unit)));
        let parameters = self
            .parameters
            .iter()
            .map(|p| (p.name.as_str(), declared(&p.unit)));
        let quantities = QUANTITIES
            .iter()
            .zip(UNITS)
            .map(|(q, u)| (q.0, Dimension::of(u)));
        let in_rates = RATE_QUANTITIES.iter().zip(RATE_UNITS);
        let in_rates = in_rates.map(|(q, u)| (q.0, Dimension::of(u)));
        let names: Vec<Named> = quantities
            .chain(in_rates)
            .chain(of_states)
            .chain(parameters)
            .collect();
        let of_table = |t: &UserTable| self.parameters.get(t.first_parameter);
        let tables: Vec<Named> = self
            .tables
            .iter()
            .map(|t| (t.name.as_str(), of_table(t).and_then(|p| declared(&p.unit))))
            .collect();
        let units = |key: String, formula: &str, wanted: Option<Dimension>| {
            let checked = dimension::check(formula, &names, &tables, wanted);
            checked.map_err(|problem| UserEffectError::Units { line, key, problem })
        };
        let wanted = match self.target {
            Target::TipForce => "N",
            Target::BeltVelocity => "m/s",
            Target::Measurement => "m",
            Target::ClampAcceleration => "m/s2",
            _ => "1",
        };
        units("expression".into(), &self.expression, Dimension::of(wanted))?;
        for UserEffectState { state, .. } in &self.states {
            let of = declared(&state.unit);
            let key = |what: &str| format!("{what} of state '{}'", state.name);
            units(key("rate"), &state.rate, of.map(Dimension::per_second))?;
            units(key("start"), &state.start, of)?;
            for (what, jump) in [
                ("on_stick", &state.on_stick),
                ("on_break_away", &state.on_break_away),
            ] {
                jump.as_ref()
                    .map_or(Ok(()), |jump| units(key(what), jump, of))?;
            }
        }
        Ok(())
    }

    /// The equation in plain text.
    pub fn equation(&self) -> String {
        let formula = &self.expression;
        let mut out = match self.target {
            Target::FrictionFactor => format!("mu -> mu ({formula})"),
            Target::NormalForceFactor => format!("F_N -> F_N ({formula})"),
            Target::TipForce => format!("F_tip = {formula}"),
            Target::BeltVelocity => format!("v_belt = v0 + {formula}"),
            Target::FrequencyFactor => {
                format!("f{} -> f{} ({formula})", self.of_mode(), self.of_mode())
            }
            Target::DampingFactor => {
                format!("D{} -> D{} ({formula})", self.of_mode(), self.of_mode())
            }
            Target::Measurement => format!("w_measured = {formula}"),
            Target::ClampAcceleration => format!("a_clamp = {formula}"),
        };
        for UserEffectState { state, .. } in &self.states {
            out += &format!(",  {}' = {}", state.name, state.rate);
        }
        out
    }

    fn of_mode(&self) -> String {
        self.mode.map_or("_j".to_owned(), |mode| format!("_{mode}"))
    }

    /// Name, unit, typical magnitude and description of all states that it brings along.
    pub(crate) fn all_states(&self) -> impl Iterator<Item = (&str, &str, f64, &str)> {
        let own = self.states.iter().map(|s| {
            let (of, description) = (&s.state, s.description.as_str());
            (of.name.as_str(), of.unit.as_str(), of.nominal, description)
        });
        let travel = (TRAVEL, "m", 1e-3, "distance added to the belt's");
        own.chain((self.target == Target::BeltVelocity).then_some(travel))
    }

    /// The physics' effect with these parameter values, or `None` where they mean "off".
    pub fn effect(&self, values: &[f64]) -> Option<UserEffect> {
        let is_on =
            |(p, value): (&UserEffectParameter, &f64)| p.role == Role::Amplitude && *value != 0.0;
        let on = self.parameters.iter().zip(values).any(is_on);
        on.then(|| self.with_values(values))
    }

    /// The physics' effect with its parameters' start values.
    pub fn at_start(&self) -> UserEffect {
        let starts: Vec<f64> = self
            .parameters
            .iter()
            .map(UserEffectParameter::start)
            .collect();
        self.with_values(&starts)
    }

    /// For each parameter, whether it is a strength: the effect is off where all of these are 0.
    pub fn strengths(&self) -> Vec<bool> {
        let is_strength = |p: &UserEffectParameter| p.role == Role::Amplitude;
        self.parameters.iter().map(is_strength).collect()
    }

    fn with_values(&self, values: &[f64]) -> UserEffect {
        let parameter = |(p, value): (&UserEffectParameter, &f64)| UserParameter {
            name: p.name.clone(),
            unit: p.unit.clone(),
            start: p.start(),
            // As for the catalogue's effects, min and max guide a calibration and bind nobody.
            min: f64::MIN,
            max: f64::MAX,
            value: *value,
        };
        UserEffect {
            id: self.id.clone(),
            target: self.target,
            mode: self.mode,
            expression: self.expression.clone(),
            parameters: self.parameters.iter().zip(values).map(parameter).collect(),
            states: self.states.iter().map(|s| s.state.clone()).collect(),
            tables: self.tables.clone(),
        }
    }
}

/// Units of [`QUANTITIES`], ...
const UNITS: [&str; QUANTITIES.len()] = ["s", "m", "m/s", "m/s", "m/s", "N", "m/s", "m", "s"];
/// ... and of [`RATE_QUANTITIES`].
const RATE_UNITS: [&str; RATE_QUANTITIES.len()] = ["N", "1"];

/// A contact without force, from which states start.
const NO_FORCE: ContactForce = ContactForce {
    force: 0.0,
    capacity: 0.0,
    stuck: false,
};

/// Motions as they occur: slip behind and ahead of the belt, and stick.
fn probes() -> [Motion; 3] {
    let slip = Motion {
        time: 0.137,
        displacement: 3.1e-4,
        velocity: 0.021,
        sensor_displacement: 3.1e-4,
        sensor_velocity: 0.021,
        given_belt_velocity: 0.1,
        belt_velocity: 0.1,
        relative_velocity: -0.079,
        speed: 0.079,
        normal_force: 90.0,
        travel: 0.0123,
        dwell: 0.0,
    };
    let ahead = Motion {
        displacement: -4.3e-4,
        velocity: 0.13,
        sensor_displacement: -4.3e-4,
        sensor_velocity: 0.13,
        relative_velocity: 0.03,
        speed: 0.03,
        travel: -0.0071,
        ..slip
    };
    let stick = Motion {
        velocity: 0.1,
        sensor_velocity: 0.1,
        relative_velocity: 0.0,
        speed: 0.0,
        dwell: 3.1e-3,
        ..slip
    };
    [slip, ahead, stick]
}
