//! What a fit is of and what it gives.

use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::point::Point;
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// A fit gains at most this many times what was expected of it: twice the most that was seen beside models that leave an effect
/// out (2.2 to 2.5 times, where the gain was large).
pub(crate) const MOST_OVER_EXPECTED: f64 = 5.0;

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
    /// What the start state of each segment costs in it, nats; empty before a fit was linearised.
    pub state_prices: Vec<f64>,
    /// Fall of the objective that its derivatives promised where they were taken last, nats (half the square of the Newton decrement;
    /// Boyd and Vandenberghe, Convex Optimization, 2004, sect. 9.5.1); infinite where nothing was differentiated.
    pub expected_fall: f64,
    /// Mean square residual of each segment in m^2, of further sensors in units of their noise over the first one's.
    pub mean_square: Vec<f64>,
    /// The same of each sensor of a segment, the first one first, NaN of one that read nothing there; empty where all segments have one
    /// sensor.
    pub by_sensor: Vec<Vec<f64>>,
    /// Covariance of the shared parameters on their scales (empty before it was asked for).
    pub covariance: Option<DMatrix<f64>>,
}

impl Fit {
    /// A point that no fit led to, with these mean square residuals of the segments in m^2.
    pub fn unfitted(point: Point, mean_square: Vec<f64>) -> Self {
        Self {
            point,
            trimmed: f64::NAN,
            misfit: f64::NAN,
            log_evidence: f64::NEG_INFINITY,
            state_prices: Vec::new(),
            expected_fall: f64::INFINITY,
            mean_square,
            by_sensor: Vec::new(),
            covariance: None,
        }
    }

    /// Mean square residual of segment `k` by the first sensor alone, in m^2.
    pub fn of_first_sensor(&self, k: usize) -> f64 {
        let of_segment = self.by_sensor.get(k).and_then(|sensors| sensors.first());
        of_segment.copied().unwrap_or(self.mean_square[k])
    }

    /// The part of it that belongs to the segments with these places among its own.
    pub fn of_segments(&self, places: &[usize]) -> Fit {
        let mut point = self.point.clone();
        point.states = places
            .iter()
            .map(|&i| self.point.states[i].clone())
            .collect();
        point.stuck = places.iter().map(|&i| self.point.stuck[i]).collect();
        let sensors = |&i: &usize| self.by_sensor.get(i).cloned();
        let price = |&i: &usize| self.state_prices.get(i).copied();
        Fit {
            state_prices: places.iter().filter_map(price).collect(),
            mean_square: places.iter().map(|&i| self.mean_square[i]).collect(),
            by_sensor: places.iter().filter_map(sensors).collect(),
            point,
            ..self.clone()
        }
    }

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_is_stored_and_read_again_with_one_sensor_and_with_several() {
        for by_sensor in [Vec::new(), vec![vec![1.0, f64::NAN]]] {
            let fit = Fit {
                point: Point {
                    shared: vec![0.5],
                    per_run: vec![vec![1.0]],
                    states: vec![vec![0.0; 4]],
                    stuck: vec![true],
                },
                trimmed: 1.0,
                misfit: 2.0,
                log_evidence: -3.0,
                state_prices: Vec::new(),
                expected_fall: 0.25,
                mean_square: vec![4.0],
                by_sensor,
                covariance: Some(DMatrix::identity(1, 1)),
            };
            let stored = postcard::to_stdvec(&fit).unwrap();
            let read: Fit = postcard::from_bytes(&stored).unwrap();
            assert_eq!(read.covariance, fit.covariance);
            assert_eq!(read.by_sensor.len(), fit.by_sensor.len());
            let first = if fit.by_sensor.is_empty() { 4.0 } else { 1.0 };
            assert_eq!(read.of_first_sensor(0), first);
        }
    }

    #[test]
    fn the_part_of_some_segments_keeps_what_belongs_together() {
        let fit = Fit {
            point: Point {
                shared: vec![0.5],
                per_run: vec![vec![1.0]],
                states: vec![vec![0.0], vec![1.0], vec![2.0]],
                stuck: vec![true, false, true],
            },
            trimmed: 1.0,
            misfit: 2.0,
            log_evidence: -3.0,
            state_prices: Vec::new(),
            expected_fall: 0.25,
            mean_square: vec![4.0, 5.0, 6.0],
            by_sensor: vec![vec![4.5], vec![5.5], vec![6.5]],
            covariance: None,
        };
        let part = fit.of_segments(&[2, 1]);
        assert_eq!(part.point.states, [[2.0], [1.0]]);
        assert_eq!(part.point.stuck, [true, false]);
        assert_eq!((part.mean_square[1], part.of_first_sensor(0)), (5.0, 6.5));
        assert_eq!(part.misfit, fit.misfit);
    }
}
