//! Which effect: every candidate is fitted and judged, and the best is taken if it explains the data.

use crate::diagnose::initialisation::search_options::THOROUGH;
use crate::diagnose::model::belt_profile::is_profile;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::variants::all_variants;
use crate::diagnose::selection::as_given::as_given;
use crate::diagnose::selection::decision::{decide, log_prior};
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::outcome::{Selection, beyond, judge_candidates};
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::selection::search::{Exploration, explore};
use crate::diagnose::stages;
use crate::error::Error;
use crate::watch::{Silent, Watch};

/// Share of the squares that a pair removes which its first effect must remove alone to be named: the usual 95 %.
const MOST: f64 = 0.95;

/// Compares the catalogue on a campaign.
///
/// # Errors
/// An FMU that can't be run.
pub fn select(problem: &Problem, watch: &dyn Watch) -> Result<Selection, Error> {
    let screen = Screen::new(problem);
    watch.stage(stages::REFERENCE);
    let (as_given, as_given_holdout, as_given_forecasts) = as_given(problem, &screen)?;
    let Exploration {
        alone,
        mut calibrated,
        mut singles,
        mut pairs,
        tested,
        untried,
        ..
    } = explore(problem, &screen, watch)?;
    let stopped = watch.stop();
    if stopped && watch.discards() {
        return Err(Error::Discarded);
    }
    watch.stage(stages::ALL_DATA);
    let mut all: Vec<&mut FittedModel> = std::iter::once(&mut calibrated)
        .chain(&mut singles)
        .chain(&mut pairs)
        .collect();
    let best = decide(problem, &mut all)?;
    let explained = best.is_some();
    let mut untried: Vec<String> = match explained {
        true => Vec::new(),
        false => untried
            .iter()
            .flatten()
            .map(|pair| name(problem, pair))
            .collect(),
    };
    // Forms of an effect have one name.
    untried.dedup();
    let mut path = match best {
        Some(0) => Vec::new(),
        Some(i) if i <= singles.len() => vec![singles.remove(i - 1)],
        Some(i)
            if explains_most(
                problem,
                &calibrated,
                &singles,
                &pairs[i - 1 - singles.len()],
            ) =>
        {
            let known = &pairs[i - 1 - singles.len()].choices[..1];
            let place = singles.iter().position(|s| s.choices == known);
            vec![singles.remove(place.expect("it explains most"))]
        }
        Some(i) => {
            let pair = pairs.remove(i - 1 - singles.len());
            let first = singles.iter().position(|s| s.choices[0] == pair.choices[0]);
            let first = first.map(|i| singles.remove(i));
            first.into_iter().chain([pair]).collect()
        }
        // What helps most, to show how far it goes.
        None if singles
            .first()
            .is_some_and(|s| s.score() < calibrated.score()) =>
        {
            vec![singles.remove(0)]
        }
        None => Vec::new(),
    };
    judge_candidates(problem, &calibrated, &mut singles, &mut pairs)?;
    let list = all_variants(problem);
    let profile = list
        .iter()
        .find(|c| is_profile(&problem.catalogue[c.effect]));
    let by_break_aways = match profile {
        Some(choice) if !explained && !stopped && problem.place_is_told() => {
            let jobs = [vec![choice.clone()]];
            let mut found = screen.compete(&jobs, &calibrated, THOROUGH, &Silent(watch))?;
            screen.polish(&mut found, &Silent(watch))?;
            calibrated = screen.recalibrate(calibrated, &found)?;
            singles.extend(path);
            singles.retain(|s| s.choices != jobs[0]);
            screen.sort(&mut singles);
            path = found;
            true
        }
        _ => false,
    };
    let beyond = beyond(problem, explained, &path, &calibrated, &singles);
    Ok(Selection {
        as_given,
        as_given_holdout,
        as_given_forecasts,
        alone,
        calibrated,
        singles,
        pairs,
        untried,
        tested,
        path,
        explained,
        by_break_aways,
        is_incomplete: false,
        beyond,
        contradicted: None,
        stopped,
        by_hand: false,
        threshold: -log_prior(problem, 1),
        by_chance: Vec::new(),
    })
}

/// Whether the effect of the catalogue that leads a pair is adequate alone and what an effect of the library adds is small: then the
/// first is named, as every hypothesis that counts has it.
fn explains_most(
    problem: &Problem,
    calibrated: &FittedModel,
    singles: &[FittedModel],
    pair: &FittedModel,
) -> bool {
    let is_of_library = |c: &Choice| is_library_effect(&problem.catalogue[c.effect].id);
    let [first, second] = &pair.choices[..] else {
        return false;
    };
    if is_of_library(first) || !is_of_library(second) {
        return false;
    }
    let squares = |model: &FittedModel| model.fit.nrmse.powi(2);
    let mut alone = singles.iter().filter(|s| s.choices[..] == [first.clone()]);
    alone.any(|single| {
        let explained = squares(calibrated) - squares(single);
        single.reaches_floor() && explained > MOST * (squares(calibrated) - squares(pair))
    })
}
