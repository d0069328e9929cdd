//! From a selection and its ladder to a diagnosis: the verdict, its numbers and its words.

use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::diagnosis::{Diagnosis, Rung, Verdict};
use crate::diagnose::result::error_ladder::Step;
use crate::diagnose::result::found_constants::{
    calibrated, fitted_library_effects, found, inputs, known_structure, run_values, stated_speed,
};
use crate::diagnose::result::further_sensors::found_sensors;
use crate::diagnose::result::remarks::remarks;
use crate::diagnose::result::run_sets::effect_values;
use crate::diagnose::result::standings::{further_effects, is_beyond, probability_of, standings};
use crate::diagnose::result::summary::{Seen, unmet_words, words};
use crate::diagnose::result::unknown::{unknown, unknown_rivals};
use crate::diagnose::selection::fitted_model::is_met;
use crate::diagnose::selection::full_refit::meets_runs_kept_out;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::selection::ties::rivals;
use crate::diagnose::validation::forecast::{Forecast, forecasts};
use crate::diagnose::validation::identifiability::{in_words, undetermined};
use crate::diagnose::validation::prior_conflict::prior_conflict;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::error::Error;
use crate::measurement::NoiseStd;

/// The diagnosis.
///
/// # Errors
/// An FMU that can't be run.
pub fn conclude(
    problem: &Problem,
    selection: &Selection,
    steps: &[Step],
) -> Result<Diagnosis, Error> {
    let base_score = selection.calibrated.score();
    let last = steps.len() - 1;
    let strained = prior_conflict(&steps[last].fitted);
    let best = selection.path.last();
    let gain = best.map_or(0.0, |p| base_score - p.score());
    // A search has compared posteriors; where chance was simulated, it may reach further than the prior odds.
    let is_decided = !selection.by_hand && selection.by_chance.is_empty();
    let beats_chance = is_decided || gain > selection.threshold;
    let verdict = match best {
        _ if selection.by_break_aways => Verdict::EffectFound,
        _ if !selection.explained || selection.beyond.is_some() => Verdict::UnknownEffect,
        Some(_) if beats_chance => Verdict::EffectFound,
        Some(_) if !selection.calibrated.reaches_floor() => Verdict::UnknownEffect,
        _ => Verdict::NoMissingEffect,
    };
    let named = if verdict == Verdict::EffectFound {
        selection.path.len()
    } else {
        0
    };
    let mut effects = Vec::new();
    for i in 0..named {
        let before = if i == 0 {
            base_score
        } else {
            selection.path[i - 1].score()
        };
        effects.push(found(
            problem,
            selection,
            steps,
            named,
            i,
            before - selection.path[i].score(),
        ));
    }
    let mut ladder = vec![rung(
        "as given",
        &selection.as_given,
        &selection.as_given_holdout,
        selection.as_given_forecasts.clone(),
    )];
    for i in 0..steps.len() {
        let step = if i == 0 {
            "calibrated".to_owned()
        } else {
            let choices = &selection.path[i - 1].choices;
            let added = choices
                .iter()
                .find(|c| i < 2 || !selection.path[i - 2].choices.contains(c))
                .expect("a step adds an effect");
            format!("+ {}", problem.catalogue[added.effect].id)
        };
        // A step that is not believed is not on the ladder.
        if i == 0 || verdict != Verdict::NoMissingEffect {
            let at = &steps[i];
            let ahead = forecasts(problem, &at.fitted)?;
            ladder.push(rung(&step, &at.fit, &at.holdout, ahead));
        }
    }
    let last = shown(problem, selection, verdict, steps);
    let fitted = &steps[last].fitted;
    let spectral_ratio: Vec<f64> = steps.iter().map(|s| s.spectral_ratio).collect();
    let proposed_terms = match verdict {
        Verdict::UnknownEffect => {
            let fitted = fitted_library_effects(problem, selection, steps);
            match fitted.is_empty() {
                false => fitted,
                true => crate::diagnose::explanation::proposed_term::propose(problem),
            }
        }
        _ => Vec::new(),
    };
    let probability = probability_of(problem, selection, verdict);
    let unknown = match verdict {
        Verdict::UnknownEffect => unknown(problem, selection, probability),
        _ => None,
    };
    let unnamed_effects = match verdict {
        Verdict::UnknownEffect if last > 0 => effect_values(problem, &steps[last]),
        _ => Vec::new(),
    };
    let seen = Seen {
        ladder: &ladder,
        spectral_ratio: &spectral_ratio,
        prior_conflict: strained.as_ref(),
        proposed: &proposed_terms,
    };
    let mut summary = words(problem, verdict, &effects, &seen, selection);
    if verdict == Verdict::UnknownEffect {
        let top = steps.last().expect("the calibrated model at least");
        summary += &unmet_words(problem, &top.fit);
    }
    if let Some(unknown) = &unknown {
        summary = format!("{summary} {}", unknown.words);
    }
    let tied = match verdict {
        Verdict::EffectFound => rivals(selection),
        Verdict::UnknownEffect => unknown_rivals(problem, selection),
        Verdict::NoMissingEffect => Vec::new(),
    };
    let next_measurement = crate::diagnose::selection::next_measurement::recommend(problem, &tied)?;
    let mut remarks = remarks(problem, fitted, selection, &effects);
    let kept_out = &steps[last].holdout;
    let is_kept_out = problem.held_out.contains(&true);
    if selection.explained && is_kept_out && !selection.by_hand && !is_met(kept_out) {
        let over_noise = kept_out.over_noise_words(problem);
        remarks.push(match meets_runs_kept_out(problem, fitted, kept_out)? {
            true => format!(
                "On the runs kept out the error is {over_noise}, and at the noise level once they are fitted too: the runs fitted do not fix the constants well enough to predict these. Fit more operating points."
            ),
            false => format!(
                "The runs kept out contradict this: their error is {over_noise}, beyond what the runs fitted promise. Fit more operating points, or look there for what is missing."
            ),
        });
    }
    let identifiability = undetermined(fitted);
    remarks.extend(in_words(&identifiability));
    remarks.extend(stated_speed(problem));
    if tied.len() > 1 && next_measurement.is_none() {
        remarks.push(crate::diagnose::selection::next_measurement::NONE_HELPS.to_owned());
    }
    let mut residual = crate::diagnose::explanation::residual::describe(
        problem,
        &steps[0].fitted.hypothesis,
        &steps[0].fit,
        &steps[0].holdout,
        &problem.break_aways,
    )?;
    if verdict == Verdict::UnknownEffect {
        residual["proposed_terms"] = serde_json::json!(proposed_terms);
    }
    let forecast = ladder[1 + last].forecasts.iter().cloned();
    let forecast = forecast
        .map(|f| f.with_band(problem, fitted))
        .collect::<Result<_, _>>()?;
    Ok(Diagnosis {
        verdict,
        verdict_probability: (!selection.by_hand).then_some(probability),
        forecast,
        noise_std: NoiseStd::of(
            problem.campaign.measurand(),
            problem.noise.iter().sum::<f64>() / problem.noise.len() as f64,
        ),
        measured_quantity: problem.campaign.measurand(),
        candidates: standings(problem, selection),
        further_effects: further_effects(problem, selection),
        untried_pairs: selection.untried.clone(),
        residual,
        proposed_terms,
        unknown,
        unnamed_effects,
        next_measurement,
        summary,
        remarks,
        calibrated: calibrated(fitted),
        inputs: inputs(problem, fitted),
        identifiability,
        residual_spectral_ratio: spectral_ratio,
        gains_by_chance: selection.by_chance.clone(),
        structure: known_structure(problem)?,
        counters: problem.work.counts(),
        runs: run_values(problem, &steps[last]),
        further_sensors: found_sensors(problem, fitted),
        effects,
        error_ladder: ladder,
    })
}

