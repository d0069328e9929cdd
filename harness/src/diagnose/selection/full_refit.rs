//! Models fitted to all segments of the runs fitted, not only to those on which they are compared.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::initialisation::multistart;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::fitted_model::{FittedModel, fits_better, is_met};
use crate::diagnose::selection::lost_runs::LostRuns;
use crate::diagnose::thresholds::MOST_SPECTRAL_RATIO;
use crate::diagnose::validation::prior_conflict::prior_conflict;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::diagnose::validation::{residual_whiteness, segment_errors};
use crate::error::Error;

/// Jacobians for the last fit of a model that explains the data.
const REFIT: usize = 40;
/// The same for one that does not: its parameters mean little.
const REFIT_OF_WRONG: usize = 8;
/// The same for a look at fewer segments from the optimum on all.
const SEEN: usize = 8;
/// Fall of the objective, as a share of it, below which that fit ends: parameters may trade along a narrow
/// valley.
const REFIT_TOLERANCE: f64 = 1e-6;

/// The options of a last fit of a model that explains the data; starts are drawn in all fits that are compared with it.
pub fn last_options() -> FitOptions {
    FitOptions {
        tolerance: REFIT_TOLERANCE,
        patience: 2,
        stride: 1,
        robust: false,
        draws: true,
        ..FitOptions::search(REFIT)
    }
}

/// The options of the fit before it, while single segments may still be far off.
fn leading_in() -> FitOptions {
    FitOptions {
        draws: true,
        ..FitOptions::search(REFIT)
    }
}

/// A model fitted to `segments`, which stand at `all` in the problem's list.
///
/// # Errors
/// An FMU that can't be run.
pub fn refit(
    problem: &Problem,
    model: &FittedModel,
    all: &[usize],
    segments: &[Segment],
) -> Result<FittedHypothesis, Error> {
    let h = problem.hypothesis(&model.choices)?;
    let mut start = Point::centre(&h, segments);
    start.shared.clone_from(&model.fitted.fit.point.shared);
    start.per_run.clone_from(&model.fitted.fit.point.per_run);
    // Segments that were in the comparison keep the starts found there.
    for (i, &k) in model.fit.segments.iter().enumerate() {
        if let Some(j) = all.iter().position(|&a| a == k) {
            start.put(j, model.fitted.fit.point.start(i));
        }
    }
    if !model.is_down_to_noise() {
        return multistart::settled(
            problem,
            h,
            segments,
            start,
            FitOptions::search(REFIT_OF_WRONG),
        );
    }
    // Segments that were not compared are far off at first, those of a profile above all: the robust objective leads them in.
    let near = multistart::settled(problem, h, segments, start, leading_in())?;
    let (h, start) = (near.hypothesis, near.fit.point);
    let fitted = multistart::continued(problem, h, segments, start, last_options())?;
    with_lost_runs(problem, fitted, all, segments)
}

/// A fit to `segments`, which stand at `all` in the problem's list, or the one from where the runs that it lost got another chance, if that
/// is better.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn with_lost_runs(
    problem: &Problem,
    fitted: FittedHypothesis,
    all: &[usize],
    segments: &[Segment],
) -> Result<FittedHypothesis, Error> {
    if segment_errors::unmet_runs(problem, all, &fitted.fit).is_empty() {
        return Ok(fitted);
    }
    let lost = LostRuns::of(problem, &fitted, segments);
    let start = match lost.may_be_found() {
        true => Some(lost.start(problem, &fitted, segments)?),
        // Single segments are brought back by the end of the one before.
        false => multistart::better_starts(problem, segments, &fitted, &[], last_options(), true)?,
    };
    let Some(start) = start else {
        return Ok(fitted);
    };
    let h = fitted.hypothesis.clone();
    let near = multistart::continued(problem, h, segments, start, leading_in())?;
    let (h, start) = (near.hypothesis, near.fit.point);
    let again = multistart::continued(problem, h, segments, start, last_options())?;
    let is_better = is_better(problem, all, &again, &fitted);
    Ok(if is_better { again } else { fitted })
}

/// Whether a fit to the segments at `all` in the problem's list is better than another one ([`fits_better`]).
pub(crate) fn is_better(
    problem: &Problem,
    all: &[usize],
    new: &FittedHypothesis,
    old: &FittedHypothesis,
) -> bool {
    let unmet =
        |fitted: &FittedHypothesis| segment_errors::unmet_runs(problem, all, &fitted.fit).len();
    fits_better((unmet(new), new), (unmet(old), old))
}

