//! The curve of an unknown function as fitted, and how smooth the data say that it is.
//!
//! At the optimum with the belief z ~ N(0, D_0) in the latent values (H: information of the data on them, all else projected out;
//! b = (H + D_0^-1) z = H z_ml) another belief z ~ N(0, D) has the evidence, up to what does not depend on D,
//!
//! ```text
//! E(D) = 1/2 b' (H + D^-1)^-1 b - 1/2 ln det(1 + D H),   D_k = (a max(k, 1)^(2 - p))^2
//! ```
//!
//! a is the strength and p the decay of the cosine coefficients ([`Smoothness`]). Source: Wahba, Spline Models for Observational
//! Data, 1990, sect. 4.8 (empirical Bayes). Exact where the displacement depends linearly on z: where D is far from D_0 it says where
//! to look, and the curve is fitted there ([`crate::diagnose::selection`]).

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{
    NODES, Smoothness, UnknownFunction, latent_name, weight,
};
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
    /// What the evidence loses by the mean over all smoothnesses that are tried, none of which counts for more than the one fitted,
    /// nats: the price of its choice.
    pub price: f64,
    /// The smoothness of most evidence, as seen from the one fitted.
    pub most_probable: Smoothness,
}

/// The curve of an unknown function; `None` where the fit has no covariance.
pub fn curve_estimate(
    problem: &Problem,
    of: &UnknownFunction,
    fitted: &FittedHypothesis,
) -> Option<CurveEstimate> {
    let h = &fitted.hypothesis;
    let effect = problem.catalogue.iter().position(|c| c.id == of.id)?;
    let strength = problem.catalogue[effect].parameters.first()?.typical;
    let believed = h.choices.iter().find(|c| c.effect == effect)?.smoothness;
    let places: Vec<usize> = (0..NODES)
        .map(|k| h.shared_index(&latent_name(&of.id, k)))
        .collect::<Option<_>>()?;
    let covariance = fitted.fit.covariance.as_ref()?;
    let of_latent = DMatrix::from_fn(NODES, NODES, |i, j| covariance[(places[i], places[j])]);
    let latent = DVector::from_iterator(NODES, places.iter().map(|&p| fitted.fit.point.shared[p]));
    let (most_probable, price) = smoothness(&latent, &of_latent, believed)?;
    let to_nodes = DMatrix::from_fn(NODES, NODES, |i, k| strength * weight(k, i));
    Some(CurveEstimate {
        values: &to_nodes * latent,
        covariance: &to_nodes * of_latent * to_nodes.transpose(),
        price,
        most_probable,
    })
}

/// The smoothness of most evidence, and the price of the one `believed`, from latent values and their covariance under it.
fn smoothness(
    latent: &DVector<f64>,
    covariance: &DMatrix<f64>,
    believed: Smoothness,
) -> Option<(Smoothness, f64)> {
    let n = latent.len();
    let stds = |of: Smoothness| DVector::from_fn(n, |k, _| of.std(k));
    let belief = |of: Smoothness| DMatrix::from_diagonal(&stds(of).map(|s| s.powi(-2)));
    let precision = covariance.clone().cholesky()?.inverse();
    let b = &precision * latent;
    // What the belief leaves to the data; never negative but for rounding.
    let eigen = SymmetricEigen::new(&precision - belief(believed));
    let values = eigen.eigenvalues.map(|v| v.max(0.0));
    let information =
        &eigen.eigenvectors * DMatrix::from_diagonal(&values) * eigen.eigenvectors.transpose();
    let evidence = |of: Smoothness| {
        let std = stds(of);
        let solved = (&information + belief(of)).cholesky()?.solve(&b);
        let scaled = DMatrix::from_fn(n, n, |i, j| std[i] * information[(i, j)] * std[j]);
        let occam = (scaled + DMatrix::identity(n, n)).cholesky()?;
        let half_log: f64 = occam.l().diagonal().iter().map(|d| d.ln()).sum();
        Some(0.5 * b.dot(&solved) - half_log)
    };
    let here = evidence(believed)?;
    let tried = STRENGTHS.iter().flat_map(|&strength| {
        DECAYS.map(|decay| Smoothness {
            strength,
            decay,
            is_told: false,
        })
    });
    let gains: Vec<(Smoothness, f64)> = tried
        .filter_map(|of| Some((of, evidence(of)? - here)))
        .collect();
    let most = gains.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
    let total: f64 = gains.iter().map(|(_, gain)| gain.min(0.0).exp()).sum();
    Some((most.0, (total / gains.len() as f64).ln()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Source: marginal likelihood of `z_ml ~ N(0, H^-1 + D)` for the linear model with independent latent values.
    #[test]
    fn val_smoothness_and_price_follow_from_marginal_likelihoods() {
        let information: [f64; 3] = [400.0, 90.0, 0.5];
        let normal = |x: f64, variance: f64| -0.5 * x * x / variance - 0.5 * variance.ln();
        for (seen, strongest) in [([12.0, -7.0, 3.0], 9.0), ([0.12, -0.07, 0.1], 1.0 / 9.0)] {
            let evidence = |of: Smoothness| -> f64 {
                let std = |k: usize| information[k].recip() + of.std(k).powi(2);
                (0..3).map(|k| normal(seen[k], std(k))).sum()
            };
            // A belief from which linear theory starts anywhere.
            let believed = Smoothness {
                strength: 2.0,
                decay: 1.5,
                is_told: true,
            };
            let precision = |k: usize| information[k] + believed.std(k).powi(-2);
            let covariance = DVector::from_fn(3, |k, _| precision(k).recip());
            let latent = DVector::from_fn(3, |k, _| information[k] * seen[k] / precision(k));
            let covariance = DMatrix::from_diagonal(&covariance);
            let (most, price) = smoothness(&latent, &covariance, believed).unwrap();
            assert_eq!(most.strength, strongest);
            let grid = STRENGTHS.iter().flat_map(|&strength| {
                DECAYS.map(|decay| Smoothness {
                    strength,
                    decay,
                    is_told: false,
                })
            });
            let shares = grid.map(|of| (evidence(of) - evidence(believed)).min(0.0).exp());
            let shares: Vec<f64> = shares.collect();
            let expected = (shares.iter().sum::<f64>() / shares.len() as f64).ln();
            assert!((price - expected).abs() < 1e-9, "{price} {expected}");
        }
    }
}
