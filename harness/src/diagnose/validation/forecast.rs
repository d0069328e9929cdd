//! Forecasts of the runs kept out: the only figure for which no later sample was looked at.
//!
//! All that the runs share comes from the runs fitted. Of a run kept out the first part, two cycles or 40 ms, whichever is
//! longer, determines what is its own: friction level, offset, phases and the state at its end. Everything after is
//! predicted. Two figures say how well:
//!
//! - one-cycle forecasts: from states filtered through the past (the start state of a piece is fitted to that piece alone)
//!   each next piece is predicted; their root mean square error over the standard deviation of the displacement;
//! - valid time: how long the free motion from the end of the first part stays within 0.4 of that standard deviation (Pathak
//!   et al., Phys. Rev. Lett. 120 (2018) 024102). Its limit is that of the model's own motion with the sensor's noise on it,
//!   forecast in the same way: no model can do better than that with so noisy a beginning.
//!
//! The whole run counts: nothing is left out, whether it grazes a transition or not.

use crate::diagnose::data::segment::{Segment, cut, smooth_run};
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{Care, FitOptions};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::run_parameters;
use crate::diagnose::model::hypothesis::{Hypothesis, structure};
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::point::{Point, SegmentStart};
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::simulator::{Samples, SegmentValues, Simulator};
use crate::diagnose::model::white_noise::gaussian;
use crate::diagnose::validation::segment_errors::from_fitted_runs;
use crate::error::Error;
use crate::measurement::{Run, Sampling};
use crate::metric::characteristics;
use crate::parallel::parallel;
use serde::Serialize;

/// Shortest first part of a run in s.
const LEAST_LEARNED: f64 = 0.04;
/// Cycles in the first part of a run.
const CYCLES_LEARNED: f64 = 2.0;
/// Error over the standard deviation of the displacement at which a forecast is no longer valid.
const VALID: f64 = 0.4;
/// Error over that deviation that counts for a forecast that ran away: as far off as the motion is wide.
const RAN_AWAY: f64 = 2.0;
/// Seed of the noise on the model's own motion.
const SEED: u64 = 1;

/// A number as measured and as predicted.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Compared {
    /// As measured; `None` where the motion has none.
    pub measured: Option<f64>,
    /// As predicted.
    pub predicted: Option<f64>,
}

/// The forecast of a run.
#[derive(Debug, Clone, Serialize)]
pub struct Forecast {
    /// Name of the run.
    pub run: String,
    /// Length in s of the first part, from which the run's own values and its state were learned.
    pub learned_s: f64,
    /// Root mean square error of one-cycle forecasts over the standard deviation of the displacement.
    pub one_cycle_nrmse: f64,
    /// Time in s for which the free motion stays near the measured one; as long as the run lasts, if it never leaves it.
    pub valid_time_s: f64,
    /// The same for the model's own motion with the sensor's noise.
    pub valid_time_limit_s: f64,
    /// Period of the motion after the first part in s.
    pub period_s: Compared,
    /// Amplitude of it in m.
    pub amplitude_m: Compared,
    /// Share of the time in stick.
    pub stick_share: Compared,
    /// Index of the run.
    #[serde(skip)]
    pub index: usize,
    /// Times in s since the run began, and the free motion predicted in m, NaN once it was given up.
    #[serde(skip)]
    pub curve: (Vec<f64>, Vec<f64>),
}

/// Forecasts of the runs kept out.
///
/// # Errors
/// An FMU that can't be run.
pub fn forecasts(problem: &Problem, fitted: &FittedHypothesis) -> Result<Vec<Forecast>, Error> {
    let runs: Vec<usize> = (0..problem.held_out.len())
        .filter(|&r| problem.held_out[r])
        .collect();
    let found = parallel(&runs, |&r| forecast(problem, fitted, r))?;
    Ok(found.into_iter().flatten().collect())
}

/// The forecast of run `r`; `None` for a run that is not longer than what must be learned from.
fn forecast(
    problem: &Problem,
    fitted: &FittedHypothesis,
    r: usize,
) -> Result<Option<Forecast>, Error> {
    let measured = &problem.campaign.runs[r];
    let cycle = problem.smoothings[r].cycle;
    let learned_s = if cycle.is_finite() {
        LEAST_LEARNED.max(CYCLES_LEARNED * cycle)
    } else {
        LEAST_LEARNED
    }
    // A whole piece must fit into it.
    .max(2.5 * problem.horizon);
    let Some(seen) = Seen::new(problem, fitted, measured, r, learned_s)? else {
        return Ok(None);
    };
    let ahead = seen.ahead()?;
    let (time, free) = seen.after(&ahead);
    let spread = problem.spread[r];
    let valid_time_s = valid_time(&time, &measured.displacement[seen.past..], free, spread);
    // The model's own motion, measured by the same sensor.
    let mut random = fastrand::Rng::with_seed(SEED);
    let noise = problem.noise[r];
    let before = &measured.displacement[..seen.last.first];
    let truth = [before, &ahead].concat();
    let per_run = Run {
        displacement: truth
            .iter()
            .map(|y| y + noise * gaussian(&mut random))
            .collect(),
        faults: Vec::new(),
        ..measured.clone()
    };
    let limit = match Seen::new(problem, fitted, &per_run, r, learned_s)? {
        Some(again) if truth.iter().all(|y| y.is_finite()) => {
            let ahead = again.ahead()?;
            let (time, free) = again.after(&ahead);
            valid_time(&time, &truth[again.past..], free, spread)
        }
        _ => f64::NAN,
    };
    let of_measured = &measured.displacement[seen.past..];
    let belt = measured.belt_velocity;
    let described = |values: &[f64]| {
        let usable = values.len() > 32 && values.iter().all(|v| v.is_finite());
        usable.then(|| characteristics(&time, values, belt, noise))
    };
    let (seen_there, predicted) = (described(of_measured), described(free));
    let compared = |read: &dyn Fn(&crate::metric::Characteristics) -> Option<f64>| Compared {
        measured: seen_there.as_ref().and_then(read),
        predicted: predicted.as_ref().and_then(read),
    };
    Ok(Some(Forecast {
        run: measured.name.clone(),
        learned_s,
        one_cycle_nrmse: seen.one_cycle()? / spread,
        valid_time_s,
        valid_time_limit_s: limit,
        period_s: compared(&|c| c.period),
        amplitude_m: compared(&|c| Some(c.amplitude)),
        stick_share: compared(&|c| Some(c.stick_fraction)),
        index: r,
        curve: (time.clone(), free.to_vec()),
    }))
}

