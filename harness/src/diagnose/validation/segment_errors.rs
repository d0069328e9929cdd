//! How well a fitted hypothesis predicts: on the runs it was fitted to and on those kept out.
//!
//! On a run kept out the common parameters stay as fitted. Run-specific parameters (friction level,
//! offset, phases, profile) is estimated on every second segment of the run and judged on the others; start
//! states are estimated on the segment itself. Where no run can be kept out, the same is done with every
//! second segment of the runs there are.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::{Fit, FittedHypothesis};
use crate::diagnose::estimation::fit_options::{Care, FitOptions, STRIDE};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::nesting::{widen_per_run, widen_state};
use crate::diagnose::estimation::run_parameters;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::thresholds::{LOST, LOST_BY_CHANCE, UNLIKELY};
use crate::error::Error;
use crate::metric::median;
use std::collections::BTreeMap;

/// Errors of prediction.
#[derive(Debug, Clone)]
pub struct SegmentErrors {
    /// Root mean square error over the standard deviation of the displacement, by the first sensor.
    pub nrmse: f64,
    /// The same for each run (NaN for runs not judged).
    pub by_run: Vec<f64>,
    /// Mean square error of each segment over the noise's, by all sensors, sorted.
    pub ratio: Vec<f64>,
    /// Runs of which more segments are lost than by chance; where that holds of all together, those that lose any.
    pub unmet_runs: Vec<UnmetRun>,
    /// Objective as the fit was done, in a search mostly without the worst fifth of the segments.
    pub trimmed: f64,
    /// Indices of the segments judged.
    pub segments: Vec<usize>,
    /// Mean square error of each of them in m^2, by all sensors.
    pub mean_square: Vec<f64>,
    /// Root of the median mean square error of each further sensor, in units of its noise; NaN where it read nothing.
    pub of_further: Vec<f64>,
    /// Where the parameters stood for them.
    pub point: Point,
    /// Of a errors on what was kept out, the segments that taught and those judged, and where all stood in the end.
    pub all_segments: Option<(Vec<usize>, Point)>,
}

/// A run that a hypothesis does not meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnmetRun {
    /// Its number.
    pub run: usize,
    /// How many of its segments are lost.
    pub lost: usize,
    /// How many were judged.
    pub judged: usize,
    /// Median error of those lost, in units of the noise.
    pub over_noise: f64,
}

impl SegmentErrors {
    /// Root of the `share`-quantile of the mean square errors, in units of the noise.
    pub fn quantile(&self, share: f64) -> f64 {
        match self.ratio.len() {
            0 => f64::NAN,
            n => self.ratio[((n - 1) as f64 * share).round() as usize].sqrt(),
        }
    }

    /// How many segments are lost.
    pub(crate) fn lost(&self) -> usize {
        let lost = |ratio: &&f64| **ratio > LOST * LOST;
        self.ratio.iter().filter(lost).count()
    }

    /// The run that is met worst, where the errors of its lost segments are beyond the upper quartile of all.
    fn worst_run(&self) -> Option<&UnmetRun> {
        let beyond = |unmet: &&UnmetRun| unmet.over_noise > self.quantile(0.75);
        let runs = self.unmet_runs.iter().filter(beyond);
        runs.max_by(|a, b| a.over_noise.total_cmp(&b.over_noise))
    }

    /// The upper quartile of the errors, or that of the lost segments of the run that is met worst where it is more, in units of the noise.
    fn worst_over_noise(&self) -> f64 {
        let worst = self.worst_run();
        worst.map_or(self.quantile(0.75), |unmet| unmet.over_noise)
    }

    /// The same in words.
    pub fn over_noise_words(&self, problem: &Problem) -> String {
        let place = match self.worst_run() {
            Some(unmet) => unmet.words(problem),
            None => "a quarter of the segments".to_owned(),
        };
        format!("{:.1} times the noise in {place}", self.worst_over_noise())
    }
}

impl UnmetRun {
    /// What is lost, as in `5 of 12 segments of run02`.
    pub fn words(&self, problem: &Problem) -> String {
        let run = &problem.campaign.runs[self.run].name;
        format!("{} of {} segments of {run}", self.lost, self.judged)
    }
}

