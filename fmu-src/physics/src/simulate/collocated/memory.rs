//! Slips of the same run, remembered: a motion that nearly repeats makes nearly the same steps again, which then take few
//! iterations.

use crate::integrate::State;
use crate::integrate::collocation::{Along, Oscillator, Tangent};

/// Slips that are remembered.
const SLIPS: usize = 16;
/// Steps of a slip that are remembered.
const STEPS: usize = 48;
/// One slip of so many follows no other: following only ever makes steps shorter. A prime, so that the slips of a motion
/// of many periods take turns.
const FRESH: usize = 11;

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
            self.remembered += 1;
        }
        self.present.steps.clear();
        self.present.sign = sign;
        self.present.state = *x;
        self.followed = None;
        if std::mem::take(&mut self.worked_out) && self.remembered.is_multiple_of(FRESH) {
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
        slip.steps.get(self.present.steps.len())
    }

    /// How many slips had to be worked out.
    #[cfg(test)]
    pub(super) fn remembered(&self) -> usize {
        self.remembered
    }

    /// Follows no other slip any more.
    pub(super) fn leave(&mut self) {
        self.followed = None;
    }

    /// Remembers the next step, with the characteristic along it if that was worked out; its tangent at the last node.
    pub(super) fn remember(&mut self, level: usize, along: Option<&Along>) -> Tangent {
        let place = self.present.steps.len();
        let (along, worked_out) = match (along, self.followed) {
            (Some(along), _) => (along, true),
            (None, Some(followed)) => (&self.slips[followed].steps[place].along, false),
            (None, None) => unreachable!("taken from a step that is not followed"),
        };
        let tangent = along.last();
        if place < STEPS {
            let along = *along;
            self.present.steps.push(Known { level, along });
            self.worked_out |= worked_out;
        } else {
            self.followed = None;
        }
        tangent
    }
}
