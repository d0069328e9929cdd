//! Which effects explain most where no hypothesis comes down to the noise.
//!
//! No model of a real machine is complete. Counted with the sensor's noise, all hypotheses are then equally hopeless, and
//! their evidence says nothing. What the best of them leaves in each run is an estimate of what nobody modelled: with its
//! size s and its correlation time tau in samples, fits count with the noise
//!
//! ```text
//! sigma = max(sensor, s sqrt(tau))
//! ```
//!
//! so that n samples say as much as n / tau independent ones with the error s. With that noise hypotheses compare by their
//! evidence as elsewhere, and effects are added one after another while a score test finds one that is worth its price.
//! The best at first is the best of what has a name and starts segments with the structure's states alone. What is most probable then tells
//! the noise anew, until it leaves no less. A memory that does not fade within a segment takes no part: with a start value of its own in
//! each it is another force in each, which takes up what is not modelled, whatever that is, and of its law the data say nothing
//! ([`super::fading`]).
//! Source: Kennedy and O'Hagan, J. R. Statist. Soc. B 63 (2001) 425, with the discrepancy's covariance reduced to its
//! variance and correlation time.

use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::FORMULA_PREFIX;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::is_unknown_function;
use crate::diagnose::model::variants::unknown;
use crate::diagnose::selection::decision::log_posterior;
use crate::diagnose::selection::extension::{fitted_as_promised, one_further, worth_their_price};
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::further_fits::POLISH;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::validation::correlation_time::correlation_times;
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;

/// Hypotheses of the search before that are compared again: as many as are judged on what was kept out.
const COMPARED: usize = 8;
/// Unknown functions that are compared with what has a name: of those found before the best of each of two places, ...
const CURVES: usize = 2;
/// ... and those that promise most with the noise that counts now, two for each of two processors.
const PROMISED: usize = 4;
/// Effects of one hypothesis at most.
const MOST_EFFECTS: usize = 4;

/// The models fitted, best first by what they leave.
fn by_error(selection: &Selection) -> Vec<&FittedModel> {
    let mut all: Vec<&FittedModel> = std::iter::once(&selection.calibrated)
        .chain(&selection.path)
        .chain(&selection.singles)
        .chain(&selection.pairs)
        .collect();
    all.sort_by(|a, b| a.fit.nrmse.total_cmp(&b.fit.nrmse));
    all
}

/// The model whose errors are what nobody modelled: once it was found what explains most, that; before, the best whose segments start with
/// the structure's states alone, of what has a name, since a curve takes up too what it finds.
fn reference<'a>(problem: &Problem, selection: &'a Selection) -> &'a FittedModel {
    if selection.is_incomplete {
        return selection.path.last().unwrap_or(&selection.calibrated);
    }
    let modes = selection.calibrated.fitted.hypothesis.modes;
    let is_rigid = |m: &&FittedModel| {
        let h = &m.fitted.hypothesis;
        h.extra_states.is_empty() && h.modes == modes && !m.is_local() && has_names(problem, m)
    };
    let best = by_error(selection).into_iter().find(is_rigid);
    best.unwrap_or(&selection.calibrated)
}

/// Whether a noise is so much less than another that fits are to count with it: by half in some run. Both are root mean squares of some
/// ten segments, good to a fifth.
fn is_less(noise: &[f64], than: &[f64]) -> bool {
    noise.iter().zip(than).any(|(a, b)| *a < 0.5 * b)
}

/// Noise in m with which fits of each run are to count: what the best model of a selection leaves.
///
/// # Errors
/// An FMU that can't be instantiated.
fn discrepancy(problem: &Problem, selection: &Selection) -> Result<Vec<f64>, Error> {
    let best = reference(problem, selection);
    let segments = problem.copies(&best.fit.segments);
    let times = correlation_times(problem, &segments, &best.fitted)?;
    let of_run = |(run, tau): (usize, &f64)| {
        let left = best.fit.by_run[run] * problem.spread[run];
        // Of runs that were not fitted nothing is known: as large a share of the motion as elsewhere.
        let left = match left.is_finite() {
            true => left,
            false => best.fit.nrmse * problem.spread[run],
        };
        problem.noise[run].max(left * tau.sqrt())
    };
    Ok(times.iter().enumerate().map(of_run).collect())
}

/// How many times as uncertain each run's readings of each further sensor are to count beside the first one, which counts with `noise` of each
/// run in m by then: with what the best model of a selection leaves of them, or their own noise where that is more.
///
/// # Errors
/// An FMU that can't be instantiated.
fn of_further(
    problem: &Problem,
    selection: &Selection,
    noise: &[f64],
) -> Result<Vec<Vec<f64>>, Error> {
    let best = reference(problem, selection);
    if best.fit.of_further.is_empty() {
        return Ok(vec![Vec::new(); noise.len()]);
    }
    let segments = problem.copies(&best.fit.segments);
    let times = correlation_times(problem, &segments, &best.fitted)?;
    let of_run = |(run, tau): (usize, &f64)| {
        let of_sensor = |left: &f64| {
            // Of a sensor that read nothing there is nothing to count.
            let left = if left.is_finite() { *left } else { 1.0 };
            (left * tau.sqrt()).max(1.0) * problem.noise[run] / noise[run]
        };
        best.fit.of_further.iter().map(of_sensor).collect()
    };
    Ok(times.iter().enumerate().map(of_run).collect())
}

