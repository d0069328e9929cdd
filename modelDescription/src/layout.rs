//! The variables of one FMU: the fixed table, then the parameters of the users' effects in it.

use crate::table::{rate_in, variables};
use crate::user_effect::{UserCard, UserEffectError};
use crate::variable::{Kind, Quantity, Variable};
use crate::{Causality, Initial, Variability};
use beam_physics::unit::{self, Unit};
use std::collections::HashMap;
use std::sync::{LazyLock, Mutex, PoisonError};

/// Marks a value reference without variable.
const NONE: u16 = u16::MAX;
/// First value reference of users' effects.
pub const FIRST_USER_REFERENCE: u32 = 9000;
/// Value references kept for each of them.
const USER_BLOCK: u32 = 100;
/// Place in the block of the state that some effects have, and of its rate.
const USER_STATE: u32 = 60;
const USER_RATE: u32 = 80;
/// Most users' effects in one FMU.
pub const MAX_USER_EFFECTS: usize = 80;

/// The variables of one FMU, with lookup by value reference and by name.
///
/// Those of the fixed table come first, so an index or a value reference means the same in every FMU.
/// Layouts are made once for each set of effects and kept while the program runs: a master may
/// make thousands of instances of an FMU, and few different FMUs.
#[derive(Debug)]
pub struct Layout {
    variables: Vec<Variable>,
    effects: Vec<UserCard>,
    /// Indices of the continuous states, and of their rates.
    states: Vec<(usize, usize)>,
    /// Indices of the states of each user's effect.
    user_states: Vec<Vec<usize>>,
    by_reference: Vec<u16>,
    by_name: HashMap<String, usize>,
}

impl Layout {
    /// The layout without users' effects.
    pub fn plain() -> &'static Self {
        static PLAIN: LazyLock<Layout> = LazyLock::new(|| Layout::new(Vec::new()));
        &PLAIN
    }

    /// The layout with these users' effects.
    ///
    /// # Errors
    /// Two effects with the same id, or more than [`MAX_USER_EFFECTS`].
    pub fn with(effects: Vec<UserCard>) -> Result<&'static Self, UserEffectError> {
        static MADE: Mutex<Vec<&'static Layout>> = Mutex::new(Vec::new());
        if effects.is_empty() {
            return Ok(Self::plain());
        }
        if effects.len() > MAX_USER_EFFECTS {
            return Err(UserEffectError::TooMany {
                count: effects.len(),
                max: MAX_USER_EFFECTS,
            });
        }
        for (i, effect) in effects.iter().enumerate() {
            if effects[..i].iter().any(|e| e.id == effect.id) {
                return Err(UserEffectError::Twice {
                    id: effect.id.clone(),
                });
            }
        }
        let mut made = MADE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(layout) = made.iter().find(|l| l.effects == effects) {
            return Ok(layout);
        }
        let layout: &'static Self = Box::leak(Box::new(Self::new(effects)));
        made.push(layout);
        Ok(layout)
    }

    fn new(effects: Vec<UserCard>) -> Self {
        let mut all = variables().to_vec();
        for (e, effect) in effects.iter().enumerate() {
            for (i, p) in effect.parameters.iter().enumerate() {
                all.push(Variable {
                    name: format!("{}.{}", effect.id, p.name),
                    reference: FIRST_USER_REFERENCE + USER_BLOCK * e as u32 + i as u32,
                    quantity: Quantity::UserParameter(e, i),
                    kind: Kind::Real(unit_named(&p.unit)),
                    causality: Causality::Parameter,
                    variability: Variability::Tunable,
                    initial: Some(Initial::Exact),
                    start: Some(p.start()),
                    min: None,
                    max: None,
                    nominal: None,
                    description: format!("{}: {}", effect.title, p.description),
                });
            }
        }
        let mut user_states = vec![Vec::new(); effects.len()];
        for (e, effect) in effects.iter().enumerate() {
            let first = FIRST_USER_REFERENCE + USER_BLOCK * e as u32;
            for (i, (name, unit, nominal, description)) in effect.all_states().enumerate() {
                let state = Variable {
                    name: format!("{}.state.{name}", effect.id),
                    reference: first + USER_STATE + i as u32,
                    quantity: Quantity::UserState(e, i),
                    kind: Kind::Real(unit_named(unit)),
                    causality: Causality::Local,
                    variability: Variability::Continuous,
                    initial: Some(Initial::Exact),
                    start: Some(0.0),
                    min: None,
                    max: None,
                    nominal: Some(nominal),
                    description: format!("{}: {description}", effect.title),
                };
                let unit = unit_named(&per_second(unit));
                let of = rate_in(unit, first + USER_RATE + i as u32, &state);
                user_states[e].push(all.len());
                all.extend([state, of]);
            }
        }
        let last = all.iter().map(|v| v.reference).max().unwrap_or(0);
        let mut by_reference = vec![NONE; last as usize + 1];
        for (index, variable) in all.iter().enumerate() {
            by_reference[variable.reference as usize] = index as u16;
        }
        let place = |reference: u32| usize::from(by_reference[reference as usize]);
        let states = all
            .iter()
            .enumerate()
            .filter_map(|(index, v)| match v.quantity {
                Quantity::Rate(state) => Some((place(state), index)),
                _ => None,
            })
            .collect();
        let names = all.iter().enumerate();
        Self {
            states,
            user_states,
            by_name: names.map(|(i, v)| (v.name.clone(), i)).collect(),
            variables: all,
            effects,
            by_reference,
        }
    }

    /// All variables, in the order of the XML.
    #[inline]
    pub fn variables(&self) -> &[Variable] {
        &self.variables
    }

    /// The continuous states in the order of the state vector: indices of state and rate.
    #[inline]
    pub fn states(&self) -> &[(usize, usize)] {
        &self.states
    }

    /// Indices of the states of the user's effect with index `effect`.
    pub fn user_states(&self, effect: usize) -> &[usize] {
        &self.user_states[effect]
    }

    /// Number of parameters of all users' effects; they stand behind the fixed table.
    pub fn user_parameters(&self) -> usize {
        self.effects.iter().map(|e| e.parameters.len()).sum()
    }

    /// The users' effects.
    pub fn effects(&self) -> &[UserCard] {
        &self.effects
    }

    /// Index of the variable with a value reference.
    #[inline]
    pub fn index_of_reference(&self, reference: u32) -> Option<usize> {
        match self.by_reference.get(reference as usize) {
            Some(&index) if index != NONE => Some(index as usize),
            _ => None,
        }
    }

    /// Index of the variable with a name.
    pub fn index_of_name(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }
}

/// Symbol of the unit of rates of what has the unit `symbol`.
fn per_second(symbol: &str) -> String {
    match symbol {
        "1" => "1/s".to_owned(),
        "s" => "1".to_owned(),
        "m/s" => "m/s2".to_owned(),
        "J" => "W".to_owned(),
        simple if !simple.contains('/') => format!("{simple}/s"),
        composed => format!("{composed}.s-1"),
    }
}

/// The unit with this symbol; one that the physics does not know is a label alone.
fn unit_named(symbol: &str) -> Unit {
    let known = unit::ALL.iter().find(|u| u.symbol == symbol);
    known.copied().unwrap_or_else(|| Unit {
        // Kept with the layout, which is kept while the program runs.
        symbol: Box::leak(symbol.to_owned().into_boxed_str()),
        kg: 0,
        m: 0,
        s: 0,
        rad: 0,
    })
}
