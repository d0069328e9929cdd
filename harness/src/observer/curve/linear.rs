//! Normal equations about a guess, and the step they give.

use super::OUTLIER;
use super::guess::Guess;
use super::search::Search;
use nalgebra::{DMatrix, DVector};

/// Normal equations about a guess.
pub(super) struct Linear {
    pub(super) cost: f64,
    pub(super) sum: f64,
    pub(super) count: f64,
    pub(super) weights: Vec<f64>,
    /// Over the node values, with the roughness.
    pub(super) mu: DMatrix<f64>,
    pub(super) mu_gradient: DVector<f64>,
    /// Per event: over the start state, mixed, and gradient.
    pub(super) events: Vec<(DMatrix<f64>, DMatrix<f64>, DVector<f64>)>,
}

impl Search<'_> {
    pub(super) fn cost(&self, guess: &Guess, weights: &[f64]) -> f64 {
        let mu = self.nodes(guess.form, &guess.parameters);
        let fit: f64 = self
            .shots
            .iter()
            .zip(&guess.starts)
            .zip(weights)
            .map(|((shot, start), weight)| {
                weight * self.deviations(shot, start, &mu).norm_squared()
            })
            .sum();
        fit + self.roughness_cost(guess)
    }

    pub(super) fn linearise(&self, guess: &Guess) -> Linear {
        let n = guess.parameters.len();
        let here = self.nodes(guess.form, &guess.parameters);
        let bending = self.bending(guess.form);
        let bases: Vec<DVector<f64>> = self
            .shots
            .iter()
            .zip(&guess.starts)
            .map(|(shot, start)| self.deviations(shot, start, &here))
            .collect();
        let rms: Vec<f64> = bases
            .iter()
            .map(|b| (b.norm_squared() / b.len() as f64).sqrt())
            .collect();
        let mut sorted = rms.clone();
        sorted.sort_by(f64::total_cmp);
        let bound = OUTLIER * sorted[sorted.len() / 2];
        let weights: Vec<f64> = rms.iter().map(|r| (bound / r).min(1.0).powi(2)).collect();
        let mut out = Linear {
            cost: self.roughness_cost(guess),
            sum: 0.0,
            count: 0.0,
            mu_gradient: &bending * guess.departure(),
            mu: bending,
            events: Vec::new(),
            weights,
        };
        for (i, (shot, start)) in self.shots.iter().zip(&guess.starts).enumerate() {
            let base = &bases[i];
            let weight = out.weights[i];
            let by_mu = DMatrix::from_columns(
                &(0..n)
                    .map(|node| {
                        let mut beside = guess.parameters.clone();
                        beside[node] += 1e-6;
                        let mu = self.nodes(guess.form, &beside);
                        (self.deviations(shot, start, &mu) - base) / 1e-6
                    })
                    .collect::<Vec<_>>(),
            );
            let by_start = DMatrix::from_columns(
                &(0..self.scale.len())
                    .map(|state| {
                        let mut x = *start;
                        x[state] += 1e-7 * self.scale[state];
                        (self.deviations(shot, &x, &here) - base) / 1e-7
                    })
                    .collect::<Vec<_>>(),
            );
            out.cost += weight * base.norm_squared();
            out.sum += weight * base.norm_squared();
            out.count += weight * base.len() as f64;
            out.mu += weight * by_mu.tr_mul(&by_mu);
            out.mu_gradient += weight * by_mu.tr_mul(base);
            out.events.push((
                weight * by_start.tr_mul(&by_start),
                weight * by_start.tr_mul(&by_mu),
                weight * by_start.tr_mul(base),
            ));
        }
        out
    }

    /// Normal equations of the node values with the start states eliminated (Schur complement).
    pub(super) fn reduced(&self, linear: &Linear, damping: f64) -> (DMatrix<f64>, DVector<f64>) {
        let mut matrix = linear.mu.clone();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] *= 1.0 + damping;
        }
        let mut gradient = linear.mu_gradient.clone();
        for (own, mixed, own_gradient) in &linear.events {
            let solved = damped(own, damping);
            matrix -= mixed.tr_mul(&(&solved * mixed));
            gradient -= mixed.tr_mul(&(&solved * own_gradient));
        }
        (matrix, gradient)
    }

    pub(super) fn step(&self, guess: &Guess, linear: &Linear, damping: f64) -> Guess {
        let (matrix, gradient) = self.reduced(linear, damping);
        let mut out = guess.clone();
        let Some(change) = matrix.lu().solve(&-gradient) else {
            return out;
        };
        for (parameter, change) in out.parameters.iter_mut().zip(change.iter()) {
            *parameter += change;
        }
        for (start, (own, mixed, own_gradient)) in out.starts.iter_mut().zip(&linear.events) {
            let change_of_start = -damped(own, damping) * (own_gradient + mixed * &change);
            for (i, change) in change_of_start.iter().enumerate() {
                start[i] += change * self.scale[i];
            }
        }
        out
    }
}

/// Inverse of a start state's normal matrix; the direction that leaves stick is projected out by
/// the simulation, so it is singular without a ridge.
fn damped(own: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let mut matrix = own.clone();
    let ridge = 1e-10 * own.amax();
    for i in 0..matrix.nrows() {
        matrix[(i, i)] = matrix[(i, i)] * (1.0 + damping) + ridge;
    }
    let size = matrix.nrows();
    matrix
        .cholesky()
        .map_or_else(|| DMatrix::zeros(size, size), |c| c.inverse())
}
