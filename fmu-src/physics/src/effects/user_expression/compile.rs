//! From the description of a user's effect to what can be evaluated.

use super::compiled::{Compiled, CompiledState};
use super::formula::{Formula, Scope};
use super::quantity::{
    CONSTANT_IN_ALL_STICK, CONSTANT_IN_STICK, COUNT, FIRST_STATE, MAX_USER_STATES, QUANTITIES,
    RATE_QUANTITIES, VARIABLE,
};
use super::{MAX_PARAMETERS, MAX_TABLES, Target, UserEffect, UserState, UserTable};
use crate::beam::MAX_MODES;
use crate::effects::CATALOGUE;
use crate::error::PhysicsError;
use crate::expression::FUNCTIONS;
use crate::expression::spline::Spline;
use crate::real::{Real, ZERO, value};
use std::sync::Arc;

fn is_name(name: &str) -> bool {
    let mut characters = name.chars();
    characters.next().is_some_and(|c| c.is_alphabetic())
        && characters.all(|c| c.is_alphanumeric() || c == '_')
}

impl UserEffect {
    /// Checks names, bounds and formulas, and compiles the effect.
    ///
    /// # Errors
    /// [`PhysicsError::Expression`] naming the effect and what to correct.
    pub fn compile(&self) -> Result<Compiled, PhysicsError> {
        self.compiled().map_err(|problem| PhysicsError::Expression {
            name: self.id.clone(),
            problem,
        })
    }

    fn compiled(&self) -> Result<Compiled, String> {
        self.check_names()?;
        let constants: Arc<[Real]> = self.parameters.iter().map(|p| p.value).collect();
        let splines = self.tables.iter().map(|t| self.spline(t, &constants));
        let splines: Arc<[Spline]> = splines.collect::<Result<_, _>>()?;
        // What a formula may use; what it may not has no name.
        let scope = |quantities: bool, force: bool, states: bool| {
            let mut names = vec![""; VARIABLE];
            if quantities {
                names[..COUNT].copy_from_slice(&QUANTITIES.map(|q| q.0));
            }
            if force {
                names[COUNT..FIRST_STATE].copy_from_slice(&RATE_QUANTITIES.map(|q| q.0));
            }
            if states {
                for (name, state) in names[FIRST_STATE..].iter_mut().zip(&self.states) {
                    *name = &state.name;
                }
            }
            names.extend(self.parameters.iter().map(|p| p.name.as_str()));
            Scope {
                names,
                tables: self.tables.iter().map(|t| t.name.as_str()).collect(),
                constants: Arc::clone(&constants),
                splines: Arc::clone(&splines),
            }
        };
        let formula = Formula::compile(&self.expression, &scope(true, false, true))?;
        let [start, rate, jump] = [
            scope(true, false, false),
            scope(true, true, true),
            scope(false, false, true),
        ];
        let state = |s: &UserState| {
            let within = |key: &str, problem: String| format!("state {}, {key} {problem}", s.name);
            let jump = |key: &str, text: &Option<String>| match text {
                Some(text) => Formula::compile(text, &jump)
                    .map(Some)
                    .map_err(|p| within(key, p)),
                None => Ok(None),
            };
            Ok(CompiledState {
                name: s.name.clone(),
                unit: s.unit.clone(),
                nominal: s.nominal,
                start: Formula::compile(&s.start, &start).map_err(|p| within("start", p))?,
                rate: Formula::compile(&s.rate, &rate).map_err(|p| within("rate", p))?,
                on_stick: jump("on_stick", &s.on_stick)?,
                on_break_away: jump("on_break_away", &s.on_break_away)?,
            })
        };
        let states: Vec<CompiledState> = self
            .states
            .iter()
            .map(state)
            .collect::<Result<_, String>>()?;
        let formulas =
            || std::iter::once(&formula).chain(states.iter().flat_map(CompiledState::formulas));
        self.check_use(
            |i| formulas().any(|f| f.uses(VARIABLE + i)),
            |t| formulas().any(|f| f.uses_table(t)),
        )?;
        let only = |allowed: &[bool; COUNT]| {
            (0..COUNT).all(|i| allowed[i] || !formula.uses(i))
                && (FIRST_STATE..VARIABLE).all(|i| !formula.uses(i))
        };
        let allowed = self.target.may_use();
        if allowed.contains(&false) && !only(&allowed) {
            let what = match self.target {
                Target::BeltVelocity => "a change of belt velocity",
                _ => "an acceleration of the clamp",
            };
            return Err(format!("{what} may depend on t, F_N and v0 only"));
        }
        let has_series = formulas().all(Formula::has_series);
        let (in_stick, in_all_stick) = (only(&CONSTANT_IN_STICK), only(&CONSTANT_IN_ALL_STICK));
        Ok(Compiled {
            id: self.id.clone(),
            target: self.target,
            modes: match self.mode {
                Some(mode) => mode - 1..mode,
                None => 0..MAX_MODES,
            },
            constant_in_stick: in_stick,
            constant_in_all_stick: in_all_stick,
            has_series,
            formula,
            states,
            stiffness: [ZERO; MAX_MODES],
            damping: [ZERO; MAX_MODES],
            participation: [ZERO; MAX_MODES],
        })
    }

