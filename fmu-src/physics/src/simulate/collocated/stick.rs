//! Stick: one product of matrix and state for each long step, and the break-away that ends it.

use super::Collocated;
use super::structure::Stuck;
use crate::contact::ContactMode;
use crate::integrate::collocation::{Chebyshev, first_below_zero};

/// Most steps in one piece.
const STEPS: usize = 16;

impl Collocated {
    /// Some steps of stick, ended early where the constraint force exceeds its limit.
    pub(super) fn stick(&mut self) {
        let step = &self.structure.stick;
        let (t, start) = (self.front, self.front_state);
        let mut x = start;
        let mut stuck = Stuck::REST;
        for steps in 0..STEPS {
            step.take(&x, &mut stuck);
            if !(stuck.spread + stuck.force[0].abs() < self.limit)
                && let Some(theta) = self.exceeded(&stuck.force)
            {
                let part = (steps as f64 + theta) * step.length;
                let x = step.state_at(theta * step.length, &x);
                let end = (steps + 1) as f64 * step.length;
                self.piece.begin(t, end, &start, ContactMode::Stuck);
                self.vary_stick(part);
                return self.break_away(t + part, x);
            }
            x = stuck.end;
        }
        let length = STEPS as f64 * step.length;
        self.piece.begin(t, length, &start, ContactMode::Stuck);
        self.vary_stick(length);
        self.go_on(t + length, x);
    }

    /// The earliest of the two ways in which a force can exceed the limit.
    fn exceeded(&self, force: &Chebyshev) -> Option<f64> {
        let gaps = [1.0, -1.0].map(|side| {
            let mut gap = force.map(|c| -side * c);
            gap[0] += self.limit;
            first_below_zero(&gap, 0.0)
        });
        gaps.into_iter().flatten().reduce(f64::min)
    }
}
