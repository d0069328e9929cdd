//! How much the best of all candidates gains by chance: a parametric bootstrap.
//!
//! The model without the effect in question is taken as true: every segment is predicted from its fitted start state, white
//! noise of the run's standard deviation is added, and the model and the whole catalogue are fitted anew, with the
//! options of the search itself. The distribution of the LARGEST gain is what a gain must be compared with: an amplitude's
//! zero lies on a boundary and shapes vanish under the null, so that no table of chi-square applies (Davies, Biometrika 74
//! (1987) 33). Holds for noise that is white and a model without the effect that is right in all else; the periodic
//! effects' first starts come from the measured force, which differs from the simulated one by the noise only.

use crate::diagnose::initialisation::search_options::{BRIEF, HIDDEN};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::simulator::{Samples, Simulator};
use crate::diagnose::model::white_noise::gaussian;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::watch::{Silent, Watch};

/// Seed of the noise: the same campaign gives the same distribution.
const SEED: u64 = 1992;

/// Largest gains over `base` of all candidates, each added to it, in `count` simulated campaigns.
///
/// # Errors
/// An FMU that can't be run.
pub fn largest_gains(
    problem: &Problem,
    base: &FittedModel,
    candidates: &[Choice],
    count: usize,
    watch: &dyn Watch,
) -> Result<Vec<f64>, Error> {
    let measured = Screen::new(problem);
    let predicted = predictions(problem, base, &measured)?;
    let jobs: Vec<Vec<Choice>> = candidates
        .iter()
        .filter(|c| base.choices.iter().all(|b| b.effect != c.effect))
        .map(|c| base.choices.iter().chain([c]).cloned().collect())
        .collect();
    let search = if base.choices.is_empty() {
        BRIEF
    } else {
        HIDDEN
    };
    let mut random = fastrand::Rng::with_seed(SEED);
    let mut gains = Vec::new();
    for done in 0..count {
        watch.step("simulating what chance alone would gain", done, count);
        let mut segments = measured.segments.clone();
        for (segment, clean) in segments.iter_mut().zip(&predicted) {
            let std = problem.noise[segment.run];
            for (value, y) in segment.measured.iter_mut().zip(clean) {
                *value = y + std * gaussian(&mut random);
            }
        }
        let screen = Screen::of_segments(problem, measured.indices.clone(), segments);
        let again = screen.refit_of(base)?;
        let found = screen.compete(&jobs, &again, search, &Silent(watch))?;
        if watch.stop() {
            break;
        }
        let again = screen.recalibrate(again, &found)?;
        let best = found
            .iter()
            .map(|c| c.score())
            .fold(f64::INFINITY, f64::min);
        gains.push(again.score() - best);
    }
    Ok(gains)
}

/// Displacement of each segment by the fitted model, m; as measured where it gave up.
fn predictions(
    problem: &Problem,
    base: &FittedModel,
    screen: &Screen,
) -> Result<Vec<Vec<f64>>, Error> {
    let h = &base.fitted.hypothesis;
    let point = &base.fitted.fit.point;
    let mut predictor = problem.predictor(h)?;
    let mut out = Vec::new();
    for (k, segment) in screen.segments.iter().enumerate() {
        let mut y = Vec::new();
        let done = predictor.predict(
            segment,
            point.values(k, segment.run),
            Samples::all(segment),
            &mut y,
        );
        match done {
            Ok(true) if y.iter().all(|v| v.is_finite()) => out.push(y),
            _ => out.push(segment.measured.clone()),
        }
    }
    Ok(out)
}
