//! Pairs of effects: each of the best single effects with every other.

use crate::diagnose::initialisation::score_test::Promise;
use crate::diagnose::initialisation::search_options::{FIXED, HIDDEN, THOROUGH};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::variants::library;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::watch::Watch;

/// Pairs that are fitted before it is asked whether one explains the data: three for each of two cores.
const BATCH: usize = 6;
/// Pairs of a leader whose second effect is searched for again from their own optima.
const RESTARTED: usize = 2;

/// Pairs of effects of which none alone explains the data, best first: each of `leaders` with every other of the catalogue and
/// with those of the library that promise most, the reference model held to what is believed of it, the best then fitted
/// freely. Ends with the first leader that has a pair without values of its own along each run down to the noise.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn held(
    screen: &Screen,
    list: &[Choice],
    leaders: &[&FittedModel],
    watch: &dyn Watch,
) -> Result<Vec<FittedModel>, Error> {
    let mut pairs: Vec<FittedModel> = Vec::new();
    let mut led: Vec<Choice> = Vec::new();
    // Values of their own along each run imitate much: such a leader comes last, and its pairs do not end the search.
    let (local, simple): (Vec<&FittedModel>, Vec<&FittedModel>) =
        leaders.iter().partition(|leader| leader.is_local());
    for leader in simple.into_iter().chain(local) {
        let first = &leader.choices[0];
        let mut jobs =
            most_promising_first(screen, with(screen, first, list, &led), leader, watch)?;
        let mut found: Vec<FittedModel> = Vec::new();
        for batch in jobs.chunks(BATCH) {
            let mut new = screen.freed(&screen.compete(batch, leader, FIXED, watch)?)?;
            screen.lend_lines(&mut new, list)?;
            if found.first().is_none_or(|f| new[0].is_before(f)) {
                screen.polish(&mut new, watch)?;
                screen.finish(&mut new, watch)?;
            }
            screen.keep_better(&mut found, new);
            if is_over(screen, watch) || explains(screen, found.first_mut())? {
                pairs.extend(found);
                screen.sort(&mut pairs);
                return Ok(pairs);
            }
        }
        // A wrong partner that helps brings the leader near its true values: from there the right one is near.
        if let Some(best) = found
            .first()
            .filter(|b| !b.reaches_floor() && screen.is_promising(b))
        {
            jobs.retain(|choices| *choices != best.choices);
            let again = screen.compete(&jobs, best, HIDDEN, watch)?;
            screen.keep_better(&mut found, again);
            screen.lend_lines(&mut found, list)?;
            screen.polish(&mut found, watch)?;
        }
        // As above: what is simpler than values along each run gets its chance.
        let is_simple = |p: &FittedModel| p.reaches_floor() && !p.is_local();
        if !found.first().is_some_and(is_simple) {
            screen.restart(&mut found, RESTARTED, watch)?;
        }
        pairs.extend(found);
        screen.sort(&mut pairs);
        led.push(first.clone());
        if is_over(screen, watch) || explains(screen, pairs.first_mut())? {
            break;
        }
    }
    Ok(pairs)
}

/// The most promising pairs with a leader that was fitted freely, the second effect searched for freely from there, best first: where
/// what is believed of the reference model is far from the data, a search that holds it to that leads away from them.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn free(
    screen: &Screen,
    list: &[Choice],
    leader: &FittedModel,
    watch: &dyn Watch,
) -> Result<Vec<FittedModel>, Error> {
    let all = with(screen, &leader.choices[0], list, &[]);
    let jobs = most_promising_first(screen, all, leader, watch)?;
    let batch = &jobs[..jobs.len().min(BATCH)];
    let mut found = screen.compete(batch, leader, THOROUGH, watch)?;
    screen.polish(&mut found, watch)?;
    screen.finish(&mut found, watch)?;
    Ok(found)
}

/// Whether no more pairs are begun: on request, or since the budget of a diagnosis is spent.
fn is_over(screen: &Screen, watch: &dyn Watch) -> bool {
    watch.stop() || screen.problem.is_budget_spent()
}

/// Whether a pair without values of its own along each run explains the data; those imitate much.
fn explains(screen: &Screen, best: Option<&mut FittedModel>) -> Result<bool, Error> {
    match best {
        Some(best) if !best.is_local() => full_refit::stands(screen.problem, best),
        _ => Ok(false),
    }
}

/// Pairs with a leader in the order of what a score test promises of the second effect, so that the search may end early. Far
/// from the noise that test orders and never drops an effect of the catalogue; what it can't test comes after what gains
/// anything. Of the library, those remain that are in the first batch.
fn most_promising_first(
    screen: &Screen,
    jobs: Vec<Vec<Choice>>,
    leader: &FittedModel,
    watch: &dyn Watch,
) -> Result<Vec<Vec<Choice>>, Error> {
    let promises = screen.promises(&jobs, leader, watch)?;
    let gain = |p: &Option<Promise>| p.as_ref().map_or(0.0, |p| p.gain);
    let mut order: Vec<(f64, Vec<Choice>)> = promises.iter().map(gain).zip(jobs).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let of_library = |choices: &[Choice]| {
        let second = choices.last().expect("a pair");
        is_library_effect(&screen.problem.catalogue[second.effect].id)
    };
    let ranked = order.into_iter().map(|(_, choices)| choices).enumerate();
    Ok(ranked
        .filter(|(rank, choices)| *rank < BATCH || !of_library(choices))
        .map(|(_, choices)| choices)
        .collect())
}

/// The pairs of an effect with every other of the catalogue that has not led yet, and of the library.
fn with(screen: &Screen, first: &Choice, list: &[Choice], led: &[Choice]) -> Vec<Vec<Choice>> {
    list.iter()
        .chain(&library(screen.problem))
        .filter(|c| c.effect != first.effect && !led.contains(c))
        .map(|c| vec![first.clone(), c.clone()])
        .collect()
}
