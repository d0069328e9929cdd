//! How hypotheses stand: probability, evidence and errors of each.

use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::diagnosis::{FurtherEffect, Standing, Verdict};
use crate::diagnose::result::found_constants::is_effect;
use crate::diagnose::selection::decision::probabilities;
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::thresholds::SEARCHED;
use std::collections::BTreeMap;

/// All models of a selection, the calibrated model first.
pub(super) fn all_models(selection: &Selection) -> Vec<&FittedModel> {
    std::iter::once(&selection.calibrated)
        .chain(&selection.path)
        .chain(&selection.singles)
        .chain(&selection.pairs)
        .collect()
}

/// Probability of the verdict: what the hypotheses share that say the same.
pub(super) fn probability_of(problem: &Problem, selection: &Selection, verdict: Verdict) -> f64 {
    let all = all_models(selection);
    let (shares, _) = probabilities(&all, &selection.tested);
    let of = |wanted: &dyn Fn(&FittedModel) -> bool| -> f64 {
        let wanted = all.iter().zip(&shares).filter(|(c, _)| wanted(c));
        wanted.map(|(_, p)| p).sum()
    };
    match (verdict, selection.path.last()) {
        // What explains most counted with another noise: it does not compare.
        (Verdict::UnknownEffect, _) if !selection.explained => SEARCHED,
        (Verdict::UnknownEffect, _) => of(&|c| is_beyond(problem, &c.choices)),
        (Verdict::NoMissingEffect, _) | (_, None) => of(&|c| c.choices.is_empty()),
        // What an effect of the library adds takes nothing away from a name.
        (_, Some(best)) => of(&|c| {
            let mut named: Vec<usize> = of_catalogue(problem, &c.choices)
                .map(|o| o.effect)
                .collect();
            named.sort_unstable();
            named == best.effects()
        }),
    }
}

/// The effects of a hypothesis that are not of the library.
pub(super) fn of_catalogue<'a>(
    problem: &'a Problem,
    choices: &'a [Choice],
) -> impl Iterator<Item = &'a Choice> {
    let is_of_library = |o: &&Choice| library::is_library_effect(&problem.catalogue[o.effect].id);
    choices.iter().filter(move |o| !is_of_library(o))
}

pub(super) fn standings(problem: &Problem, selection: &Selection) -> Vec<Standing> {
    let base = selection.calibrated.score();
    // The list is the catalogue's: a term beyond it stands among the proposals.
    let is_known = |c: &FittedModel| !is_beyond(problem, &c.choices);
    let everything = all_models(selection);
    let (shares, of_tested) = probabilities(&everything, &selection.tested);
    let listed: Vec<&FittedModel> = selection
        .path
        .iter()
        .chain(&selection.singles)
        .chain(selection.listed_pairs())
        .collect();
    let is_listed = |c: &FittedModel| listed.iter().any(|l| std::ptr::eq(*l, c));
    // As for the verdict, a name has what it shares with effects of the library.
    let named = selection.path.last().filter(|_| selection.explained);
    let share = |c: &FittedModel, alone: f64| match named {
        Some(named) if std::ptr::eq(named, c) => {
            let same = everything.iter().zip(&shares);
            let same = same.filter(|(o, _)| of_catalogue(problem, &o.choices).eq(&c.choices));
            same.map(|(_, p)| p).sum()
        }
        _ => alone,
    };
    let all: Vec<(&FittedModel, f64)> = everything
        .iter()
        .zip(&shares)
        .filter(|(c, _)| is_known(c) && is_listed(c))
        .map(|(c, alone)| (*c, share(c, *alone)))
        .collect();
    let fitted = all.iter().map(|(c, probability)| Standing {
        id: name(problem, &c.choices),
        holdout_nrmse: c.holdout.as_ref().map_or(f64::NAN, |h| h.nrmse),
        probability: *probability,
        score: base - c.score(),
        log_evidence: -c.score(),
        misfit_fall: selection.calibrated.fitted.fit.misfit - c.fitted.fit.misfit,
        fit_over_noise: c.fit.quantile(0.5),
        free_values: c.size(),
        parameters: c
            .fitted
            .hypothesis
            .shared
            .iter()
            .zip(&c.fitted.fit.point.shared)
            .filter(|(k, _)| is_effect(problem, &k.name))
            .map(|(k, u)| (k.name.clone(), k.value(*u)))
            .collect(),
        fitted: true,
        passed_over: c.is_passed_over,
        refuted: c.is_refuted,
        detection_limit: None,
    });
    let not_fitted = selection.tested.iter().zip(of_tested);
    let not_fitted = not_fitted.filter_map(|(t, probability)| {
        let beside = all_models(selection)
            .into_iter()
            .find(|c| c.choices == t.beside())?;
        (t.beside().is_empty() && !is_beyond(problem, &t.choices)).then(|| Standing {
            id: name(problem, &t.choices),
            holdout_nrmse: f64::NAN,
            probability,
            score: base - beside.score() + t.gain,
            log_evidence: t.gain - beside.score(),
            misfit_fall: selection.calibrated.fitted.fit.misfit - beside.fitted.fit.misfit + t.fall,
            fit_over_noise: beside.fit.quantile(0.5),
            free_values: beside.size(),
            parameters: BTreeMap::new(),
            fitted: false,
            passed_over: false,
            refuted: false,
            detection_limit: t.detection_limit,
        })
    });
    let mut standings: Vec<Standing> = fitted.chain(not_fitted).collect();
    // What is compared on all segments may stand in another order on those of the scores.
    standings.sort_by(|a, b| {
        let by_probability = b.probability.total_cmp(&a.probability);
        by_probability.then(b.score.total_cmp(&a.score))
    });
    standings
}

/// What a score test says of effects beside the hypothesis named.
pub(super) fn further_effects(problem: &Problem, selection: &Selection) -> Vec<FurtherEffect> {
    let (_, shares) = probabilities(&all_models(selection), &selection.tested);
    let named = selection.path.last().map(|p| p.choices.as_slice());
    let rows = selection.tested.iter().zip(shares);
    let rows = rows.filter(|(t, _)| Some(t.beside()) == named);
    rows.map(|(t, probability)| FurtherEffect {
        id: name(problem, &t.choices[t.beside().len()..]),
        probability,
        score: t.gain,
        detection_limit: t.detection_limit,
    })
    .collect()
}

/// Whether an effect among these is none of the catalogue's.
pub(super) fn is_beyond(problem: &Problem, choices: &[Choice]) -> bool {
    let mut effects = choices.iter().map(|c| &problem.catalogue[c.effect]);
    effects.any(|card| library::is_library_effect(&card.id))
}
