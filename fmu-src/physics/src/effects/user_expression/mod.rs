//! Effects that a user writes as formulas, without compiling anything.

mod compile;
mod compiled;
mod formula;
mod quantity;
mod target;

pub use compiled::Compiled;
pub use quantity::{MAX_USER_STATES, QUANTITIES, RATE_QUANTITIES};
pub use target::Target;

use crate::real::Real;

/// Most parameters of one user effect, the nodes of its tables included.
pub const MAX_PARAMETERS: usize = 48;
/// Most tables of one user effect.
pub const MAX_TABLES: usize = 4;

/// Name of the state that keeps what an effect adds to the belt's travel.
pub const TRAVEL: &str = "travel";

/// A named, bounded number in a user's formula.
#[derive(Debug, Clone, PartialEq)]
pub struct UserParameter {
    /// Name in the formula.
    pub name: String,
    /// Unit, for people.
    pub unit: String,
    /// Value that makes the effect neutral, from which a calibration starts.
    pub start: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Value in use.
    pub value: Real,
}

/// A state of a user's effect, e.g. a temperature that friction drives.
///
/// `x' = rate`, from `start` on; at the arrival in stick and at break-away it may jump.
#[derive(Debug, Clone, PartialEq)]
pub struct UserState {
    /// Name in the formulas.
    pub name: String,
    /// Unit, for people.
    pub unit: String,
    /// Typical magnitude, for the integrator's error.
    pub nominal: f64,
    /// Its value at the start: a formula over [`QUANTITIES`] and the parameters.
    pub start: String,
    /// Its rate in its unit per s: a formula over [`QUANTITIES`], [`RATE_QUANTITIES`], the states and the parameters.
    pub rate: String,
    /// What it becomes at the arrival in stick: a formula over the states and the parameters.
    pub on_stick: Option<String>,
    /// The same at break-away.
    pub on_break_away: Option<String>,
}

/// A curve through nodes, used as `table(x, name)`: a natural cubic spline, continued by straight lines. The values at the
/// nodes are parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct UserTable {
    /// Name in the formulas.
    pub name: String,
    /// Places of the nodes, rising.
    pub at: Vec<f64>,
    /// The value at the first node among the parameters; those of the others follow.
    pub first_parameter: usize,
}

/// An effect given by a formula over [`QUANTITIES`], its parameters, states and tables, e.g. friction that depends on
/// the direction of motion: target `friction_factor`, formula `1 + a*tanh(w_dot/v)`.
///
/// It is on as long as it is listed.
#[derive(Debug, Clone, PartialEq)]
pub struct UserEffect {
    /// Identifier, different from those of the catalogue.
    pub id: String,
    /// What the formula's value acts on.
    pub target: Target,
    /// The mode on which a factor on frequencies or damping acts, counted from 1; all modes without.
    pub mode: Option<usize>,
    /// The formula; see [`crate::expression::Expression`] for what it may contain.
    pub expression: String,
    /// Its parameters.
    pub parameters: Vec<UserParameter>,
    /// Its states.
    pub states: Vec<UserState>,
    /// Its tables.
    pub tables: Vec<UserTable>,
}

impl UserEffect {
    /// An effect without states and tables.
    pub fn new(id: &str, target: Target, expression: &str, parameters: Vec<UserParameter>) -> Self {
        Self {
            id: id.to_owned(),
            target,
            mode: None,
            expression: expression.to_owned(),
            parameters,
            states: Vec::new(),
            tables: Vec::new(),
        }
    }

    /// Names of the states that it brings along, in their order.
    pub fn state_names(&self) -> impl Iterator<Item = &str> {
        let own = self.states.iter().map(|s| s.name.as_str());
        own.chain((self.target == Target::BeltVelocity).then_some(TRAVEL))
    }

    /// Magnitudes of the states that it brings along, in their order: its own, then the belt's travel where it adds to the
    /// belt's velocity.
    pub fn nominals(&self) -> Vec<f64> {
        let own = self.states.iter().map(|s| s.nominal);
        let travel = (self.target == Target::BeltVelocity).then_some(1e-3);
        own.chain(travel).collect()
    }
}
