//! The event loop: integrate a smooth piece, locate the transition that ends it, apply it, go on.

mod change;
#[cfg(not(feature = "tangent"))]
pub(crate) mod collocated;
mod expanded;
mod outputs;
#[cfg(not(feature = "tangent"))]
mod piece;
mod sample;
mod slip;
#[cfg(not(feature = "tangent"))]
pub mod snapshot;
mod start;
mod stick;

use crate::belt::Inputs;
use crate::contact::{ContactMode, Transition};
use crate::energy::Energy;
use crate::error::PhysicsError;
use crate::integrate::dop853::Dop853;
use crate::integrate::{MAX_STATES, Scales, Segment, State, System};
use crate::model::Model;
use crate::model::series::Workspace;
use crate::real::{Real, ZERO, value};
pub use outputs::Outputs;
pub use sample::Row;
pub use start::{Start, StartContact};
use std::sync::Arc;
#[cfg(not(feature = "tangent"))]
pub(crate) use stick::DEPARTURE_VELOCITY;
use stick::StickSystem;

/// A run whose steps are shorter than this on average, in s, over [`PATIENCE`] of them is given up.
const LEAST_PROGRESS: f64 = 1e-7;
/// Number of steps after which progress is judged.
const PATIENCE: u64 = 2_000;

/// Relative tolerance at which transitions of the default model are good to 1e-6 s over seconds.
pub const DEFAULT_TOLERANCE: f64 = 1e-10;

/// Work of the integrator, for tests that catch "same answer, more work".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Pieces of slip integrated.
    pub slip_steps: u64,
    /// Pieces of stick integrated.
    pub stick_steps: u64,
    /// Evaluations of the rates; each power of a series counts as one.
    pub evaluations: u64,
}

/// What ends the present segment.
#[derive(Clone, Copy)]
enum End {
    Smooth,
    Event(Transition),
}

/// The model within one mode, as the integrators see it.
struct InMode<'a> {
    model: &'a Model,
    mode: ContactMode,
}

impl System for InMode<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension()
    }
    #[inline]
    fn rates(&self, t: Real, x: &State, rates: &mut State) {
        self.model.rates(t, x, self.mode, rates);
    }
}

/// A run of the model. Integrates ahead of the present time in steps of its own and interpolates,
/// so that results do not depend on where the caller stops; a change of inputs discards what lies ahead.
#[derive(Clone)]
pub struct Simulation {
    model: Model,
    tolerance: f64,
    scales: Scales,
    time: Real,
    /// State and mode at `front`, the end of the segment.
    front: Real,
    front_state: State,
    front_mode: ContactMode,
    segment: Segment,
    room: Workspace,
    segment_mode: ContactMode,
    /// The polynomials of a segment are worked out only once somebody looks at them.
    segment_is_ready: bool,
    end: End,
    stepper: Dop853,
    /// The equations of stick under the present inputs, where they are linear.
    stick_system: Option<Arc<StickSystem>>,
    first_slip_step: f64,
    /// The slip has left v_r = 0 by more than rounding, so that a return counts as arrival.
    departed: bool,
    transition_count: u64,
    last_transition: Real,
    recorded: Option<Vec<Transition>>,
    energy: Option<Energy>,
    statistics: Statistics,
}

impl Simulation {
    /// Inputs that hold now.
    pub fn inputs(&self) -> Inputs {
        self.model.inputs
    }

