//! From the values of the variables to a run of the physics.
//!
//! Compiled twice: for `physics` with plain numbers and, in [`crate::tangent`], with numbers that carry derivatives.

use super::physics::beam::{Beam, MAX_MODES, ModalOscillator};
use super::physics::belt::Inputs;
use super::physics::effects::CATALOGUE;
use super::physics::effects::user_expression::UserEffect;
use super::physics::error::PhysicsError;
use super::physics::friction::{Exponential, FrictionLaw, MAX_TABLE, Table};
use super::physics::integrate::MAX_STATES;
use super::physics::model::Model;
use super::physics::parameters::ModelParameters;
use super::physics::real::{Real, ZERO, value};
use super::physics::simulate::{Start, StartContact};
use beam_model_description::{Layout, ModeItem, Quantity, UserCard, variables};
use std::sync::LazyLock;

/// Number of inputs: belt velocity, normal force, external force and acceleration of the clamp, in this order wherever they stand
/// in a row.
pub const INPUTS: usize = 4;

/// Where the quantities that a start needs lie in the table, looked up once.
pub struct Places {
    /// Index of `belt_velocity`.
    pub belt_velocity: usize,
    /// Index of `normal_force`.
    pub normal_force: usize,
    /// Index of `external_force`.
    pub external_force: usize,
    /// Index of `clamp_acceleration`.
    pub clamp_acceleration: usize,
    /// Index of `tolerance`.
    pub tolerance: usize,
    /// Index of `mode_count`.
    pub mode_count: usize,
    /// Index of `start.contact`.
    pub start_contact: usize,
    start_effects: usize,
    belt_travel: usize,
    dwell: usize,
    q: [usize; MAX_MODES],
    q_dot: [usize; MAX_MODES],
    /// Index of an effect's first state, by card.
    effect_states: Vec<usize>,
    /// Indices in the fixed table of everything that the model is built from.
    model: Vec<usize>,
    /// Where the parameters of users' effects begin; all of them are needed for the model.
    user: usize,
}

/// The places.
pub static PLACES: LazyLock<Places> = LazyLock::new(|| {
    let find = |quantity: Quantity| {
        variables()
            .iter()
            .position(|v| v.quantity == quantity)
            .expect("the table has every quantity")
    };
    let effect_states = CATALOGUE
        .iter()
        .enumerate()
        .map(|(card, entry)| {
            if entry.states.is_empty() {
                usize::MAX
            } else {
                find(Quantity::EffectState(card, 0))
            }
        })
        .collect();
    Places {
        belt_velocity: find(Quantity::BeltVelocity),
        normal_force: find(Quantity::NormalForce),
        external_force: find(Quantity::ExternalForce),
        clamp_acceleration: find(Quantity::ClampAcceleration),
        tolerance: find(Quantity::Tolerance),
        mode_count: find(Quantity::ModeCount),
        start_contact: find(Quantity::StartContact),
        start_effects: find(Quantity::StartEffects),
        belt_travel: find(Quantity::BeltTravelStart),
        dwell: find(Quantity::DwellTimeStart),
        q: std::array::from_fn(|j| find(Quantity::Mode(j, ModeItem::Displacement))),
        q_dot: std::array::from_fn(|j| find(Quantity::Mode(j, ModeItem::Velocity))),
        effect_states,
        model: variables()
            .iter()
            .enumerate()
            .filter(|(_, v)| v.is_settable() && builds_the_model(v.quantity))
            .map(|(index, _)| index)
            .collect(),
        user: variables().len(),
    }
});

/// Whether a change of the quantity needs the model to be built anew.
fn builds_the_model(quantity: Quantity) -> bool {
    !matches!(
        quantity,
        Quantity::BeltVelocity
            | Quantity::NormalForce
            | Quantity::ExternalForce
            | Quantity::ClampAcceleration
            | Quantity::Tolerance
            | Quantity::StartContact
            | Quantity::StartEffects
            | Quantity::BeltTravelStart
            | Quantity::DwellTimeStart
            | Quantity::EffectState(..)
            | Quantity::Mode(_, ModeItem::Displacement | ModeItem::Velocity)
            | Quantity::UserState(..)
    )
}

impl Places {
    /// Whether both sets of values lead to the same model.
    pub fn same_model(&self, layout: &Layout, a: &[f64], b: &[f64]) -> bool {
        if a.len() != b.len() {
            return false;
        }
        let same = |i: usize| a[i].to_bits() == b[i].to_bits();
        self.model.iter().all(|&i| same(i)) && self.users_parameters(layout).all(same)
    }

    /// Whether the model is built from the variable with this index.
    pub fn is_of_model(&self, layout: &Layout, index: usize) -> bool {
        self.users_parameters(layout).contains(&index) || self.model.binary_search(&index).is_ok()
    }

    /// Places of the parameters of users' effects.
    fn users_parameters(&self, layout: &Layout) -> std::ops::Range<usize> {
        self.user..self.user + layout.user_parameters()
    }

    /// Indices of the inputs.
    pub fn input_indices(&self) -> [usize; INPUTS] {
        [
            self.belt_velocity,
            self.normal_force,
            self.external_force,
            self.clamp_acceleration,
        ]
    }

    /// The inputs of `values` with rates per second, from `since` in s on.
    pub fn inputs(&self, values: &[Real], rates: [Real; INPUTS], since: Real) -> Inputs {
        Inputs {
            since,
            belt_velocity: values[self.belt_velocity],
            belt_acceleration: rates[0],
            normal_force: values[self.normal_force],
            normal_force_rate: rates[1],
            external_force: values[self.external_force],
            external_force_rate: rates[2],
            clamp_acceleration: values[self.clamp_acceleration],
            clamp_acceleration_rate: rates[3],
        }
    }

