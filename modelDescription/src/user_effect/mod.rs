//! Effects that users write: one TOML file each, read and checked here for those who pack an FMU and
//! for the FMU that finds it among its resources.
//!
//! ```toml
//! id = "direction"
//! title = "Friction depends on the direction of motion"
//! target = "friction_factor"          # or normal_force_factor, tip_force, belt_velocity
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

mod error;
mod file;

pub use error::UserEffectError;

use beam_physics::belt::Inputs;
use beam_physics::effects::user_expression::{Compiled, Target, UserEffect, UserParameter};
use beam_physics::effects::{Effect, Motion, Role};
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
    /// What the formula acts on.
    pub target: Target,
    /// The formula.
    pub expression: String,
    /// Its parameters.
    pub parameters: Vec<UserEffectParameter>,
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
        let off = self.at_start().compile().map_err(wrong)?;
        let (neutral, example) = match self.target {
            Target::FrictionFactor | Target::NormalForceFactor => (1.0, "1 + a*w"),
            Target::TipForce => (0.0, "a*w"),
            Target::BeltVelocity => (0.0, "a*v0"),
        };
        for motion in probes() {
            let value = value_of(&off, self.target, &motion);
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

    /// The equation in plain text.
    pub fn equation(&self) -> String {
        let formula = &self.expression;
        match self.target {
            Target::FrictionFactor => format!("mu -> mu ({formula})"),
            Target::NormalForceFactor => format!("F_N -> F_N ({formula})"),
            Target::TipForce => format!("F_tip = {formula}"),
            Target::BeltVelocity => format!("v_belt = v0 + {formula}"),
        }
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
            expression: self.expression.clone(),
            parameters: self.parameters.iter().zip(values).map(parameter).collect(),
        }
    }
}

/// Motions as they occur: slip behind and ahead of the belt, and stick.
fn probes() -> [Motion; 3] {
    let slip = Motion {
        time: 0.137,
        displacement: 3.1e-4,
        velocity: 0.021,
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
        relative_velocity: 0.03,
        speed: 0.03,
        travel: -0.0071,
        ..slip
    };
    let stick = Motion {
        velocity: 0.1,
        relative_velocity: 0.0,
        speed: 0.0,
        dwell: 3.1e-3,
        ..slip
    };
    [slip, ahead, stick]
}

fn value_of(effect: &Compiled, target: Target, m: &Motion) -> f64 {
    match target {
        Target::FrictionFactor => effect.friction_factor(m),
        Target::NormalForceFactor => effect.normal_factor(m),
        Target::TipForce => effect.tip_force(m),
        Target::BeltVelocity => {
            let inputs = Inputs::constant(m.given_belt_velocity, m.normal_force);
            effect.belt_ripple(m.time, &inputs)
        }
    }
}
