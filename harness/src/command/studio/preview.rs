//! Predicts all segments of a campaign by a draft, fast enough to follow a slider.
//!
//! Each segment has a start of its own, which belongs to no model but to the measurement, and has to be found anew where the model
//! changes. A [`Base`] holds for each segment where a rung of the ladder starts it and the linear estimate of a better start from the
//! residual. [`quick`] predicts from there, corrects the starts once by that estimate, and predicts again: twice the cost of a
//! prediction, no derivative. [`careful`] finds them by least squares. Both depend on the draft and the base alone, not on the way
//! of the slider.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::model::{Draft, Starts, hypothesis, point};
use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::estimation::fitter::{Fitter, directions};
use crate::diagnose::estimation::scaled_matrix::scaled_inverse;
use crate::diagnose::estimation::sensitivities::Turned;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::segment_errors::typical;
use crate::error::Error;
use crate::parallel::parallel;

/// Every how many-th sample counts while a slider moves: 1.25 kHz of a record at 10 kHz.
const QUICK_STRIDE: usize = 8;
/// The same for what is kept.
const CAREFUL_STRIDE: usize = 2;
/// Steps of least squares for what is kept.
const CAREFUL_STEPS: usize = 8;
/// Damping of the linear estimate, relative to the diagonal.
const DAMPING: f64 = 1e-4;
/// Parts of the work for each processor: enough that none waits for the last, few as each needs an instance of the FMU.
const PARTS: usize = 2;
/// Error of a segment, over the standard deviation of the run's measurement, beyond which the motion has left the measurement.
const AWAY: f64 = 2.0;

/// Errors of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Of each run: root mean square error over the standard deviation of what is measured, without the tenth of the segments that
    /// graze a transition; `None` for a run without segments.
    pub by_run: Vec<Option<f64>>,
    /// Of the runs that are fitted.
    pub fitted: Option<f64>,
    /// Of those kept out; `None` where none is.
    pub kept_out: Option<f64>,
    /// Segments in which the motion ran away from the measurement.
    pub ran_away: usize,
    /// Segments in all.
    pub segments: usize,
}

/// A draft, predicted.
pub struct Predicted {
    /// Its hypothesis.
    pub hypothesis: Hypothesis,
    /// Its parameters, and where its segments start.
    pub point: Point,
    /// Mean square residual of each segment, in the square of the sensor's unit.
    pub mean_square: Vec<f64>,
    /// Its errors.
    pub errors: Errors,
}

impl Predicted {
    /// Where its segments start.
    pub fn starts(&self) -> Starts {
        Starts {
            states: self.point.states.clone(),
            stuck: self.point.stuck.clone(),
        }
    }
}

/// Where predictions start.
pub struct Base {
    hypothesis: Hypothesis,
    starts: Starts,
    /// For each segment the matrix that makes a better start of a residual; `None` where the FMU gave up.
    corrections: Vec<Option<DMatrix<f64>>>,
}

impl Base {
    /// The base at a point of a hypothesis, its segments starting as they do there.
    ///
    /// # Errors
    /// An FMU that can't be instantiated.
    pub fn at(problem: &Problem, h: Hypothesis, point: &Point) -> Result<Base, Error> {
        let parts = parallel(&parts(problem.segments.len()), |part| {
            let data = problem.data(&problem.segments[part.clone()]);
            let mut predictor = problem.predictor(&h)?;
            let mut fitter = Fitter::new(&mut predictor, &h, &data, options(QUICK_STRIDE));
            let here = fitter.evaluate(part_of(point, part));
            let one = |k: usize| {
                let residual = here.residual[k].clone()?;
                let linear = fitter.linearise(k, &here.point, residual, Turned::State);
                let inverse = scaled_inverse(&linear.states.tr_mul(&linear.states), DAMPING)?;
                Some(inverse * linear.states.transpose())
            };
            Ok((0..part.len()).map(one).collect::<Vec<_>>())
        })?;
        Ok(Base {
            hypothesis: h,
            starts: Starts {
                states: point.states.clone(),
                stuck: point.stuck.clone(),
            },
            corrections: parts.into_iter().flatten().collect(),
        })
    }

    /// What starts segments.
    pub fn starts(&self) -> (&Hypothesis, &Starts) {
        (&self.hypothesis, &self.starts)
    }

    /// A better start of segment `k` than that in `point`, where `residual` is left.
    fn correct(&self, k: usize, residual: &[f64], stuck: bool, state: &mut [f64]) {
        let list = directions(&self.hypothesis, stuck);
        if let Some(matrix) = &self.corrections[k]
            && matrix.ncols() == residual.len()
            && matrix.nrows() == list.len()
            && stuck == self.starts.stuck[k]
        {
            let step = matrix * DVector::from_column_slice(residual);
            // States of effects come after the modal ones, and those of the base need not be those here.
            let modal = 2 * self.hypothesis.modes;
            for (change, &i) in step.iter().zip(&list).filter(|(_, i)| **i < modal) {
                state[i] += change;
            }
        }
    }
}

