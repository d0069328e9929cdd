//! Start states by themselves: others for segments that ended in a wrong basin, and of those that a step leaves behind.

use crate::diagnose::estimation::drawn_starts::random_of;
use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::estimation::fitter::{Fitter, Place, TRIMMED, directions, sum_of_squares};
use crate::diagnose::estimation::scaled_matrix::scaled_inverse;
use crate::diagnose::estimation::sensitivities::Turned;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::SegmentStart;
use crate::diagnose::thresholds::FLOOR_MEDIAN;
use nalgebra::DVector;

/// Shares of a segment over which its start is fitted one after another, and iterations for each.
const GROWING: [(f64, usize); 5] = [(0.12, 4), (0.25, 4), (0.5, 4), (0.75, 4), (1.0, 6)];

/// Fall in nats of a segment's loss that another start must bring: less is what the fit of all gains anyway.
pub(crate) const NOTICED: f64 = 1.0;
/// Iterations by which a start follows a step.
const FOLLOWING: usize = 4;
/// How many of these shares are a segment's beginning.
const BEGINNING: usize = 2;
/// Fall of a segment's sum of squares, as a share of it, below which the fit of its start ends.
const START_TOLERANCE: f64 = 1e-3;
/// How often segments in a wrong basin get other starts where only starts are fitted: what is found may be where the next begins.
const RESTARTS_OF_STATES: usize = 2;
/// Share to which the objective must have fallen before a segment that was not found is looked for again.
const FOUND_ANEW: f64 = 0.7;

/// A segment whose mean square error is above this many times that of the better ones is in a wrong basin.
const WRONG: f64 = 4.0;

impl Fitter<'_, '_> {
    pub(crate) fn sum(&mut self, k: usize, point: &Point) -> f64 {
        sum_of_squares(&self.residual(k, point))
    }

    /// Fits the start states alone, over a growing share of the segments: the beginning of a segment is met from
    /// afar where its end would lead astray. Segments that end in a wrong basin get other starts.
    pub fn fit_initial_states(&mut self, start: Point) -> Fit {
        let mut point = start;
        for k in 0..self.data.segments.len() {
            self.fit_start(k, &mut point, &GROWING);
        }
        let mut here = self.evaluate(point);
        for _ in 0..RESTARTS_OF_STATES {
            self.reinitialise(&mut here);
        }
        self.fit_at(here)
    }

    /// Fits the start states alone from where they are, each over the whole of its segment by at most `iterations` steps: enough
    /// for a model that has changed little since they were found.
    pub fn follow_initial_states(&mut self, start: Point, iterations: usize) -> Fit {
        let mut point = start;
        for k in 0..self.data.segments.len() {
            self.fit_start_over(k, &mut point, iterations);
        }
        let here = self.evaluate(point);
        self.fit_at(here)
    }

    /// Fits the start states of the segments that a step has left behind, at its end. The step is good for all but these: a transition
    /// that a segment grazes makes its motion jump where its derivatives tell of none, and its start state is what lets it follow. So
    /// the start states are eliminated exactly (variable projection, Golub and Pereyra, SIAM J. Numer. Anal. 10 (1973) 413, eq. 3.6)
    /// where to first order is not enough. Nothing is done where more are left behind than a search may lose: the step is too long.
    pub(crate) fn follow(&mut self, next: &mut Place, old: &Place) {
        let rise = |k: usize| self.loss(k, next.sums[k]) - self.loss(k, old.sums[k]);
        let behind: Vec<usize> = (0..next.sums.len())
            .filter(|&k| rise(k) > NOTICED)
            .collect();
        if behind.len() as f64 > TRIMMED * next.sums.len() as f64 {
            return;
        }
        for k in behind {
            self.fit_start_over(k, &mut next.point, FOLLOWING);
            next.residual[k] = self.residual(k, &next.point);
            next.sums[k] = sum_of_squares(&next.residual[k]);
        }
        next.merit = self.trimmed(&next.point, &next.sums);
    }

