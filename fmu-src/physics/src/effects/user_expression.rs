//! Effects that a user writes as a formula, without compiling anything.

use super::{BeltGive, CATALOGUE, ContactForce, Effect, Motion, StateVariable};
use crate::belt::Inputs;
use crate::error::PhysicsError;
use crate::expression::{Expression, FUNCTIONS};
use crate::real::{Real, ZERO, real, value};
use crate::unit::METRE;

/// Quantities that a formula may use, with what they mean.
pub const QUANTITIES: [(&str, &str); 9] = [
    ("t", "time in s"),
    ("w", "tip displacement in m"),
    ("w_dot", "tip velocity in m/s"),
    ("v_r", "relative velocity w_dot - v_belt in m/s, 0 in stick"),
    ("v_abs", "sliding speed |v_r| in m/s, 0 in stick"),
    ("F_N", "normal force in N as given, before any effect"),
    ("v0", "belt velocity in m/s as given, before any effect"),
    (
        "s",
        "belt travel in m: the place on the belt where the tip stands",
    ),
    ("t_stick", "time in s since stick began, 0 in slip"),
];
const COUNT: usize = QUANTITIES.len();
/// Quantities that do not change during stick at constant normal force: v_r, v_abs, F_N, s.
const CONSTANT_IN_STICK: [bool; COUNT] =
    [false, false, false, true, true, true, false, true, false];
/// Those of them that are constants of the equations, which s is not: s differs from stick to stick.
const CONSTANT_IN_ALL_STICK: [bool; COUNT] =
    [false, false, false, true, true, true, false, false, false];
/// Quantities that depend on time and inputs alone: t, F_N, v0.
const GIVEN: [bool; COUNT] = [true, false, false, false, false, true, true, false, false];
/// Most parameters of one user effect.
pub const MAX_PARAMETERS: usize = 16;

/// What a user's effect acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Factor on the coefficient of friction, static (at v_r = 0) and kinetic.
    FrictionFactor,
    /// Factor on the normal force.
    NormalForceFactor,
    /// Force on the tip in N, positive along w.
    TipForce,
    /// Velocity in m/s added to the belt's; its formula may use t, F_N and v0 only.
    BeltVelocity,
}

impl Target {
    /// All targets with their names in files.
    pub const ALL: [(&'static str, Self); 4] = [
        ("friction_factor", Self::FrictionFactor),
        ("normal_force_factor", Self::NormalForceFactor),
        ("tip_force", Self::TipForce),
        ("belt_velocity", Self::BeltVelocity),
    ];

    /// The target of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().find(|t| t.0 == name).map(|t| t.1)
    }

    /// Its name in files.
    pub fn name(self) -> &'static str {
        let is_it = |t: &&(&str, Self)| t.1 == self;
        Self::ALL.iter().find(is_it).expect("ALL is complete").0
    }
}

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

/// An effect given by a formula over [`QUANTITIES`] and its parameters, e.g. friction that depends on
/// the direction of motion: target `friction_factor`, formula `1 + a*tanh(w_dot/v)`.
///
/// It is on as long as it is listed.
#[derive(Debug, Clone, PartialEq)]
pub struct UserEffect {
    /// Identifier, different from those of the catalogue.
    pub id: String,
    /// What the formula's value acts on.
    pub target: Target,
    /// The formula; see [`Expression`] for what it may contain.
    pub expression: String,
    /// Its parameters.
    pub parameters: Vec<UserParameter>,
}

fn is_name(name: &str) -> bool {
    let mut characters = name.chars();
    characters.next().is_some_and(|c| c.is_alphabetic())
        && characters.all(|c| c.is_alphanumeric() || c == '_')
}

