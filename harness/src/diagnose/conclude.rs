//! From a selection and its ladder to a diagnosis: the verdict, its numbers and its words.

use super::contender::Contender;
use super::decision::probabilities;
use super::fit::Fit;
use super::forecast::{Forecast, forecasts};
use super::hypothesis::{Choice, Hypothesis, structure};
use super::identifiability::{in_words, undetermined};
use super::judge::Judgement;
use super::knob::{Kind, Scale};
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
use crate::metric::half_width;
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
    let base_score = selection.calibrated.score();
    let last = steps.len() - 1;
    let strained = strain(&steps[last].trial);
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
            selection.path[i - 1].score()
        };
        effects.push(found(
            session,
            selection,
            steps,
            depth,
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
    let identifiability = undetermined(trial);
    remarks.extend(in_words(&identifiability));
    remarks.extend(stated_speed(session));
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
        verdict_probability: (!selection.by_hand).then(|| probability_of(selection, verdict)),
        forecast: ladder[1 + last].forecasts.clone(),
        noise_std_m: session.noise.iter().sum::<f64>() / session.noise.len() as f64,
        candidates: standings(session, selection),
        residual,
        proposed_terms,
        next_measurement,
        summary,
        remarks,
        calibrated: calibrated(trial),
        inputs: inputs(session, trial),
        identifiability,
        residual_colour: colours,
        gains_by_chance: selection.by_chance.clone(),
        structure: known_structure(session)?,
        runs: run_values(session, &steps[last]),
        effects,
        error_ladder: ladder,
    })
}

/// The shared knobs of a kind.
fn of_kind(trial: &Trial, kind: Kind) -> impl Iterator<Item = (String, Estimate)> + '_ {
    let knobs = trial.hypothesis.shared.iter().enumerate();
    let wanted = knobs.filter(move |(_, knob)| knob.kind == kind);
    wanted.map(|(i, k)| (k.name.clone(), estimate(&trial.hypothesis, &trial.fit, i)))
}

/// Factors from the stated inputs to those found.
fn inputs(session: &Session, trial: &Trial) -> BTreeMap<String, Estimate> {
    let mut out: BTreeMap<String, Estimate> = of_kind(trial, Kind::Input).collect();
    if let Some(belt) = out.get_mut("belt_velocity.scale") {
        belt.value *= session.belt_scale.value;
        belt.std *= session.belt_scale.value;
    }
    out
}

/// That the stated belt speeds are off, where the stick phases contradict them; half the 95 % interval as everywhere.
fn stated_speed(session: &Session) -> Option<String> {
    let scale = session.belt_scale;
    let half = half_width(scale.std);
    ((scale.value - 1.0).abs() > half).then(|| {
        format!(
            "In stick the tip moves {:.4} +- {half:.4} (95 %) times as fast as the stated belt speeds: the diagnosis counts with the belt speeds found.",
            scale.value
        )
    })
}

/// The constants of the reference model; the first mode's mass also under its earlier name.
fn calibrated(trial: &Trial) -> BTreeMap<String, Estimate> {
    let mut out: BTreeMap<String, Estimate> = of_kind(trial, Kind::Reference).collect();
    if let Some(mass) = out.get("mode[1].mass").cloned() {
        out.insert("mass".to_owned(), mass);
    }
    out
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
fn known_structure(session: &Session) -> Result<BTreeMap<String, f64>, Error> {
    let structure = structure(session.fmu, &session.campaign.beam)?;
    let modes = structure.modes();
    let mut out = BTreeMap::from([("mode_count".to_owned(), modes.len() as f64)]);
    for (j, mode) in modes.iter().enumerate() {
        out.insert(format!("mode[{}].tip_value", j + 1), mode.tip_value);
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

/// All contenders of a selection, the calibrated model first.
fn all_contenders(selection: &Selection) -> Vec<&Contender> {
    std::iter::once(&selection.calibrated)
        .chain(&selection.path)
        .chain(&selection.singles)
        .chain(&selection.pairs)
        .collect()
}

/// Probability of the verdict: what the hypotheses share that say the same.
fn probability_of(selection: &Selection, verdict: Verdict) -> f64 {
    let all = all_contenders(selection);
    let shares = probabilities(&all);
    let of = |wanted: &dyn Fn(&Contender) -> bool| -> f64 {
        let wanted = all.iter().zip(&shares).filter(|(c, _)| wanted(c));
        wanted.map(|(_, p)| p).sum()
    };
    match (verdict, selection.path.last()) {
        (Verdict::UnknownEffect, _) if !selection.explained => 1.0 - of(&|_| true),
        (Verdict::NoMissingEffect, _) | (_, None) => of(&|c| c.choices.is_empty()),
        (_, Some(best)) => of(&|c| c.effects() == best.effects()),
    }
}

fn standings(session: &Session, selection: &Selection) -> Vec<Standing> {
    let base = selection.calibrated.score();
    // The list is the catalogue's: a term beyond it stands among the proposals.
    let is_term = |c: &&Choice| terms::is_term(&session.catalogue[c.effect].id);
    let of_catalogue = |c: &Contender| !c.choices.iter().any(|choice| is_term(&choice));
    let everything = all_contenders(selection);
    let shares = probabilities(&everything);
    let listed: Vec<&Contender> = selection
        .path
        .iter()
        .chain(&selection.singles)
        .chain(selection.listed_pairs())
        .collect();
    let is_listed = |c: &Contender| listed.iter().any(|l| std::ptr::eq(*l, c));
    let mut all: Vec<(&Contender, f64)> = everything
        .into_iter()
        .zip(shares)
        .filter(|(c, _)| of_catalogue(c) && is_listed(c))
        .collect();
    all.sort_by(|(a, _), (b, _)| a.score().total_cmp(&b.score()));
    all.iter()
        .map(|(c, probability)| Standing {
            id: super::contender::name(session, &c.choices),
            holdout_nrmse: c.holdout.as_ref().map_or(f64::NAN, |h| h.nrmse),
            probability: *probability,
            score: base - c.score(),
            misfit_fall: selection.calibrated.trial.fit.misfit - c.trial.fit.misfit,
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
                belt_velocity_m_per_s: session.stated_belt_velocity(r),
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
