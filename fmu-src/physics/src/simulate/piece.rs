//! The run piece by piece, for those who look at every polynomial: sweeps locate sections on them.

use super::{End, Simulation};
use crate::contact::Transition;
use crate::error::PhysicsError;
use crate::integrate::{Segment, State};

impl Simulation {
    /// Goes to the end of the present piece and integrates the next.
    ///
    /// # Errors
    /// As [`Simulation::advance_to`], except that the caller watches the progress.
    pub(crate) fn next_piece(&mut self) -> Result<(), PhysicsError> {
        self.time = self.segment.end;
        self.finish_segment();
        self.next_segment()
    }

    /// Relative tolerance of the integration.
    pub fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The present piece; its polynomials hold after [`Simulation::ready_piece`].
    pub(crate) fn piece(&self) -> &Segment {
        &self.segment
    }

    /// Works out the polynomials of the present piece where they are not yet.
    pub(crate) fn ready_piece(&mut self) {
        self.ready_segment();
    }

    /// State at the end of the present piece, after the jump there if one ends it.
    pub(crate) fn piece_end(&self) -> &State {
        &self.front_state
    }

    /// The transition that ends the present piece.
    pub(crate) fn piece_transition(&self) -> Option<Transition> {
        match self.end {
            End::Event(transition) if !self.model.has_memory() => Some(transition),
            _ => None,
        }
    }
}
