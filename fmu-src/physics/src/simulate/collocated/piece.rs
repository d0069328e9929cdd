//! A piece of motion: what it was computed from, so that its states can be worked out where somebody looks into it.

use super::structure::Structure;
use crate::contact::ContactMode;
use crate::integrate::State;
use crate::integrate::collocation::{Chebyshev, Course, NODES, Nodes, integral_to};

/// A piece of motion on [start, end].
#[derive(Clone)]
pub(crate) struct Piece {
    /// Start in s.
    pub(crate) start: f64,
    /// End in s up to which it is to be used.
    pub(crate) end: f64,
    /// Length in s of the step; theta = (t - start) / length.
    pub(crate) length: f64,
    /// Mode of the contact.
    pub(crate) mode: ContactMode,
    /// State at the start.
    pub(crate) state: State,
    level: usize,
    /// Of a step of slip: friction in N at its nodes, its motion, and the belt's velocity in m/s.
    capacity: Nodes,
    pub(super) course: Course,
    belt: f64,
}

impl Piece {
    /// A piece of no length.
    pub(super) fn at(t: f64, x: &State, mode: ContactMode) -> Self {
        Self {
            start: t,
            end: t,
            length: 1.0,
            mode,
            state: *x,
            level: 0,
            capacity: [0.0; NODES],
            course: Course::REST,
            belt: 0.0,
        }
    }

    pub(super) fn begin(&mut self, t: f64, length: f64, x: &State, mode: ContactMode) {
        self.start = t;
        self.end = t + length;
        self.length = length;
        self.mode = mode;
        self.state = *x;
    }

    /// What a step of slip knows beside its course: its level and the friction in N at its nodes.
    pub(super) fn slides(&mut self, level: usize, belt: f64, capacity: &Nodes) {
        self.level = level;
        self.belt = belt;
        self.capacity = *capacity;
    }

    /// Normalised time of `t` in s.
    pub(crate) fn theta(&self, t: f64) -> f64 {
        (t - self.start) / self.length
    }

    /// State at `theta`.
    pub(super) fn state_at(&self, structure: &Structure, theta: f64) -> State {
        self.difference_at(structure, theta, &self.state, &self.capacity)
    }

    /// What a difference `begin` of the states at the start, which changes the friction at the nodes by `friction` in N, has
    /// become at `theta`: between transitions all is linear but for friction.
    pub(super) fn difference_at(
        &self,
        structure: &Structure,
        theta: f64,
        begin: &State,
        friction: &Nodes,
    ) -> State {
        if self.end == self.start {
            return *begin;
        }
        if self.mode == ContactMode::Stuck {
            return structure.stick.state_at(theta * self.length, begin);
        }
        let response = structure.ladder.response(self.level);
        response.state_at(theta, begin, self.mode.sign(), friction)
    }

    /// Velocity of the tip in m/s over a piece of slip.
    pub(crate) fn velocity(&self) -> Chebyshev {
        let sign = self.mode.sign();
        let mut out = self.course.speed.map(|c| sign * c);
        out[0] += self.belt;
        out
    }

    /// Whether the velocity of the tip certainly keeps the sign that is given over a piece of slip, as far as is told at once.
    pub(crate) fn keeps_direction(&self, rising: bool) -> bool {
        let mean = self.mode.sign() * self.course.speed[0] + self.belt;
        let mean = if rising { mean } else { -mean };
        mean >= self.course.spread
    }

    /// Way in m of the tip from the start of a piece of slip to `theta`.
    pub(crate) fn way_to(&self, theta: f64) -> f64 {
        let sliding = self.mode.sign() * integral_to(&self.course.speed, theta);
        self.length * (sliding + self.belt * theta)
    }
}