    /// Fits the start state of one segment alone over growing shares of it, from the start it has in `point`.
    fn fit_start(&mut self, k: usize, point: &mut Point, growing: &[(f64, usize)]) -> f64 {
        let share = self.options.share;
        let mut sum = f64::INFINITY;
        for &(part, iterations) in growing {
            self.options.share = share * part;
            sum = self.fit_start_over(k, point, iterations);
        }
        self.options.share = share;
        sum
    }

    /// The same where most segments are met: as each share is left for a longer one, starts drawn from what it tells are tried there.
    fn fit_start_by_draws(&mut self, k: usize, point: &mut Point) -> f64 {
        let share = self.options.share;
        let mut random = random_of(&self.data.segments[k]);
        let mut sum = f64::INFINITY;
        for (number, (part, iterations)) in GROWING.into_iter().enumerate() {
            let of_shorter = match number {
                0 => None,
                _ => self.start_posterior(k, point),
            };
            self.options.share = share * part;
            if let Some(posterior) = of_shorter {
                self.draw_start(k, point, &posterior, &mut random);
            }
            sum = self.fit_start_over(k, point, iterations);
        }
        self.options.share = share;
        sum
    }

    /// Whether a fit meets segment `k` noticeably better than another one does.
    pub fn is_met_better(&self, k: usize, by: &Fit, than: &Fit) -> bool {
        let loss = |fit: &Fit| self.loss(k, fit.mean_square[k] * self.count(k));
        loss(by) < loss(than) - NOTICED
    }

    /// Puts another start into `point` if, fitted, it lowers the segment's loss by more than chance would; whether it did.
    pub fn try_start(&mut self, k: usize, point: &mut Point, start: SegmentStart) -> bool {
        let mine = point.start(k);
        if mine == start {
            return false;
        }
        let before = self.sum(k, point);
        point.put(k, start);
        let after = self.fit_start(k, point, &GROWING[GROWING.len() - 1..]);
        let is_better = self.loss(k, after) < self.loss(k, before) - NOTICED;
        if !is_better {
            point.put(k, mine);
        }
        is_better
    }

    fn fit_start_over(&mut self, k: usize, point: &mut Point, iterations: usize) -> f64 {
        let mut sum = self.sum(k, point);
        let mut damping = 1e-3;
        for _ in 0..iterations {
            let Some(residual) = self.residual(k, point) else {
                break;
            };
            let l = self.linearise(k, point, residual, Turned::State);
            let list = directions(self.hypothesis, point.stuck[k]);
            let mut xx = l.states.tr_mul(&l.states);
            let mut gx = l.states.tr_mul(&DVector::from_vec(l.residual));
            self.add_state_prior(
                &list,
                &point.states[k],
                sum / self.count(k),
                &mut xx,
                &mut gx,
            );
            let before = sum;
            for _ in 0..4 {
                if let Some(inverse) = scaled_inverse(&xx, damping) {
                    let step = inverse * &gx;
                    let old = point.states[k].clone();
                    for (c, &i) in list.iter().enumerate() {
                        point.states[k][i] += step[c];
                    }
                    let new = self.sum(k, point);
                    if new < sum {
                        sum = new;
                        damping *= 0.1;
                        break;
                    }
                    point.states[k] = old;
                }
                damping *= 10.0;
            }
            if before - sum < START_TOLERANCE * before {
                break;
            }
        }
        sum
    }