    /// The start of a run at `time` in s.
    pub fn start(&self, layout: &Layout, values: &[Real], model: &Model, time: Real) -> Start {
        let mut state = [ZERO; MAX_STATES];
        for j in 0..value(values[self.mode_count]) as usize {
            state[2 * j] = values[self.q[j]];
            state[2 * j + 1] = values[self.q_dot[j]];
        }
        for (card, &place) in self.effect_states.iter().enumerate() {
            if place != usize::MAX
                && let Some((first, count)) = model.effect_states(card)
            {
                state[first..first + count].copy_from_slice(&values[place..place + count]);
            }
        }
        for (e, effect) in layout.effects().iter().enumerate() {
            if let Some((first, _)) = model.user_states(&effect.id) {
                for (i, &place) in layout.user_states(e).iter().enumerate() {
                    state[first + i] = values[place];
                }
            }
        }
        Start {
            time,
            state,
            contact: match value(values[self.start_contact]) as i32 {
                1 => StartContact::Stick,
                2 => StartContact::Slip,
                _ => StartContact::Automatic,
            },
            belt_travel: values[self.belt_travel],
            dwell: values[self.dwell],
            settled: values[self.start_effects] == 1.0,
        }
    }
}

/// Builds the model from `values` in the order of `layout`; `user` makes an effect from a card and its values.
///
/// # Errors
/// Parameters outside the range in which the equations hold.
pub fn model(
    layout: &'static Layout,
    values: &[Real],
    inputs: Inputs,
    user: impl Fn(&UserCard, &[Real]) -> Option<UserEffect>,
) -> Result<Model, PhysicsError> {
    let mut parameters = parameters(values)?;
    let mut own = &values[PLACES.user..];
    for effect in layout.effects() {
        let (mine, rest) = own.split_at(effect.parameters.len());
        parameters.user_effects.extend(user(effect, mine));
        own = rest;
    }
    Model::new(&parameters, inputs)
}

/// The physics' parameters from `values`, without users' effects.
fn parameters(values: &[Real]) -> Result<ModelParameters, PhysicsError> {
    let mut out = ModelParameters::default();
    let mut modes = [ModalOscillator {
        frequency: ZERO,
        damping_ratio: ZERO,
        damping_rate: ZERO,
        mass: ZERO,
        tip_value: ZERO,
    }; MAX_MODES];
    let mut clamp_shares = [ZERO; MAX_MODES];
    let mut mode_count = 0;
    let mut law = 1;
    let mut eq7 = Exponential::default();
    let (mut mu_s, mut mu_k) = (ZERO, ZERO);
    let (mut velocity, mut exponent, mut viscous) = (ZERO, ZERO, ZERO);
    let mut rows = 0;
    let mut speeds = [ZERO; MAX_TABLE];
    let mut coefficients = [ZERO; MAX_TABLE];
    for &index in &PLACES.model {
        let quantity = values[index];
        match variables()[index].quantity {
            Quantity::ModeCount => mode_count = value(quantity) as usize,
            Quantity::Mode(j, item) => match item {
                ModeItem::Frequency => modes[j].frequency = quantity,
                ModeItem::DampingRatio => modes[j].damping_ratio = quantity,
                ModeItem::DampingRate => modes[j].damping_rate = quantity,
                ModeItem::Mass => modes[j].mass = quantity,
                ModeItem::TipValue => modes[j].tip_value = quantity,
                ModeItem::SensorRatio => out.sensor_ratios[j] = quantity,
                ModeItem::ClampShare => clamp_shares[j] = quantity,
                ModeItem::Displacement | ModeItem::Velocity => {}
            },
            Quantity::FrictionLaw => law = value(quantity) as i32,
            Quantity::Mu0 => eq7.mu_0 = quantity,
            Quantity::A1 => eq7.a1 = quantity,
            Quantity::V1 => eq7.v1 = quantity,
            Quantity::A2 => eq7.a2 = quantity,
            Quantity::C2 => eq7.c2 = quantity,
            Quantity::MuS => mu_s = quantity,
            Quantity::MuK => mu_k = quantity,
            Quantity::StribeckVelocity => velocity = quantity,
            Quantity::StribeckExponent => exponent = quantity,
            Quantity::Viscous => viscous = quantity,
            Quantity::TableCount => rows = value(quantity) as usize,
            Quantity::TableVelocity(row) => speeds[row] = quantity,
            Quantity::TableCoefficient(row) => coefficients[row] = quantity,
            Quantity::FrictionLevel => out.friction_level = quantity,
            Quantity::SensorOffset => out.sensor_offset = quantity,
            Quantity::EffectParameter(card, parameter) => {
                out.effects.set(card, parameter, quantity)
            }
            _ => {}
        }
    }
    out.beam = Beam::new(&modes[..mode_count])?.with_clamp_shares(clamp_shares)?;
    out.friction = match law {
        2 => FrictionLaw::StelterAsPrinted(eq7),
        3 => FrictionLaw::Coulomb { mu_s, mu_k },
        4 => FrictionLaw::Stribeck {
            mu_s,
            mu_k,
            velocity,
            exponent,
            viscous,
        },
        5 => FrictionLaw::Table(Table::new(&speeds[..rows], &coefficients[..rows])?),
        _ => FrictionLaw::Stelter(eq7),
    };
    Ok(out)
}
