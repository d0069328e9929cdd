//! What a fit is of and what it gives.

use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::point::Point;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// What a fit found.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Fit {
    /// The point reached.
    pub point: Point,
    /// Objective there, of a search or of what is compared, as the fit was done.
    pub trimmed: f64,
    /// Negative logarithm of likelihood and prior there, nats, no segment left out.
    pub misfit: f64,
    /// Logarithm of the evidence by Laplace's approximation, nats, up to what is the same for every hypothesis on the same
    /// segments and samples, with the likelihood of [`likelihood`]: no segment is left out of it. Negative infinity before a fit
    /// was linearised.
    pub log_evidence: f64,
    /// Mean square residual of each segment in m^2.
    pub mean_square: Vec<f64>,
    /// Covariance of the shared parameters on their scales (empty before it was asked for).
    pub covariance: Option<DMatrix<f64>>,
}

impl Fit {
    /// Root of the `share`-quantile of the mean square errors of the segments, in units of the noise.
    pub fn error_quantile(&self, data: &Observations, share: f64) -> f64 {
        let mut ratio: Vec<f64> = data
            .segments
            .iter()
            .zip(&self.mean_square)
            .map(|(segment, m)| m / data.noise[segment.run].powi(2))
            .collect();
        ratio.sort_by(f64::total_cmp);
        match ratio.len() {
            0 => f64::NAN,
            n => ratio[((n - 1) as f64 * share).round() as usize].sqrt(),
        }
    }
}

/// A hypothesis and the best fit found.
#[derive(Clone)]
pub struct FittedHypothesis {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// The fit.
    pub fit: Fit,
}
