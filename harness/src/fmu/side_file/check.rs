//! What the tables of a side file must be: each name a variable of the FMU that can be what it stands for, and no two names for one.

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;

use super::file::{Raw, RawConstant, RawEffect};
use super::{Belief, Constant, ROLES, SideFile};
use crate::error::Error;
use crate::fmu::description::{Causality, Kind, ModelDescription, Variable};
use crate::fmu::effect_card::{EffectCard, EffectParameter, EffectState, Role};
use crate::measurement::{factor_to_si, line_of};
use crate::wording::nearest;

/// The checks; knows the text, so that it can name lines.
pub(super) struct Check<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub description: &'a ModelDescription,
}

impl Check<'_> {
    fn error(&self, span: Range<usize>, problem: String) -> Error {
        Error::EffectFile {
            path: self.path.to_owned(),
            line: Some(line_of(self.text, span)),
            problem,
        }
    }

    /// The FMU's Real variable that is named.
    fn variable(&self, name: &Spanned<String>) -> Result<&Variable, Error> {
        let found = self.description.find(name.get_ref());
        let real = found.filter(|v| v.kind == Kind::Real);
        real.ok_or_else(|| {
            let what = match found {
                Some(_) => "is no Real".to_owned(),
                None => {
                    let like = self.description.nearest(name.get_ref());
                    format!("does not exist; like it: {}", like.join(", "))
                }
            };
            let problem = format!("variable '{}' of the FMU {what}", name.get_ref());
            self.error(name.span(), problem)
        })
    }

    fn number(&self, span: Range<usize>, what: &str, value: f64) -> Result<f64, Error> {
        match value.is_finite() {
            true => Ok(value),
            false => Err(self.error(span, format!("{what} = {value} is no number"))),
        }
    }

    /// The side file of these tables.
    ///
    /// # Errors
    /// What does not fit the FMU or each other, with its line.
    pub fn side_file(&self, raw: Raw) -> Result<SideFile, Error> {
        let mut own_names = HashMap::new();
        let names = ROLES.map(|(name, _)| name);
        for (role, variable) in &raw.variables {
            let known = ROLES.iter().find(|(name, _)| name == role.get_ref());
            let Some((_, is_set)) = known else {
                let like = nearest(role.get_ref(), names);
                let problem = format!(
                    "'{}' is no name that [variables] knows{}; known are {}",
                    role.get_ref(),
                    like.first()
                        .map_or(String::new(), |l| format!(", '{l}' is")),
                    names.join(", ")
                );
                return Err(self.error(role.span(), problem));
            };
            let own = match is_set {
                true => self.settable(variable)?,
                false => self.variable(variable)?,
            };
            self.in_si(variable.span(), own)?;
            own_names.insert(role.get_ref().clone(), own.name.clone());
        }
        let mut starts = Vec::new();
        for (i, state) in raw.state.iter().enumerate() {
            let start = self.settable(&state.start)?;
            starts.push((start.name.clone(), start.reference));
            let value = self.variable(state.value.as_ref().unwrap_or(&state.start))?;
            self.in_si(state.start.span(), start)?;
            self.in_si(state.start.span(), value)?;
            let name = match i % 2 {
                0 => format!("q[{}]", i / 2 + 1),
                _ => format!("q_dot[{}]", i / 2 + 1),
            };
            own_names.insert(name, value.name.clone());
        }
        let constants = raw.constant.iter().map(|c| self.constant(c));
        let constants = constants.collect::<Result<_, _>>()?;
        self.stand_alone(&raw)?;
        let mut effects: Vec<EffectCard> = Vec::new();
        for effect in raw.effect {
            if effects.iter().any(|e| e.id == *effect.id.get_ref()) {
                let problem = format!("effect '{}' is there twice", effect.id.get_ref());
                return Err(self.error(effect.id.span(), problem));
            }
            effects.push(self.effect(effect, &mut own_names)?);
        }
        let friction_coefficient = match raw.friction_coefficient {
            Some(mu) if !(*mu.get_ref() > 0.0 && mu.get_ref().is_finite()) => {
                let problem = format!(
                    "friction_coefficient = {} is no positive number",
                    mu.get_ref()
                );
                return Err(self.error(mu.span(), problem));
            }
            mu => mu.map(Spanned::into_inner),
        };
        Ok(SideFile {
            path: self.path.to_owned(),
            text: self.text.to_owned(),
            own_names,
            starts,
            friction_coefficient,
            constants,
            effects,
        })
    }

    /// The FMU's Real variable that is named, if a value may be given to it before a start.
    fn settable(&self, name: &Spanned<String>) -> Result<&Variable, Error> {
        let variable = self.variable(name)?;
        let is_calculated = variable.initial.as_deref() == Some("calculated")
            || variable.causality == Causality::CalculatedParameter;
        let is_fixed = variable.variability == "constant" || is_calculated;
        if !is_fixed && (variable.is_settable() || variable.start.is_some()) {
            return Ok(variable);
        }
        let problem = format!(
            "variable '{}' of the FMU has no start value that could be set; name a parameter, an input or a variable with initial = \"exact\"",
            variable.name
        );
        Err(self.error(name.span(), problem))
    }

    /// That a variable whose unit is known is in SI units.
    fn in_si(&self, span: Range<usize>, variable: &Variable) -> Result<(), Error> {
        let unit = variable.unit.as_deref().unwrap_or_default();
        match factor_to_si(unit) {
            Some(factor) if factor != 1.0 => Err(self.error(
                span,
                format!(
                    "variable '{}' of the FMU is in {unit}; only variables in SI units can be named here",
                    variable.name
                ),
            )),
            _ => Ok(()),
        }
    }

    /// That nothing sets a variable twice, and that no name of an effect is that of something else.
    fn stand_alone(&self, raw: &Raw) -> Result<(), Error> {
        let starts = raw.state.iter().map(|s| &s.start);
        let constants = raw.constant.iter().map(|c| &c.variable);
        let of_effects = raw.effect.iter().flat_map(|e| e.parameter.iter());
        let all = starts
            .chain(constants)
            .chain(of_effects.map(|p| &p.variable));
        let mut seen: Vec<&str> = Vec::new();
        for variable in all {
            if seen.contains(&variable.get_ref().as_str()) {
                let problem = format!(
                    "variable '{}' of the FMU is set twice, as state, constant or parameter of an effect",
                    variable.get_ref()
                );
                return Err(self.error(variable.span(), problem));
            }
            seen.push(variable.get_ref());
        }
        for effect in &raw.effect {
            let id = effect.id.get_ref();
            let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '_';
            let constant = raw.constant.iter().find(|c| {
                let rest = c.variable.get_ref().strip_prefix(id.as_str());
                rest.is_some_and(|rest| rest.starts_with('.'))
            });
            let problem = if id.is_empty() || !id.chars().all(is_plain) {
                format!("effect '{id}': an id is made of letters, digits and _")
            } else if id.starts_with("term_") {
                format!("effect '{id}': ids that begin with term_ are those of the library")
            } else if let Some(constant) = constant {
                format!(
                    "effect '{id}' is called as constant '{}' begins; give it another id",
                    constant.variable.get_ref()
                )
            } else {
                continue;
            };
            return Err(self.error(effect.id.span(), problem));
        }
        Ok(())
    }

    fn constant(&self, raw: &RawConstant) -> Result<Constant, Error> {
        let variable = self.settable(&raw.variable)?;
        let span = raw.variable.span();
        let name = &variable.name;
        let value = raw.value.or(variable.start_number()).unwrap_or(f64::NAN);
        let value = self.number(
            span.clone(),
            &format!("the value of constant {name}"),
            value,
        )?;
        let wrong =
            |problem: String| Err(self.error(span.clone(), format!("constant {name} {problem}")));
        let belief = match (raw.std, raw.std_absolute) {
            (Some(std), None) if value > 0.0 => Belief::Relative(std),
            (Some(_), None) => {
                return wrong(format!(
                    "is {value}, of which std can't be a share; give std_absolute in its unit"
                ));
            }
            (None, Some(std)) => Belief::Absolute(std),
            _ => {
                return wrong(
                    "needs either std, as a share, or std_absolute, in its unit: how well it is known"
                        .into(),
                );
            }
        };
        let (Belief::Relative(std) | Belief::Absolute(std)) = belief;
        if !(std > 0.0 && std.is_finite()) {
            return wrong(format!(
                "has a standard deviation of {std}; give a positive number"
            ));
        }
        let (min, max) = (raw.min.or(variable.min), raw.max.or(variable.max));
        if min.is_some_and(|m| !(m <= value)) || max.is_some_and(|m| !(m >= value)) {
            return wrong(format!("is {value}, outside its bounds {min:?} to {max:?}"));
        }
        Ok(Constant {
            variable: name.clone(),
            reference: variable.reference,
            unit: variable.unit.clone().unwrap_or_default(),
            value,
            belief,
            min,
            max,
            per_run: raw.per_run,
        })
    }

    fn effect(
        &self,
        raw: RawEffect,
        own_names: &mut HashMap<String, String>,
    ) -> Result<EffectCard, Error> {
        let id = raw.id.get_ref().clone();
        if raw.parameter.is_empty() {
            let problem = format!("effect '{id}' has no parameter that would switch it on");
            return Err(self.error(raw.id.span(), problem));
        }
        let mut parameters = Vec::new();
        for p in raw.parameter {
            let variable = self.settable(&p.variable)?;
            let name = p.name.unwrap_or_else(|| variable.name.clone());
            let start = variable.start_number().unwrap_or(0.0);
            let wrong = |problem: String| {
                let problem = format!("parameter {name} of effect '{id}' {problem}");
                Err(self.error(p.variable.span(), problem))
            };
            let role = Role::named(p.role.get_ref()).filter(|role| *role != Role::Node);
            let Some(role) = role else {
                return wrong(format!(
                    "has the role '{}'; give amplitude (0 is off), shape, phase or setting",
                    p.role.get_ref()
                ));
            };
            if parameters
                .iter()
                .any(|known: &EffectParameter| known.name == name)
            {
                return wrong("is there twice; give one of them another name".into());
            }
            let in_order = p.min < p.max && (p.min..=p.max).contains(&p.typical);
            if !(in_order && p.min.is_finite() && p.max.is_finite()) {
                return wrong(format!(
                    "has min = {}, typical = {}, max = {}; give finite numbers in this order",
                    p.min, p.typical, p.max
                ));
            }
            if matches!(role, Role::Amplitude | Role::Shape) && p.typical == 0.0 {
                return wrong(
                    "has typical = 0; give a value at which the effect is plainly visible".into(),
                );
            }
            if role == Role::Amplitude && !(p.min <= 0.0 && p.max >= 0.0) {
                return wrong(format!(
                    "lies between {} and {}; 0, which switches the effect off, must be allowed",
                    p.min, p.max
                ));
            }
            own_names.insert(format!("{id}.{name}"), variable.name.clone());
            parameters.push(EffectParameter {
                description: variable.description.clone(),
                reference: variable.reference,
                unit: variable.unit.clone().unwrap_or_default(),
                start,
                typical: p.typical,
                min: p.min,
                max: p.max,
                role,
                name,
            });
        }
        let mut states = Vec::new();
        for s in raw.state {
            let variable = self.settable(&s.variable)?;
            let name = s.name.unwrap_or_else(|| variable.name.clone());
            let wrong = |problem: &str| {
                let problem = format!("state {name} of effect '{id}' {problem}");
                Err(self.error(s.variable.span(), problem))
            };
            if variable.causality == Causality::Parameter {
                return wrong(
                    "is a parameter, which does not show how it moves on; name the variable itself",
                );
            }
            if !(s.nominal > 0.0 && s.nominal.is_finite()) {
                return wrong("needs a positive nominal value, its typical size");
            }
            own_names.insert(format!("{id}.state.{name}"), variable.name.clone());
            states.push(EffectState {
                name,
                reference: variable.reference,
                nominal: s.nominal,
            });
        }
        let phase = parameters.iter().find(|p| p.role == Role::Phase);
        let shape = parameters.iter().find(|p| p.role == Role::Shape);
        let repeats = shape.is_some_and(|p| ["Hz", "m"].contains(&p.unit.as_str()));
        let has_amplitude = parameters.iter().any(|p| p.role == Role::Amplitude);
        if phase.is_some() && !(repeats && has_amplitude) {
            let problem = format!(
                "effect '{id}' has a phase; it needs an amplitude and as its first shape a frequency in Hz or a wavelength in m"
            );
            return Err(self.error(raw.id.span(), problem));
        }
        Ok(EffectCard {
            title: raw.title,
            equation: raw.equation,
            description: raw.description,
            source: raw.source,
            signature: raw.signature,
            confounders: raw.confounders,
            parameters,
            states,
            is_own: false,
            id,
        })
    }
}
