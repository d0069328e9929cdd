//! Reads an effect's file and checks it entry by entry.

use super::{UserCard, UserEffectError, UserEffectParameter, UserEffectState};
use crate::table::variables;
use beam_physics::beam::MAX_MODES;
use beam_physics::effects::user_expression::{MAX_PARAMETERS, Target, UserState, UserTable};
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
    family: Option<Spanned<String>>,
    argument: Option<Spanned<String>>,
    mode: Option<Spanned<usize>>,
    #[serde(default)]
    parameter: Vec<RawParameter>,
    #[serde(default)]
    state: Vec<RawState>,
    #[serde(default)]
    table: Vec<RawTable>,
}

/// A formula; a number stands for itself.
#[derive(Deserialize)]
#[serde(untagged)]
enum RawFormula {
    Number(f64),
    Text(String),
}

impl RawFormula {
    fn text(self) -> String {
        match self {
            Self::Number(x) => format!("{x:?}"),
            Self::Text(text) => text,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawState {
    name: Spanned<String>,
    unit: Spanned<String>,
    description: Option<Spanned<String>>,
    nominal: Spanned<f64>,
    start: Option<RawFormula>,
    rate: RawFormula,
    on_stick: Option<RawFormula>,
    on_break_away: Option<RawFormula>,
}

/// One typical value for all nodes, or one for each.
#[derive(Deserialize)]
#[serde(untagged)]
enum RawTypical {
    All(f64),
    Each(Vec<f64>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawTable {
    name: Spanned<String>,
    unit: Spanned<String>,
    description: Option<Spanned<String>>,
    at: Spanned<Vec<f64>>,
    min: Spanned<f64>,
    max: Spanned<f64>,
    typical: Spanned<RawTypical>,
    role: Option<Spanned<String>>,
}

#[derive(Clone, Deserialize)]
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
        let target_choice = Target::from_name(&target).ok_or_else(|| UserEffectError::Choice {
            line: target_line,
            key: "target",
            found: target,
            known: Target::ALL.map(|t| t.0).join(", "),
        })?;
        let mut parameters = raw
            .parameter
            .into_iter()
            .map(|p| file.parameter(p))
            .collect::<Result<Vec<_>, _>>()?;
        let mut tables = Vec::new();
        for table in raw.table {
            let line = file.line(&table.name);
            let (table, nodes) = file.table(table, parameters.len())?;
            tables.push(table);
            parameters.extend(nodes);
            if parameters.len() > MAX_PARAMETERS {
                return Err(UserEffectError::Parameters {
                    line,
                    count: parameters.len(),
                    max: MAX_PARAMETERS,
                });
            }
        }
        let card = Self {
            id: file.id(raw.id)?,
            title: file.text("title", 80, raw.title)?,
            description: file.optional("description", raw.description, DESCRIPTION)?,
            source: file.optional("source", raw.source, SOURCE)?,
            signature: file.optional("signature", raw.signature, "")?,
            confounders: file.optional("confounders", raw.confounders, "")?,
            target: target_choice,
            expression: file.text("expression", 2000, raw.expression)?,
            family: file.optional("family", raw.family, "")?,
            argument: file.optional("argument", raw.argument, "")?,
            mode: file.mode(raw.mode, target_choice)?,
            states: raw
                .state
                .into_iter()
                .map(|s| file.state(s))
                .collect::<Result<_, _>>()?,
            parameters,
            tables,
            text: text.to_owned(),
        };
        card.check_formula(formula_line)?;
        card.check_units(formula_line)?;
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

    /// The mode on which a factor on frequencies or damping acts.
    fn mode(
        &self,
        mode: Option<Spanned<usize>>,
        target: Target,
    ) -> Result<Option<usize>, UserEffectError> {
        let Some(mode) = mode else {
            return Ok(None);
        };
        let has_modes = matches!(target, Target::FrequencyFactor | Target::DampingFactor);
        if !has_modes || !(1..=MAX_MODES).contains(mode.as_ref()) {
            return Err(UserEffectError::Choice {
                line: self.line(&mode),
                key: "mode",
                found: mode.as_ref().to_string(),
                known: format!(
                    "1 to {MAX_MODES} with target = 'frequency_factor' or 'damping_factor', else leave it out"
                ),
            });
        }
        Ok(Some(mode.into_inner()))
    }

    fn state(&self, raw: RawState) -> Result<UserEffectState, UserEffectError> {
        let line = self.line(&raw.nominal);
        let name = self.text("name", 60, raw.name)?;
        let unit = self.text("unit", 40, raw.unit)?;
        let nominal = raw.nominal.into_inner();
        if !(nominal > 0.0 && nominal.is_finite()) {
            return Err(UserEffectError::Value {
                line,
                name,
                key: "nominal",
                value: nominal,
                unit,
                required: "positive: the typical magnitude of the state",
            });
        }
        Ok(UserEffectState {
            description: self.optional("description", raw.description, "state of the formula")?,
            state: UserState {
                name,
                unit,
                nominal,
                start: raw.start.map_or("0".to_owned(), RawFormula::text),
                rate: raw.rate.text(),
                on_stick: raw.on_stick.map(RawFormula::text),
                on_break_away: raw.on_break_away.map(RawFormula::text),
            },
        })
    }

    /// A table, and the parameters that are the values at its nodes.
    fn table(
        &self,
        raw: RawTable,
        first_parameter: usize,
    ) -> Result<(UserTable, Vec<UserEffectParameter>), UserEffectError> {
        let at = raw.at.as_ref();
        let rises = at.windows(2).all(|pair| pair[0] < pair[1]);
        if at.len() < 2 || !rises || !at.iter().all(|a| a.is_finite()) {
            return Err(UserEffectError::Choice {
                line: self.line(&raw.at),
                key: "at",
                found: format!("{at:?}"),
                known: "2 places or more, each behind the one before".into(),
            });
        }
        let typical: Vec<f64> = match raw.typical.as_ref() {
            RawTypical::All(value) => vec![*value; at.len()],
            RawTypical::Each(values) if values.len() == at.len() => values.clone(),
            RawTypical::Each(values) => {
                return Err(UserEffectError::Choice {
                    line: self.line(&raw.typical),
                    key: "typical",
                    found: format!("{values:?}"),
                    known: format!("one number, or {} as at has", at.len()),
                });
            }
        };
        let mut nodes = Vec::new();
        for (i, place) in at.iter().enumerate() {
            let mut node = self.parameter(RawParameter {
                name: raw.name.clone(),
                unit: raw.unit.clone(),
                description: raw.description.clone(),
                min: raw.min.clone(),
                max: raw.max.clone(),
                typical: Spanned::new(raw.typical.span(), typical[i]),
                role: raw.role.clone(),
            })?;
            let of = match raw.description.is_some() {
                true => node.description.as_str(),
                false => "value of the table",
            };
            node.description = format!("{of} at {place:?}");
            node.name = format!("{}_{}", raw.name.as_ref(), i + 1);
            nodes.push(node);
        }
        let table = UserTable {
            name: raw.name.into_inner(),
            at: raw.at.into_inner(),
            first_parameter,
        };
        Ok((table, nodes))
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
