//! Constants of a fit as they are reported: those of effects, of the model and of inputs, with intervals.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::explanation::library_term::proposal;
use crate::diagnose::explanation::proposed_term::ProposedTerm;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::library;
use crate::diagnose::model::parameter::Kind;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::profile_values::named_values;
use crate::diagnose::result::diagnosis::{Evidence, FoundEffect, RunValues};
use crate::diagnose::result::error_ladder::Step;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::selection::ties::{other_forms, rivals};
use crate::diagnose::validation::estimate::{Estimate, estimate};
use crate::error::Error;
use crate::metric::half_width;
use std::collections::BTreeMap;

/// The shared parameters of a kind.
pub(super) fn of_kind(
    fitted: &FittedHypothesis,
    kind: Kind,
) -> impl Iterator<Item = (String, Estimate)> + '_ {
    let parameters = fitted.hypothesis.shared.iter().enumerate();
    let wanted = parameters.filter(move |(_, parameter)| parameter.kind == kind);
    wanted.map(|(i, k)| (k.name.clone(), estimate(&fitted.hypothesis, &fitted.fit, i)))
}

/// Factors from the stated inputs to those found, by the names of the parameters and by those of the file format.
pub(super) fn inputs(problem: &Problem, fitted: &FittedHypothesis) -> BTreeMap<String, Estimate> {
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

/// The constants of the reference model; the first mode's mass also under its earlier name.
pub(super) fn calibrated(fitted: &FittedHypothesis) -> BTreeMap<String, Estimate> {
    let mut out: BTreeMap<String, Estimate> = of_kind(fitted, Kind::Reference).collect();
    if let Some(mass) = out.get("mode[1].mass").cloned() {
        out.insert("mass".to_owned(), mass);
    }
    out
}

/// The terms beyond the catalogue that a path ends with, but for unknown functions.
pub(super) fn fitted_library_effects(
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
pub(super) fn known_structure(problem: &Problem) -> Result<BTreeMap<String, f64>, Error> {
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

pub(super) fn is_effect(problem: &Problem, parameter: &str) -> bool {
    parameter
        .split_once('.')
        .is_some_and(|(id, _)| problem.catalogue.iter().any(|c| c.id == id))
}

/// Parameters, settings included, that a rival has for the effect of `choice` in another form; `None` where it has it in
/// the same.
pub(super) fn values_in(
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

pub(super) fn run_values(problem: &Problem, step: &Step) -> Vec<RunValues> {
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

pub(super) fn found(
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

/// That the stated belt speeds are off, where the stick phases contradict them; half the 95 % interval as everywhere.
pub(super) fn stated_speed(problem: &Problem) -> Option<String> {
    let scale = problem.belt_scale;
    let half = half_width(scale.std);
    ((scale.value - 1.0).abs() > half).then(|| {
        format!(
            "In stick the tip moves {:.4} +- {half:.4} (95 %) times as fast as the stated belt speeds: the diagnosis counts with the belt speeds found.",
            scale.value
        )
    })
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
