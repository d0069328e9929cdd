//! The vector of continuous states (FMI 2.0.5, section 3.2.1): the same for every set of parameters, so that
//! its length can stand in modelDescription.xml. States that the present model does not have keep the value
//! set and have the rate 0.

use crate::instance::Content;
use crate::setup::PLACES;
use beam_model_description::{Layout, ModeItem, Quantity};
use beam_physics::hybrid::{Hybrid, Rates};
use beam_physics::integrate::{MAX_STATES, State};
use beam_physics::model::Model;

/// Where a continuous state lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Index in the model's state.
    Model(usize),
    /// Distance that the belt has run.
    BeltDistance,
    /// Index of the energy.
    Energy(usize),
}

/// Where a state lies in the present model, which has `modes` modes of its own; `None` if it lacks it.
pub fn place(layout: &Layout, model: &Model, modes: usize, quantity: Quantity) -> Option<Place> {
    let first = |states: Option<(usize, usize)>| states.map(|(first, _)| first);
    match quantity {
        Quantity::Mode(j, ModeItem::Displacement) => (j < modes).then_some(Place::Model(2 * j)),
        Quantity::Mode(j, ModeItem::Velocity) => (j < modes).then_some(Place::Model(2 * j + 1)),
        Quantity::EffectState(card, i) => {
            first(model.effect_states(card)).map(|first| Place::Model(first + i))
        }
        Quantity::UserState(e, i) => {
            let id = &layout.effects()[e].id;
            first(model.user_states(id)).map(|first| Place::Model(first + i))
        }
        Quantity::BeltDistance => Some(Place::BeltDistance),
        Quantity::EnergyBeltWork => Some(Place::Energy(0)),
        Quantity::EnergyContactDissipation => Some(Place::Energy(1)),
        Quantity::EnergyStructuralDissipation => Some(Place::Energy(2)),
        Quantity::EnergyExternalWork => Some(Place::Energy(3)),
        _ => None,
    }
}

impl Place {
    /// The state's value at an instant.
    pub fn value(self, hybrid: &Hybrid) -> f64 {
        match self {
            Self::Model(i) => hybrid.state()[i],
            Self::BeltDistance => hybrid.belt_distance(),
            Self::Energy(i) => hybrid.energy()[i],
        }
    }

    /// Sets the state.
    pub fn set(self, hybrid: &mut Hybrid, value: f64) {
        match self {
            Self::Model(i) => hybrid.set_state(i, value),
            Self::BeltDistance => hybrid.set_belt_distance(value),
            Self::Energy(i) => hybrid.set_energy(i, value),
        }
    }

    /// The state's rate per s.
    pub fn rate(self, rates: &Rates) -> f64 {
        match self {
            Self::Model(i) => rates.state[i],
            Self::BeltDistance => rates.belt_distance,
            Self::Energy(i) => rates.energy[i],
        }
    }
}

impl Content {
    /// Number of modes of the structure itself.
    pub fn modes(&self) -> usize {
        self.values[PLACES.mode_count] as usize
    }

    /// Where the state with an index in the table lies in `model`.
    pub fn place(&self, model: &Model, index: usize) -> Option<Place> {
        let quantity = self.layout.variables()[index].quantity;
        place(self.layout, model, self.modes(), quantity)
    }

    /// The state `x` of `old` in the order of `new`. States that come in have the value set; values of
    /// those that go are kept in the table.
    pub fn carried_over(&mut self, old: &Model, x: &State, new: &Model) -> State {
        let mut out = [0.0; MAX_STATES];
        for &(index, _) in self.layout.states() {
            if let Some(Place::Model(from)) = self.place(old, index) {
                self.values[index] = x[from];
            }
            if let Some(Place::Model(to)) = self.place(new, index) {
                out[to] = self.values[index];
            }
        }
        out
    }
}