/// The step of the ladder that is written as the calibrated model: the last one where its effects are named, are terms beyond the
/// catalogue that explain what no named one does, or explain most of what is missing; else the calibrated model.
pub fn shown(problem: &Problem, selection: &Selection, verdict: Verdict, steps: &[Step]) -> usize {
    let choices = selection.path.last().map(|m| m.choices.as_slice());
    let is_beyond = choices.is_some_and(|c| is_beyond(problem, c));
    match verdict {
        Verdict::EffectFound => steps.len() - 1,
        Verdict::UnknownEffect if is_beyond || selection.is_incomplete => steps.len() - 1,
        _ => 0,
    }
}

/// Root mean square error of the forecasts over the runs, and the mean of their valid times; `None` without a run kept out.
fn summarised(forecasts: &[Forecast]) -> (Option<f64>, Option<f64>) {
    if forecasts.is_empty() {
        return (None, None);
    }
    let count = forecasts.len() as f64;
    let squares: f64 = forecasts.iter().map(|f| f.one_cycle_nrmse.powi(2)).sum();
    let times: f64 = forecasts.iter().map(|f| f.valid_time_s).sum();
    (Some((squares / count).sqrt()), Some(times / count))
}

fn rung(
    step: &str,
    fit: &SegmentErrors,
    holdout: &SegmentErrors,
    forecasts: Vec<Forecast>,
) -> Rung {
    let (forecast_nrmse, valid_time_s) = summarised(&forecasts);
    let by_run = fit
        .by_run
        .iter()
        .zip(&holdout.by_run)
        .map(|(f, h)| if h.is_finite() { *h } else { *f })
        .collect();
    Rung {
        step: step.to_owned(),
        fit_nrmse: fit.nrmse,
        holdout_nrmse: holdout.nrmse,
        holdout_over_noise: holdout.quantile(0.5),
        forecast_nrmse,
        valid_time_s,
        forecasts,
        by_run,
        further_over_noise: holdout.of_further.clone(),
    }
}