/// Judges a fit by its residuals.
pub fn of_fit(problem: &Problem, segments: &[usize], fit: &Fit) -> SegmentErrors {
    let count = problem.campaign.runs.len();
    let mut squares = vec![Vec::new(); count];
    let mut ratio = Vec::new();
    for (place, (&k, m)) in segments.iter().zip(&fit.mean_square).enumerate() {
        let run = problem.segments[k].run;
        squares[run].push(fit.of_first_sensor(place));
        ratio.push(m / problem.noise[run].powi(2));
    }
    ratio.sort_by(f64::total_cmp);
    let by_run: Vec<f64> = squares
        .iter_mut()
        .zip(&problem.spread)
        .map(|(s, spread)| typical(s).sqrt() / spread)
        .collect();
    let judged: Vec<f64> = by_run.iter().copied().filter(|v| v.is_finite()).collect();
    let nrmse = (judged.iter().map(|v| v * v).sum::<f64>() / judged.len() as f64).sqrt();
    SegmentErrors {
        nrmse,
        by_run,
        ratio,
        unmet_runs: unmet_runs(problem, segments, fit),
        trimmed: fit.trimmed,
        segments: segments.to_vec(),
        mean_square: fit.mean_square.clone(),
        of_further: of_further(problem, segments, fit),
        point: fit.point.clone(),
        all_segments: None,
    }
}

/// Runs of which more segments are lost than by chance; `segments` says where those fitted stand in the problem's list.
pub(crate) fn unmet_runs(problem: &Problem, segments: &[usize], fit: &Fit) -> Vec<UnmetRun> {
    debug_assert_eq!(segments.len(), fit.mean_square.len(), "fitted to others");
    let errors = segments.iter().zip(&fit.mean_square);
    unmet(errors.map(|(&k, mean_square)| {
        let run = problem.segments[k].run;
        (run, mean_square.sqrt() / problem.noise[run])
    }))
}

/// Runs of which more segments are lost than by chance, from each segment's run and error over the noise; those that lose any, where that
/// holds of all together.
fn unmet(errors: impl Iterator<Item = (usize, f64)>) -> Vec<UnmetRun> {
    let mut of_runs: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for (run, over_noise) in errors {
        of_runs.entry(run).or_default().push(over_noise);
    }
    let judged: Vec<UnmetRun> = of_runs
        .into_iter()
        .map(|(run, over_noise)| {
            let mut lost: Vec<f64> = over_noise.iter().copied().filter(|e| *e > LOST).collect();
            UnmetRun {
                run,
                lost: lost.len(),
                judged: over_noise.len(),
                over_noise: median(&mut lost),
            }
        })
        .collect();
    let is_unlikely = |lost: usize, judged: usize| lost_by_chance(lost, judged) < UNLIKELY;
    let all = |count: fn(&UnmetRun) -> usize| judged.iter().map(count).sum();
    let are_many = is_unlikely(all(|r| r.lost), all(|r| r.judged));
    judged
        .into_iter()
        .filter(|r| r.lost > 0 && (are_many || is_unlikely(r.lost, r.judged)))
        .collect()
}

/// Probability that of so many segments at least so many are lost by chance, each with [`LOST_BY_CHANCE`]: the upper tail of the binomial
/// distribution.
fn lost_by_chance(lost: usize, judged: usize) -> f64 {
    let p = LOST_BY_CHANCE;
    let mut exactly = (1.0 - p).powi(judged as i32);
    let mut fewer = 0.0;
    for k in 0..lost {
        fewer += exactly;
        exactly *= (judged - k) as f64 / (k + 1) as f64 * p / (1.0 - p);
    }
    1.0 - fewer
}

/// Root of the median mean square error of each further sensor, over its noise.
fn of_further(problem: &Problem, segments: &[usize], fit: &Fit) -> Vec<f64> {
    let of_sensor = |number: usize| {
        let mut ratio = Vec::new();
        for (&k, squares) in segments.iter().zip(&fit.by_sensor) {
            let segment = &problem.segments[k];
            let read = segment.further.iter().zip(&squares[1..]);
            let own = read.filter(|(part, square)| part.sensor == number && !square.is_nan());
            ratio.extend(own.map(|(_, square)| square / problem.noise[segment.run].powi(2)));
        }
        ratio.sort_by(f64::total_cmp);
        let middle = ratio.get(ratio.len() / 2).copied();
        middle.map_or(f64::NAN, f64::sqrt)
    };
    let sensors = 0..problem.campaign.further_sensors.len();
    sensors.map(of_sensor).collect()
}

/// Share of the segments of a run that an error leaves out: those that graze a transition, where the
/// prediction turns on the last digit of the start state even with the true model.
pub const GRAZING: f64 = 0.1;

