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
            Scale::Log => x.clamp(-50.0, 50.0).exp(),
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
    let information = jacobian.transpose() * &jacobian;
    let spread = information
        .clone()
        .pseudo_inverse(1e-12 * information.amax())
        .ok()?;
    let widen = (chi / degrees).max(1.0).sqrt() * student(degrees);
    let parameters = start
        .iter()
        .enumerate()
        .map(|(i, (name, unit, scale, _))| {
            let half = widen * spread[(i, i)].max(0.0).sqrt();
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
