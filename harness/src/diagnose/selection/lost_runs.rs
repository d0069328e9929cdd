//! Runs that a fit lost while it came down to the noise on the others.
//!
//! The friction level of a run is its own; once it has wandered off, every segment of the run is lost, and lost segments have
//! no say. What the other runs found brings it back: their level, with the start states of the smoother, and then what is its
//! own, phases all round, while all that the runs share is held, as for a run that was kept out.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{Care, FitOptions};
use crate::diagnose::estimation::run_parameters;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::thresholds::LOST;
use crate::error::Error;
use crate::metric::median;

/// Median error of a run over the noise up to which it has arrived; beyond [`LOST`] it is lost.
const ARRIVED: f64 = 1.5;
/// Jacobians for what is their own.
const STEPS: usize = 3;

/// Runs that a fit met, and runs that it lost.
pub(crate) struct LostRuns {
    arrived: Vec<usize>,
    lost: Vec<usize>,
}

impl LostRuns {
    /// Those of a fit to `segments`.
    pub(crate) fn of(problem: &Problem, fitted: &FittedHypothesis, segments: &[Segment]) -> Self {
        let error = |run: usize| -> Option<f64> {
            let of_run = segments.iter().zip(&fitted.fit.mean_square);
            let mut ratios: Vec<f64> = of_run
                .filter(|(segment, _)| segment.run == run)
                .map(|(_, m)| m.sqrt() / problem.noise[run])
                .collect();
            (!ratios.is_empty()).then(|| median(&mut ratios))
        };
        let of_runs: Vec<(usize, f64)> = (0..problem.campaign.runs.len())
            .filter_map(|run| Some((run, error(run)?)))
            .collect();
        let runs = |wanted: &dyn Fn(f64) -> bool| -> Vec<usize> {
            let some = of_runs.iter().filter(|(_, error)| wanted(*error));
            some.map(|(run, _)| *run).collect()
        };
        Self {
            arrived: runs(&|e| e <= ARRIVED),
            lost: runs(&|e| e > LOST),
        }
    }

    /// Whether there are any, and any that were met, from which they may be found.
    pub(crate) fn may_be_found(&self) -> bool {
        !self.lost.is_empty() && !self.arrived.is_empty()
    }

    /// Whether no more were lost than met: where more were, a search had better look elsewhere.
    pub(crate) fn are_few(&self) -> bool {
        self.lost.len() <= self.arrived.len()
    }

    /// Where to fit the hypothesis from so that these get another chance.
    ///
    /// # Errors
    /// An FMU that can't be instantiated.
    pub(crate) fn start(
        &self,
        problem: &Problem,
        fitted: &FittedHypothesis,
        segments: &[Segment],
    ) -> Result<Point, Error> {
        let h = &fitted.hypothesis;
        let mut point = fitted.fit.point.clone();
        point.spread_per_run(h, &self.arrived, &self.lost);
        let of_lost: Vec<usize> = (0..segments.len())
            .filter(|&k| self.lost.contains(&segments[k].run))
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
        let care = Care::Brief;
        let found = run_parameters::learn(&mut predictor, h, &data, theirs, options, care).point;
        for &run in &self.lost {
            point.per_run[run].clone_from(&found.per_run[run]);
        }
        for (i, &k) in of_lost.iter().enumerate() {
            point.put(k, found.start(i));
        }
        Ok(point)
    }
}
