//! Derivatives of a shot's prediction by its start state and by the knobs.

use super::{Fitter, LOST, Place, directions};
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::knob::Knob;
use crate::diagnose::predictor::Point;
use crate::diagnose::shot::Shot;
use nalgebra::{DMatrix, DVector};

/// A shot's prediction, linearised.
pub(super) struct Linear {
    /// Measured less predicted displacement in m.
    pub residual: Vec<f64>,
    /// Derivatives of the prediction by the start state, in the order of [`directions`].
    pub states: DMatrix<f64>,
    /// Derivatives by the shared knobs, then by the run's own.
    pub knobs: DMatrix<f64>,
}

impl Fitter<'_, '_> {
    /// All shots, linearised by differences.
    pub(super) fn linearise_all(&mut self, here: &Place) -> Vec<Option<Linear>> {
        (0..self.data.shots.len())
            .map(|k| {
                let residual = here.residual[k].clone()?;
                Some(self.linearise(k, &here.point, residual))
            })
            .collect()
    }

    /// Derivatives for one shot by differences.
    pub(super) fn linearise(&mut self, k: usize, point: &Point, residual: Vec<f64>) -> Linear {
        let shot = &self.data.shots[k];
        let h = self.hypothesis;
        let n = residual.len();
        let noise = self.data.noise[shot.run];
        let used = self.used(shot);
        let target = (0.3 * noise).max(3e-9);
        let stuck = point.stuck[k];
        let list = directions(h, stuck);
        let own = h.own[shot.run].len();
        let mut states = DMatrix::zeros(n, list.len());
        let mut knobs = DMatrix::zeros(n, h.shared.len() + own);
        let mut trial = Point {
            shared: point.shared.clone(),
            own: vec![Vec::new(); point.own.len()],
            states: Vec::new(),
            stuck: Vec::new(),
        };
        trial.own[shot.run] = point.own[shot.run].clone();
        let mut state = point.states[k].clone();
        let stride = self.effort.stride;
        let mut out = Vec::new();
        let mut column =
            |this: &mut Self, trial: &Point, state: &[f64], step: f64, into: &mut [f64]| -> f64 {
                let done = this.predictor.predict(
                    shot,
                    &trial.shared,
                    &trial.own[shot.run],
                    state,
                    stuck,
                    used,
                    stride,
                    &mut out,
                );
                let mut norm = 0.0;
                if matches!(done, Ok(true)) {
                    for (i, y) in out.iter().enumerate() {
                        let changed = if shot.trusted[i * stride] {
                            shot.measured[i * stride] - y
                        } else {
                            0.0
                        };
                        let slope = (residual[i] - changed) / step;
                        into[i] = if slope.is_finite() { slope } else { 0.0 };
                        norm += into[i] * into[i];
                    }
                }
                (norm / n as f64).sqrt() * step.abs()
            };
        for (c, &i) in list.iter().enumerate() {
            let step = self.state_step[i];
            state[i] += step;
            let response = column(
                self,
                &trial,
                &state,
                step,
                states.column_mut(c).as_mut_slice(),
            );
            state[i] = point.states[k][i];
            adapt(&mut self.state_step[i], response, target);
        }
        if self.effort.knobs {
            if self.effort.shared {
                for c in 0..h.shared.len() {
                    let knob = &h.shared[c];
                    let step = towards_inside(knob, point.shared[c], self.shared_step[c]);
                    trial.shared[c] += step;
                    let response = column(
                        self,
                        &trial,
                        &state,
                        step,
                        knobs.column_mut(c).as_mut_slice(),
                    );
                    trial.shared[c] = point.shared[c];
                    adapt(&mut self.shared_step[c], response, target);
                }
            }
            for c in 0..own {
                let knob = &h.own[shot.run][c];
                let outside = knob.support.is_some_and(|(low, high)| {
                    shot.travel_end.max(shot.travel) < low
                        || shot.travel.min(shot.travel_end) > high
                });
                if knob.prior_std == 0.0 || outside {
                    continue;
                }
                if knob.is_offset() {
                    // Added to the displacement as it is.
                    for (i, row) in (0..used).step_by(stride).enumerate() {
                        knobs[(i, h.shared.len() + c)] = f64::from(u8::from(shot.trusted[row]));
                    }
                    continue;
                }
                let at = point.own[shot.run][c];
                let step = towards_inside(knob, at, self.own_step[shot.run][c]);
                trial.own[shot.run][c] += step;
                let response = column(
                    self,
                    &trial,
                    &state,
                    step,
                    knobs.column_mut(h.shared.len() + c).as_mut_slice(),
                );
                trial.own[shot.run][c] = at;
                if knob.support.is_none() {
                    adapt(&mut self.own_step[shot.run][c], response, target);
                }
            }
        }
        Linear {
            residual,
            states,
            knobs,
        }
    }

}

