//! Symmetric matrices of quantities of many sizes, scaled to a unit diagonal before anything is done with them.

use nalgebra::{DMatrix, DVector};

/// Eigenvalue of the matrix scaled to a unit diagonal below which rounding decides.
const LEAST_EIGENVALUE: f64 = 1e-13;

/// Logarithm of the determinant of a symmetric matrix that is positive but for rounding: directions that rounding has made
/// indefinite count with the least eigenvalue that it leaves certain. `None` for what is not finite.
pub(crate) fn log_determinant(matrix: &DMatrix<f64>) -> Option<f64> {
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
pub(crate) fn clamped_inverse(matrix: &DMatrix<f64>) -> Option<DMatrix<f64>> {
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

pub(crate) fn scaled_solve(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
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