/// Mean of the squares without the largest tenth; NaN if there are none.
pub fn typical(squares: &mut [f64]) -> f64 {
    squares.sort_by(f64::total_cmp);
    let kept = &squares[..squares.len() - (squares.len() as f64 * GRAZING) as usize];
    kept.iter().sum::<f64>() / kept.len() as f64
}

/// Segments on which a held-out errors estimates what is a run's own, and those it judges.
pub fn held_out_segments(problem: &Problem) -> (Vec<usize>, Vec<usize>) {
    let none = !problem.held_out.iter().any(|h| *h);
    let pick = |parity: usize| -> Vec<usize> {
        (0..problem.campaign.runs.len())
            .filter(|&run| none || problem.held_out[run])
            .flat_map(|run| {
                let of_run: Vec<usize> = (0..problem.segments.len())
                    .filter(|&k| problem.segments[k].run == run)
                    .collect();
                of_run
                    .into_iter()
                    .enumerate()
                    .filter(move |(i, _)| i % 2 == parity)
                    .map(|(_, k)| k)
                    .collect::<Vec<_>>()
            })
            .collect()
    };
    (pick(0), pick(1))
}

/// Every how many-th of the segments kept out is used in a brief errors.
const BRIEF_EVERY: usize = 3;

/// Judges a hypothesis on what its fit has not seen.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn held_out(
    problem: &Problem,
    fitted: &FittedHypothesis,
    care: Care,
) -> Result<SegmentErrors, Error> {
    held_out_from(problem, fitted, care, None)
}

/// The same, what is a run's own (but for phases, which are looked for all round) and the start states being looked for
/// from where a smaller hypothesis, judged before, found them.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn held_out_from(
    problem: &Problem,
    fitted: &FittedHypothesis,
    care: Care,
    smaller: Option<(&Hypothesis, &SegmentErrors)>,
) -> Result<SegmentErrors, Error> {
    let (mut learn, mut test) = held_out_segments(problem);
    if care == Care::Brief {
        // The same places in both, so that each segment judged follows one that teaches.
        let some = |list: Vec<usize>| list.into_iter().step_by(BRIEF_EVERY).collect();
        (learn, test) = (some(learn), some(test));
    }
    let h = &fitted.hypothesis;
    let mut predictor = problem.predictor(h)?;
    // What varies with the place on the belt can be learned only where the run passes: there every segment
    // teaches, and what is judged are the samples in between those used (every second).
    let local = h.per_run.iter().flatten().any(|k| k.support.is_some());
    let mut both: Vec<usize> = learn.iter().chain(&test).copied().collect();
    both.sort_unstable();
    let learn = if local { both.clone() } else { learn };
    let learn_segments = problem.copies(&learn);
    let mut start = from_fitted_runs(problem, fitted, &learn_segments);
    if let Some((known, judged)) = smaller {
        let out: Vec<usize> = (0..problem.held_out.len())
            .filter(|&run| problem.held_out[run])
            .collect();
        take_over(h, &learn, &mut start, known, judged, &out);
    }
    let iterations = match (care, local) {
        (Care::Brief, false) => 3,
        (Care::Thorough, false) => 6,
        // Many values of its own, from nothing known.
        (_, true) => 15,
    };
    let options = FitOptions {
        shared: false,
        draws: care == Care::Thorough,
        ..FitOptions::search(iterations)
    };
    let data = problem.data(&learn_segments);
    let learned = run_parameters::learn(&mut predictor, h, &data, start, options, care);
    // Both halves together, so that a start can be taken from the end of the segment before.
    let segments = problem.copies(&both);
    let mut start = Point::centre(h, &segments);
    start.shared = learned.point.shared;
    start.per_run = learned.point.per_run;
    if let Some((known, judged)) = smaller {
        take_over(h, &both, &mut start, known, judged, &[]);
    }
    let data = problem.data(&segments);
    let judged = FitOptions {
        stride: if local { 1 } else { STRIDE },
        ..options
    };
    let fit = Fitter::new(&mut predictor, h, &data, judged).fit_initial_states(start);
    let judged = of_fit(problem, &test, &only(&fit, &both, &test));
    Ok(SegmentErrors {
        all_segments: Some((both, fit.point)),
        ..judged
    })
}