/// Time in s until the error exceeds [`VALID`] of the spread.
fn valid_time(time: &[f64], measured: &[f64], predicted: &[f64], spread: f64) -> f64 {
    let wrong = measured
        .iter()
        .zip(predicted)
        .position(|(m, p)| !((m - p).abs() <= VALID * spread));
    match (wrong, time) {
        (_, []) => f64::NAN,
        (Some(k), _) => time[k] - time[0],
        (None, _) => time[time.len() - 1] - time[0],
    }
}

/// A run of which the first part has been learned.
struct Seen<'a> {
    problem: &'a Problem<'a>,
    hypothesis: &'a Hypothesis,
    /// All runs of the campaign, this one as it is learned from.
    runs: Vec<Run>,
    index: usize,
    shared: Vec<f64>,
    per_run: Vec<f64>,
    /// The last piece of the first part, and where it starts.
    last: Segment,
    start: SegmentStart,
    /// Index of the first sample that was not learned from.
    past: usize,
}

impl<'a> Seen<'a> {
    /// Learns the first `learned` s of a run; `None` where nothing is left to predict or no piece fits in.
    fn new(
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
        let beginning = Run {
            time: run.time[..past].to_vec(),
            displacement: run.displacement[..past].to_vec(),
            sampling: Sampling::of(&run.time[..past]),
            faults: run
                .faults
                .iter()
                .filter(|f| f.first + f.samples <= past)
                .cloned()
                .collect(),
            ..run.clone()
        };
        let structure = structure(problem.fmu, &problem.campaign.beam)?;
        let Ok(smoothing) = smooth_run(&beginning, &structure) else {
            return Ok(None);
        };
        let segments = cut(index, &beginning, &smoothing, problem.horizon);
        let Some(last) = segments.last().cloned() else {
            return Ok(None);
        };
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
        let shared = found.point.shared.clone();
        let per_run = found.point.per_run[index].clone();
        let start = found.point.start(segments.len() - 1);
        Ok(Some(Self {
            problem,
            hypothesis: h,
            runs,
            index,
            shared,
            per_run,
            last,
            start,
            past,
        }))
    }

    fn predictor(&self) -> Result<Predictor<'_>, Error> {
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
    fn motion(
        &self,
        predictor: &mut Predictor,
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
            shared: &self.shared,
            per_run: &self.per_run,
            state: &start.state,
            stuck: start.stuck,
        };
        // A motion that the FMU can't follow ends there.
        let _ = predictor.predict(&long, values, Samples::all(&long), &mut out);
        out.resize(range.len(), f64::NAN);
        out
    }

    /// The free motion from the start of the last piece learned from to the end of the run.
    fn ahead(&self) -> Result<Vec<f64>, Error> {
        let end = self.runs[self.index].time.len();
        Ok(self.motion(&mut self.predictor()?, &self.last, &self.start, end))
    }

    /// Times since the run began, and what of the motion [`Self::ahead`] lies after the first part.
    fn after<'b>(&self, ahead: &'b [f64]) -> (Vec<f64>, &'b [f64]) {
        let time = &self.runs[self.index].time;
        let since = time[self.past..].iter().map(|t| t - time[0]);
        (since.collect(), &ahead[self.past - self.last.first..])
    }

    /// Root mean square error in m of forecasts of each piece after the first part from the piece before it.
    fn one_cycle(&self) -> Result<f64, Error> {
        let (problem, h, r) = (self.problem, self.hypothesis, self.index);
        let run = &self.runs[r];
        let segments = cut(r, run, &problem.smoothings[r], problem.horizon);
        let mut point = Point::centre(h, &segments);
        point.shared.clone_from(&self.shared);
        point.per_run[r].clone_from(&self.per_run);
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
            let all = self.motion(&mut predictor, from, &filtered.start(k - 1), end);
            let past = from.first + from.time.len();
            for i in past..end {
                if !trusted[i] {
                    continue;
                }
                let error = run.displacement[i] - all[i - from.first];
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
fn learning() -> FitOptions {
    FitOptions {
        stride: 1,
        shared: false,
        ..FitOptions::search(6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_forecast_is_valid_until_it_first_errs_by_more_than_its_share_of_the_spread() {
        let time = [0.0, 0.1, 0.2, 0.3];
        let measured = [1.0, 2.0, 3.0, 4.0];
        // The bound is 0.4 of a spread of 1; later agreement does not count.
        assert_eq!(
            valid_time(&time, &measured, &[1.3, 2.39, 3.5, 4.0], 1.0),
            0.2
        );
        assert_eq!(valid_time(&time, &measured, &measured, 1.0), 0.3);
        // What ran away is wrong from there on.
        let run_away = [1.0, f64::NAN, 3.0, 4.0];
        assert_eq!(valid_time(&time, &measured, &run_away, 1.0), 0.1);
        assert!(valid_time(&[], &[], &[], 1.0).is_nan());
    }
}
