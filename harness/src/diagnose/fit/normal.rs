//! The weighted normal equations of a fit.

use super::jacobian::Linear;
use super::{Fitter, Place, directions};
use crate::diagnose::knob::{Knob, Scale};
use crate::diagnose::predictor::Point;
use nalgebra::{DMatrix, DVector};

/// Eigenvalue of the matrix scaled to a unit diagonal below which rounding decides.
const LEAST_EIGENVALUE: f64 = 1e-10;

/// The weighted normal equations, with each shot's start state eliminated.
pub(super) struct Normal {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Per shot: H_xx, H_xk, g_x, indices of the states.
    blocks: Vec<Option<Block>>,
    shared: usize,
    /// First column of each run's own knobs.
    own_first: Vec<usize>,
    moves: bool,
}

struct Block {
    xx: DMatrix<f64>,
    xk: DMatrix<f64>,
    gx: DVector<f64>,
    list: Vec<usize>,
    columns: Vec<usize>,
    kk: DMatrix<f64>,
    gk: DVector<f64>,
    /// Whether the shot has a say in the knobs.
    kept: bool,
}

/// Matrix and gradient of the knobs, and the inverse of each shot's block of start states.
type Reduced = (DMatrix<f64>, DVector<f64>, Vec<Option<DMatrix<f64>>>);

impl Normal {
    /// The equations at a place, each shot weighted by the error variance that it has there.
    pub fn assemble(f: &Fitter, here: &Place, linear: &[Option<Linear>]) -> Self {
        let (point, sums) = (&here.point, &here.sums);
        let h = f.hypothesis;
        let shared = h.shared.len();
        let mut own_first = Vec::new();
        let mut size = shared;
        for run in &h.own {
            own_first.push(size);
            size += run.len();
        }
        let mut matrix = DMatrix::zeros(size, size);
        let mut gradient = DVector::zeros(size);
        let mut blocks = Vec::new();
        let kept = f.kept(sums);
        for (k, l) in linear.iter().enumerate() {
            let shot = &f.data.shots[k];
            let Some(l) = l else {
                blocks.push(None);
                continue;
            };
            let weight = f.weight(k, sums[k]);
            let r = DVector::from_column_slice(&l.residual);
            let list = directions(h, point.stuck[k]);
            let mut xx = weight * l.states.tr_mul(&l.states);
            let mut gx = weight * l.states.tr_mul(&r);
            f.add_state_prior(&list, &point.states[k], 1.0, &mut xx, &mut gx);
            let first = own_first[shot.run];
            let columns: Vec<usize> = (0..shared)
                .chain(first..first + h.own[shot.run].len())
                .collect();
            let xk = weight * l.states.tr_mul(&l.knobs);
            let kk = weight * l.knobs.tr_mul(&l.knobs);
            let gk = weight * l.knobs.tr_mul(&r);
            blocks.push(Some(Block {
                xx,
                xk,
                gx,
                list,
                columns,
                kk,
                gk,
                kept: kept[k],
            }));
        }
        let mut prior = |c: usize, knob: &Knob, u: f64, moves: bool| {
            if moves && knob.prior_std > 0.0 {
                let precision = f.precision(knob);
                matrix[(c, c)] += precision;
                gradient[c] -= precision * (u - knob.position(knob.prior));
            } else {
                matrix[(c, c)] += 1.0;
            }
        };
        for (c, knob) in h.shared.iter().enumerate() {
            prior(c, knob, point.shared[c], f.moves(knob));
        }
        for (run, knobs) in h.own.iter().enumerate() {
            for (i, knob) in knobs.iter().enumerate() {
                prior(own_first[run] + i, knob, point.own[run][i], true);
            }
        }
        Self {
            matrix,
            gradient,
            blocks,
            shared,
            own_first,
            moves: f.effort.knobs,
        }
    }

