//! Slips of the same run, remembered: a motion that nearly repeats makes nearly the same steps again, which then take few
//! iterations.

use crate::integrate::State;
use crate::integrate::collocation::{Along, Oscillator, Step, Tangent};

/// Slips that are remembered.
const SLIPS: usize = 16;
/// Steps of a slip that are remembered.
const STEPS: usize = 48;
/// One slip of so many follows no other: following only ever makes steps shorter. A prime, so that the slips of a motion
/// of many periods take turns.
const FRESH: usize = 11;
/// Slips in a row that took more than three iterations for two steps, after which one is worked out although it need not: those
/// that follow will be nearer to it.
const HARD: usize = 2;

/// A step of slip.
#[derive(Clone)]
pub(super) struct Known {
    /// Its length.
    pub(super) level: usize,
    /// Friction along it.
    pub(super) along: Along,
}

/// A slip from its departure on.
#[derive(Clone, Default)]
struct Slip {
    sign: f64,
    state: State,
    steps: Vec<Known>,
}

/// The last slips of a run.
#[derive(Clone)]
pub(super) struct Memory {
    slips: Vec<Slip>,
    oldest: usize,
    remembered: usize,
    /// Whether the present slip differs from the one that it follows.
    worked_out: bool,
    /// The slip that is being made, and which of the others it follows.
    present: Slip,
    followed: Option<usize>,
    /// Steps of the present slip that are those of the one it follows, and are not copied yet.
    taken: usize,
    /// Iterations that they took.
    iterations: usize,
    /// Slips in a row that took many.
    hard: usize,
    /// Whether the present slip is worked out for the sake of those to come.
    renews: bool,
    /// The size that counts of each state of the oscillators, in m/s per its unit.
    weight: Vec<f64>,
}

impl Memory {
    /// Nothing is remembered yet.
    pub(super) fn new(oscillators: &[Oscillator]) -> Self {
        let seen = oscillators.iter().map(|o| (o.seen.abs(), o.frequency));
        let weight = seen
            .flat_map(|(seen, frequency)| [seen * frequency, seen])
            .collect();
        Self {
            slips: Vec::new(),
            oldest: 0,
            remembered: 0,
            worked_out: false,
            present: Slip::default(),
            followed: None,
            taken: 0,
            iterations: 0,
            hard: 0,
            renews: false,
            weight,
        }
    }

    /// Begins a slip from rest in state `x`, which follows the one that began nearest by.
    pub(super) fn depart(&mut self, sign: f64, x: &State) {
        if self.worked_out {
            if self.slips.len() < SLIPS {
                self.slips.push(std::mem::take(&mut self.present));
            } else {
                std::mem::swap(&mut self.slips[self.oldest], &mut self.present);
                self.oldest = (self.oldest + 1) % SLIPS;
            }
            self.remembered += usize::from(!self.renews);
        }
        let is_fresh = self.worked_out && !self.renews && self.remembered.is_multiple_of(FRESH);
        let is_hard = !self.worked_out && 2 * self.iterations > 3 * self.taken;
        self.hard = if is_hard { self.hard + 1 } else { 0 };
        self.renews = self.hard == HARD;
        self.worked_out = false;
        self.iterations = 0;
        self.present.steps.clear();
        self.present.sign = sign;
        self.present.state = *x;
        self.followed = None;
        self.taken = 0;
        if is_fresh {
            return;
        }
        let mut nearest = f64::INFINITY;
        for (i, slip) in self.slips.iter().enumerate() {
            let distance = self.distance(x, &slip.state);
            if slip.sign == sign && distance < nearest {
                nearest = distance;
                self.followed = Some(i);
            }
        }
    }

    fn distance(&self, a: &State, b: &State) -> f64 {
        let states = a.iter().zip(b).zip(&self.weight);
        states.map(|((a, b), w)| ((a - b) * w).powi(2)).sum()
    }

    /// The step that is expected next.
    pub(super) fn expected(&self) -> Option<&Known> {
        let slip = &self.slips[self.followed?];
        slip.steps.get(self.taken + self.present.steps.len())
    }

    /// Whether the present slip is to be worked out although it need not.
    pub(super) fn renews(&self) -> bool {
        self.renews
    }

    /// How many slips had to be worked out.
    #[cfg(test)]
    pub(super) fn remembered(&self) -> usize {
        self.remembered
    }

    /// Follows no other slip any more.
    pub(super) fn leave(&mut self) {
        self.copy_taken();
        self.followed = None;
    }

    fn copy_taken(&mut self) {
        if let Some(followed) = self.followed {
            let steps = &mut self.present.steps;
            let rest = self.slips[followed].steps.iter().skip(steps.len());
            steps.extend(rest.take(std::mem::take(&mut self.taken)).cloned());
        }
    }

    /// Remembers the next step, which was solved at `level`; the tangent of the characteristic at its last node.
    pub(super) fn remember(&mut self, level: usize, step: &Step) -> Tangent {
        let Some(along) = &step.along else {
            let known = self.expected().expect("taken from a step that is followed");
            let tangent = known.along.last();
            // Only a slip that differs will be remembered.
            self.taken += 1;
            self.iterations += step.iterations;
            if self.worked_out {
                self.copy_taken();
            }
            return tangent;
        };
        self.copy_taken();
        if self.present.steps.len() < STEPS {
            let along = *along;
            self.present.steps.push(Known { level, along });
            self.worked_out = true;
        } else {
            self.followed = None;
        }
        along.last()
    }
}