    /// Present time in s.
    pub fn time(&self) -> Real {
        self.time
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Advances to time `t` in s, not before the present.
    ///
    /// # Errors
    /// A motion that is no longer finite, or no progress in time; the run stays at the last good time.
    pub fn advance_to(&mut self, t: Real) -> Result<(), PhysicsError> {
        self.pass_to(t)?;
        self.ready_segment();
        Ok(())
    }

    /// Advances to time `t` in s without working out the interpolant there.
    fn pass_to(&mut self, t: Real) -> Result<(), PhysicsError> {
        let (mut steps, mut since) = (0, (self.time, self.transition_count));
        while t >= self.segment.end {
            self.time = self.segment.end;
            self.finish_segment();
            self.next_segment()?;
            steps += 1;
            if steps % PATIENCE == 0 {
                if self.time - since.0 < LEAST_PROGRESS * PATIENCE as f64 {
                    return Err(PhysicsError::Stalled {
                        time: value(self.time),
                        step: self.segment.length,
                        transitions: self.transition_count - since.1,
                    });
                }
                since = (self.time, self.transition_count);
            }
        }
        self.time = t;
        Ok(())
    }

    /// Works out the interpolant of the present segment.
    fn ready_segment(&mut self) {
        if self.segment_is_ready {
            return;
        }
        self.segment_is_ready = true;
        if self.segment_mode == ContactMode::Stuck {
            self.ready_stick();
        } else {
            let system = InMode {
                model: &self.model,
                mode: self.segment_mode,
            };
            self.stepper.segment(&system, &mut self.segment);
        }
    }

    /// Counts the energy that flows in the present segment up to time `until` in s.
    fn count_energy(&mut self, until: Real) {
        if self.energy.is_some() {
            self.ready_segment();
        }
        if let Some(energy) = &mut self.energy {
            energy.add(&self.model, &self.segment, self.segment_mode, until);
        }
    }

    /// Counts what the finished segment ended with.
    fn finish_segment(&mut self) {
        self.count_energy(self.segment.end);
        if let End::Event(transition) = self.end {
            self.note(transition);
            self.end = End::Smooth;
        }
    }

    fn note(&mut self, transition: Transition) {
        // A law with memory has no discrete modes: its change of sign is only a place to restart.
        if self.model.has_memory() {
            return;
        }
        self.transition_count += 1;
        self.last_transition = transition.time;
        if transition.to == ContactMode::Stuck {
            self.model.stick_since = transition.time;
        }
        if let Some(list) = &mut self.recorded {
            list.push(transition);
        }
    }

    fn next_segment(&mut self) -> Result<(), PhysicsError> {
        let (t, x, mode) = (self.front, self.front_state, self.front_mode);
        self.segment_mode = mode;
        let done = if mode != ContactMode::Stuck {
            if self.model.has_series() {
                self.expanded_slip(false)
            } else {
                self.slip_segment(false)
            }
        } else {
            self.stick_segment()
        };
        let finite = self.front_state[..self.model.dimension()]
            .iter()
            .all(|v| v.is_finite());
        match done {
            Ok(()) if finite => Ok(()),
            failed => Err(self
                .fault_near(t, &x, mode)
                .or(failed.err())
                .unwrap_or(PhysicsError::NotFinite { time: value(t) })),
        }
    }

    /// An effect that can't be evaluated at this instant or shortly after it: the better explanation of
    /// a run that can't go on.
    fn fault_near(&self, t: Real, x: &State, mode: ContactMode) -> Option<PhysicsError> {
        if let Some(fault) = self.model.fault(t, x, mode) {
            return Some(fault);
        }
        let mut rates = [ZERO; MAX_STATES];
        self.model.rates(t, x, mode, &mut rates);
        if !rates.iter().all(|r| r.is_finite()) {
            return None;
        }
        [1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6]
            .into_iter()
            .find_map(|h| {
                let ahead = std::array::from_fn(|i| x[i] + h * rates[i]);
                self.model.fault(t + h, &ahead, mode)
            })
    }

    fn stalled(&self) -> PhysicsError {
        PhysicsError::Stalled {
            time: value(self.front),
            step: self.stepper.next_length,
            transitions: 0,
        }
    }

    /// Writes the state at the present time.
    pub fn state(&self) -> State {
        let mut x = [ZERO; MAX_STATES];
        self.segment.state_at(self.segment.theta(self.time), &mut x);
        x
    }

    /// Mode of the contact at the present time.
    pub fn contact_mode(&self) -> ContactMode {
        self.segment_mode
    }

    /// Number of transitions so far.
    pub fn transition_count(&self) -> u64 {
        self.transition_count
    }

    /// Time of the last transition in s, the start time before the first.
    pub fn last_transition_time(&self) -> Real {
        self.last_transition
    }

    /// Keeps a list of transitions from now on.
    pub fn record_transitions(&mut self) {
        self.recorded.get_or_insert_default();
    }

    /// The transitions recorded.
    pub fn transitions(&self) -> &[Transition] {
        self.recorded.as_deref().unwrap_or_default()
    }

    /// Keeps account of energies from now on.
    pub fn account_energy(&mut self) {
        self.energy.get_or_insert_with(Energy::default);
    }

    /// Energies are being accounted for.
    pub fn accounts_energy(&self) -> bool {
        self.energy.is_some()
    }

    /// Energies in J since accounting began; `None` where it has not.
    pub fn energy(&self) -> Option<Energy> {
        let mut energy = self.energy?;
        energy.add(&self.model, &self.segment, self.segment_mode, self.time);
        energy.stored = self.model.stored_energy(&self.state());
        Some(energy)
    }

    /// Work done so far.
    pub fn statistics(&self) -> Statistics {
        Statistics {
            evaluations: self.stepper.evaluations,
            ..self.statistics
        }
    }
}