    /// The reduced system of the knobs at a damping: `H + damping diag(H)`.
    fn reduced(&self, damping: f64) -> Option<Reduced> {
        let mut matrix = self.matrix.clone();
        let mut gradient = self.gradient.clone();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] *= 1.0 + damping;
        }
        let mut inverses = Vec::new();
        for block in &self.blocks {
            let Some(b) = block else {
                inverses.push(None);
                continue;
            };
            let inverse = scaled_inverse(&b.xx, damping)?;
            if self.moves && b.kept {
                let t = &inverse * &b.xk;
                let schur = &b.kk - b.xk.tr_mul(&t);
                let reduced = &b.gk - t.tr_mul(&b.gx);
                for (i, &ci) in b.columns.iter().enumerate() {
                    gradient[ci] += reduced[i];
                    for (j, &cj) in b.columns.iter().enumerate() {
                        matrix[(ci, cj)] += schur[(i, j)];
                    }
                    matrix[(ci, ci)] += damping * b.kk[(i, i)];
                }
            }
            inverses.push(Some(inverse));
        }
        Some((matrix, gradient, inverses))
    }

    /// The point after a step; `None` if the damped matrix is not positive definite.
    pub fn step(&self, f: &Fitter, point: &Point, damping: f64) -> Option<Point> {
        let (matrix, gradient, inverses) = self.reduced(damping)?;
        let mut trial = point.clone();
        let mut moved = DVector::zeros(matrix.nrows());
        if self.moves {
            let step = scaled_solve(&matrix, &gradient)?;
            let h = f.hypothesis;
            for c in 0..self.shared {
                if f.moves(&h.shared[c]) {
                    let u = h.shared[c].clamp(point.shared[c] + limited(step[c], &h.shared[c]));
                    moved[c] = u - point.shared[c];
                    trial.shared[c] = u;
                }
            }
            for (run, knobs) in h.own.iter().enumerate() {
                for (i, knob) in knobs.iter().enumerate() {
                    if knob.prior_std > 0.0 {
                        let c = self.own_first[run] + i;
                        let u = knob.clamp(point.own[run][i] + step[c]);
                        moved[c] = u - point.own[run][i];
                        trial.own[run][i] = u;
                    }
                }
            }
        }
        for (k, block) in self.blocks.iter().enumerate() {
            let (Some(b), Some(inverse)) = (block, &inverses[k]) else {
                continue;
            };
            let part = DVector::from_iterator(b.columns.len(), b.columns.iter().map(|&c| moved[c]));
            let step = inverse * (&b.gx - &b.xk * part);
            for (c, &i) in b.list.iter().enumerate() {
                trial.states[k][i] += step[c];
            }
        }
        Some(trial)
    }

    /// Covariance of the shared knobs on their scales.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        let (matrix, _, _) = self.reduced(1e-9)?;
        let inverse = scaled_inverse(&matrix, 1e-9).or_else(|| clamped_inverse(&matrix))?;
        Some(
            inverse
                .view((0, 0), (self.shared, self.shared))
                .into_owned(),
        )
    }
}

/// At most one e-fold of a logarithmic knob at a time.
fn limited(step: f64, knob: &Knob) -> f64 {
    match knob.scale {
        Scale::Log => step.clamp(-0.7, 0.7),
        Scale::Linear => step,
    }
}

fn scaling(matrix: &DMatrix<f64>) -> DVector<f64> {
    DVector::from_iterator(
        matrix.nrows(),
        (0..matrix.nrows()).map(|i| {
            if matrix[(i, i)] > 0.0 {
                matrix[(i, i)].sqrt().recip()
            } else {
                1.0
            }
        }),
    )
}

fn scaled(matrix: &DMatrix<f64>, scale: &DVector<f64>, damping: f64) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        let value = matrix[(i, j)] * scale[i] * scale[j];
        if i == j {
            value.max(1e-14) * (1.0 + damping) + 1e-13
        } else {
            value
        }
    })
}

/// Inverse of a symmetric matrix that rounding has made indefinite: directions that the data leave open get a variance
/// that is large, not negative.
fn clamped_inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let scale = scaling(matrix);
    let scaled = scaled(matrix, &scale, 0.0);
    if scaled.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let eigen = scaled.symmetric_eigen();
    let inverse =
        DMatrix::from_diagonal(&eigen.eigenvalues.map(|v| v.max(LEAST_EIGENVALUE).recip()));
    let inverse = &eigen.eigenvectors * inverse * eigen.eigenvectors.transpose();
    Some(DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        inverse[(i, j)] * scale[i] * scale[j]
    }))
}

fn scaled_solve(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = scaling(matrix);
    let solution = scaled(matrix, &scale, 0.0)
        .cholesky()?
        .solve(&right.component_mul(&scale));
    Some(solution.component_mul(&scale))
}

/// Inverse of a symmetric positive matrix, scaled to a unit diagonal and damped.
pub(in crate::diagnose) fn scaled_inverse(
    matrix: &DMatrix<f64>,
    damping: f64,
) -> Option<DMatrix<f64>> {
    let scale = scaling(matrix);
    let inverse = scaled(matrix, &scale, damping).cholesky()?.inverse();
    Some(DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        inverse[(i, j)] * scale[i] * scale[j]
    }))
}