impl UserEffect {
    /// Checks names, bounds and formula, and compiles the effect.
    ///
    /// # Errors
    /// [`PhysicsError::Expression`] naming the effect and what to correct.
    pub fn compile(&self) -> Result<Compiled, PhysicsError> {
        let wrong = |problem: String| PhysicsError::Expression {
            name: self.id.clone(),
            problem,
        };
        if !is_name(&self.id) || CATALOGUE.iter().any(|card| card.id == self.id) {
            return Err(wrong(
                "the id must be a name of letters, digits and '_' that no catalogue effect has"
                    .into(),
            ));
        }
        if self.parameters.len() > MAX_PARAMETERS {
            return Err(wrong(format!("more than {MAX_PARAMETERS} parameters")));
        }
        let mut names: Vec<&str> = QUANTITIES.iter().map(|q| q.0).collect();
        for p in &self.parameters {
            let taken = names.contains(&p.name.as_str())
                || p.name == "pi"
                || FUNCTIONS.iter().any(|f| f.0 == p.name);
            if taken || !is_name(&p.name) {
                return Err(wrong(format!(
                    "'{}' can't name a parameter: it is taken, or not made of letters, digits and '_'",
                    p.name
                )));
            }
            // Negated, so that a value that is not a number is refused too.
            let ordered = p.min <= p.max && p.min.is_finite() && p.max.is_finite();
            if !(ordered && p.min <= p.value && p.value <= p.max) {
                return Err(wrong(format!(
                    "parameter {} = {} {} lies outside its bounds {} .. {}",
                    p.name,
                    value(p.value),
                    p.unit,
                    p.min,
                    p.max
                )));
            }
            names.push(&p.name);
        }
        let formula = Expression::compile(&self.expression, &names)
            .map_err(|problem| wrong(format!("'{}', {problem}", self.expression)))?;
        for (i, p) in self.parameters.iter().enumerate() {
            if !formula.uses(COUNT + i) {
                return Err(wrong(format!(
                    "parameter '{}' is not in the formula",
                    p.name
                )));
            }
        }
        let only = |allowed: &[bool; COUNT]| (0..COUNT).all(|i| allowed[i] || !formula.uses(i));
        if self.target == Target::BeltVelocity && !only(&GIVEN) {
            return Err(wrong(
                "a change of belt velocity may depend on t, F_N and v0 only".into(),
            ));
        }
        let mut values = [ZERO; COUNT + MAX_PARAMETERS];
        for (slot, p) in values[COUNT..].iter_mut().zip(&self.parameters) {
            *slot = p.value;
        }
        Ok(Compiled {
            id: self.id.clone(),
            target: self.target,
            constant_in_stick: only(&CONSTANT_IN_STICK),
            constant_in_all_stick: only(&CONSTANT_IN_ALL_STICK),
            formula,
            values,
        })
    }

    /// States that the effect brings along.
    pub(crate) fn states(&self) -> &'static [StateVariable] {
        if self.target == Target::BeltVelocity {
            &TRAVEL
        } else {
            &[]
        }
    }
}

static TRAVEL: [StateVariable; 1] = [StateVariable {
    name: "travel",
    description: "displacement of the belt by the added velocity",
    unit: METRE,
    nominal: 1e-3,
}];

/// A user's effect, ready to be evaluated.
#[derive(Debug)]
pub struct Compiled {
    id: String,
    target: Target,
    formula: Expression,
    constant_in_stick: bool,
    constant_in_all_stick: bool,
    /// Values of the parameters, behind room for the quantities.
    values: [Real; COUNT + MAX_PARAMETERS],
}

impl Compiled {
    fn value(&self, m: &Motion) -> Real {
        let mut values = self.values;
        values[..COUNT].copy_from_slice(&[
            m.time,
            m.displacement,
            m.velocity,
            m.relative_velocity,
            m.speed,
            m.normal_force,
            m.given_belt_velocity,
            m.travel,
            m.dwell,
        ]);
        self.formula.value(&values)
    }

    fn value_for(&self, target: Target, m: &Motion, neutral: Real) -> Real {
        if self.target == target {
            self.value(m)
        } else {
            neutral
        }
    }
}

impl Effect for Compiled {
    fn tip_force(&self, m: &Motion) -> Real {
        self.value_for(Target::TipForce, m, ZERO)
    }
    fn friction_factor(&self, m: &Motion) -> Real {
        self.value_for(Target::FrictionFactor, m, real(1.0))
    }
    fn normal_factor(&self, m: &Motion) -> Real {
        self.value_for(Target::NormalForceFactor, m, real(1.0))
    }
    fn belt_ripple(&self, t: Real, inputs: &Inputs) -> Real {
        let m = Motion {
            time: t,
            normal_force: inputs.normal_force_at(t),
            given_belt_velocity: inputs.belt_velocity_at(t),
            ..Motion::default()
        };
        self.value_for(Target::BeltVelocity, &m, ZERO)
    }
    fn has_belt_ripple(&self) -> bool {
        self.target == Target::BeltVelocity
    }
    fn belt_give(&self, x: &[Real]) -> BeltGive {
        BeltGive {
            displacement: x.first().copied().unwrap_or(ZERO),
            ..BeltGive::default()
        }
    }
    fn add_rates(&self, m: &Motion, _contact: &ContactForce, _x: &[Real], rates: &mut [Real]) {
        if let Some(rate) = rates.first_mut() {
            *rate += self.value(m);
        }
    }
    fn is_linear_in_stick(&self) -> bool {
        // A friction or normal force factor acts on the limit alone.
        match self.target {
            Target::TipForce => self.constant_in_all_stick,
            Target::BeltVelocity => false,
            _ => true,
        }
    }
    fn keeps_limit_constant(&self) -> bool {
        match self.target {
            Target::FrictionFactor | Target::NormalForceFactor => self.constant_in_stick,
            _ => true,
        }
    }
    fn fault(&self, m: &Motion) -> Option<PhysicsError> {
        let force = self.value(m);
        (!force.is_finite()).then(|| PhysicsError::Expression {
            name: self.id.clone(),
            problem: format!(
                "the formula gives {} at t = {} s, w = {} m, w_dot = {} m/s, v_r = {} m/s, s = {} m, t_stick = {} s",
                value(force),
                value(m.time),
                value(m.displacement),
                value(m.velocity),
                value(m.relative_velocity),
                value(m.travel),
                value(m.dwell)
            ),
        })
    }
}
