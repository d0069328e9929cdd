//! The equations at one instant, for an integrator from outside: rates, event functions, and what an
//! event does. [`crate::simulate`] is the integrator from inside.
//!
//! The contact is an automaton with the modes of [`ContactMode`] (Stelter 1992, eqs. 3-5):
//!
//! | mode | event functions (an event is a change from positive to not positive) |
//! |---|---|
//! | stick | `mu_0 F_N + h_F - F`, `mu_0 F_N + h_F + F` |
//! | slip | `sgn v_r + h_v` |
//!
//! The bands `h_F`, `h_v` keep every function off zero right after an event, so that an integrator that
//! looks for changes of sign neither stops at once nor misses the next event.

mod event;
mod stiffness;

pub use stiffness::Stiffness;

use crate::belt::Inputs;
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::integrate::{MAX_STATES, State};
use crate::model::Model;
use crate::simulate::snapshot::Codec;
use crate::simulate::{Outputs, Simulation, snapshot};

/// Event functions of the contact.
pub const EVENT_FUNCTIONS: usize = 3;
/// Band h_v in m/s below v_r = 0 in which slip has not yet arrived. At an arrival with 100 m/s^2 it is
/// passed in 1e-11 s.
const ARRIVAL_BAND: f64 = 1e-9;
/// Band h_F above the static limit, relative to it, and in N.
const FORCE_BAND: (f64, f64) = (1e-10, 1e-12);
/// Rate at which stick takes a relative velocity back to zero, over the structure's highest frequency.
const RESTORING: f64 = 10.0;

/// Rates of everything that is integrated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rates {
    /// Those of the model's states, in its order.
    pub state: State,
    /// Of the distance that the belt has run, in m/s.
    pub belt_distance: f64,
    /// Of belt work, heat in the contact, heat in the structure and external work, in W.
    pub energy: [f64; 4],
}

/// The model at one instant.
///
/// In stick the constraint force is `F_c = (v_belt' - k v_r - w''_free) / mobility`. An integrator from
/// outside keeps `v_r = 0` to its tolerance only, and knows no rate of the belt's velocity: the term
/// with `k` leads `v_r` back to zero within `1/k`, ten times faster than the structure's highest
/// frequency. A belt that accelerates with `a` is followed with the lag `a/k` in `v_r`.
#[derive(Clone)]
pub struct Hybrid {
    /// The model; its inputs hold from the present time on, its travel offset is the belt's distance.
    model: Model,
    time: f64,
    state: State,
    mode: ContactMode,
    /// Belt work, heat in the contact, heat in the structure and external work since the start, in J.
    energy: [f64; 4],
    transition_count: u64,
    last_transition: f64,
    /// k in 1/s; 0 where the rate of the belt's velocity is known.
    restoring: f64,
    /// Rate of the belt's velocity as given, in m/s^2.
    belt_acceleration: f64,
    /// The belt's velocity has jumped since the last event.
    jumped: bool,
}

impl Hybrid {
    /// The present instant of a run, with the rates of the inputs that hold there.
    pub fn of(run: &Simulation) -> Self {
        let time = run.time();
        let now = run.inputs();
        let mut model = run.model().clone();
        model.travel_offset += now.belt_distance_at(time);
        model.inputs = now.from(time);
        Self {
            model,
            time,
            state: run.state(),
            mode: run.contact_mode(),
            energy: [0.0; 4],
            transition_count: run.transition_count(),
            last_transition: run.last_transition_time(),
            restoring: 0.0,
            belt_acceleration: now.belt_acceleration,
            jumped: false,
        }
    }

    /// The start of an integration from outside, where a run stands that has just been placed.
    pub fn start(run: &Simulation) -> Self {
        let mut hybrid = Self::of(run);
        hybrid.restoring = RESTORING * hybrid.model.highest_frequency();
        hybrid.belt_acceleration = 0.0;
        hybrid.model.inputs.normal_force_rate = 0.0;
        hybrid.model.inputs.external_force_rate = 0.0;
        hybrid.model.inputs.clamp_acceleration_rate = 0.0;
        hybrid.follow();
        hybrid
    }

    fn slip_of_state(&self) -> ContactMode {
        ContactMode::slip_towards(self.model.relative_velocity(self.time, &self.state))
    }