/// Compares the best models of a selection that explains nothing again, with what nobody modelled as noise, until what the most probable
/// of them leaves is that noise. Fits count with it then: its standard deviation of each run in m, and by how much more uncertain each
/// run's readings of further sensors are.
///
/// # Errors
/// An FMU that can't be run.
pub fn explain_most(
    problem: &mut Problem,
    selection: &mut Selection,
    watch: &dyn Watch,
) -> Result<(Vec<f64>, Vec<Vec<f64>>), Error> {
    let sensors = problem.segments.clone();
    let mut noise = discrepancy(problem, selection)?;
    loop {
        let further = of_further(problem, selection, &noise)?;
        problem.segments.clone_from(&sensors);
        problem.count_with(noise.clone(), &further);
        compare(problem, selection, watch)?;
        let left = discrepancy(problem, selection)?;
        if watch.stop() || !is_less(&left, &noise) {
            return Ok((noise, further));
        }
        noise = left;
    }
}

/// Compares the best models of a selection with the noise that the problem's fits count with by now, adds effects while they are worth
/// their price, and puts the most probable hypothesis at the end of the path.
fn compare(problem: &Problem, selection: &mut Selection, watch: &dyn Watch) -> Result<(), Error> {
    let screen = Screen::new(problem);
    let of_reference = reference(problem, selection).choices.clone();
    let named: Vec<FittedModel> = by_error(selection)
        .into_iter()
        .filter(|m| !m.is_local() && !m.choices.is_empty() && has_names(problem, m))
        .cloned()
        .collect();
    let compared = screen.fading(named)?.into_iter().enumerate();
    let compared = compared.filter(|(place, m)| *place < COMPARED || m.choices == of_reference);
    let calibrated = std::iter::once(selection.calibrated.clone());
    let known: Vec<FittedModel> = calibrated.chain(compared.map(|(_, m)| m)).collect();
    let models = parallel(&known, |model| screen.further(model, POLISH))?;
    let mut models = screen.fading(models)?;
    let curves = curves(problem, &screen, selection, &models[0], watch)?;
    let mut led: Vec<Vec<Choice>> = Vec::new();
    while !watch.stop() {
        let leader = most_probable(problem, &models);
        if leader.choices.len() == MOST_EFFECTS || led.contains(&leader.choices) {
            break;
        }
        watch.step(&name(problem, &leader.choices), led.len(), MOST_EFFECTS);
        led.push(leader.choices.clone());
        let new = one_further(&screen, leader, POLISH, watch)?;
        screen.keep_better(&mut models, screen.fading(new)?);
    }
    // What has no name must have more evidence than all that has one, its constants priced.
    screen.keep_better(&mut models, curves);
    let best = most_probable(problem, &models).clone();
    let path = screen.path_to(best)?;
    let has_path = |m: &FittedModel| path.iter().any(|p| p.choices == m.choices);
    models.retain(|m| !has_path(m));
    if let Some(i) = models.iter().position(|m| m.choices.is_empty()) {
        selection.calibrated = models.remove(i);
    }
    models.sort_by(|a, b| log_posterior(problem, b).total_cmp(&log_posterior(problem, a)));
    (selection.singles, selection.pairs) = models.into_iter().partition(|m| m.choices.len() == 1);
    selection.judge_candidates(problem)?;
    selection.path = path;
    selection.tested.clear();
    selection.is_incomplete = true;
    Ok(())
}

/// Unknown functions, fitted: the best that were found before, and those of which a score test beside the calibrated model promises most.
/// Before, the search counted with the sensor's noise, far from which such a test says little.
fn curves(
    problem: &Problem,
    screen: &Screen,
    selection: &Selection,
    calibrated: &FittedModel,
    watch: &dyn Watch,
) -> Result<Vec<FittedModel>, Error> {
    let found: Vec<FittedModel> = by_error(selection)
        .into_iter()
        .filter(|m| !has_names(problem, m))
        .take(CURVES)
        .cloned()
        .collect();
    let mut curves = parallel(&found, |model| screen.further(model, POLISH))?;
    let jobs = unknown(problem).into_iter().map(|c| vec![c]).collect();
    let mut promised = worth_their_price(screen, jobs, calibrated, watch)?;
    promised.truncate(PROMISED);
    let promised = fitted_as_promised(screen, &promised, POLISH)?;
    screen.keep_better(&mut curves, promised);
    screen.fading(curves)
}

/// Whether all effects of a model are those of catalogue and library.
fn has_names(problem: &Problem, model: &FittedModel) -> bool {
    let mut cards = model.choices.iter().map(|c| &problem.catalogue[c.effect]);
    cards.all(|card| !is_unknown_function(&card.id) && !card.id.starts_with(FORMULA_PREFIX))
}

fn most_probable<'a>(problem: &Problem, models: &'a [FittedModel]) -> &'a FittedModel {
    models
        .iter()
        .max_by(|a, b| log_posterior(problem, a).total_cmp(&log_posterior(problem, b)))
        .expect("the calibrated model is among them")
}
