//! A run kept out, of which the first part has been learned, and its motion from there.

use crate::diagnose::data::segment::{Segment, cut, further_parts};
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{Care, FitOptions};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::run_parameters;
use crate::diagnose::model::friction_prior::StartFriction;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::simulator::{Samples, SegmentStart, SegmentValues, Simulator};
use crate::diagnose::validation::segment_errors::from_fitted_runs;
use crate::error::Error;
use crate::measurement::Run;
use crate::smoothing::smooth_run;

/// Error over that deviation that counts for a forecast that ran away: as far off as the motion is wide.
const RAN_AWAY: f64 = 2.0;

/// A run of which the first part has been learned.
pub(crate) struct LearnedRun<'a> {
    problem: &'a Problem<'a>,
    hypothesis: &'a Hypothesis,
    /// All runs of the campaign, this one as it is learned from.
    runs: Vec<Run>,
    index: usize,
    /// The first part, and where everything stands that explains it.
    pub segments: Vec<Segment>,
    pub point: Point,
    /// Index of the first sample that was not learned from.
    pub past: usize,
}

impl<'a> LearnedRun<'a> {
    /// Learns the first `learned` s of a run; `None` where nothing is left to predict or no piece fits in.
    pub(crate) fn new(
        problem: &'a Problem<'a>,
        fitted: &'a FittedHypothesis,
        run: &Run,
        index: usize,
        learned: f64,
    ) -> Result<Option<Self>, Error> {
        let past = run.time.partition_point(|t| t - run.time[0] < learned);
        if past + 32 > run.time.len() || past < 16 {
            return Ok(None);
        }
        let beginning = run.beginning(past);
        let structure = structure(problem.fmu, &problem.campaign.beam)?;
        let expected = StartFriction::of(problem.fmu)?;
        let (zero, _) = problem.zero.beliefs[index];
        let Ok(smoothing) = smooth_run(&beginning, &structure, &|v| expected.at(v), zero) else {
            return Ok(None);
        };
        let further = further_parts(
            &beginning,
            &smoothing,
            problem.noise[index],
            &problem.delays,
        );
        let segments = cut((index, &beginning), &smoothing, &further, problem.horizon);
        if segments.is_empty() {
            return Ok(None);
        }
        let mut runs = problem.campaign.runs.clone();
        runs[index] = run.clone();
        let h = &fitted.hypothesis;
        let start = from_fitted_runs(problem, fitted, &segments);
        let mut predictor =
            Predictor::new(problem.fmu, &problem.references, &runs, h, &problem.work)?;
        let data = Observations {
            segments: &segments,
            noise: &problem.noise,
            work: &problem.work,
        };
        let found =
            run_parameters::learn(&mut predictor, h, &data, start, learning(), Care::Thorough);
        drop(predictor);
        Ok(Some(Self {
            problem,
            hypothesis: h,
            runs,
            index,
            point: found.point,
            segments,
            past,
        }))
    }

    /// The last piece of the first part, from whose start on the motion is predicted.
    pub(crate) fn last(&self) -> &Segment {
        self.segments.last().expect("a first part has a piece")
    }

    pub(crate) fn predictor(&self) -> Result<Predictor<'_>, Error> {
        let references = &self.problem.references;
        Predictor::new(
            self.problem.fmu,
            references,
            &self.runs,
            self.hypothesis,
            &self.problem.work,
        )
    }

    /// The motion from the start of a piece at the run's samples from there to `end`; NaN where it ran away.
    pub(crate) fn motion(
        &self,
        predictor: &mut Predictor,
        point: &Point,
        from: &Segment,
        start: &SegmentStart,
        end: usize,
    ) -> Vec<f64> {
        let run = &self.runs[self.index];
        let range = from.first..end;
        let long = Segment {
            time: run.time[range.clone()].to_vec(),
            measured: vec![f64::NAN; range.len()],
            trusted: vec![true; range.len()],
            count: range.len(),
            ..from.clone()
        };
        let mut out = Vec::new();
        let values = SegmentValues {
            shared: &point.shared,
            per_run: &point.per_run[self.index],
            state: &start.state,
            stuck: start.stuck,
        };
        // A motion that the FMU can't follow ends there.
        let _ = predictor.predict(&long, values, Samples::all(&long), &mut out);
        out.resize(range.len(), f64::NAN);
        out
    }

    /// The free motion from the start of the last piece learned from to the end of the run, with all as it was learned.
    pub(crate) fn ahead(&self) -> Result<Vec<f64>, Error> {
        self.ahead_from(&self.point)
    }

    /// The same with all as it is at a point.
    pub(crate) fn ahead_from(&self, point: &Point) -> Result<Vec<f64>, Error> {
        let end = self.runs[self.index].time.len();
        let start = point.start(self.segments.len() - 1);
        Ok(self.motion(&mut self.predictor()?, point, self.last(), &start, end))
    }

    /// Times since the run began, and what of the motion [`Self::ahead`] lies after the first part.
    pub(crate) fn after<'b>(&self, ahead: &'b [f64]) -> (Vec<f64>, &'b [f64]) {
        let time = &self.runs[self.index].time;
        let since = time[self.past..].iter().map(|t| t - time[0]);
        (since.collect(), &ahead[self.past - self.last().first..])
    }

    /// Root mean square error of forecasts, in the unit of what is measured, of each piece after the first part from the piece before it.
    pub(crate) fn one_cycle(&self) -> Result<f64, Error> {
        let (problem, h, r) = (self.problem, self.hypothesis, self.index);
        let run = &self.runs[r];
        let smoothing = &problem.smoothings[r];
        let further = further_parts(run, smoothing, problem.noise[r], &problem.delays);
        let segments = cut((r, run), smoothing, &further, problem.horizon);
        let mut point = Point::centre(h, &segments);
        point.shared.clone_from(&self.point.shared);
        point.per_run.clone_from(&self.point.per_run);
        let mut predictor = self.predictor()?;
        let data = Observations {
            segments: &segments,
            noise: &problem.noise,
            work: &problem.work,
        };
        let filtered = Fitter::new(&mut predictor, h, &data, learning())
            .fit_initial_states(point)
            .point;
        let limit = RAN_AWAY * problem.spread[r];
        let (mut sum, mut count) = (0.0, 0.0);
        let trusted = run.trusted();
        for k in 1..segments.len() {
            let (from, to) = (&segments[k - 1], &segments[k]);
            if to.first < self.past {
                continue;
            }
            let end = to.first + to.time.len();
            let all = self.motion(&mut predictor, &filtered, from, &filtered.start(k - 1), end);
            let past = from.first + from.time.len();
            for i in past..end {
                if !trusted[i] {
                    continue;
                }
                let error = run.measured[i] - all[i - from.first];
                let error = if error.is_finite() {
                    error.abs().min(limit)
                } else {
                    limit
                };
                sum += error * error;
                count += 1.0;
            }
        }
        Ok((sum / count).sqrt())
    }
}

/// How a run's own values are learned.
pub(crate) fn learning() -> FitOptions {
    FitOptions {
        stride: 1,
        shared: false,
        draws: true,
        ..FitOptions::search(6)
    }
}
