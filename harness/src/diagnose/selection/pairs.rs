//! Pairs of effects: each of the best single effects with every other.

use crate::diagnose::initialisation::search_options::THOROUGH;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::variants::{adds_library_effect, library};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::watch::Watch;

/// Pairs that are fitted before it is asked whether one explains the data: three for each of two cores.
const BATCH: usize = 6;

/// What a search among pairs has found.
pub(crate) struct Searched {
    /// The pairs tried, best first.
    pub pairs: Vec<FittedModel>,
    /// Those of the catalogue that were not begun, since the budget of the diagnosis was spent or on request.
    pub untried: Vec<Vec<Choice>>,
}

/// Pairs of effects of which none alone explains the data, best first: each of `leaders` with every other of the catalogue and
/// with those of the library that promise most. Ends with the first pair without values of its own along each run that comes
/// down to the noise.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn with_leaders(
    screen: &Screen,
    list: &[Choice],
    leaders: &[&FittedModel],
    watch: &dyn Watch,
) -> Result<Searched, Error> {
    let mut pairs: Vec<FittedModel> = Vec::new();
    let mut untried: Vec<Vec<Choice>> = Vec::new();
    let mut led: Vec<Choice> = Vec::new();
    for leader in leaders {
        let first = &leader.choices[0];
        let mut left = with(screen, first, list, &led);
        let mut goes_on = !screen.is_over(watch);
        led.push(first.clone());
        if goes_on {
            left = most_promising_first(screen, left, leader, watch)?;
        }
        while goes_on && !left.is_empty() {
            let batch: Vec<Vec<Choice>> = left.drain(..BATCH.min(left.len())).collect();
            let mut new = screen.compete(&batch, leader, THOROUGH, watch)?;
            screen.lend_lines(&mut new, list)?;
            let is_best = |new: &FittedModel| pairs.first().is_none_or(|best| new.is_before(best));
            if new.first().is_some_and(is_best) {
                screen.polish(&mut new, watch)?;
                screen.finish(&mut new, watch)?;
            }
            screen.keep_better(&mut pairs, new);
            goes_on = !screen.is_over(watch);
            if goes_on && explains(screen, pairs.first_mut())? {
                screen.sort(&mut pairs);
                let untried = Vec::new();
                return Ok(Searched { pairs, untried });
            }
        }
        let of_library = |pair: &Vec<Choice>| adds_library_effect(screen.problem, pair);
        untried.extend(left.into_iter().filter(|pair| !of_library(pair)));
    }
    screen.sort(&mut pairs);
    Ok(Searched { pairs, untried })
}

/// Whether a pair without values of its own along each run explains the data; those imitate much.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn explains(screen: &Screen, best: Option<&mut FittedModel>) -> Result<bool, Error> {
    match best {
        Some(best) if !best.is_local() => full_refit::stands(screen.problem, best),
        _ => Ok(false),
    }
}

/// Pairs with a leader in the order of what a score test promises of the second effect, so that the search may end early. Far
/// from the noise that test orders and never drops an effect of the catalogue; what it can't test comes after what gains
/// anything. Of the library, those remain that are in the first batch, and they come last: two known effects come first.
fn most_promising_first(
    screen: &Screen,
    jobs: Vec<Vec<Choice>>,
    leader: &FittedModel,
    watch: &dyn Watch,
) -> Result<Vec<Vec<Choice>>, Error> {
    let ranked = screen.by_promise(jobs, leader, watch)?;
    let mut ranked: Vec<Vec<Choice>> = ranked.into_iter().map(|(choices, _)| choices).collect();
    let of_library = |choices: &Vec<Choice>| adds_library_effect(screen.problem, choices);
    let later = ranked.split_off(BATCH.min(ranked.len()));
    ranked.extend(later.into_iter().filter(|choices| !of_library(choices)));
    ranked.sort_by_key(of_library);
    Ok(ranked)
}

/// The pairs of an effect with every other of the catalogue that has not led yet, and of the library.
fn with(screen: &Screen, first: &Choice, list: &[Choice], led: &[Choice]) -> Vec<Vec<Choice>> {
    list.iter()
        .chain(&library(screen.problem))
        .filter(|c| c.effect != first.effect && !led.contains(c))
        .map(|c| vec![first.clone(), c.clone()])
        .collect()
}