    /// The best of other starts for segment `k`: the end of the segment before, followed to the end of the segment at once; with `draws`
    /// the best end to which draws of its start lead ([`super::carried_starts`]), fitted to the whole segment; or else the smoothed state
    /// in either mode of the contact, the better over the beginning followed to the end; where none is good, with `draws` both modes
    /// again with draws from the beginning.
    fn find_start(
        &mut self,
        k: usize,
        point: &mut Point,
        sums: &[f64],
        draws: bool,
        good: impl Fn(&Self, usize, f64) -> bool,
    ) -> (f64, SegmentStart) {
        let segment = &self.data.segments[k];
        let mut best = (f64::INFINITY, point.start(k));
        if k > 0 && self.data.segments[k - 1].run == segment.run && good(self, k - 1, sums[k - 1]) {
            for drawn in [false, true] {
                let (start, growing) = match drawn {
                    false => (self.carried_on(k, point), &GROWING[..]),
                    true if draws => (
                        self.drawn_and_carried_on(k, point),
                        &GROWING[GROWING.len() - 1..],
                    ),
                    true => break,
                };
                let Some(start) = start else {
                    continue;
                };
                point.put(k, start);
                let sum = self.fit_start(k, point, growing);
                if sum < best.0 {
                    best = (sum, point.start(k));
                }
                if good(self, k, sum) {
                    return best;
                }
            }
        }
        let mut smoothed = segment.state.clone();
        smoothed.resize(point.states[k].len(), 0.0);
        let (beginning, rest) = GROWING.split_at(BEGINNING);
        let tried = [!segment.stuck, segment.stuck].map(|stuck| {
            let state = smoothed.clone();
            point.put(k, SegmentStart { state, stuck });
            (self.fit_start(k, point, beginning), point.start(k))
        });
        let better = if tried[0].0 < tried[1].0 { 0 } else { 1 };
        point.put(k, tried[better].1.clone());
        let sum = self.fit_start(k, point, rest);
        if sum < best.0 {
            best = (sum, point.start(k));
        }
        for stuck in [segment.stuck, !segment.stuck] {
            if !draws || good(self, k, best.0) {
                break;
            }
            let state = smoothed.clone();
            point.put(k, SegmentStart { state, stuck });
            let sum = self.fit_start_by_draws(k, point);
            if sum < best.0 {
                best = (sum, point.start(k));
            }
        }
        best
    }

    /// Gives segments that fit far worse than the others another start: the end of the segment before, the
    /// smoothed state, and both with the other mode of the contact.
    pub(crate) fn reinitialise(&mut self, here: &mut Place) {
        let Place {
            point, sums, merit, ..
        } = here;
        let merit = *merit;
        let ratio = |this: &Self, k: usize, sum: f64| {
            let noise = this.data.noise[this.data.segments[k].run];
            sum / (this.count(k) * noise * noise)
        };
        let mut sorted: Vec<f64> = (0..sums.len()).map(|k| ratio(self, k, sums[k])).collect();
        sorted.sort_by(f64::total_cmp);
        // At most the worst third, and only those far above the better half.
        let limit =
            (WRONG * sorted[sorted.len() * 2 / 5].max(1.0)).max(sorted[sorted.len() * 2 / 3]);
        let draws = self.options.draws && sorted[sorted.len() / 2] <= FLOOR_MEDIAN * FLOOR_MEDIAN;
        let mut changed = Vec::new();
        for k in 0..sums.len() {
            // A segment that was not found is looked for again once the model has become better.
            let in_vain = merit > FOUND_ANEW * self.lost_at[k];
            if ratio(self, k, sums[k]) < limit || in_vain {
                continue;
            }
            changed.push(k);
            let old = (sums[k], point.start(k));
            let good = |this: &Self, k, sum| ratio(this, k, sum) < limit;
            let found = self.find_start(k, point, sums, draws, good);
            let best = if found.0 < old.0 { found } else { old };
            if ratio(self, k, best.0) >= limit {
                self.lost_at[k] = merit;
            }
            sums[k] = best.0;
            point.put(k, best.1);
        }
        for k in changed {
            here.residual[k] = self.residual(k, &here.point);
            here.sums[k] = sum_of_squares(&here.residual[k]);
        }
        here.merit = self.trimmed(&here.point, &here.sums);
    }
}
