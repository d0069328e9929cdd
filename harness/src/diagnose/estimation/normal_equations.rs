//! The weighted normal equations of a fit, and what the evidence pays for all that is free.

use crate::diagnose::estimation::fitter::{Fitter, Place, directions};
use crate::diagnose::estimation::sensitivities::Linear;
use crate::diagnose::model::parameter::{Parameter, Scale};
use crate::diagnose::model::point::Point;
use crate::diagnose::thresholds::STATE_SPREAD;
use nalgebra::{DMatrix, DVector};

/// Eigenvalue of the matrix scaled to a unit diagonal below which rounding decides.
const LEAST_EIGENVALUE: f64 = 1e-13;

/// Damping of matrices that are inverted as they are, relative to the diagonal: far below what beliefs add there, 1e-9 for
/// constants that the data show to 1e-6 and only act together with others.
const LEAST_DAMPING: f64 = 1e-13;

/// The weighted normal equations, with each segment's start state eliminated.
pub(crate) struct Normal {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Per segment: H_xx, H_xk, g_x, indices of the states.
    blocks: Vec<Option<Block>>,
    shared: usize,
    /// First column of each run's own parameters.
    own_first: Vec<usize>,
    moves: bool,
}

struct Block {
    xx: DMatrix<f64>,
    /// H_xx as it is where the segment is met.
    met: DMatrix<f64>,
    xk: DMatrix<f64>,
    gx: DVector<f64>,
    list: Vec<usize>,
    columns: Vec<usize>,
    kk: DMatrix<f64>,
    gk: DVector<f64>,
    /// Whether the segment has a say in the parameters.
    kept: bool,
}

/// Matrix and gradient of the parameters, and the inverse of each segment's block of start states.
type Reduced = (DMatrix<f64>, DVector<f64>, Vec<Option<DMatrix<f64>>>);

impl Normal {
    /// The equations at a place, each segment weighted by the error variance that it has there.
    pub fn assemble(f: &Fitter, here: &Place, linear: &[Option<Linear>]) -> Self {
        let (point, sums) = (&here.point, &here.sums);
        let h = f.hypothesis;
        let shared = h.shared.len();
        let mut own_first = Vec::new();
        let mut size = shared;
        for run in &h.per_run {
            own_first.push(size);
            size += run.len();
        }
        let mut matrix = DMatrix::zeros(size, size);
        let mut gradient = DVector::zeros(size);
        let mut blocks = Vec::new();
        let kept = f.kept(sums);
        for (k, l) in linear.iter().enumerate() {
            let segment = &f.data.segments[k];
            let Some(l) = l else {
                blocks.push(None);
                continue;
            };
            let weight = f.weight(k, sums[k]);
            let r = DVector::from_column_slice(&l.residual);
            let list = directions(h, point.stuck[k]);
            let states = l.states.tr_mul(&l.states);
            let mut met = f.likelihood(k).weight(0.0) * &states;
            let mut xx = weight * states;
            let mut gx = weight * l.states.tr_mul(&r);
            f.add_state_prior(&list, &point.states[k], 1.0, &mut met, &mut gx.clone());
            f.add_state_prior(&list, &point.states[k], 1.0, &mut xx, &mut gx);
            let first = own_first[segment.run];
            let columns: Vec<usize> = (0..shared)
                .chain(first..first + h.per_run[segment.run].len())
                .collect();
            let xk = weight * l.states.tr_mul(&l.parameters);
            let kk = weight * l.parameters.tr_mul(&l.parameters);
            let gk = weight * l.parameters.tr_mul(&r);
            blocks.push(Some(Block {
                xx,
                met,
                xk,
                gx,
                list,
                columns,
                kk,
                gk,
                kept: kept[k],
            }));
        }
        let mut prior = |c: usize, parameter: &Parameter, u: f64, moves: bool| {
            if moves && parameter.prior_std > 0.0 {
                let precision = f.precision(parameter);
                matrix[(c, c)] += precision;
                gradient[c] -= precision * (u - parameter.position(parameter.prior));
            } else {
                matrix[(c, c)] += 1.0;
            }
        };
        for (c, parameter) in h.shared.iter().enumerate() {
            prior(c, parameter, point.shared[c], f.moves(parameter));
        }
        for (run, parameters) in h.per_run.iter().enumerate() {
            for (i, parameter) in parameters.iter().enumerate() {
                prior(own_first[run] + i, parameter, point.per_run[run][i], true);
            }
        }
        Self {
            matrix,
            gradient,
            blocks,
            shared,
            own_first,
            moves: f.options.parameters,
        }
    }

