//! From a selection and its ladder to a diagnosis: the verdict, its numbers and its words.

use super::contender::{Contender, FLOOR_COLOUR, FLOOR_HELD_OUT};
use super::fit::Fit;
use super::forecast::{Forecast, forecasts};
use super::hypothesis::{Choice, Hypothesis, structure};
use super::judge::Judgement;
use super::knob::Scale;
use super::outcome::{
    Diagnosis, Estimate, Evidence, FoundEffect, RunValues, Rung, Standing, Verdict,
};
use super::propose::ProposedTerm;
use super::rivals::{other_forms, rivals};
use super::search::Trial;
use super::select::Selection;
use super::session::Session;
use super::steps::Step;
use super::strain::strain;
use super::terms;
use super::words::{Seen, remarks, words};
use crate::error::Error;
use std::collections::BTreeMap;

/// The diagnosis.
///
/// # Errors
/// An FMU that can't be run.
pub fn conclude(
    session: &Session,
    selection: &Selection,
    steps: &[Step],
) -> Result<Diagnosis, Error> {
    let samples = selection.samples;
    let base_score = selection.calibrated.score(samples);
    let gain = selection
        .path
        .last()
        .map_or(0.0, |p| base_score - p.score(samples));
    let base_is_enough = selection.calibrated.reaches_floor() && gain < selection.threshold;
    // What gains no more than chance is not named, though it may be just what brings the errors below the limit.
    let is_worth_it = gain >= selection.threshold;
    let is_white = |depth: usize| !(steps[depth].colour > FLOOR_COLOUR);
    let last = steps.len() - 1;
    let predicts = !(steps[last].holdout.quantile(0.5) > FLOOR_HELD_OUT);
    let strained = strain(&steps[if base_is_enough { 0 } else { last }].trial);
    let is_strained = strained.is_some();
    let verdict = if selection.beyond.is_some() {
        Verdict::UnknownEffect
    } else if base_is_enough && is_white(0) && !is_strained {
        Verdict::NoMissingEffect
    } else if selection.explained && is_worth_it && is_white(last) && predicts && !is_strained
        || selection.by_break_aways
    {
        Verdict::EffectFound
    } else {
        Verdict::UnknownEffect
    };
    let depth = if verdict == Verdict::EffectFound {
        selection.path.len()
    } else {
        0
    };
    let mut effects = Vec::new();
    for i in 0..depth {
        let before = if i == 0 {
            base_score
        } else {
            selection.path[i - 1].score(samples)
        };
        effects.push(found(
            session,
            selection,
            steps,
            depth,
            i,
            before - selection.path[i].score(samples),
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
            format!("+ {}", session.catalogue[added.effect].id)
        };
        // A step that is not believed is not on the ladder.
        if i == 0 || verdict != Verdict::NoMissingEffect {
            let at = &steps[i];
            let ahead = forecasts(session, &at.trial)?;
            ladder.push(rung(&step, &at.fit, &at.holdout, ahead));
        }
    }
    let last = if depth == 0 { 0 } else { steps.len() - 1 };
    let trial = &steps[last].trial;
    let colours: Vec<f64> = steps.iter().map(|s| s.colour).collect();
    let proposed_terms = match verdict {
        Verdict::UnknownEffect => match fitted_term(session, selection, steps) {
            Some(term) => vec![term],
            None => super::propose::propose(session),
        },
        _ => Vec::new(),
    };
    let seen = Seen {
        ladder: &ladder,
        colours: &colours,
        strain: strained.as_ref(),
        proposed: &proposed_terms,
    };
    let summary = words(session, verdict, &effects, &seen, selection);
    let tied = match verdict {
        Verdict::EffectFound => rivals(selection),
        _ => Vec::new(),
    };
    let next_measurement = super::next_measurement::recommend(session, &tied)?;
    let mut remarks = remarks(session, trial, selection, &effects);
    if tied.len() > 1 && next_measurement.is_none() {
        remarks.push(super::next_measurement::NONE_HELPS.to_owned());
    }
    let mut residual = super::residual::describe(
        session,
        &steps[0].trial.hypothesis,
        &steps[0].fit,
        &steps[0].holdout,
        &session.break_aways,
    )?;
    if verdict == Verdict::UnknownEffect {
        residual["proposed_terms"] = serde_json::json!(proposed_terms);
    }
    Ok(Diagnosis {
        verdict,
        forecast: ladder[1 + last].forecasts.clone(),
        noise_std_m: session.noise.iter().sum::<f64>() / session.noise.len() as f64,
        candidates: standings(session, selection),
        residual,
        proposed_terms,
        next_measurement,
        summary,
        remarks,
        calibrated: trial
            .hypothesis
            .shared
            .iter()
            .enumerate()
            .filter(|(_, k)| !is_effect(session, &k.name))
            .map(|(i, k)| (k.name.clone(), estimate(&trial.hypothesis, &trial.fit, i)))
            .collect(),
        residual_colour: colours,
        gains_by_chance: selection.by_chance.clone(),
        structure: known_structure(session, trial)?,
        runs: run_values(session, &steps[last]),
        effects,
        error_ladder: ladder,
    })
}

/// The term beyond the catalogue at the end of the path.
fn fitted_term(session: &Session, selection: &Selection, steps: &[Step]) -> Option<ProposedTerm> {
    selection.beyond.as_ref()?;
    let choice = selection.path.last()?.choices.last()?;
    let last = steps.last()?;
    let left = last.holdout.nrmse / steps[0].holdout.nrmse;
    terms::proposal(session, choice, &last.trial, 1.0 - left.powi(2))
}

/// What the calibrated model takes from the campaign as known, by FMU variable.
fn known_structure(session: &Session, trial: &Trial) -> Result<BTreeMap<String, f64>, Error> {
    let structure = structure(session.fmu, &session.campaign.beam)?;
    let modes = structure.modes();
    let mass = trial
        .hypothesis
        .shared_index("mass")
        .map(|i| trial.hypothesis.shared[i].value(trial.fit.point.shared[i]));
    let mut out = BTreeMap::from([("mode_count".to_owned(), modes.len() as f64)]);
    for (j, mode) in modes.iter().enumerate() {
        out.insert(format!("mode[{}].tip_value", j + 1), mode.tip_value);
        if let Some(mass) = mass {
            let ratio = mode.mass_kg / modes[0].mass_kg;
            out.insert(format!("mode[{}].mass", j + 1), mass * ratio);
        }
    }
    Ok(out)
}

fn is_effect(session: &Session, knob: &str) -> bool {
    knob.split_once('.')
        .is_some_and(|(id, _)| session.catalogue.iter().any(|c| c.id == id))
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

fn rung(step: &str, fit: &Judgement, holdout: &Judgement, forecasts: Vec<Forecast>) -> Rung {
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
    }
}

/// A shared knob's value and standard deviation in its unit.
pub fn estimate(h: &Hypothesis, fit: &Fit, index: usize) -> Estimate {
    let knob = &h.shared[index];
    let value = knob.value(fit.point.shared[index]);
    let spread = fit
        .covariance
        .as_ref()
        .map_or(f64::NAN, |c| c[(index, index)].max(0.0).sqrt());
    let std = match knob.scale {
        Scale::Linear => spread,
        Scale::Log => spread * value,
    };
    Estimate {
        value,
        std,
        unit: knob.unit.clone(),
        at_bound: knob.is_at_bound(fit.point.shared[index]),
    }
}

fn found(
    session: &Session,
    selection: &Selection,
    steps: &[Step],
    depth: usize,
    i: usize,
    gain: f64,
) -> FoundEffect {
    let contender = &selection.path[i];
    let choice = contender
        .choices
        .iter()
        .find(|c| i == 0 || !selection.path[i - 1].choices.contains(c))
        .expect("a step adds an effect");
    let card = &session.catalogue[choice.effect];
    let trial = &steps[depth].trial;
    let prefix = format!("{}.", card.id);
    let mut parameters = BTreeMap::new();
    for (index, knob) in trial.hypothesis.shared.iter().enumerate() {
        if let Some(name) = knob.name.strip_prefix(&prefix) {
            parameters.insert(
                name.to_owned(),
                estimate(&trial.hypothesis, &trial.fit, index),
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
    for knob in &trial.hypothesis.own[0] {
        if let Some(name) = knob.name.strip_prefix(&prefix) {
            let values = trial
                .hypothesis
                .own
                .iter()
                .enumerate()
                .map(|(run, knobs)| {
                    let point = steps[depth].point(session, run);
                    knobs
                        .iter()
                        .position(|k| k.name == knob.name)
                        .map_or(f64::NAN, |j| knobs[j].value(point.own[run][j]))
                })
                .collect();
            own_parameters.insert(name.to_owned(), values);
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
        .map(|c| session.catalogue[c.effect].id.clone())
        .collect();
    confounded_with.dedup();
    let other_forms = other_forms(selection)
        .into_iter()
        .filter_map(|rival| values_in(session, rival, choice))
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
            break_away_falls: break_away_falls(session, selection),
        },
        confounded_with,
        other_forms,
    }
}

/// Parameters, settings included, that a rival has for the effect of `choice` in another form; `None` where it has it in
/// the same.
fn values_in(
    session: &Session,
    rival: &Contender,
    choice: &Choice,
) -> Option<BTreeMap<String, f64>> {
    let other = rival
        .choices
        .iter()
        .find(|c| c.effect == choice.effect && *c != choice)?;
    let card = &session.catalogue[choice.effect];
    let prefix = format!("{}.", card.id);
    let trial = &rival.trial;
    let knobs = trial.hypothesis.shared.iter().zip(&trial.fit.point.shared);
    let fitted = knobs.filter_map(|(knob, u)| {
        let name = knob.name.strip_prefix(&prefix)?;
        Some((name.to_owned(), knob.value(*u)))
    });
    let settings = other.settings.iter();
    let given = settings.map(|&(i, value)| (card.parameters[i].name.clone(), value));
    Some(fitted.chain(given).collect())
}

/// For each run the fall of the error of predicting its break-aways by their place, if the effect is believed for that.
fn break_away_falls(session: &Session, selection: &Selection) -> Vec<f64> {
    let falls = session.break_aways.iter().map(|b| b.fall_by_place);
    falls.filter(|_| selection.by_break_aways).collect()
}

/// Probability of a gain as large by chance, from the campaigns simulated for step `i`; never below one in their number
/// and one.
fn p_value(selection: &Selection, i: usize, gain: f64) -> Option<f64> {
    let gains = selection.by_chance.get(i).filter(|g| !g.is_empty())?;
    let as_large = gains.iter().filter(|g| **g >= gain).count();
    Some((1 + as_large) as f64 / (1 + gains.len()) as f64)
}

fn standings(session: &Session, selection: &Selection) -> Vec<Standing> {
    let base = selection.calibrated.score(selection.samples);
    // The list is the catalogue's: a term beyond it stands among the proposals.
    let is_term = |c: &&Choice| terms::is_term(&session.catalogue[c.effect].id);
    let of_catalogue = |c: &&Contender| !c.choices.iter().any(|choice| is_term(&choice));
    let mut all: Vec<&Contender> = selection
        .path
        .iter()
        .filter(of_catalogue)
        .chain(&selection.singles)
        .chain(selection.listed_pairs())
        .collect();
    all.sort_by(|a, b| {
        a.score(selection.samples)
            .total_cmp(&b.score(selection.samples))
    });
    all.iter()
        .map(|c| Standing {
            id: super::contender::name(session, &c.choices),
            holdout_nrmse: c.holdout.as_ref().map_or(f64::NAN, |h| h.nrmse),
            score: base - c.score(selection.samples),
            misfit_fall: selection.calibrated.fit.trimmed - c.fit.trimmed,
            fit_over_noise: c.fit.quantile(0.5),
            free_values: c.size(),
            parameters: c
                .trial
                .hypothesis
                .shared
                .iter()
                .zip(&c.trial.fit.point.shared)
                .filter(|(k, _)| is_effect(session, &k.name))
                .map(|(k, u)| (k.name.clone(), k.value(*u)))
                .collect(),
        })
        .collect()
}

fn run_values(session: &Session, step: &Step) -> Vec<RunValues> {
    session
        .campaign
        .runs
        .iter()
        .enumerate()
        .map(|(r, run)| {
            let point = step.point(session, r);
            RunValues {
                name: run.name.clone(),
                belt_velocity_m_per_s: run.belt_velocity,
                normal_force_n: run.normal_force,
                held_out: session.held_out[r],
                own: step.trial.hypothesis.own[r]
                    .iter()
                    .zip(&point.own[r])
                    .map(|(k, u)| (k.name.clone(), k.value(*u)))
                    .collect(),
            }
        })
        .collect()
}
