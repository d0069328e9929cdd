//! Reads an effect's file and checks it entry by entry.

use super::{UserCard, UserEffectError, UserEffectParameter};
use crate::table::variables;
use beam_physics::effects::user_expression::{MAX_PARAMETERS, Target};
use beam_physics::effects::{CATALOGUE, Role};
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// Description of an effect whose file has none.
const DESCRIPTION: &str = "An effect that the user has written as a formula.";
/// Source of an effect whose file names none.
const SOURCE: &str = "the user's own";

/// Roles that a user's parameter may have.
const ROLES: [(&str, Role); 4] = [
    ("amplitude", Role::Amplitude),
    ("shape", Role::Shape),
    ("phase", Role::Phase),
    ("setting", Role::Setting),
];

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
            description: file.optional("description", raw.description, DESCRIPTION)?,
            source: file.optional("source", raw.source, SOURCE)?,
            signature: file.optional("signature", raw.signature, "")?,
            confounders: file.optional("confounders", raw.confounders, "")?,
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
        card.check_formula(formula_line)?;
        Ok(card)
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
        default: &str,
    ) -> Result<String, UserEffectError> {
        text.map_or(Ok(default.to_owned()), |text| self.text(key, 2000, text))
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
        let default = format!("{} {name} of the formula", role_name(role));
        Ok(UserEffectParameter {
            description: self.optional("description", raw.description, &default)?,
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