/// Keeps difference quotients in the linear range: the response should be a fraction of the noise.
fn adapt(step: &mut f64, response: f64, target: f64) {
    if response > 0.0 && response.is_finite() {
        *step *= (target / response).clamp(0.2, 5.0).powf(0.5);
    }
}

/// A step that stays within the knob's bounds.
fn towards_inside(knob: &Knob, at: f64, step: f64) -> f64 {
    if knob.clamp(at + step) == at + step {
        step
    } else {
        -step
    }
}


/// Broyden's rank-one update after a step (Broyden 1965, method 1), with each direction measured by the
/// response that it has: `J += (dy - J dx) (D dx)' D / |D dx|^2`, D the norms of the columns of J. Shots that
/// left their basin wait for the next Jacobian.
pub(super) fn update(
    linear: &mut [Option<Linear>],
    h: &Hypothesis,
    shots: &[Shot],
    old: &Place,
    new: &Place,
) {
    for k in 0..linear.len() {
        let lost = new.sums[k] > LOST * old.sums[k];
        let (Some(l), Some(after), false) = (&mut linear[k], &new.residual[k], lost) else {
            linear[k] = None;
            continue;
        };
        let run = shots[k].run;
        let difference = |a: &[f64], b: &[f64], i: usize| b[i] - a[i];
        let states = DVector::from_iterator(
            l.states.ncols(),
            directions(h, old.point.stuck[k])
                .into_iter()
                .map(|i| difference(&old.point.states[k], &new.point.states[k], i)),
        );
        let knobs = DVector::from_iterator(
            l.knobs.ncols(),
            (0..h.shared.len())
                .map(|i| difference(&old.point.shared, &new.point.shared, i))
                .chain(
                    (0..h.own[run].len())
                        .map(|i| difference(&old.point.own[run], &new.point.own[run], i)),
                ),
        );
        let mut error = DVector::from_iterator(
            after.len(),
            l.residual.iter().zip(after).map(|(before, after)| before - after),
        );
        error -= &l.states * &states + &l.knobs * &knobs;
        let weights = |matrix: &DMatrix<f64>, step: &DVector<f64>| -> Vec<f64> {
            (0..matrix.ncols())
                .map(|i| matrix.column(i).norm_squared() * step[i])
                .collect()
        };
        let (by_state, by_knob) = (weights(&l.states, &states), weights(&l.knobs, &knobs));
        let length: f64 = by_state.iter().zip(&states).map(|(w, d)| w * d).sum::<f64>()
            + by_knob.iter().zip(&knobs).map(|(w, d)| w * d).sum::<f64>();
        if length > 0.0 {
            for (i, w) in by_state.iter().enumerate() {
                l.states.column_mut(i).axpy(w / length, &error, 1.0);
            }
            for (i, w) in by_knob.iter().enumerate() {
                l.knobs.column_mut(i).axpy(w / length, &error, 1.0);
            }
        }
        l.residual.clone_from(after);
    }
}
