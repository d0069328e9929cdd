//! The curve of an unknown function as fitted, with its smoothness fitted too.
//!
//! At the optimum with the unit belief in the latent values z (H: information of the data on them, all else projected out;
//! b = H z_ml) the belief z ~ N(0, D) has the evidence, up to what does not depend on D,
//!
//! ```text
//! E(D) = 1/2 b' (H + D^-1)^-1 b - 1/2 ln det(1 + D H),   D_k = (a k^(2 - p))^2
//! ```
//!
//! a is the strength and p the decay of the cosine coefficients: 1 for a curve that is continuous, 2 for one with a slope,
//! 3 for a smoother one. The curve is the one of the most probable (a, p); its evidence is the mean over all of them,
//! which is the price of the choice. Source: Wahba, Spline Models for Observational Data, 1990, sect. 4.8 (empirical Bayes); exact
//! where the displacement depends linearly on z.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{NODES, UnknownFunction, latent_name, weight};
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Strengths that are tried, in units of the typical one.
const STRENGTHS: [f64; 5] = [1.0 / 9.0, 1.0 / 3.0, 1.0, 3.0, 9.0];
/// Decays that are tried.
const DECAYS: [f64; 3] = [1.0, 2.0, 3.0];

/// A curve with its uncertainty.
pub struct CurveEstimate {
    /// Values at the nodes.
    pub values: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// What its evidence gains by a fitted smoothness, nats.
    pub gain: f64,
}

impl CurveEstimate {
    /// Standard deviation of what all values are off by together: the root of their least covariance.
    pub fn common_std(&self) -> f64 {
        let least = self
            .covariance
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        least.max(0.0).sqrt()
    }
}

/// The curve of an unknown function; `None` where the fit has no covariance.
pub fn curve_estimate(
    problem: &Problem,
    of: &UnknownFunction,
    fitted: &FittedHypothesis,
) -> Option<CurveEstimate> {
    let h = &fitted.hypothesis;
    let card = problem.catalogue.iter().find(|c| c.id == of.id)?;
    let strength = card.parameters.first()?.typical;
    let places: Vec<usize> = (0..NODES)
        .map(|k| h.shared_index(&latent_name(&of.id, k)))
        .collect::<Option<_>>()?;
    let covariance = fitted.fit.covariance.as_ref()?;
    let of_latent = DMatrix::from_fn(NODES, NODES, |i, j| covariance[(places[i], places[j])]);
    let latent = DVector::from_iterator(NODES, places.iter().map(|&p| fitted.fit.point.shared[p]));
    let (latent, of_latent, gain) = smoothed(&latent, &of_latent)?;
    let to_nodes = DMatrix::from_fn(NODES, NODES, |i, k| strength * weight(k, i));
    Some(CurveEstimate {
        values: &to_nodes * latent,
        covariance: &to_nodes * of_latent * to_nodes.transpose(),
        gain,
    })
}

/// Latent values, their covariance and the gain in evidence under the most probable smoothness, from those under the unit
/// belief.
fn smoothed(
    latent: &DVector<f64>,
    covariance: &DMatrix<f64>,
) -> Option<(DVector<f64>, DMatrix<f64>, f64)> {
    let n = latent.len();
    let precision = covariance.clone().cholesky()?.inverse();
    let b = &precision * latent;
    // What the belief leaves to the data; never negative but for rounding.
    let eigen = SymmetricEigen::new(&precision - DMatrix::identity(n, n));
    let values = eigen.eigenvalues.map(|v| v.max(0.0));
    let information =
        &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose();
    let of = |strength: f64, decay: f64| {
        let std = DVector::from_fn(n, |k, _| strength * (k.max(1) as f64).powf(2.0 - decay));
        let belief = DMatrix::from_diagonal(&std.map(|s| s.powi(-2)));
        let factor = (&information + belief).cholesky()?;
        let solved = factor.solve(&b);
        let scaled = DMatrix::from_fn(n, n, |i, j| std[i] * information[(i, j)] * std[j]);
        let occam = (scaled + DMatrix::identity(n, n)).cholesky()?;
        let half_log: f64 = occam.l().diagonal().iter().map(|d| d.ln()).sum();
        Some((0.5 * b.dot(&solved) - half_log, solved, factor.inverse()))
    };
    let unit = of(1.0, 2.0)?.0;
    let grid = STRENGTHS.iter().flat_map(|&a| DECAYS.map(|p| (a, p)));
    let all: Vec<_> = grid.filter_map(|(a, p)| of(a, p)).collect();
    let count = all.len() as f64;
    let best = all.into_iter().map(|f| (f.0 - unit, f.1, f.2));
    let best: Vec<_> = best.collect();
    let top = best.iter().map(|f| f.0).fold(f64::NEG_INFINITY, f64::max);
    let mean: f64 = best.iter().map(|f| (f.0 - top).exp()).sum::<f64>() / count;
    let (_, latent, covariance) = best.into_iter().find(|f| f.0 == top)?;
    Some((latent, covariance, top + mean.ln()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Source: marginal likelihood of `z_ml ~ N(0, H^-1 + D)` for the linear model with independent latent values.
    #[test]
    fn val_the_gain_is_the_ratio_of_marginal_likelihoods_averaged_over_the_grid() {
        let information: [f64; 3] = [400.0, 90.0, 0.5];
        let seen = [1.2, -0.7, 3.0];
        let normal = |x: f64, variance: f64| -0.5 * x * x / variance - 0.5 * variance.ln();
        let evidence = |a: f64, p: f64| -> f64 {
            (0..3)
                .map(|k| {
                    let std = a * (k.max(1) as f64).powf(2.0 - p);
                    normal(seen[k], information[k].recip() + std * std)
                })
                .sum()
        };
        let unit = evidence(1.0, 2.0);
        let grid = STRENGTHS.iter().flat_map(|&a| DECAYS.map(|p| (a, p)));
        let mean: f64 = grid
            .map(|(a, p)| (evidence(a, p) - unit).exp())
            .sum::<f64>()
            / (STRENGTHS.len() * DECAYS.len()) as f64;
        let covariance = DVector::from_fn(3, |k, _| (information[k] + 1.0).recip());
        let latent = DVector::from_fn(3, |k, _| covariance[k] * information[k] * seen[k]);
        let (_, _, gain) = smoothed(&latent, &DMatrix::from_diagonal(&covariance)).unwrap();
        assert!((gain - mean.ln()).abs() < 1e-9, "{gain} {}", mean.ln());
    }
}