    /// The reduced system of the parameters at a damping: `H + damping diag(H)`.
    pub fn reduced(&self, damping: f64) -> Option<Reduced> {
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
            for (run, parameters) in h.per_run.iter().enumerate() {
                for (i, parameter) in parameters.iter().enumerate() {
                    if parameter.prior_std > 0.0 {
                        let c = self.own_first[run] + i;
                        let u = parameter.clamp(point.per_run[run][i] + step[c]);
                        moved[c] = u - point.per_run[run][i];
                        trial.per_run[run][i] = u;
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

    /// Logarithm of the share of the prior's volume that the posterior takes up, nats: the price of all that is free.
    ///
    /// ```text
    /// -1/2 ln det(S H S) - 1/2 sum_segments ln det(I + T H_xx T)
    /// ```
    ///
    /// with H the reduced information matrix with the priors, S the priors' standard deviations, H_xx the information on a
    /// segment's start state as it is where the segment is met (a lost segment must not be cheaper for that), and T the same scale
    /// for every model: [`STATE_SPREAD`] times the sensor's noise for deflections, times the mode's angular frequency for
    /// velocities, and the prior's for the states of effects. Holds where the posterior is about normal (Laplace);
    /// MacKay, Information Theory, Inference, and Learning Algorithms (2003), eq. 28.10. `None` where the matrix is not
    /// positive definite.
    pub fn occam(&self, f: &Fitter) -> Option<f64> {
        let h = f.hypothesis;
        let (mut matrix, _, _) = self.reduced(LEAST_DAMPING)?;
        let mut free = Vec::new();
        let per_run = h.per_run.iter().enumerate();
        let per_run = per_run.flat_map(|(run, parameters)| {
            let first = self.own_first[run];
            parameters
                .iter()
                .enumerate()
                .map(move |(i, k)| (first + i, k))
        });
        let shared = h.shared.iter().enumerate().filter(|(_, k)| f.moves(k));
        for (c, parameter) in shared.chain(per_run).filter(|(_, k)| k.prior_std > 0.0) {
            let volume = parameter.volume_std();
            matrix[(c, c)] += volume.powi(-2) - parameter.prior_std.powi(-2);
            free.push((c, volume));
        }
        let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            let ((a, s), (b, t)) = (free[i], free[j]);
            matrix[(a, b)] * s * t
        });
        let mut price = log_determinant(&scaled)?;
        for (segment, block) in f.data.segments.iter().zip(&self.blocks) {
            let Some(b) = block else { continue };
            let spread = STATE_SPREAD * f.data.noise[segment.run];
            let scale: Vec<f64> = b
                .list
                .iter()
                .map(|&i| match h.state_scales.get(i) {
                    Some(scale) => scale * spread,
                    None => STATE_SPREAD * h.extra_states[i - h.state_scales.len()].1,
                })
                .collect();
            let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, j| {
                let flat = i == j && b.list[i] < h.state_scales.len();
                f64::from(u8::from(flat)) + b.met[(i, j)] * scale[i] * scale[j]
            });
            price += log_determinant(&scaled)?;
        }
        Some(-0.5 * price)
    }

    /// Covariance of the shared parameters on their scales.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        let (matrix, _, _) = self.reduced(LEAST_DAMPING)?;
        let inverse =
            scaled_inverse(&matrix, LEAST_DAMPING).or_else(|| clamped_inverse(&matrix))?;
        Some(
            inverse
                .view((0, 0), (self.shared, self.shared))
                .into_owned(),
        )
    }
}

/// At most one e-fold of a logarithmic parameter at a time.
fn limited(step: f64, parameter: &Parameter) -> f64 {
    match parameter.scale {
        Scale::Log => step.clamp(-0.7, 0.7),
        Scale::Linear => step,
    }
}

/// Logarithm of the determinant of a symmetric matrix that is positive but for rounding: directions that rounding has made
/// indefinite count with the least eigenvalue that it leaves certain. `None` for what is not finite.
fn log_determinant(matrix: &DMatrix<f64>) -> Option<f64> {
    if matrix.iter().any(|v| !v.is_finite()) {
        return None;
    }
    let scale = scaling(matrix);
    let scaled = scaled(matrix, &scale, 0.0);
    let of_scale: f64 = scale.iter().map(|s| s.ln()).sum();
    let eigenvalues = scaled.symmetric_eigenvalues();
    let of_scaled: f64 = eigenvalues
        .iter()
        .map(|v| v.max(LEAST_EIGENVALUE).ln())
        .sum();
    Some(of_scaled - 2.0 * of_scale)
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
pub(crate) fn scaled_inverse(matrix: &DMatrix<f64>, damping: f64) -> Option<DMatrix<f64>> {
    let scale = scaling(matrix);
    let inverse = scaled(matrix, &scale, damping).cholesky()?.inverse();
    Some(DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        inverse[(i, j)] * scale[i] * scale[j]
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_of_a_determinant_is_that_of_the_product_of_the_eigenvalues() {
        let matrix = DMatrix::from_row_slice(2, 2, &[4e8, 100.0, 100.0, 9e-4]);
        let expected = (4e8_f64 * 9e-4 - 1e4).ln();
        let indefinite = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0 - 1e-15]);
        assert!(
            (log_determinant(&(matrix * 10.0)).unwrap() - expected - 100.0_f64.ln()).abs() < 1e-9
        );
        assert!(log_determinant(&indefinite).is_some_and(f64::is_finite));
        assert_eq!(
            log_determinant(&DMatrix::from_element(1, 1, f64::NAN)),
            None
        );
    }
}
