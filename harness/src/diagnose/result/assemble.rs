//! From a selection and its ladder to a diagnosis: the verdict, its numbers and its words.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::explanation::library_term::proposal;
use crate::diagnose::explanation::proposed_term::ProposedTerm;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::library;
use crate::diagnose::model::parameter::Kind;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::profile_values::named_values;
use crate::diagnose::result::diagnosis::{
    Diagnosis, Evidence, FoundEffect, FurtherEffect, RunValues, Rung, Standing, Verdict,
};
use crate::diagnose::result::error_ladder::Step;
use crate::diagnose::result::further_sensors::found_sensors;
use crate::diagnose::result::run_sets::effect_values;
use crate::diagnose::result::summary::{Seen, remarks, words};
use crate::diagnose::result::unknown::{unknown, unknown_rivals};
use crate::diagnose::selection::decision::probabilities;
use crate::diagnose::selection::fitted_model::{FittedModel, is_small, name};
use crate::diagnose::selection::full_refit::meets_runs_kept_out;
use crate::diagnose::selection::select::Selection;
use crate::diagnose::selection::ties::{other_forms, rivals};
use crate::diagnose::thresholds::SEARCHED;
use crate::diagnose::validation::estimate::{Estimate, estimate};
use crate::diagnose::validation::forecast::{Forecast, forecasts};
use crate::diagnose::validation::identifiability::{in_words, undetermined};
use crate::diagnose::validation::prior_conflict::prior_conflict;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::error::Error;
use crate::measurement::NoiseStd;
use crate::metric::half_width;
use std::collections::BTreeMap;

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
    if selection.explained && is_kept_out && !selection.by_hand && !is_small(kept_out) {
        let over_noise = kept_out.quantile(0.75);
        remarks.push(match meets_runs_kept_out(problem, fitted, kept_out)? {
            true => format!(
                "On the runs kept out the error is {over_noise:.1} times the noise in a quarter of the segments, and down to the noise once they are fitted too: the runs fitted do not fix the constants well enough to predict these. Fit more operating points."
            ),
            false => format!(
                "The runs kept out contradict this: their error is {over_noise:.1} times the noise in a quarter of the segments, beyond what the runs fitted promise. Fit more operating points, or look there for what is missing."
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

/// Whether an effect among these is none of the catalogue's.
fn is_beyond(problem: &Problem, choices: &[Choice]) -> bool {
    let mut effects = choices.iter().map(|c| &problem.catalogue[c.effect]);
    effects.any(|card| library::is_library_effect(&card.id))
}

/// The shared parameters of a kind.
fn of_kind(fitted: &FittedHypothesis, kind: Kind) -> impl Iterator<Item = (String, Estimate)> + '_ {
    let parameters = fitted.hypothesis.shared.iter().enumerate();
    let wanted = parameters.filter(move |(_, parameter)| parameter.kind == kind);
    wanted.map(|(i, k)| (k.name.clone(), estimate(&fitted.hypothesis, &fitted.fit, i)))
}

/// Factors from the stated inputs to those found, by the names of the parameters and by those of the file format.
fn inputs(problem: &Problem, fitted: &FittedHypothesis) -> BTreeMap<String, Estimate> {
    let mut out: BTreeMap<String, Estimate> = of_kind(fitted, Kind::Input).collect();
    if let Some(belt) = out.get_mut("belt_velocity.scale") {
        belt.value *= problem.belt_scale.value;
        belt.std *= problem.belt_scale.value;
    }
    for name in ["belt_velocity", "normal_force"] {
        if let Some(scale) = out.get(&format!("{name}.scale")).cloned() {
            out.insert(format!("{name}_scale"), scale);
        }
    }
    out
}

/// That the stated belt speeds are off, where the stick phases contradict them; half the 95 % interval as everywhere.
fn stated_speed(problem: &Problem) -> Option<String> {
    let scale = problem.belt_scale;
    let half = half_width(scale.std);
    ((scale.value - 1.0).abs() > half).then(|| {
        format!(
            "In stick the tip moves {:.4} +- {half:.4} (95 %) times as fast as the stated belt speeds: the diagnosis counts with the belt speeds found.",
            scale.value
        )
    })
}

/// The constants of the reference model; the first mode's mass also under its earlier name.
fn calibrated(fitted: &FittedHypothesis) -> BTreeMap<String, Estimate> {
    let mut out: BTreeMap<String, Estimate> = of_kind(fitted, Kind::Reference).collect();
    if let Some(mass) = out.get("mode[1].mass").cloned() {
        out.insert("mass".to_owned(), mass);
    }
    out
}

/// The terms beyond the catalogue that a path ends with, but for unknown functions.
fn fitted_library_effects(
    problem: &Problem,
    selection: &Selection,
    steps: &[Step],
) -> Vec<ProposedTerm> {
    let (Some(named), Some(last)) = (selection.path.last(), steps.last()) else {
        return Vec::new();
    };
    if selection.beyond.is_none() {
        return Vec::new();
    }
    let left = last.holdout.nrmse / steps[0].holdout.nrmse;
    let explained = 1.0 - left.powi(2);
    let of_library = |c: &&Choice| library::is_library_effect(&problem.catalogue[c.effect].id);
    let terms = named.choices.iter().filter(of_library);
    terms
        .filter_map(|choice| proposal(problem, choice, &last.fitted, explained))
        .collect()
}

/// What the calibrated model takes from the campaign as known, by FMU variable: nothing for an FMU with parameters of its own.
fn known_structure(problem: &Problem) -> Result<BTreeMap<String, f64>, Error> {
    if problem.fmu.side_file().is_some() {
        return Ok(BTreeMap::new());
    }
    let structure = structure(problem.fmu, &problem.campaign.beam)?;
    let modes = structure.modes();
    let mut out = BTreeMap::from([("mode_count".to_owned(), modes.len() as f64)]);
    for (j, mode) in modes.iter().enumerate() {
        let mut put = |item: &str, value: f64| {
            out.insert(format!("mode[{}].{item}", j + 1), value);
        };
        put("tip_value", mode.tip_value);
        if let Some(&share) = problem.campaign.beam.clamp_shares.get(j) {
            put("clamp_share", share);
        }
        if mode.is_free() {
            put("frequency", 0.0);
            put("damping_ratio", 0.0);
        }
        // One that is calibrated comes from there.
        if let Some(&rate) = problem.campaign.beam.damping_rates_per_s.get(j) {
            put("damping_rate", rate);
        }
    }
    let ratios = problem.campaign.beam.sensor.ratios.iter().enumerate();
    for (j, ratio) in ratios.skip(modes.len()) {
        out.insert(format!("mode[{}].sensor_ratio", j + 1), *ratio);
    }
    Ok(out)
}

fn is_effect(problem: &Problem, parameter: &str) -> bool {
    parameter
        .split_once('.')
        .is_some_and(|(id, _)| problem.catalogue.iter().any(|c| c.id == id))
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

fn found(
    problem: &Problem,
    selection: &Selection,
    steps: &[Step],
    search: usize,
    i: usize,
    gain: f64,
) -> FoundEffect {
    let model = &selection.path[i];
    let choice = model
        .choices
        .iter()
        .find(|c| i == 0 || !selection.path[i - 1].choices.contains(c))
        .expect("a step adds an effect");
    let card = &problem.catalogue[choice.effect];
    let fitted = &steps[search].fitted;
    let prefix = format!("{}.", card.id);
    let mut parameters = BTreeMap::new();
    for (index, parameter) in fitted.hypothesis.shared.iter().enumerate() {
        if let Some(name) = parameter.name.strip_prefix(&prefix) {
            parameters.insert(
                name.to_owned(),
                estimate(&fitted.hypothesis, &fitted.fit, index),
            );
        }
    }
    for &(index, value) in &choice.settings {
        let parameter = &card.parameters[index];
        parameters.insert(
            parameter.name.clone(),
            Estimate {
                value,
                std: 0.0,
                unit: parameter.unit.clone(),
                at_bound: false,
            },
        );
    }
    let mut own_parameters: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let runs = fitted.hypothesis.per_run.len();
    for (run, parameters) in fitted.hypothesis.per_run.iter().enumerate() {
        let own = &steps[search].point(problem, run).per_run[run];
        for (name, value) in named_values(&problem.catalogue, parameters, own) {
            if let Some(name) = name.strip_prefix(&prefix) {
                // Where break-aways map them, a run with few has fewer values along the belt.
                let of_runs = own_parameters.entry(name.to_owned());
                of_runs.or_insert_with(|| vec![f64::NAN; runs])[run] = value;
            }
        }
    }
    let mut confounded_with: Vec<String> = rivals(selection)
        .into_iter()
        .skip(1)
        .flat_map(|r| &r.choices)
        .filter(|c| {
            let named = &selection.path[selection.path.len() - 1].choices;
            !named.iter().any(|n| n.effect == c.effect)
        })
        .map(|c| problem.catalogue[c.effect].id.clone())
        .collect();
    confounded_with.dedup();
    let other_forms = other_forms(selection)
        .into_iter()
        .filter_map(|rival| values_in(problem, rival, choice))
        .collect();
    FoundEffect {
        id: card.id.clone(),
        parameters,
        own_parameters,
        evidence: Evidence {
            holdout_nrmse_before: steps[i].holdout.nrmse,
            holdout_nrmse_after: steps[i + 1].holdout.nrmse,
            gain,
            threshold: selection.threshold,
            p_value: p_value(selection, i, gain),
            floor_ratio: steps[i + 1].fit.quantile(0.5),
            break_away_falls: break_away_falls(problem, selection),
        },
        confounded_with,
        other_forms,
    }
}

/// Parameters, settings included, that a rival has for the effect of `choice` in another form; `None` where it has it in
/// the same.
fn values_in(
    problem: &Problem,
    rival: &FittedModel,
    choice: &Choice,
) -> Option<BTreeMap<String, f64>> {
    let other = rival
        .choices
        .iter()
        .find(|c| c.effect == choice.effect && *c != choice)?;
    let card = &problem.catalogue[choice.effect];
    let prefix = format!("{}.", card.id);
    let fitted = &rival.fitted;
    let parameters = fitted
        .hypothesis
        .shared
        .iter()
        .zip(&fitted.fit.point.shared);
    let fitted = parameters.filter_map(|(parameter, u)| {
        let name = parameter.name.strip_prefix(&prefix)?;
        Some((name.to_owned(), parameter.value(*u)))
    });
    let settings = other.settings.iter();
    let given = settings.map(|&(i, value)| (card.parameters[i].name.clone(), value));
    Some(fitted.chain(given).collect())
}

/// For each run the fall of the error of predicting its break-aways by their place, if the effect is believed for that.
fn break_away_falls(problem: &Problem, selection: &Selection) -> Vec<f64> {
    let falls = problem.break_aways.iter().map(|b| b.fall_by_place);
    falls.filter(|_| selection.by_break_aways).collect()
}

/// Probability of a gain as large by chance, from the campaigns simulated for step `i`; never below one in their number
/// and one.
fn p_value(selection: &Selection, i: usize, gain: f64) -> Option<f64> {
    let gains = selection.by_chance.get(i).filter(|g| !g.is_empty())?;
    let as_large = gains.iter().filter(|g| **g >= gain).count();
    Some((1 + as_large) as f64 / (1 + gains.len()) as f64)
}

/// All models of a selection, the calibrated model first.
fn all_models(selection: &Selection) -> Vec<&FittedModel> {
    std::iter::once(&selection.calibrated)
        .chain(&selection.path)
        .chain(&selection.singles)
        .chain(&selection.pairs)
        .collect()
}

/// Probability of the verdict: what the hypotheses share that say the same.
fn probability_of(problem: &Problem, selection: &Selection, verdict: Verdict) -> f64 {
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
fn of_catalogue<'a>(
    problem: &'a Problem,
    choices: &'a [Choice],
) -> impl Iterator<Item = &'a Choice> {
    let is_of_library = |o: &&Choice| library::is_library_effect(&problem.catalogue[o.effect].id);
    choices.iter().filter(move |o| !is_of_library(o))
}

fn standings(problem: &Problem, selection: &Selection) -> Vec<Standing> {
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
fn further_effects(problem: &Problem, selection: &Selection) -> Vec<FurtherEffect> {
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

fn run_values(problem: &Problem, step: &Step) -> Vec<RunValues> {
    problem
        .campaign
        .runs
        .iter()
        .enumerate()
        .map(|(r, run)| {
            let point = step.point(problem, r);
            RunValues {
                name: run.name.clone(),
                belt_velocity_m_per_s: problem.stated_belt_velocity(r),
                normal_force_n: run.normal_force,
                held_out: problem.held_out[r],
                per_run: named_values(
                    &problem.catalogue,
                    &step.fitted.hypothesis.per_run[r],
                    &point.per_run[r],
                )
                .into_iter()
                .collect(),
            }
        })
        .collect()
}
