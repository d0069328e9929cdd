//! How far a forecast may be off for what is not known of the constants and of the beginning.
//!
//! Each member of the band is one motion that the data allow as well: the shared parameters are drawn from their posterior, the
//! first part of the run is measured again (the sensor's noise added anew), what is the run's own is fitted to that, and the
//! motion goes on from there (randomised maximum likelihood: exact for a linear model with normal noise; Oliver, He and Reynolds 1996).
//! The band leaves out the outermost member on either side.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::data::white_noise::gaussian;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::learned_run::{LearnedRun, learning};
use crate::error::Error;
use crate::parallel::parallel;
use nalgebra::{DMatrix, DVector};

/// Motions that make a band: without the outermost ones the middle 8 of 10.
const MEMBERS: u64 = 10;

/// Half the width of the middle 8 of 10 of a normal distribution, in standard deviations.
const MIDDLE_EIGHT: f64 = 1.2816;

/// Where the middle eight of ten motions run that the data allow, m.
#[derive(Debug, Clone)]
pub struct Band {
    /// Times in s since the run began.
    pub time: Vec<f64>,
    /// Lower edge in m.
    pub low: Vec<f64>,
    /// Upper edge in m.
    pub high: Vec<f64>,
}

impl Band {
    /// Share (1) of the samples measured up to a time in s that lie in the band, widened on either side by what the middle
    /// eight of ten of the sensor's errors stay within.
    pub fn share_inside(&self, time: &[f64], measured: &[f64], noise: f64, until: f64) -> f64 {
        let margin = MIDDLE_EIGHT * noise;
        let first = time.len() - self.time.len();
        let count = self.time.partition_point(|t| *t <= until);
        let inside = (0..count).filter(|&i| {
            let y = measured[first + i];
            self.low[i] - margin <= y && y <= self.high[i] + margin
        });
        inside.count() as f64 / count as f64
    }
}

/// The band about the forecast of run `r`, of which the first `learned_s` s were learned from; `None` where nothing could be forecast.
///
/// # Errors
/// An FMU that can't be run.
pub fn band(
    problem: &Problem,
    fitted: &FittedHypothesis,
    r: usize,
    learned_s: f64,
) -> Result<Option<Band>, Error> {
    let run = &problem.campaign.runs[r];
    let learned = LearnedRun::new(problem, fitted, run, r, learned_s)?;
    let Some(learned) = learned else {
        return Ok(None);
    };
    let root = fitted.fit.covariance.as_ref().map(square_root);
    let seeds: Vec<u64> = (0..MEMBERS).collect();
    let motions = parallel(&seeds, |&seed| {
        member(problem, fitted, &learned, root.as_ref(), seed)
    })?;
    let (time, _) = learned.after(&motions[0]);
    let after: Vec<&[f64]> = motions.iter().map(|m| learned.after(m).1).collect();
    let edges = (0..time.len()).map(|i| {
        let mut at: Vec<f64> = after.iter().map(|m| m[i]).collect();
        at.sort_by(f64::total_cmp);
        // A motion that ran away, not a number, counts as the highest.
        (at[1], at[at.len() - 2])
    });
    let (low, high) = edges.unzip();
    Ok(Some(Band { time, low, high }))
}

/// One motion that the data allow.
fn member(
    problem: &Problem,
    fitted: &FittedHypothesis,
    learned: &LearnedRun,
    root: Option<&DMatrix<f64>>,
    seed: u64,
) -> Result<Vec<f64>, Error> {
    let mut random = fastrand::Rng::with_seed(seed);
    let h = &fitted.hypothesis;
    let mut point = learned.point.clone();
    if let Some(root) = root {
        let draw = DVector::from_fn(root.ncols(), |_, _| gaussian(&mut random));
        for (i, change) in (root * draw).iter().enumerate() {
            point.shared[i] = h.shared[i].clamp(point.shared[i] + change);
        }
    }
    let measured_again = learned.segments.iter().map(|s| {
        let noise = problem.noise[s.run];
        let mut segment = s.clone();
        let further = segment.further.iter_mut().map(|part| &mut part.measured);
        for measured in std::iter::once(&mut segment.measured).chain(further) {
            for y in measured {
                *y += noise * gaussian(&mut random);
            }
        }
        segment
    });
    let segments: Vec<Segment> = measured_again.collect();
    let data = Observations {
        segments: &segments,
        noise: &problem.noise,
        work: &problem.work,
    };
    let mut predictor = learned.predictor()?;
    let fit = Fitter::new(&mut predictor, h, &data, learning()).run(point);
    drop(predictor);
    learned.ahead_from(&fit.point)
}

/// A matrix whose square is a symmetric one that is positive but for rounding.
fn square_root(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let eigen = matrix.clone().symmetric_eigen();
    let roots = eigen.eigenvalues.map(|v| v.max(0.0).sqrt());
    &eigen.eigenvectors * DMatrix::from_diagonal(&roots)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_the_root_of_a_covariance_gives_it_back() {
        // Source: the definition, R R' = C; a direction without variance stays without.
        let covariance =
            DMatrix::from_row_slice(3, 3, &[4.0, 2.0, 0.0, 2.0, 3.0, 0.0, 0.0, 0.0, 0.0]);
        let root = square_root(&covariance);
        let error = (&root * root.transpose() - &covariance).abs().max();
        assert!(error < 1e-12, "{error}");
    }
}