/// Where what runs kept out have of their own is looked for: the shared parameters as fitted, and their own near those of the runs fitted.
///
/// Friction levels of runs on one rig lie near each other, perhaps far from what was believed of them.
pub(crate) fn from_fitted_runs(
    problem: &Problem,
    fitted: &FittedHypothesis,
    segments: &[Segment],
) -> Point {
    let h = &fitted.hypothesis;
    let mut start = Point::centre(h, segments);
    start.shared.clone_from(&fitted.fit.point.shared);
    let (out, learned): (Vec<usize>, Vec<usize>) =
        (0..problem.held_out.len()).partition(|&run| problem.held_out[run]);
    for &run in &learned {
        start.per_run[run].clone_from(&fitted.fit.point.per_run[run]);
    }
    start.spread_per_run(h, &learned, &out);
    start
}

/// Takes the start states of the segments `list`, and what the runs `runs` have of their own, from where a smaller
/// hypothesis stood when it was judged.
fn take_over(
    h: &Hypothesis,
    list: &[usize],
    start: &mut Point,
    known: &Hypothesis,
    judged: &SegmentErrors,
    runs: &[usize],
) {
    let Some((segments, point)) = &judged.all_segments else {
        return;
    };
    for &run in runs {
        let own = &mut start.per_run[run];
        widen_per_run(
            (&known.per_run[run], &point.per_run[run]),
            &h.per_run[run],
            own,
        );
    }
    for (place, k) in list.iter().enumerate() {
        let Some(there) = segments.iter().position(|s| s == k) else {
            continue;
        };
        widen_state(known, &point.states[there], h, &mut start.states[place]);
        start.stuck[place] = point.stuck[there];
    }
}

/// The part of a fit that belongs to some of its segments.
fn only(fit: &Fit, all: &[usize], wanted: &[usize]) -> Fit {
    let places: Vec<usize> = wanted
        .iter()
        .filter_map(|k| all.iter().position(|a| a == k))
        .collect();
    fit.of_segments(&places)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_unmet_of_which_more_segments_are_lost_than_by_chance() {
        let is_unmet = |met: usize, lost: usize| {
            let errors = [vec![1.1; met], vec![40.0; lost]].concat();
            !unmet(errors.into_iter().map(|e| (0, e))).is_empty()
        };
        for (met, lost, is) in [
            (3, 0, false),
            (0, 1, false),
            (1, 2, true),
            (5, 1, false),
            (4, 2, false),
            (10, 2, false),
            (9, 3, true),
            (78, 4, false),
            (76, 6, true),
        ] {
            assert_eq!(is_unmet(met, lost), is, "{met} met, {lost} lost");
        }
        // Off, but not lost: of that the quartile of all segments tells.
        assert!(unmet([(0, 2.0); 9].into_iter()).is_empty());
    }

    // Source: the binomial distribution for 12 segments, by its terms.
    #[test]
    fn val_segments_lost_by_chance_are_binomial() {
        let p = LOST_BY_CHANCE;
        let none = (1.0 - p).powi(12);
        let one = 12.0 * p * (1.0 - p).powi(11);
        let two = 66.0 * p * p * (1.0 - p).powi(10);
        for (lost, expected) in [(0, 1.0), (1, 1.0 - none), (3, 1.0 - none - one - two)] {
            let found = lost_by_chance(lost, 12);
            assert!((found - expected).abs() < 1e-14, "{found} for {expected}");
        }
        assert!((lost_by_chance(12, 12) - p.powi(12)).abs() < 1e-14);
    }

    #[test]
    fn what_is_lost_in_many_runs_is_no_chance_though_it_may_be_in_each() {
        let of_run = |run: usize| {
            let errors = [vec![1.1; 10], vec![40.0; if run < 4 { 2 } else { 0 }]].concat();
            errors.into_iter().map(move |e| (run, e))
        };
        assert!(unmet(of_run(0)).is_empty());
        let runs: Vec<usize> = unmet((0..5).flat_map(of_run))
            .iter()
            .map(|r| r.run)
            .collect();
        assert_eq!(runs, [0, 1, 2, 3]);
    }

    #[test]
    fn what_is_lost_of_a_run_is_told() {
        let errors = [
            (0, 1.0),
            (2, 40.0),
            (0, 1.3),
            (2, 30.0),
            (2, 1.1),
            (0, 1.2),
            (4, 0.9),
        ];
        let found = UnmetRun {
            run: 2,
            lost: 2,
            judged: 3,
            over_noise: 40.0,
        };
        assert_eq!(unmet(errors.into_iter()), [found]);
    }
}