/// Whether a model that is down to the noise on the segments compared also stands when it is fitted to all: it must neither bend
/// the structure, nor leave what is not white, nor lose more segments than by chance. One that does not is marked, so that it no longer counts as down to the
/// noise.
///
/// # Errors
/// An FMU that can't be run.
pub fn stands(problem: &Problem, model: &mut FittedModel) -> Result<bool, Error> {
    if !model.is_down_to_noise() {
        return Ok(false);
    }
    if model.full_refit.is_none() {
        let all = problem.fit_segments(1);
        let segments = problem.copies(&all);
        let fitted = refit(problem, model, &all, &segments)?;
        if !model.reaches_floor() {
            *model = seen_on(problem, model, &all, &fitted)?;
        }
        put(problem, model, &segments, fitted)?;
    }
    Ok(model.reaches_floor())
}

/// A model on the segments on which it is compared, from where a fit to `all` stands.
fn seen_on(
    problem: &Problem,
    model: &FittedModel,
    all: &[usize],
    on_all: &FittedHypothesis,
) -> Result<FittedModel, Error> {
    let compared = &model.fit.segments;
    let segments = problem.copies(compared);
    let start = restricted(&on_all.fit.point, all, compared);
    let h = on_all.hypothesis.clone();
    let options = FitOptions::search(SEEN);
    let fitted = multistart::continued(problem, h, &segments, start, options)?;
    FittedModel::new(problem, model.choices.clone(), fitted, compared, &segments)
}

/// Whether a model fitted to all segments of the runs fitted also meets the runs kept out once it is fitted to them too: then its constants
/// were off, of which the runs fitted show too little, and not the physics. It has to stand on all of them ([`stands`]). A profile, of
/// which each run has its own values, meets what it is fitted to whatever the physics: of that nothing is known.
///
/// # Errors
/// An FMU that can't be run.
pub fn meets_runs_kept_out(
    problem: &Problem,
    fitted: &FittedHypothesis,
    judged: &SegmentErrors,
) -> Result<bool, Error> {
    let h = &fitted.hypothesis;
    let has_profile = h.per_run.iter().flatten().any(|p| p.support.is_some());
    if has_profile || judged.ratio.is_empty() {
        return Ok(false);
    }
    let all: Vec<usize> = (0..problem.segments.len()).collect();
    let segments = problem.copies(&all);
    let mut start = Point::centre(h, &segments);
    let known = &fitted.fit.point;
    start.shared.clone_from(&known.shared);
    for (run, is_out) in problem.held_out.iter().enumerate() {
        let there = if *is_out { &judged.point } else { known };
        start.per_run[run].clone_from(&there.per_run[run]);
    }
    start.take_starts(&problem.fit_segments(1), known);
    if let Some((out, point)) = &judged.all_segments {
        start.take_starts(out, point);
    }
    let continued =
        |start, options| multistart::continued(problem, h.clone(), &segments, start, options);
    let near = continued(start, leading_in())?;
    let together = continued(near.fit.point, last_options())?;
    let together = with_lost_runs(problem, together, &all, &segments)?;
    let meets = |some: &[usize]| {
        is_met(&segment_errors::of_fit(
            problem,
            some,
            &together.fit.of_segments(some),
        ))
    };
    let (_, test) = segment_errors::held_out_segments(problem);
    let is_met = meets(&test) && meets(&problem.fit_segments(1));
    Ok(is_met && !is_bent_or_coloured(problem, &segments, &together)?)
}

/// A point with the start states of some of the segments that stand at `all` in the problem's list.
pub(crate) fn restricted(point: &Point, all: &[usize], some: &[usize]) -> Point {
    let place = |k: &usize| all.binary_search(k).expect("of the runs fitted");
    Point {
        states: some
            .iter()
            .map(|k| point.states[place(k)].clone())
            .collect(),
        stuck: some.iter().map(|k| point.stuck[place(k)]).collect(),
        ..point.clone()
    }
}

/// Gives a model its fit to all segments of the runs fitted, and marks it where that shows it to be wrong.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn put(
    problem: &Problem,
    model: &mut FittedModel,
    segments: &[Segment],
    fitted: FittedHypothesis,
) -> Result<(), Error> {
    let unmet = segment_errors::unmet_runs(problem, &problem.fit_segments(1), &fitted.fit);
    model.unmet_runs = unmet.len();
    model.is_refuted = !unmet.is_empty() || is_bent_or_coloured(problem, segments, &fitted)?;
    model.full_refit = Some(fitted);
    Ok(())
}

/// Whether a fit bends the structure or leaves what is not white.
fn is_bent_or_coloured(
    problem: &Problem,
    segments: &[Segment],
    fitted: &FittedHypothesis,
) -> Result<bool, Error> {
    let spectral_ratio = residual_whiteness::spectral_ratio(problem, segments, fitted)?;
    Ok(prior_conflict(fitted).is_some() || spectral_ratio > MOST_SPECTRAL_RATIO)
}
