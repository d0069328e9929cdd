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

use crate::table::variables;
use beam_physics::belt::Inputs;
use beam_physics::effects::user_expression::{
    Compiled, MAX_PARAMETERS, Target, UserEffect, UserParameter,
};
use beam_physics::effects::{CATALOGUE, Effect, Motion, Role};
use beam_physics::error::PhysicsError;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// Roles that a user's parameter may have.
const ROLES: [(&str, Role); 4] = [
    ("amplitude", Role::Amplitude),
    ("shape", Role::Shape),
    ("phase", Role::Phase),
    ("setting", Role::Setting),
];

/// What is wrong with a user's effect.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum UserEffectError {
    /// Not TOML, an unknown or missing key, or a value of the wrong type.
    #[error("{problem}")]
    File {
        /// Line, counted from 1.
        line: usize,
        /// What is wrong.
        problem: String,
    },
    /// An id that can't be used.
    #[error("id = '{id}' can't be used: {problem}; choose another")]
    Id {
        /// Line, counted from 1.
        line: usize,
        /// The id.
        id: String,
        /// Why not.
        problem: &'static str,
    },
    /// A text that is not one of a list.
    #[error("{key} = '{found}' is unknown; write {known}")]
    Choice {
        /// Line, counted from 1.
        line: usize,
        /// The key.
        key: &'static str,
        /// The text found.
        found: String,
        /// What is known.
        known: String,
    },
    /// A text that is empty, too long or has characters that can't be shown.
    #[error(
        "{key} is empty, longer than {most} characters or has control characters; shorten or correct it"
    )]
    Text {
        /// Line, counted from 1.
        line: usize,
        /// The key.
        key: &'static str,
        /// Most characters.
        most: usize,
    },
    /// A number of a parameter that can't be.
    #[error("parameter '{name}': {key} = {value} {unit} is not possible; it must be {required}")]
    Value {
        /// Line, counted from 1.
        line: usize,
        /// Name of the parameter.
        name: String,
        /// The key.
        key: &'static str,
        /// The value.
        value: f64,
        /// Unit of the parameter.
        unit: String,
        /// The condition in words.
        required: &'static str,
    },
    /// Too many parameters.
    #[error("{count} parameters; at most {max} are possible, write constants as numbers")]
    Parameters {
        /// Line of the first one too many, counted from 1.
        line: usize,
        /// Number of parameters.
        count: usize,
        /// The largest number.
        max: usize,
    },
    /// No parameter switches the effect on.
    #[error(
        "no [[parameter]] has role = \"amplitude\"; one must, since the effect is off where all amplitudes are 0"
    )]
    NoAmplitude {
        /// Line of the formula, counted from 1.
        line: usize,
    },
    /// The formula or its names can't be used.
    #[error("{problem}; correct the expression or the parameters")]
    Expression {
        /// Line of the formula, counted from 1.
        line: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// The formula does something although the effect is off.
    #[error(
        "with all amplitudes 0 the expression gives {value} instead of {neutral}, so the effect would never be off; \
         multiply by an amplitude what acts, for example {example}"
    )]
    NeverOff {
        /// Line of the formula, counted from 1.
        line: usize,
        /// Value of the formula.
        value: f64,
        /// Value that means no effect.
        neutral: f64,
        /// A formula that can be off.
        example: &'static str,
    },
    /// Two effects with the same id.
    #[error("two effects have the id '{id}'; rename one")]
    Twice {
        /// The id.
        id: String,
    },
    /// Too many effects.
    #[error("{count} effects of one's own; at most {max} are possible in one FMU")]
    TooMany {
        /// Number of effects.
        count: usize,
        /// The largest number.
        max: usize,
    },
}

impl UserEffectError {
    /// Line of the file, counted from 1, where one is to blame.
    pub fn line(&self) -> Option<usize> {
        match self {
            Self::File { line, .. }
            | Self::Id { line, .. }
            | Self::Choice { line, .. }
            | Self::Text { line, .. }
            | Self::Value { line, .. }
            | Self::Parameters { line, .. }
            | Self::NoAmplitude { line }
            | Self::Expression { line, .. }
            | Self::NeverOff { line, .. } => Some(*line),
            Self::Twice { .. } | Self::TooMany { .. } => None,
        }
    }
}

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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    id: Spanned<String>,
    title: Spanned<String>,
    target: Spanned<String>,
    expression: Spanned<String>,
    description: Option<Spanned<String>>,
    source: Option<Spanned<String>>,
    signature: Option<Spanned<String>>,
    confounders: Option<Spanned<String>>,
    #[serde(default)]
    parameter: Vec<RawParameter>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawParameter {
    name: Spanned<String>,
    unit: Spanned<String>,
    description: Option<Spanned<String>>,
    min: Spanned<f64>,
    max: Spanned<f64>,
    typical: Spanned<f64>,
    role: Option<Spanned<String>>,
}

