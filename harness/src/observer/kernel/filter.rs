//! The filter: forwards through the record, one sample after the other.

use super::small_matrix::{
    Matrix, Vector, add_scaled, axpy, congruence, dot, matrix, times, vector,
};
use super::{CONVERGED, Known, Problem};

/// What the filter knows at one sample before it sees it, and the gains there.
#[derive(Clone, Copy)]
pub(super) struct Gain<const N: usize> {
    pub(super) covariance: Matrix<N>,
    pub(super) gain: Vector<N>,
    /// Innovation variance; infinite where there is no sample.
    pub(super) variance: f64,
    /// The same for what else is known, applied after what is measured.
    pub(super) held_gain: Vector<N>,
    pub(super) held_variance: f64,
}

pub(super) struct Fixed<'a, const N: usize> {
    pub(super) a: Matrix<N>,
    /// Row of what is measured.
    pub(super) c: Vector<N>,
    pub(super) displacement: Vector<N>,
    pub(super) velocity: Vector<N>,
    pub(super) noise: Matrix<N>,
    pub(super) varying: Vec<(Matrix<N>, &'a [f64])>,
    pub(super) r: f64,
    pub(super) force_index: usize,
    pub(super) measured: &'a [f64],
    pub(super) known: Option<&'a [Known]>,
    pub(super) start: Vector<N>,
    pub(super) start_covariance: Matrix<N>,
    pub(super) converge: bool,
}

impl<'a, const N: usize> Fixed<'a, N> {
    pub(super) fn new(problem: &'a Problem) -> Self {
        Self {
            a: matrix(&problem.model.transition),
            c: vector(&problem.model.reading),
            displacement: vector(&problem.model.output),
            velocity: vector(&problem.model.velocity),
            noise: matrix(&problem.noise),
            varying: problem
                .varying
                .iter()
                .map(|v| (matrix(v.unit), v.level))
                .collect(),
            r: problem.measurement_variance,
            force_index: problem.model.force_index,
            measured: problem.measured,
            known: problem.known,
            start: vector(&problem.start),
            start_covariance: matrix(&problem.start_covariance),
            converge: problem.converge && problem.varying.is_empty(),
        }
    }

    pub(super) fn known_at(&self, k: usize) -> Option<&Known> {
        self.known
            .map(|known| &known[k])
            .filter(|k| k.is_something())
    }

    /// The row of something known over the states.
    pub(super) fn row(&self, known: &Known) -> Vector<N> {
        let mut row = self.velocity.map(|v| v * known.velocity);
        row[self.force_index] += known.force;
        row
    }

    /// Process noise covariance of interval `k` to `k + 1`.
    pub(super) fn noise_at(&self, k: usize) -> Matrix<N> {
        let mut q = self.noise;
        for (unit, level) in &self.varying {
            add_scaled(&mut q, unit, level[k]);
        }
        q
    }

    pub(super) fn gain(
        &self,
        covariance: &Matrix<N>,
        seen: bool,
        known: Option<&Known>,
    ) -> (Gain<N>, Matrix<N>) {
        let mut p = *covariance;
        let mut out = Gain {
            covariance: *covariance,
            gain: [0.0; N],
            variance: f64::INFINITY,
            held_gain: [0.0; N],
            held_variance: f64::INFINITY,
        };
        if seen {
            (out.gain, out.variance) = measure(&mut p, &self.c, self.r);
        }
        if let Some(known) = known {
            (out.held_gain, out.held_variance) = measure(&mut p, &self.row(known), known.variance);
        }
        (out, p)
    }

    /// Runs the filter; `visit(k, predicted state, gain number, gain, innovation, held innovation)`.
    pub(super) fn filter(&self, mut visit: impl FnMut(usize, &Vector<N>, u32, &Gain<N>, f64, f64)) {
        let mut x = self.start;
        let mut p = self.start_covariance;
        let mut number = 0_u32;
        let mut steady: Option<Gain<N>> = None;
        for (k, &y) in self.measured.iter().enumerate() {
            let (seen, known) = (!y.is_nan(), self.known_at(k));
            let gain = match steady {
                Some(gain) if seen && known.is_none() => gain,
                _ => {
                    steady = None;
                    number += u32::from(k > 0);
                    let (gain, filtered) = self.gain(&p, seen, known);
                    let mut next = congruence(&self.a, &filtered);
                    add_scaled(&mut next, &self.noise, 1.0);
                    for (unit, level) in &self.varying {
                        add_scaled(&mut next, unit, level[k]);
                    }
                    if self.converge && seen && known.is_none() && close(&p, &next) {
                        steady = Some(gain);
                    } else {
                        p = next;
                    }
                    gain
                }
            };
            let e = if seen { y - dot(&self.c, &x) } else { 0.0 };
            let mut filtered = x;
            axpy(&mut filtered, e, &gain.gain);
            let mut e_held = 0.0;
            if let Some(known) = known {
                e_held = known.value - dot(&self.row(known), &filtered);
                axpy(&mut filtered, e_held, &gain.held_gain);
            }
            visit(k, &x, number, &gain, e, e_held);
            x = times(&self.a, &filtered);
        }
    }
}

/// Scalar measurement `row x` with variance `r`: gain, innovation variance; `p` is updated.
pub(super) fn measure<const N: usize>(
    p: &mut Matrix<N>,
    row: &Vector<N>,
    r: f64,
) -> (Vector<N>, f64) {
    let h = times(p, row);
    let s = dot(row, &h) + r;
    let gain = h.map(|h| h / s);
    for i in 0..N {
        for j in 0..=i {
            let value = p[i][j] - gain[i] * h[j] - h[i] * gain[j] + s * gain[i] * gain[j];
            p[i][j] = value;
            p[j][i] = value;
        }
    }
    (gain, s)
}

pub(super) fn close<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> bool {
    (0..N).all(|i| {
        (0..=i).all(|j| (a[i][j] - b[i][j]).abs() <= CONVERGED * (a[i][i] * a[j][j]).abs().sqrt())
    })
}
