//! The smoother: backwards through what the filter left.

use super::filter::{Fixed, Gain, close};
use super::small_matrix::{
    Matrix, Vector, axpy, dot, quadratic, times, transposed_congruence, transposed_times,
};
use super::{OUTPUTS, Solution};
use crate::observer::structure::DiscreteModel;

/// What the filter leaves for the smoother.
pub(super) struct Forward<const N: usize> {
    pub(super) states: Vec<Vector<N>>,
    pub(super) innovation: Vec<f64>,
    pub(super) held_innovation: Vec<f64>,
    pub(super) number: Vec<u32>,
    pub(super) gains: Vec<Gain<N>>,
}

impl<const N: usize> Fixed<'_, N> {
    pub(super) fn backward(
        &self,
        forward: &Forward<N>,
        model: &DiscreteModel,
        solution: &mut Solution,
    ) {
        let n = self.measured.len();
        let f = model.force_index;
        let mut unit = [0.0; N];
        unit[f] = 1.0;
        let directions = [unit, self.displacement, self.velocity];
        let mut lambda = [0.0; N];
        // Information of the later samples, without and with the present one.
        let mut information: Matrix<N> = [[0.0; N]; N];
        let mut seen = information;
        let mut variance = [0.0; OUTPUTS];
        // Set while the information stays at its converged value for this gain.
        let mut steady: Option<u32> = None;
        for k in (0..n).rev() {
            let number = forward.number[k];
            let gain = &forward.gains[number as usize];
            let held = self.known_at(k).map(|known| self.row(known));
            if let Some(row) = &held {
                let e = forward.held_innovation[k];
                let t = e / gain.held_variance - dot(&gain.held_gain, &lambda);
                axpy(&mut lambda, t, row);
            }
            if gain.variance.is_finite() {
                let t = forward.innovation[k] / gain.variance - dot(&gain.gain, &lambda);
                axpy(&mut lambda, t, &self.c);
            }
            let p = &gain.covariance;
            let mut x = forward.states[k];
            for (x, row) in x.iter_mut().zip(p) {
                *x += dot(row, &lambda);
            }
            solution.states[k * solution.size..(k + 1) * solution.size]
                .copy_from_slice(&x[..solution.size]);
            if steady != Some(number) {
                steady = None;
                seen = information;
                if let Some(row) = &held {
                    absorb(&mut seen, row, &gain.held_gain, gain.held_variance);
                }
                if gain.variance.is_finite() {
                    absorb(&mut seen, &self.c, &gain.gain, gain.variance);
                }
                for (variance, u) in variance.iter_mut().zip(&directions) {
                    let pu = times(p, u);
                    *variance = (dot(u, &pu) - quadratic(&seen, &pu)).max(0.0);
                }
            }
            for (out, value) in solution.variance.iter_mut().zip(variance) {
                out[k] = value;
            }
            if k > 0 && !solution.increments.is_empty() {
                let q = self.noise_at(k - 1);
                for (state, out) in solution.increments.iter_mut().enumerate() {
                    let row = &q[f + state];
                    let mean = dot(row, &lambda);
                    out[k - 1] = mean * mean + row[f + state] - quadratic(&seen, row);
                }
            }
            lambda = transposed_times(&self.a, &lambda);
            if steady.is_none() {
                let next = transposed_congruence(&self.a, &seen);
                let uniform = k > 0 && forward.number[k - 1] == number;
                if self.converge && uniform && close(&information, &next) {
                    steady = Some(number);
                }
                information = next;
            }
        }
    }
}

/// Takes a measurement into the smoother's information: `(I - K c)' M (I - K c) + c' c / s`.
fn absorb<const N: usize>(m: &mut Matrix<N>, row: &Vector<N>, gain: &Vector<N>, s: f64) {
    let h = times(m, gain);
    let t = dot(gain, &h) + 1.0 / s;
    for i in 0..N {
        for j in 0..=i {
            let value = m[i][j] - row[i] * h[j] - h[i] * row[j] + t * row[i] * row[j];
            m[i][j] = value;
            m[j][i] = value;
        }
    }
}
