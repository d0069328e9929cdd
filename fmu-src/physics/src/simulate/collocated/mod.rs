//! The reference model by collocation: the motion of [`Simulation`](super::Simulation) in few long steps, for studies of
//! many points.
//!
//! Covered are models without effects, with constant inputs, a belt that moves, and a law made of exponentials. Events are
//! those of the event loop, found as rigorously: every step is a polynomial whose first root is isolated.

mod memory;
mod piece;
mod slip;
mod stick;
mod structure;
#[cfg(test)]
mod tests;
mod variation;

use super::{DEPARTURE_VELOCITY, Simulation};
use crate::contact::{ContactMode, Transition};
use crate::error::PhysicsError;
use crate::integrate::collocation::{Characteristic, Goal, Step, Tangent};
use crate::integrate::{MAX_STATES, State};
use crate::model::Model;
use memory::Memory;
use piece::Piece;
use std::sync::Arc;
use structure::Structure;
use variation::{Crossing, Variation};

/// Smallest tolerance that a step can keep: rounding adds up over the sums of a step.
const LEAST_TOLERANCE: f64 = 1e-13;

/// Whether the processor multiplies and adds in one operation, in vectors. Without, the same digits would take a
/// hundred times as long.
fn has_fused_products() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("fma")
        && std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    return cfg!(target_arch = "aarch64");
}

/// How long a step was, and how rough.
#[derive(Debug, Clone, Copy, Default)]
struct Pace {
    level: usize,
    /// In m/s.
    roughness: f64,
}

/// A run of the reference model by collocation, piece by piece.
#[derive(Clone)]
pub(crate) struct Collocated {
    model: Model,
    structure: Arc<Structure>,
    law: Characteristic,
    belt: f64,
    limit: f64,
    tolerance: f64,
    /// Tip velocity in m/s that the tolerance is a share of.
    scale: f64,
    goal: Goal,
    /// The present piece of motion, and the transition that ends it.
    piece: Piece,
    end: Option<Transition>,
    /// Time in s, state and mode at the end of the piece, after the jump there.
    front: f64,
    front_state: State,
    front_mode: ContactMode,
    /// The slip has left v_r = 0 by more than rounding, so that a return counts as arrival.
    departed: bool,
    /// Sliding speed in m/s at the front of a slip, its rate in m/s^2 where it has departed, and friction there.
    speed: f64,
    rise: f64,
    tangent: Tangent,
    /// Friction at rest.
    at_rest: Tangent,
    /// The last step of slip, and the one that left v_r = 0 last.
    pace: Pace,
    departure: Pace,
    transition_count: u64,
    memory: Memory,
    /// The step that is being made.
    step: Step,
    variation: Option<Box<Variation>>,
}

impl Collocated {
    /// Takes a run over from its present state; `None` for models that are not covered.
    pub(crate) fn take_over(run: &Simulation) -> Option<Self> {
        let (model, tolerance) = (run.model(), run.tolerance);
        let inputs = &model.inputs;
        let belt = inputs.belt_velocity;
        if !has_fused_products()
            || !inputs.are_steady()
            || inputs.external_force != 0.0
            || inputs.clamp_acceleration != 0.0
            || belt == 0.0
            || tolerance < LEAST_TOLERANCE
            || !model.is_bare()
        {
            return None;
        }
        let law = model.characteristic()?;
        let structure = structure::of(model)?;
        let (t, x) = (run.time(), run.state());
        let mode = run.contact_mode();
        let departed = mode != ContactMode::Stuck && !model.is_at_rest(t, &x);
        let (mut speed, mut rise) = (0.0, 0.0);
        if departed {
            let mut rates = [0.0; MAX_STATES];
            model.rates(t, &x, mode, &mut rates);
            speed = mode.sign() * model.relative_velocity(t, &x);
            rise = mode.sign() * model.relative_acceleration(t, &rates);
        }
        let scale = structure.velocity_scale(&model.state_scales());
        Some(Self {
            limit: model.static_limit(t, &x),
            scale,
            goal: Goal {
                speed: 0.2 * tolerance * scale,
                share: 100.0 * tolerance,
                overshoot: 0.5 * law.scale(),
                roughness: 2.0 * tolerance.sqrt() * scale,
            },
            piece: Piece::at(t, &x, mode),
            end: None,
            front: t,
            front_state: x,
            front_mode: mode,
            departed,
            speed,
            rise,
            tangent: law.tangent(speed),
            at_rest: law.tangent(0.0),
            pace: Pace::default(),
            departure: Pace::default(),
            transition_count: run.transition_count(),
            step: Step::default(),
            variation: None,
            memory: Memory::new(structure.ladder.oscillators()),
            model: model.clone(),
            structure,
            law,
            belt,
            tolerance,
        })
    }

