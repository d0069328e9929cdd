//! How much the best of all candidates gains by chance: a parametric bootstrap.
//!
//! The model without the effect in question is taken as true: every shot is predicted from its fitted start state, white
//! noise of the run's standard deviation is added, and the model and the whole catalogue are fitted anew, with the
//! effort of the search itself. The distribution of the LARGEST gain is what a gain must be compared with: an amplitude's
//! zero lies on a boundary and shapes vanish under the null, so that no table of chi-square applies (Davies, Biometrika 74
//! (1987) 33). Holds for noise that is white and a model without the effect that is right in all else; the periodic
//! effects' first starts come from the measured force, which differs from the simulated one by the noise only.

use super::contender::Contender;
use super::hypothesis::Choice;
use super::screen::Screen;
use super::search::{BRIEF, HIDDEN};
use super::select::Silent;
use super::session::Session;
use crate::error::Error;
use crate::watch::Watch;

/// Seed of the noise: the same campaign gives the same distribution.
const SEED: u64 = 1992;

/// Largest gains over `base` of all candidates, each added to it, in `count` simulated campaigns.
///
/// # Errors
/// An FMU that can't be run.
pub fn largest_gains(
    session: &Session,
    base: &Contender,
    candidates: &[Choice],
    count: usize,
    watch: &dyn Watch,
) -> Result<Vec<f64>, Error> {
    let measured = Screen::new(session);
    let predicted = predictions(session, base, &measured)?;
    let jobs: Vec<Vec<Choice>> = candidates
        .iter()
        .filter(|c| base.choices.iter().all(|b| b.effect != c.effect))
        .map(|c| base.choices.iter().chain([c]).cloned().collect())
        .collect();
    let depth = if base.choices.is_empty() {
        BRIEF
    } else {
        HIDDEN
    };
    let mut random = fastrand::Rng::with_seed(SEED);
    let mut gains = Vec::new();
    for done in 0..count {
        watch.step("simulating what chance alone would gain", done, count);
        let mut shots = measured.shots.clone();
        for (shot, clean) in shots.iter_mut().zip(&predicted) {
            let std = session.noise[shot.run];
            for (value, y) in shot.measured.iter_mut().zip(clean) {
                *value = y + std * gaussian(&mut random);
            }
        }
        let screen = Screen::of_shots(session, measured.indices.clone(), shots);
        let again = screen.refit_of(base)?;
        let found = screen.compete(&jobs, &again, depth, &Silent(watch))?;
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

/// Displacement of each shot by the fitted model, m; as measured where it gave up.
fn predictions(
    session: &Session,
    base: &Contender,
    screen: &Screen,
) -> Result<Vec<Vec<f64>>, Error> {
    let h = &base.trial.hypothesis;
    let point = &base.trial.fit.point;
    let mut predictor = session.predictor(h)?;
    let mut out = Vec::new();
    for (k, shot) in screen.shots.iter().enumerate() {
        let mut y = Vec::new();
        let own = &point.own[shot.run];
        let (state, stuck) = (&point.states[k], point.stuck[k]);
        let all = shot.time.len();
        let done = predictor.predict(shot, &point.shared, own, state, stuck, all, 1, &mut y);
        match done {
            Ok(true) if y.iter().all(|v| v.is_finite()) => out.push(y),
            _ => out.push(shot.measured.clone()),
        }
    }
    Ok(out)
}

/// A standard normal number (Box and Muller 1958).
pub(super) fn gaussian(random: &mut fastrand::Rng) -> f64 {
    let radius = (-2.0 * (1.0 - random.f64()).ln()).sqrt();
    radius * (std::f64::consts::TAU * random.f64()).cos()
}
