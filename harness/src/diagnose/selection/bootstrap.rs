//! How much the best of all candidates gains by chance: a parametric bootstrap.
//!
//! The model without the effect in question is taken as true: every segment is predicted from its fitted start state, white
//! noise of the run's standard deviation is added, the model is fitted anew, and everything beside it is searched as beside a
//! measured campaign that it explains: the score test on all data and the fits that this asks for
//! ([`crate::diagnose::selection::extension`]), and brief fits of the effects that no score test speaks of. The distribution of the
//! LARGEST gain is what a gain must be compared with: an amplitude's zero lies on a boundary and shapes vanish under the null,
//! so that no table of chi-square applies (Davies, Biometrika 74 (1987) 33). Holds for noise that is white and a model without
//! the effect that is right in all else.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::data::white_noise::gaussian;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::initialisation::multistart::continued;
use crate::diagnose::initialisation::score_test::is_testable;
use crate::diagnose::initialisation::search_options::{BRIEF, HIDDEN};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::simulator::{Samples, Simulator};
use crate::diagnose::model::variants::all_variants;
use crate::diagnose::selection::extension::largest_gain;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::watch::{Silent, Watch};
use std::ops::Range;

/// Seed of the noise: the same campaign gives the same distribution.
const SEED: u64 = 1992;

/// Largest gains over `base` of an effect more, in those of the simulated campaigns that `which` numbers. A campaign is the same
/// whichever others are simulated.
///
/// # Errors
/// An FMU that can't be run.
pub fn largest_gains(
    problem: &Problem,
    base: &FittedModel,
    which: Range<usize>,
    watch: &dyn Watch,
) -> Result<Vec<f64>, Error> {
    let all = problem.fit_segments(1);
    let measured = problem.copies(&all);
    let on_all = match &base.full_refit {
        Some(fitted) => fitted.clone(),
        None => full_refit::refit(problem, base, &all, &measured)?,
    };
    let predicted = predictions(problem, &on_all, &measured)?;
    let search = if base.choices.is_empty() {
        BRIEF
    } else {
        HIDDEN
    };
    let untested: Vec<Vec<Choice>> = all_variants(problem)
        .into_iter()
        .filter(|c| base.choices.iter().all(|b| b.effect != c.effect))
        .filter(|c| !is_testable(problem, c.effect))
        .map(|c| base.choices.iter().cloned().chain([c]).collect())
        .collect();
    let of_screen = Screen::new(problem).indices;
    let mut random = fastrand::Rng::with_seed(SEED);
    let mut gains = Vec::new();
    for number in 0..which.end {
        let mut segments = measured.clone();
        for (segment, clean) in segments.iter_mut().zip(&predicted) {
            let std = problem.noise[segment.run];
            let further = segment.further.iter_mut().map(|part| &mut part.measured);
            let measured = std::iter::once(&mut segment.measured).chain(further);
            for (value, y) in measured.flatten().zip(clean) {
                *value = y + std * gaussian(&mut random);
            }
        }
        // The noise of those before it is drawn all the same.
        let Some(done) = number.checked_sub(which.start) else {
            continue;
        };
        watch.step("simulating what chance alone would gain", done, which.len());
        let h = problem.hypothesis(&base.choices)?;
        let start = on_all.fit.point.clone();
        let again = continued(problem, h, &segments, start, full_refit::last_options())?;
        let tested = largest_gain(problem, &segments, &again)?;
        let of_screen_segments = of_screen.iter().map(|k| {
            let place = all.binary_search(k).expect("of the runs fitted");
            segments[place].clone()
        });
        let screen = Screen::of_segments(problem, of_screen.clone(), of_screen_segments.collect());
        let again = screen.refit_of(base)?;
        let found = screen.compete(&untested, &again, search, &Silent(watch))?;
        if watch.stop() {
            break;
        }
        let fitted = found.iter().map(|c| again.score() - c.score());
        gains.push(fitted.fold(tested, f64::max));
    }
    Ok(gains)
}

/// What all sensors read in each segment by the fitted model; as measured where it gave up.
fn predictions(
    problem: &Problem,
    base: &FittedHypothesis,
    segments: &[Segment],
) -> Result<Vec<Vec<f64>>, Error> {
    let point = &base.fit.point;
    let mut predictor = problem.predictor(&base.hypothesis)?;
    let mut out = Vec::new();
    for (k, segment) in segments.iter().enumerate() {
        let mut y = Vec::new();
        let done = predictor.predict(
            segment,
            point.values(k, segment.run),
            Samples::all(segment).of_all_sensors(),
            &mut y,
        );
        match done {
            Ok(true) if y.iter().all(|v| v.is_finite()) => out.push(y),
            _ => {
                let further = segment.further.iter().flat_map(|part| &part.measured);
                out.push(segment.measured.iter().chain(further).copied().collect());
            }
        }
    }
    Ok(out)
}