    /// Names that can't be used or occur twice, values outside of their bounds, too many of anything.
    fn check_names(&self) -> Result<(), String> {
        if !is_name(&self.id) || CATALOGUE.iter().any(|card| card.id == self.id) {
            return Err(
                "the id must be a name of letters, digits and '_' that no catalogue effect has"
                    .into(),
            );
        }
        for (count, most, what) in [
            (self.parameters.len(), MAX_PARAMETERS, "parameters"),
            (self.states.len(), MAX_USER_STATES, "states"),
            (self.tables.len(), MAX_TABLES, "tables"),
        ] {
            if count > most {
                return Err(format!("more than {most} {what}"));
            }
        }
        let mut names: Vec<&str> = QUANTITIES.iter().map(|q| q.0).collect();
        names.extend(["pi", "table"]);
        names.extend(FUNCTIONS.iter().map(|f| f.0));
        if !self.states.is_empty() {
            names.extend(RATE_QUANTITIES.iter().map(|q| q.0));
        }
        let all = self
            .parameters
            .iter()
            .map(|p| ("parameter", p.name.as_str()))
            .chain(self.states.iter().map(|s| ("state", s.name.as_str())))
            .chain(self.tables.iter().map(|t| ("table", t.name.as_str())));
        for (what, name) in all {
            if names.contains(&name) || !is_name(name) {
                return Err(format!(
                    "'{name}' can't name a {what}: it is taken, or not made of letters, digits and '_'"
                ));
            }
            names.push(name);
        }
        for p in &self.parameters {
            // Negated, so that a value that is not a number is refused too.
            let ordered = p.min <= p.max && p.min.is_finite() && p.max.is_finite();
            if !(ordered && p.min <= p.value && p.value <= p.max) {
                return Err(format!(
                    "parameter {} = {} {} lies outside its bounds {} .. {}",
                    p.name,
                    value(p.value),
                    p.unit,
                    p.min,
                    p.max
                ));
            }
        }
        for s in &self.states {
            if !(s.nominal > 0.0 && s.nominal.is_finite()) {
                return Err(format!(
                    "state {}: nominal = {} {} must be positive",
                    s.name, s.nominal, s.unit
                ));
            }
        }
        match self.mode {
            Some(mode) if mode == 0 || mode > MAX_MODES => {
                Err(format!("mode = {mode} must be from 1 to {MAX_MODES}"))
            }
            _ => Ok(()),
        }
    }

    fn spline(&self, table: &UserTable, values: &[Real]) -> Result<Spline, String> {
        let (name, at) = (&table.name, &table.at);
        if at.len() < 2 {
            return Err(format!(
                "table {name} has {} nodes; at least 2 make a curve",
                at.len()
            ));
        }
        if let Some(i) = (1..at.len()).find(|&i| !(at[i] > at[i - 1])) {
            return Err(format!(
                "table {name}: node {} at {} does not lie behind node {} at {}; let them rise",
                i + 1,
                at[i],
                i,
                at[i - 1]
            ));
        }
        let end = table.first_parameter + at.len();
        let values = values
            .get(table.first_parameter..end)
            .ok_or_else(|| format!("table {name} has more nodes than values"))?;
        Ok(Spline::new(at, values))
    }

    /// Every parameter and every table must occur.
    fn check_use(
        &self,
        uses_parameter: impl Fn(usize) -> bool,
        uses_table: impl Fn(usize) -> bool,
    ) -> Result<(), String> {
        let is_node = |i: usize| {
            let mut tables = self.tables.iter();
            tables.any(|t| (t.first_parameter..t.first_parameter + t.at.len()).contains(&i))
        };
        for (i, p) in self.parameters.iter().enumerate() {
            if !is_node(i) && !uses_parameter(i) {
                return Err(format!("parameter '{}' is not in the formula", p.name));
            }
        }
        for (i, t) in self.tables.iter().enumerate() {
            if !uses_table(i) {
                return Err(format!("table '{}' is not in the formula", t.name));
            }
        }
        Ok(())
    }
}