    /// Brings the constraint force up to date with time, state and inputs.
    fn follow(&mut self) {
        let back = if self.mode == ContactMode::Stuck {
            -self.restoring * self.model.relative_velocity(self.time, &self.state)
        } else {
            0.0
        };
        self.model.inputs.belt_acceleration = self.belt_acceleration + back;
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Present time in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// States in the order of the model.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Mode of the contact.
    pub fn mode(&self) -> ContactMode {
        self.mode
    }

    /// Distance in m that the belt has run, counted so that the place under the tip is right.
    pub fn belt_distance(&self) -> f64 {
        self.model.travel_offset
    }

    /// Belt work, heat in the contact, heat in the structure and external work since the start, in J.
    pub fn energy(&self) -> [f64; 4] {
        self.energy
    }

    /// Number of transitions so far.
    pub fn transition_count(&self) -> u64 {
        self.transition_count
    }

    /// Time of the last transition in s.
    pub fn last_transition_time(&self) -> f64 {
        self.last_transition
    }

    /// Goes to time `t` in s; states stay.
    pub fn set_time(&mut self, t: f64) {
        self.time = t;
        self.model.inputs.since = t;
        self.follow();
    }

    /// Sets one state of the model.
    pub fn set_state(&mut self, index: usize, value: f64) {
        self.state[index] = value;
        self.follow();
    }

    /// Sets the distance in m that the belt has run.
    pub fn set_belt_distance(&mut self, distance: f64) {
        self.model.travel_offset = distance;
    }

    /// Sets one of the energies, in J.
    pub fn set_energy(&mut self, index: usize, energy: f64) {
        self.energy[index] = energy;
    }

    /// Sets belt velocity in m/s, normal force in N, external force in N and acceleration of the clamp in m/s^2; at an event they
    /// may `jump`.
    ///
    /// # Errors
    /// Inputs outside the range in which the equations hold; nothing is changed then.
    pub fn set_inputs(
        &mut self,
        [
            belt_velocity,
            normal_force,
            external_force,
            clamp_acceleration,
        ]: [f64; 4],
        jump: bool,
    ) -> Result<(), PhysicsError> {
        let inputs = Inputs {
            belt_velocity,
            normal_force,
            external_force,
            clamp_acceleration,
            ..self.model.inputs
        };
        inputs.check()?;
        self.jumped |= jump && belt_velocity != self.model.inputs.belt_velocity;
        self.model.inputs = inputs;
        self.follow();
        Ok(())
    }

    /// Goes on with another model whose state is `state` in its own order: parameters that change at
    /// an event.
    pub fn set_model(&mut self, mut model: Model, state: State) {
        let sticks = self.mode == ContactMode::Stuck;
        model.inputs = self.model.inputs;
        model.travel_offset = self.model.travel_offset;
        model.stick_since = self.model.stick_since;
        if self.restoring > 0.0 {
            self.restoring = RESTORING * model.highest_frequency();
        }
        self.model = model;
        self.state = state;
        if sticks && self.model.has_memory() {
            self.mode = self.slip_of_state();
        }
        self.follow();
    }

    /// Rates of all states now.
    ///
    /// # Errors
    /// An effect that can't be evaluated here, or rates that are not finite.
    pub fn rates(&self) -> Result<Rates, PhysicsError> {
        let (t, x, mode) = (self.time, &self.state, self.mode);
        if let Some(fault) = self.model.fault(t, x, mode) {
            return Err(fault);
        }
        let mut state = [0.0; MAX_STATES];
        let force = self.model.evaluate(t, x, mode, &mut state).force;
        let motion = self.model.motion(t, x, mode);
        let rates = Rates {
            state,
            belt_distance: motion.given_belt_velocity,
            energy: [
                force * motion.belt_velocity,
                -force * motion.relative_velocity,
                self.model.structural_dissipation(x),
                self.model.external_power(t, x, motion.velocity),
            ],
        };
        let finite = state.iter().chain(&rates.energy).all(|r| r.is_finite());
        finite
            .then_some(rates)
            .ok_or(PhysicsError::NotFinite { time: t })
    }

    /// The observables now.
    pub fn outputs(&self) -> Outputs {
        Outputs::of(&self.model, self.time, &self.state, self.mode)
    }

    /// Writes or reads everything that changes; the model's constants must be the same on both sides.
    pub fn exchange(&mut self, codec: &mut impl Codec) -> Option<()> {
        let inputs = &mut self.model.inputs;
        for number in [
            &mut inputs.since,
            &mut inputs.belt_velocity,
            &mut inputs.belt_acceleration,
            &mut inputs.normal_force,
            &mut inputs.normal_force_rate,
            &mut inputs.external_force,
            &mut inputs.external_force_rate,
            &mut inputs.clamp_acceleration,
            &mut inputs.clamp_acceleration_rate,
            &mut self.model.travel_offset,
            &mut self.model.stick_since,
            &mut self.time,
            &mut self.last_transition,
            &mut self.restoring,
            &mut self.belt_acceleration,
        ] {
            codec.number(number)?;
        }
        let numbers = self.state.iter_mut().chain(&mut self.energy);
        numbers.into_iter().try_for_each(|n| codec.number(n))?;
        snapshot::mode(&mut self.mode, codec)?;
        codec.count(&mut self.transition_count)?;
        codec.flag(&mut self.jumped)
    }
}