impl UserCard {
    /// Reads and checks the text of a file.
    ///
    /// # Errors
    /// What is wrong, where, and what to do.
    pub fn parse(text: &str) -> Result<Self, UserEffectError> {
        let raw: RawFile = toml::from_str(text).map_err(|e| UserEffectError::File {
            line: line_of(text, e.span().unwrap_or(0..0)),
            problem: e.message().replace('\n', "; "),
        })?;
        let file = File { text };
        let formula_line = file.line(&raw.expression);
        let target_line = file.line(&raw.target);
        let target = raw.target.into_inner();
        if let Some(extra) = raw.parameter.get(MAX_PARAMETERS) {
            return Err(UserEffectError::Parameters {
                line: file.line(&extra.name),
                count: raw.parameter.len(),
                max: MAX_PARAMETERS,
            });
        }
        let card = Self {
            id: file.id(raw.id)?,
            title: file.text("title", 80, raw.title)?,
            description: file.optional("description", raw.description)?,
            source: file.optional("source", raw.source)?,
            signature: file.optional("signature", raw.signature)?,
            confounders: file.optional("confounders", raw.confounders)?,
            target: Target::from_name(&target).ok_or_else(|| UserEffectError::Choice {
                line: target_line,
                key: "target",
                found: target,
                known: Target::ALL.map(|t| t.0).join(", "),
            })?,
            expression: file.text("expression", 2000, raw.expression)?,
            parameters: raw
                .parameter
                .into_iter()
                .map(|p| file.parameter(p))
                .collect::<Result<_, _>>()?,
            text: text.to_owned(),
        };
        card.check(formula_line)?;
        Ok(card)
    }

    /// Checks that the formula can be compiled, and that it does nothing where the effect is off.
    fn check(&self, line: usize) -> Result<(), UserEffectError> {
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
        let off: Vec<f64> = self
            .parameters
            .iter()
            .map(UserEffectParameter::start)
            .collect();
        let off = self.with_values(&off).compile().map_err(wrong)?;
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

fn line_of(text: &str, span: Range<usize>) -> usize {
    let before = text.bytes().take(span.start);
    1 + before.filter(|b| *b == b'\n').count()
}

/// The checks; knows the text, so that it can name lines.
struct File<'a> {
    text: &'a str,
}

impl File<'_> {
    fn line<T>(&self, value: &Spanned<T>) -> usize {
        line_of(self.text, value.span())
    }

    fn id(&self, id: Spanned<String>) -> Result<String, UserEffectError> {
        let line = self.line(&id);
        let id = id.into_inner();
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let problem = if CATALOGUE.iter().any(|card| card.id == id) {
            "an effect of the catalogue has it"
        } else if !id.starts_with(|c: char| c.is_ascii_alphabetic())
            || !id.chars().all(plain)
            || id.len() > 60
        {
            "it must be 1 to 60 letters (a-z), digits and '_', beginning with a letter"
        } else if variables()
            .iter()
            .any(|v| v.name.split(['.', '[']).next() == Some(&id))
        {
            "variables of the FMU begin with it"
        } else {
            return Ok(id);
        };
        Err(UserEffectError::Id { line, id, problem })
    }

    /// A text with line breaks and the like made single spaces.
    fn text(
        &self,
        key: &'static str,
        most: usize,
        text: Spanned<String>,
    ) -> Result<String, UserEffectError> {
        let line = self.line(&text);
        let words: Vec<&str> = text.as_ref().split_whitespace().collect();
        let text = words.join(" ");
        let unfit = |c: char| c.is_control() || c == '\u{fffe}' || c == '\u{ffff}';
        if text.is_empty() || text.chars().count() > most || text.contains(unfit) {
            return Err(UserEffectError::Text { line, key, most });
        }
        Ok(text)
    }

    fn optional(
        &self,
        key: &'static str,
        text: Option<Spanned<String>>,
    ) -> Result<String, UserEffectError> {
        text.map_or(Ok(String::new()), |text| self.text(key, 2000, text))
    }

    fn parameter(&self, raw: RawParameter) -> Result<UserEffectParameter, UserEffectError> {
        let role = match raw.role {
            None => Role::Amplitude,
            Some(role) => {
                let known = ROLES.iter().find(|r| r.0 == role.as_ref());
                let unknown = || UserEffectError::Choice {
                    line: self.line(&role),
                    key: "role",
                    found: role.as_ref().clone(),
                    known: ROLES.map(|r| r.0).join(", "),
                };
                known.ok_or_else(unknown)?.1
            }
        };
        let name_line = self.line(&raw.name);
        let name = self.text("name", 60, raw.name)?;
        let unit = self.text("unit", 40, raw.unit)?;
        let (min, max) = (*raw.min.as_ref(), *raw.max.as_ref());
        let typical = *raw.typical.as_ref();
        let value = |key, value: &Spanned<f64>, required| UserEffectError::Value {
            line: self.line(value),
            name: name.clone(),
            key,
            value: *value.as_ref(),
            unit: unit.clone(),
            required,
        };
        if !min.is_finite() {
            return Err(value("min", &raw.min, "finite"));
        }
        if !(max.is_finite() && max > min) {
            return Err(value("max", &raw.max, "finite and greater than min"));
        }
        if !(min <= typical && typical <= max) {
            return Err(value("typical", &raw.typical, "from min to max"));
        }
        if role == Role::Amplitude {
            if typical == 0.0 {
                let required =
                    "different from 0: the strength at which the effect is plainly visible";
                return Err(value("typical", &raw.typical, required));
            }
            if min > 0.0 {
                let required = "0 or less: an amplitude of 0 means off (else give another role)";
                return Err(value("min", &raw.min, required));
            }
            if max < 0.0 {
                let required = "0 or more: an amplitude of 0 means off (else give another role)";
                return Err(value("max", &raw.max, required));
            }
        }
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.chars().all(plain) {
            return Err(UserEffectError::Choice {
                line: name_line,
                key: "name",
                found: name,
                known: "letters (a-z), digits and '_'".into(),
            });
        }
        let description = self.optional("description", raw.description)?;
        Ok(UserEffectParameter {
            description: if description.is_empty() {
                format!("{} {name} of the formula", role_name(role))
            } else {
                description
            },
            name,
            unit,
            typical,
            min,
            max,
            role,
        })
    }
}

fn role_name(role: Role) -> &'static str {
    ROLES.iter().find(|r| r.1 == role).map_or("", |r| r.0)
}
