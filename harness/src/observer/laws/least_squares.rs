//! Weighted nonlinear least squares of a law's parameters, with intervals.

use super::{FittedParameter, FrictionLaw, LawFit, LawPoints, chi_squared, criterion, residual};
use crate::observer::dwell::student;
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::{DMatrix, DVector, Dyn, Owned};

/// Whether a parameter is searched by its logarithm (it is positive) or as it is.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Scale {
    Log,
    Linear,
}

impl Scale {
    fn outer(self, x: f64) -> f64 {
        match self {
            Scale::Log => x.exp(),
            Scale::Linear => x,
        }
    }

    fn inner(self, value: f64) -> f64 {
        match self {
            Scale::Log => value.ln(),
            Scale::Linear => value,
        }
    }
}

pub(super) type Start<'a> = (&'static str, &'static str, Scale, f64);

/// Weighted least squares (Levenberg 1944, Marquardt 1963), intervals from the curvature, widened
/// where the law does not fit within the errors.
pub(super) fn fit(
    points: &LawPoints,
    start: &[Start],
    build: impl Fn(&[f64]) -> FrictionLaw,
) -> Option<LawFit> {
    let inner: Vec<f64> = start
        .iter()
        .map(|(_, _, scale, v)| scale.inner(*v))
        .collect();
    let problem = Fit {
        points,
        scales: start.iter().map(|s| s.2).collect(),
        at: DVector::from_vec(inner),
        build: &build,
    };
    let (solved, _) = LevenbergMarquardt::new()
        .with_patience(200)
        .minimize(problem);
    let law = solved.law(&solved.at);
    let degrees = (points.mu.len() as f64 - start.len() as f64).max(1.0);
    let chi = chi_squared(points, &law);
    if !chi.is_finite() {
        return None;
    }
    let jacobian = solved.jacobian()?;
    let variance = variances(jacobian.transpose() * &jacobian);
    let widen = (chi / degrees).max(1.0).sqrt() * student(degrees);
    let parameters = start
        .iter()
        .enumerate()
        .map(|(i, (name, unit, scale, _))| {
            let half = widen * variance[i].sqrt();
            FittedParameter {
                name,
                unit,
                value: scale.outer(solved.at[i]),
                low: scale.outer(solved.at[i] - half),
                high: scale.outer(solved.at[i] + half),
            }
        })
        .collect();
    Some(LawFit {
        parameters,
        residual: residual(points, &law),
        criterion: criterion(points, &law, start.len()),
        law,
    })
}

/// Variances of the parameters from their information matrix; infinite where the points do not
/// determine a parameter, alone or against others.
fn variances(information: DMatrix<f64>) -> Vec<f64> {
    let n = information.nrows();
    let scale: Vec<f64> = (0..n).map(|i| information[(i, i)].sqrt()).collect();
    // Of unit diagonal, so that the parameters' sizes do not count; a parameter without any effect
    // keeps a zero row.
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        let size = scale[i] * scale[j];
        if size > 0.0 {
            information[(i, j)] / size
        } else {
            0.0
        }
    });
    let eigen = scaled.symmetric_eigen();
    let largest = eigen.eigenvalues.amax();
    (0..n)
        .map(|i| {
            let shares = (0..n).map(|k| {
                let part = eigen.eigenvectors[(i, k)].powi(2);
                let value = eigen.eigenvalues[k];
                if value > UNDETERMINED * largest {
                    part / value
                } else if part > PART {
                    f64::INFINITY
                } else {
                    0.0
                }
            });
            shares.sum::<f64>() / scale[i].powi(2)
        })
        .map(|variance| {
            if variance.is_nan() {
                f64::INFINITY
            } else {
                variance
            }
        })
        .collect()
}

/// Share of the largest eigenvalue below which a combination of parameters has no visible effect.
const UNDETERMINED: f64 = 1e-12;
/// Share of such a combination from which on a parameter counts as part of it.
const PART: f64 = 1e-6;

struct Fit<'a, B> {
    points: &'a LawPoints,
    scales: Vec<Scale>,
    at: DVector<f64>,
    build: &'a B,
}

impl<B: Fn(&[f64]) -> FrictionLaw> Fit<'_, B> {
    fn law(&self, at: &DVector<f64>) -> FrictionLaw {
        let values: Vec<f64> = self
            .scales
            .iter()
            .zip(at.iter())
            .map(|(s, x)| s.outer(*x))
            .collect();
        (self.build)(&values)
    }

    fn deviations(&self, at: &DVector<f64>) -> DVector<f64> {
        let law = self.law(at);
        let p = self.points;
        DVector::from_fn(p.mu.len(), |i, _| {
            (law.mu(p.speed[i]) - p.mu[i]) / p.error[i]
        })
    }
}

impl<B: Fn(&[f64]) -> FrictionLaw> LeastSquaresProblem<f64, Dyn, Dyn> for Fit<'_, B> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, x: &DVector<f64>) {
        self.at.copy_from(x);
    }

    fn params(&self) -> DVector<f64> {
        self.at.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.deviations(&self.at))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let h = 1e-5;
        let columns: Vec<DVector<f64>> = (0..self.at.len())
            .map(|i| {
                let mut beside = self.at.clone();
                beside[i] += h;
                let after = self.deviations(&beside);
                beside[i] -= 2.0 * h;
                (after - self.deviations(&beside)) / (2.0 * h)
            })
            .collect();
        Some(DMatrix::from_columns(&columns))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Source: exact; the inverse of a regular information matrix, and no effect at all.
    #[test]
    fn val_variances_are_the_inverse_or_infinite() {
        let regular = DMatrix::from_row_slice(2, 2, &[4.0, 1e-4, 1e-4, 9.0e-8]);
        let inverse = regular.clone().try_inverse().unwrap();
        for (i, found) in variances(regular).iter().enumerate() {
            assert!((found / inverse[(i, i)] - 1.0).abs() < 1e-9);
        }
        let without = DMatrix::from_row_slice(2, 2, &[4.0, 0.0, 0.0, 0.0]);
        assert_eq!(variances(without), [0.25, f64::INFINITY]);
        // Only the sum of the two shows.
        let sum = DMatrix::from_element(2, 2, 1.0);
        assert_eq!(variances(sum), [f64::INFINITY, f64::INFINITY]);
    }
}
