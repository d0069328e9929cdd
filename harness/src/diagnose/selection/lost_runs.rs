//! Runs that a fit lost while it came down to the noise on the others.
//!
//! The friction level of a run is its own; once it has wandered off, every segment of the run is lost, and lost segments have
//! no say. What the other runs found brings it back: their level, with the start states of the smoother, and then what is its
//! own, phases all round, while all that the runs share is held, as for a run that was kept out.
//!
//! Where that does not bring it back the hypothesis is wrong, however well it meets the others: each run is an experiment, and what made
//! the data meets most segments of each.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{Care, FitOptions};
use crate::diagnose::estimation::run_parameters;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::error::Error;
use crate::metric::median;

/// Median error of a run over the noise up to which it has arrived, ...
const ARRIVED: f64 = 1.5;
/// ... and beyond which it is lost.
const LOST: f64 = 3.0;
/// Jacobians for what is their own.
const STEPS: usize = 3;

/// Run and mean square of what is left of each segment.
type Left = Vec<(usize, f64)>;

fn left(segments: &[Segment], fitted: &FittedHypothesis) -> Left {
    let runs = segments.iter().map(|segment| segment.run);
    runs.zip(fitted.fit.mean_square.iter().copied()).collect()
}

/// Median error of each run's segments over its noise, of the runs that have any.
fn errors(noise: &[f64], left: &[(usize, f64)]) -> Vec<(usize, f64)> {
    let error = |run: usize| {
        let of_run = left.iter().filter(|(of, _)| *of == run);
        let mut ratios: Vec<f64> = of_run.map(|(_, m)| m.sqrt() / noise[run]).collect();
        (!ratios.is_empty()).then(|| (run, median(&mut ratios)))
    };
    (0..noise.len()).filter_map(error).collect()
}

fn is_any_lost(errors: &[(usize, f64)]) -> bool {
    errors.iter().any(|(_, error)| *error > LOST)
}

/// Whether a fit to these segments leaves most of some run unmet.
pub(crate) fn leaves_a_run(
    problem: &Problem,
    segments: &[Segment],
    fitted: &FittedHypothesis,
) -> bool {
    is_any_lost(&errors(&problem.noise, &left(segments, fitted)))
}

/// Where to fit a hypothesis from so that the runs that it lost get another chance; `None` if it lost none, or more
/// than it found.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn without_loss(
    problem: &Problem,
    fitted: &FittedHypothesis,
    segments: &[Segment],
) -> Result<Option<Point>, Error> {
    let of_runs = errors(&problem.noise, &left(segments, fitted));
    let runs = |wanted: &dyn Fn(f64) -> bool| -> Vec<usize> {
        let some = of_runs.iter().filter(|(_, error)| wanted(*error));
        some.map(|(run, _)| *run).collect()
    };
    let (arrived, lost) = (runs(&|e| e <= ARRIVED), runs(&|e| e > LOST));
    if lost.is_empty() || arrived.len() < lost.len() {
        return Ok(None);
    }
    let h = &fitted.hypothesis;
    let mut point = fitted.fit.point.clone();
    point.spread_per_run(h, &arrived, &lost);
    let of_lost: Vec<usize> = (0..segments.len())
        .filter(|&k| lost.contains(&segments[k].run))
        .collect();
    let their_segments: Vec<Segment> = of_lost.iter().map(|&k| segments[k].clone()).collect();
    let mut theirs = Point::centre(h, &their_segments);
    theirs.shared.clone_from(&point.shared);
    theirs.per_run.clone_from(&point.per_run);
    let mut predictor = problem.predictor(h)?;
    let options = FitOptions {
        shared: false,
        ..FitOptions::search(STEPS)
    };
    let data = problem.data(&their_segments);
    let found = run_parameters::learn(&mut predictor, h, &data, theirs, options, Care::Brief).point;
    for &run in &lost {
        point.per_run[run].clone_from(&found.per_run[run]);
    }
    for (i, &k) in of_lost.iter().enumerate() {
        point.put(k, found.start(i));
    }
    Ok(Some(point))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_lost_where_most_of_its_segments_are_however_many_are_met_elsewhere() {
        let noise: [f64; 3] = [1e-6, 2e-6, 3e-6];
        // Of the run in the middle, which has five segments, the first ones are not met.
        let with_lost = |count: usize| -> Left {
            let met = (0..20).map(|k| (2 * (k % 2), (1.02 * noise[2 * (k % 2)]).powi(2)));
            let of_run = (0..5).map(|k| match k < count {
                true => (1, 1e-8),
                false => (1, 4e-12),
            });
            met.chain(of_run).collect()
        };
        let is_lost = |count| is_any_lost(&errors(&noise, &with_lost(count)));
        assert!(!is_lost(0) && !is_lost(2));
        assert!(is_lost(3) && is_lost(5));
    }

    #[test]
    fn a_run_that_was_not_fitted_is_not_lost() {
        let found = errors(&[1e-6, 1e-6], &[(1, 1e-12)]);
        assert_eq!(found, [(1, 1.0)]);
    }
}