/// Predicts every segment from a base, its start corrected once. `None` once `superseded` is set.
///
/// # Errors
/// A draft that is none of this FMU's, or an FMU that can't be instantiated.
pub fn quick(
    problem: &Problem,
    draft: &Draft,
    base: &Base,
    superseded: &AtomicBool,
) -> Result<Option<Predicted>, Error> {
    let h = hypothesis(problem, draft)?;
    let point = point(problem, &h, draft, Some(base.starts()))?;
    over_parts(
        problem,
        h,
        point,
        superseded,
        |h, segments, start, first| {
            let data = problem.data(segments);
            let mut predictor = problem.predictor(h)?;
            let mut fitter = Fitter::new(&mut predictor, h, &data, options(QUICK_STRIDE));
            let here = fitter.evaluate(start);
            let mut better = here.point.clone();
            for (k, residual) in here.residual.iter().enumerate() {
                if let Some(residual) = residual {
                    base.correct(first + k, residual, better.stuck[k], &mut better.states[k]);
                }
            }
            let there = fitter.evaluate(better);
            let (mut reached, mut sums) = (there.point, there.sums);
            for k in 0..sums.len() {
                if here.sums[k] < sums[k] {
                    sums[k] = here.sums[k];
                    reached.states[k].clone_from(&here.point.states[k]);
                }
            }
            let count = |k: usize| fitter.count(k);
            let squares = (0..sums.len()).map(|k| sums[k] / count(k)).collect();
            Ok((reached, squares))
        },
    )
}

/// Predicts every segment, its start found by least squares from where `from` has it. `None` once `superseded` is set.
///
/// # Errors
/// As [`quick`].
pub fn careful(
    problem: &Problem,
    draft: &Draft,
    from: Option<(&Hypothesis, &Starts)>,
    superseded: &AtomicBool,
) -> Result<Option<Predicted>, Error> {
    let h = hypothesis(problem, draft)?;
    let point = point(problem, &h, draft, from)?;
    // Without a start from a model the smoothed ones are too far off for a few steps.
    let is_first = from.is_none();
    over_parts(problem, h, point, superseded, |h, segments, start, _| {
        let data = problem.data(segments);
        let mut predictor = problem.predictor(h)?;
        let mut fitter = Fitter::new(&mut predictor, h, &data, options(CAREFUL_STRIDE));
        let mut fit = fitter.follow_initial_states(start.clone(), CAREFUL_STEPS);
        if is_first {
            // From afar a growing share of the segment finds some starts that the whole of it misses, and misses others.
            let grown = fitter.fit_initial_states(start);
            for k in 0..segments.len() {
                if grown.mean_square[k] < fit.mean_square[k] {
                    fit.mean_square[k] = grown.mean_square[k];
                    fit.point.put(k, grown.point.start(k));
                }
            }
            if fitter.try_carried_on(&mut fit.point) {
                fit = fitter.follow_initial_states(fit.point, 0);
            }
        }
        Ok((fit.point, fit.mean_square))
    })
}

/// [`careful`] for what nothing supersedes.
///
/// # Errors
/// As [`quick`].
pub fn careful_to_its_end(
    problem: &Problem,
    draft: &Draft,
    from: Option<(&Hypothesis, &Starts)>,
) -> Result<Predicted, Error> {
    let never = AtomicBool::new(false);
    let predicted = careful(problem, draft, from, &never)?;
    Ok(predicted.expect("nothing supersedes it"))
}

/// Work on the segments of a part: what is reached from a start, and the mean square residuals.
type PartDone = (Point, Vec<f64>);

fn over_parts(
    problem: &Problem,
    h: Hypothesis,
    mut point: Point,
    superseded: &AtomicBool,
    work: impl Fn(&Hypothesis, &[Segment], Point, usize) -> Result<PartDone, Error> + Sync,
) -> Result<Option<Predicted>, Error> {
    let parts = parts(problem.segments.len());
    let done = parallel(&parts, |part| {
        if superseded.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let segments = &problem.segments[part.clone()];
        work(&h, segments, part_of(&point, part), part.start).map(Some)
    })?;
    let mut mean_square = Vec::with_capacity(problem.segments.len());
    for (part, done) in parts.iter().zip(done) {
        let Some((reached, squares)) = done else {
            return Ok(None);
        };
        point.states[part.clone()].clone_from_slice(&reached.states);
        point.stuck[part.clone()].copy_from_slice(&reached.stuck);
        mean_square.extend(squares);
    }
    Ok(Some(Predicted {
        errors: errors(problem, &mean_square),
        mean_square,
        hypothesis: h,
        point,
    }))
}

fn parts(count: usize) -> Vec<Range<usize>> {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let size = count.div_ceil(PARTS * threads).max(1);
    let firsts = (0..count).step_by(size);
    firsts.map(|i| i..(i + size).min(count)).collect()
}

fn part_of(point: &Point, part: &Range<usize>) -> Point {
    Point {
        shared: point.shared.clone(),
        per_run: point.per_run.clone(),
        states: point.states[part.clone()].to_vec(),
        stuck: point.stuck[part.clone()].to_vec(),
    }
}

fn options(stride: usize) -> FitOptions {
    FitOptions {
        stride,
        ..FitOptions::search(0)
    }
}

/// The errors that mean square residuals of all segments make.
fn errors(problem: &Problem, mean_square: &[f64]) -> Errors {
    let mut squares = vec![Vec::new(); problem.campaign.runs.len()];
    let mut ran_away = 0;
    for (segment, square) in problem.segments.iter().zip(mean_square) {
        squares[segment.run].push(*square);
        ran_away += usize::from(!(square.sqrt() <= AWAY * problem.spread[segment.run]));
    }
    let finite = |value: f64| value.is_finite().then_some(value);
    let of_runs = squares.iter_mut().zip(&problem.spread);
    let by_run: Vec<Option<f64>> = of_runs
        .map(|(squares, spread)| finite(typical(squares).sqrt() / spread))
        .collect();
    let mean = |out: bool| {
        let of = by_run.iter().zip(&problem.held_out);
        let of: Vec<f64> = of
            .filter(|(_, held)| **held == out)
            .filter_map(|(error, _)| error.map(|e| e * e))
            .collect();
        finite((of.iter().sum::<f64>() / of.len() as f64).sqrt())
    };
    Errors {
        fitted: mean(false),
        kept_out: mean(true),
        by_run,
        ran_away,
        segments: mean_square.len(),
    }
}
