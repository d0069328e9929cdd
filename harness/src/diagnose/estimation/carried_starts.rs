//! Start states that the segment before leads to.
//!
//! In stick the tip goes with the belt whatever the beam does inside: a segment that begins there tells of its second mode only when the
//! contact breaks away, and a start state that misses the break-away has no derivatives that lead there. The segment before has seen
//! that mode slip. Its start state is known as [`drawn_starts`](super::drawn_starts) has it, and the motion from a draw of that, followed
//! through both segments, is a draw of what both tell (the prediction and weighting of a particle filter: Gordon, Salmond and Smith, IEE
//! Proceedings F 140 (1993) 107, sect. 3). Holds where the segment before is met.

use crate::diagnose::estimation::drawn_starts::{DRAWS, random_of};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::SegmentStart;

impl Fitter<'_, '_> {
    /// Where the motion is at the beginning of segment `k` when it goes on from the segment before in the same run; `None` without one, or
    /// where the motion ran away.
    pub(crate) fn carried_on(&mut self, k: usize, point: &Point) -> Option<SegmentStart> {
        let before = k.checked_sub(1)?;
        let (from, to) = (&self.data.segments[before], &self.data.segments[k]);
        if from.run != to.run {
            return None;
        }
        let residual = self.residual(before, point)?;
        let rows = self.used(from).div_ceil(self.options.stride);
        if self.predicted(before, &residual) < rows {
            return None;
        }
        let own = &point.per_run[to.run];
        let carried = self.simulator.carry_on(to, &point.shared, own).ok()?;
        let is_finite = carried.state.iter().all(|x| x.is_finite());
        is_finite.then_some(carried)
    }

    /// That of the draws of the start of the segment before with which segment `k` is met best, as it arrives there; `None` where the
    /// segment before lies further back than it is long, so that a draw would tell nothing.
    pub(crate) fn drawn_and_carried_on(&mut self, k: usize, point: &Point) -> Option<SegmentStart> {
        let before = k.checked_sub(1)?;
        let (from, to) = (&self.data.segments[before], &self.data.segments[k]);
        if !to.follows(from) {
            return None;
        }
        let posterior = self.start_posterior(before, point)?;
        let mut random = random_of(to);
        let mut trial = point.clone();
        let mut best: Option<(f64, SegmentStart)> = None;
        for _ in 0..DRAWS {
            let centre = &point.states[before];
            posterior.draw(centre, &mut random, &mut trial.states[before]);
            let Some(start) = self.carried_on(k, &trial) else {
                continue;
            };
            trial.put(k, start.clone());
            let sum = self.sum(k, &trial);
            if best.as_ref().is_none_or(|(least, _)| sum < *least) {
                best = Some((sum, start));
            }
        }
        best.map(|(_, start)| start)
    }

    /// Tries for each segment the starts that the segment before leads to, where that is met; whether one lowers a loss by more than chance
    /// would.
    pub fn try_carried_on(&mut self, point: &mut Point) -> bool {
        let mut any = false;
        for k in 1..self.data.segments.len() {
            let sum = self.sum(k - 1, point);
            if self.likelihood(k - 1).is_lost(sum) {
                continue;
            }
            let carried = self.carried_on(k, point);
            any |= carried.is_some_and(|start| self.try_start(k, point, start));
            let drawn = self.drawn_and_carried_on(k, point);
            any |= drawn.is_some_and(|start| self.try_start(k, point, start));
        }
        any
    }
}