    /// The model.
    pub(crate) fn model(&self) -> &Model {
        &self.model
    }

    /// The present piece of motion.
    pub(crate) fn piece(&self) -> &Piece {
        &self.piece
    }

    /// State at time `t` in s within the present piece.
    pub(crate) fn state_at(&self, t: f64) -> State {
        let theta = self.piece.theta(t);
        self.piece.state_at(&self.structure, theta)
    }

    /// The transition that ends the present piece.
    pub(crate) fn piece_transition(&self) -> Option<Transition> {
        self.end
    }

    /// Time in s, state and mode at the end of the piece, after the jump there if one ends it.
    pub(crate) fn front(&self) -> (f64, &State, ContactMode) {
        (self.front, &self.front_state, self.front_mode)
    }

    /// Number of transitions so far.
    pub(crate) fn transition_count(&self) -> u64 {
        self.transition_count
    }

    /// Goes to the end of the present piece and integrates the next; false where no step is short enough to converge, and the
    /// run stays at the end of the present piece.
    ///
    /// # Errors
    /// A motion that is no longer finite.
    pub(crate) fn next_piece(&mut self) -> Result<bool, PhysicsError> {
        if self.end.take().is_some() {
            self.transition_count += 1;
        }
        let begin = self.front;
        let done = if self.front_mode == ContactMode::Stuck {
            self.stick();
            true
        } else {
            self.slip()
        };
        let states = 2 * self.structure.ladder.oscillators().len();
        if self.front_state[..states].iter().all(|x| x.is_finite()) {
            Ok(done)
        } else {
            Err(PhysicsError::NotFinite { time: begin })
        }
    }

    /// Ends the piece at time `t` in s in state `x`, where v_r = 0, and decides how the motion goes on.
    fn land(&mut self, t: f64, mut x: State) {
        let before = Crossing {
            time: t,
            state: x,
            mode: self.front_mode,
            gap: |run, x| run.model.tip(x).1,
        };
        self.model.project_on_stick(t, &mut x);
        self.front_mode = self.model.mode_at_rest(t, &x);
        self.turn(t, x, &before);
    }

    /// Ends the piece at time `t` in s in state `x`, where the constraint force reaches its limit.
    fn break_away(&mut self, t: f64, mut x: State) {
        let before = Crossing {
            time: t,
            state: x,
            mode: ContactMode::Stuck,
            gap: |run, x| run.model.constraint_force(run.front, x),
        };
        let force = self.model.constraint_force(t, &x);
        self.model.project_on_stick(t, &mut x);
        self.front_mode = ContactMode::slip_towards(-force);
        let seed = self.front_mode.sign() * DEPARTURE_VELOCITY;
        self.model.push(seed, &mut x);
        self.turn(t, x, &before);
    }

    fn turn(&mut self, t: f64, x: State, before: &Crossing) {
        self.piece.end = t;
        self.end = Some(Transition {
            time: t,
            from: before.mode,
            to: self.front_mode,
        });
        self.departed = false;
        (self.speed, self.rise) = (0.0, 0.0);
        self.tangent = self.at_rest;
        self.go_on(t, x);
        self.vary_transition(before);
    }

    fn go_on(&mut self, t: f64, x: State) {
        self.front = t;
        self.front_state = x;
    }
}
