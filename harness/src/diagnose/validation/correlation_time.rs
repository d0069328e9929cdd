//! How many samples in a row err alike where a model misses more than noise.
//!
//! Integrated autocorrelation time of the residuals r of each segment about its mean, in samples:
//!
//! ```text
//! tau = 1 + 2 sum_{k = 1}^{K} rho_k,   rho_k = sum_i r_i r_{i+k} / sum_i r_i^2
//! ```
//!
//! K ends before the first rho_k that is not positive. n samples then say as much as n / tau independent ones. Source of
//! the cut: Geyer 1992, Statist. Sci. 7:473, sect. 3.3. Holds where a segment is several times as long as tau; the fitted
//! start state takes the slowest part.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::residual_whiteness::residuals;
use crate::error::Error;
use crate::metric::median;

/// Median correlation time in samples over the segments of each run that a fit was made to; 1 for other runs.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn correlation_times(
    problem: &Problem,
    segments: &[Segment],
    fitted: &FittedHypothesis,
) -> Result<Vec<f64>, Error> {
    let mut predictor = problem.predictor(&fitted.hypothesis)?;
    let mut of_runs: Vec<Vec<f64>> = vec![Vec::new(); problem.campaign.runs.len()];
    let mut y = Vec::new();
    for (k, segment) in segments.iter().enumerate() {
        let values = fitted.fit.point.values(k, segment.run);
        let Some(rest) = residuals(&mut predictor, values, segment, &mut y) else {
            continue;
        };
        of_runs[segment.run].push(correlation_time(&rest));
    }
    let typical = |times: &mut Vec<f64>| match times.is_empty() {
        true => 1.0,
        false => median(times),
    };
    Ok(of_runs.iter_mut().map(typical).collect())
}

/// Integrated autocorrelation time of a series, in samples; 1 of one that does not vary.
fn correlation_time(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let product = |lag: usize| -> f64 {
        centred
            .iter()
            .zip(&centred[lag..])
            .map(|(a, b)| a * b)
            .sum()
    };
    let power = product(0);
    if power == 0.0 {
        return 1.0;
    }
    let positive = (1..values.len()).map(product).take_while(|p| *p > 0.0);
    1.0 + 2.0 * positive.sum::<f64>() / power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_an_autoregressive_series_has_the_time_of_its_closed_form() {
        // Source: closed form, tau = (1 + a) / (1 - a) of x_{i+1} = a x_i + white noise.
        let mut random = fastrand::Rng::with_seed(7);
        for a in [0.0, 0.6, 0.9] {
            let mut x = 0.0;
            let series: Vec<f64> = (0..40_000)
                .map(|_| {
                    x = a * x + random.f64() - 0.5;
                    x
                })
                .collect();
            let (found, truth) = (correlation_time(&series), (1.0 + a) / (1.0 - a));
            assert!((found / truth - 1.0).abs() < 0.15, "{a}: {found} {truth}");
        }
        assert_eq!(correlation_time(&[3.0; 10]), 1.0);
    }
}
