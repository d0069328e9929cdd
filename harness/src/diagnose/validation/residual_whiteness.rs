//! Whether what a model leaves is white, as the sensor's noise is.
//!
//! The size of the residuals says little more than the noise estimate is good for, a few percent; a wrong model may hide
//! below that. But what a wrong model leaves is slow beside the samples, while white noise has the same power at all
//! frequencies. So the power of the residuals' discrete cosine transform in the lowest fifth of the coefficients is compared
//! with that in the upper half:
//!
//! ```text
//! spectral ratio = median over segments of  mean_{k <= n/5} c_k^2 / mean_{k > n/2} c_k^2
//! ```
//!
//! with the means of the upper half taken over all segments of a run. The fitted start states take a few of the lowest
//! coefficients, so that noise alone gives somewhat less than 1. Holds for a samples rate well above the motion's
//! frequencies and for noise that the recorder has not smoothed.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::simulator::{Samples, SegmentValues, Simulator};
use crate::error::Error;
use rustdct::DctPlanner;

/// Share of the coefficients, from the lowest, in which a model's errors lie.
const LOW: f64 = 0.2;
/// Share from which on only noise is left.
const HIGH: f64 = 0.5;

/// Power of a fit's residuals at low frequencies over that at high ones or of the sensor's noise, whichever is more, on the segments that it was fitted to; NaN
/// without segments.
///
/// # Errors
/// An FMU that can't be run.
pub fn spectral_ratio(
    problem: &Problem,
    segments: &[Segment],
    fitted: &FittedHypothesis,
) -> Result<f64, Error> {
    let point = &fitted.fit.point;
    let mut predictor = problem.predictor(&fitted.hypothesis)?;
    let runs = problem.campaign.runs.len();
    let mut planner = DctPlanner::new();
    let (mut high, mut count) = (vec![0.0; runs], vec![0.0; runs]);
    let mut low = Vec::new();
    let mut y = Vec::new();
    for (i, segment) in segments.iter().enumerate() {
        let Some(rest) = residuals(
            &mut predictor,
            point.values(i, segment.run),
            segment,
            &mut y,
        ) else {
            continue;
        };
        let n = rest.len();
        let power = powers(&mut planner, rest);
        let (lowest, highest) = ((LOW * n as f64) as usize, (HIGH * n as f64) as usize);
        if lowest < 4 {
            continue;
        }
        low.push((
            segment.run,
            power[..lowest].iter().sum::<f64>() / lowest as f64,
        ));
        high[segment.run] += power[highest..].iter().sum::<f64>();
        count[segment.run] += (power.len() - highest) as f64;
    }
    // Structure below the sensor's noise can't be told from it: where the high frequencies have less than that, the low ones are
    // compared with the noise.
    let reference = |run: usize| (high[run] / count[run]).max(problem.noise[run].powi(2));
    let mut ratios: Vec<f64> = low
        .iter()
        .map(|&(run, power)| power / reference(run))
        .collect();
    ratios.sort_by(f64::total_cmp);
    Ok(ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN))
}

/// What a prediction of a segment leaves, in m; `None` where it ran away, or where a gap would look like motion. `y` is room for the
/// prediction.
pub(super) fn residuals(
    simulator: &mut dyn Simulator,
    values: SegmentValues,
    segment: &Segment,
    y: &mut Vec<f64>,
) -> Option<Vec<f64>> {
    let done = simulator.predict(segment, values, Samples::all(segment), y);
    if !matches!(done, Ok(true)) || segment.trusted.iter().any(|t| !t) {
        return None;
    }
    let pairs = segment.measured.iter().zip(y.iter());
    Some(pairs.map(|(m, y)| m - y).collect())
}

/// Powers of the orthonormal cosine transform (type II) of some values, but for that of their mean.
fn powers(planner: &mut DctPlanner<f64>, mut values: Vec<f64>) -> Vec<f64> {
    let n = values.len();
    planner.plan_dct2(n).process_dct2(&mut values);
    let power = |c: &f64| c * c * 2.0 / n as f64;
    values.iter().skip(1).map(power).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transform_keeps_the_power_of_what_has_no_mean() {
        let values: Vec<f64> = (0..64).map(|i| (0.3 * f64::from(i)).sin()).collect();
        let mean = values.iter().sum::<f64>() / 64.0;
        let centred: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
        let power: f64 = powers(&mut DctPlanner::new(), values.clone()).iter().sum();
        assert!((power / centred - 1.0).abs() < 1e-12);
    }
}
