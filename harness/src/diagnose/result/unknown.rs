//! What is said of physics that nobody wrote a term for: where it acts, what it depends on, and the curve.

use super::hysteresis::{Loop, hysteresis};
use super::shape::{is_flat, shape};
use crate::diagnose::explanation::argument::course;
use crate::diagnose::explanation::curve_estimate::{CurveEstimate, curve_estimate};
use crate::diagnose::explanation::library_term::proposal;
use crate::diagnose::model::library::{File, is_library_effect};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{UnknownFunction, is_unknown_function};
use crate::diagnose::result::curve_formula::function_of;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::select::Selection;
use crate::diagnose::thresholds::{SEARCHED, TIE};
use crate::diagnose::validation::estimate::{Estimate, estimate};
use serde::Serialize;
use std::collections::BTreeMap;

/// Effects of the library that are listed.
const NEAREST: usize = 3;
/// Intervals of the histogram over a curve.
const INTERVALS: usize = 28;

/// An unknown function as fitted, in `diagnosis.json` as `unknown`.
#[derive(Debug, Clone, Serialize)]
pub struct Unknown {
    /// Where it acts: `friction`, `normal_force`, `tip_force`, `frequency`, `damping`, `measurement` or `belt`.
    pub target: String,
    /// The mode, from 1, where it acts on the frequency of one alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mode: Option<usize>,
    /// What it depends on.
    pub argument: String,
    /// Unit of the argument.
    pub argument_unit: String,
    /// Time constant in s with which the argument is low-passed; `None` without a memory.
    pub memory_s: Option<f64>,
    /// Argument, value and standard deviation of the value at the nodes.
    pub curve: Vec<[f64; 3]>,
    /// Probability among the unknown functions that were fitted; small where none of them explains the data.
    pub probability: f64,
    /// Others that the data can't tell from it.
    pub alternatives: Vec<Alternative>,
    /// Effects of the library that come nearest, best first.
    pub nearest_library_effects: Vec<String>,
    /// Unit of the value.
    pub value_unit: String,
    /// A short formula that took the curve's place; `None` where none explains as much.
    pub formula: Option<Formula>,
    /// What shape the curve has, as the end of a sentence that begins with "the curve".
    pub shape: String,
    /// With a memory, the loop of the value over what the argument is made of, at the same instant.
    #[serde(rename = "loop", skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<Loop>,
    /// Where the data lie: from, to, and the share of the samples of the runs fitted between them.
    pub samples: Vec<[f64; 3]>,
    /// The curve as a user's effect.
    #[serde(skip)]
    pub file: String,
    /// The same in words.
    #[serde(skip)]
    pub words: String,
}

/// A short formula in place of a curve, as fitted to the data.
#[derive(Debug, Clone, Serialize)]
pub struct Formula {
    /// Target in an effect's file.
    pub target: String,
    /// What the target is.
    pub expression: String,
    /// Its constants.
    pub parameters: BTreeMap<String, Estimate>,
}

/// Another unknown function.
#[derive(Debug, Clone, Serialize)]
pub struct Alternative {
    /// Where it acts.
    pub target: String,
    /// What it depends on.
    pub argument: String,
    /// Probability among the unknown functions that were fitted.
    pub probability: f64,
}

/// The best unknown function of a selection; `None` where none was fitted.
pub fn unknown(problem: &Problem, selection: &Selection) -> Option<Unknown> {
    let (fitted, is_any_adequate) = candidates(problem, selection);
    let first = fitted.first()?;
    let (best, model) = (first.function, first.model);
    let odds = |c: &Candidate| (c.log_evidence - first.log_evidence).min(0.0).exp();
    let known = if is_any_adequate { 1.0 } else { 1.0 - SEARCHED };
    let total = fitted.iter().map(odds).sum::<f64>() / known;
    let alternatives = fitted[1..]
        .iter()
        .filter(|c| first.log_evidence - c.log_evidence < TIE)
        .map(|c| Alternative {
            target: c.function.place.to_owned(),
            argument: c.function.argument.to_owned(),
            probability: odds(c) / total,
        })
        .collect();
    let curve = curve(best, first.estimate.as_ref()?);
    let h = &model.fitted.hypothesis;
    let memory = h.shared_index(&format!("{}.tau", best.id));
    let memory = memory.map(|i| estimate(h, &model.fitted.fit, i));
    let memory_s = memory.as_ref().map(|m| m.value);
    let values: Vec<f64> = curve.iter().map(|c| c[1]).collect();
    let value_unit = best.value_unit();
    let shape = shape(&curve, value_unit);
    let hysteresis = memory_s.filter(|tau| *tau > 0.0).and_then(|tau| {
        let units = (value_unit, best.argument_unit);
        hysteresis(problem, best.argument, tau, &curve, units)
    });
    let mut words = in_words(best, &shape, memory.as_ref(), is_any_adequate);
    if let Some(found) = &hysteresis {
        let names = (place_in_words(best.place), argument_in_words(best.argument));
        words = format!("{words} {}", found.words(names.0, names.1));
    }
    Some(Unknown {
        target: best.place.to_owned(),
        mode: best.mode,
        argument: best.argument.to_owned(),
        argument_unit: best.argument_unit.to_owned(),
        memory_s,
        words,
        shape,
        hysteresis,
        samples: samples(problem, best.argument, memory_s, &curve),
        curve,
        probability: 1.0 / total,
        alternatives,
        nearest_library_effects: nearest(problem, selection),
        value_unit: value_unit.to_owned(),
        formula: formula(problem, selection),
        file: best.file_with("unknown", &values, memory_s),
    })
}

/// An unknown function that was fitted.
struct Candidate<'a> {
    function: &'a UnknownFunction,
    model: &'a FittedModel,
    estimate: Option<CurveEstimate>,
    /// With the smoothness fitted too, nats.
    log_evidence: f64,
}

impl<'a> Candidate<'a> {
    fn new(problem: &'a Problem, model: &'a FittedModel) -> Option<Self> {
        let function = function_of(problem, model)?;
        let estimate = curve_estimate(problem, function, &model.fitted);
        let gain = estimate.as_ref().map_or(0.0, |e| e.gain);
        Some(Self {
            function,
            model,
            estimate,
            log_evidence: gain - model.score(),
        })
    }
}

/// The unknown functions that the data can't tell from the best one, that one first.
pub fn unknown_rivals<'a>(problem: &'a Problem, selection: &'a Selection) -> Vec<&'a FittedModel> {
    let (fitted, is_any_adequate) = candidates(problem, selection);
    let best = fitted.first().map_or(f64::NAN, |c| c.log_evidence);
    let tied = fitted
        .into_iter()
        .filter(|c| is_any_adequate && best - c.log_evidence < TIE);
    tied.map(|c| c.model).collect()
}

/// The unknown functions that were fitted, best first, and whether any is adequate. As in the verdict: adequate ones share all,
/// and where none is, all share the little that is left beside something else.
fn candidates<'a>(problem: &'a Problem, selection: &'a Selection) -> (Vec<Candidate<'a>>, bool) {
    let all = selection.path.iter().chain(&selection.singles);
    let mut fitted: Vec<Candidate> = all
        .filter_map(|model| Candidate::new(problem, model))
        .collect();
    let is_any_adequate = fitted.iter().any(|c| c.model.reaches_floor());
    fitted.retain(|c| !is_any_adequate || c.model.reaches_floor());
    fitted.sort_by(|a, b| match is_any_adequate {
        true => b.log_evidence.total_cmp(&a.log_evidence),
        false => a.model.compare(b.model),
    });
    (fitted, is_any_adequate)
}

/// The formula that a selection ends with in place of a curve, as fitted.
fn formula(problem: &Problem, selection: &Selection) -> Option<Formula> {
    let model = selection.path.last()?;
    let choice = model.choices.last()?;
    let fitted = model.full_refit.as_ref().unwrap_or(&model.fitted);
    let is_formula = problem.formula_files.iter().any(|f| {
        toml::from_str::<File>(f).is_ok_and(|f| f.id == problem.catalogue[choice.effect].id)
    });
    let term = proposal(problem, choice, fitted, f64::NAN).filter(|_| is_formula)?;
    Some(Formula {
        target: term.target,
        expression: term.expression,
        parameters: term.parameters,
    })
}

/// Value and standard deviation at each node.
fn curve(of: &UnknownFunction, estimate: &CurveEstimate) -> Vec<[f64; 3]> {
    let std = |i: usize| estimate.covariance[(i, i)].max(0.0).sqrt();
    let nodes = of.at.iter().enumerate();
    nodes
        .map(|(i, at)| [*at, estimate.values[i], std(i)])
        .collect()
}

/// Effects of the library that were fitted, best first.
fn nearest(problem: &Problem, selection: &Selection) -> Vec<String> {
    let all = selection.path.iter().chain(&selection.singles);
    let mut of_library: Vec<(&FittedModel, &str)> = all
        .filter_map(|m| {
            let [choice] = &m.choices[..] else {
                return None;
            };
            let id = problem.catalogue[choice.effect].id.as_str();
            (is_library_effect(id) && !is_unknown_function(id)).then_some((m, id))
        })
        .collect();
    of_library.sort_by(|a, b| a.0.compare(b.0));
    of_library
        .iter()
        .take(NEAREST)
        .map(|(_, id)| (*id).to_owned())
        .collect()
}

/// The place in words.
pub fn place_in_words(place: &str) -> &'static str {
    match place {
        "friction" => "the coefficient of friction",
        "normal_force" => "the normal force",
        "tip_force" => "a force on the tip",
        "frequency" => "the natural frequencies",
        "damping" => "the damping",
        "measurement" => "the reading of the sensor",
        _ => "the velocity of the belt",
    }
}

/// The argument in words, without its memory.
pub fn argument_in_words(argument: &str) -> &'static str {
    match argument {
        "w" => "the tip displacement",
        "w_dot" => "the tip velocity",
        "v_r" | "low_passed_v_r" => "the sliding speed",
        "time" => "the time since the start of a run",
        "dwell" => "the time since stick began",
        "normal_force" => "the normal force",
        "low_passed_power" => "the friction power",
        _ => "the deflection",
    }
}

/// Where it acts, what it depends on and what shape the curve has, in words.
fn in_words(
    of: &UnknownFunction,
    shape: &str,
    memory: Option<&Estimate>,
    is_adequate: bool,
) -> String {
    let argument = argument_in_words(of.argument);
    let memory = memory.map_or(String::new(), |tau| {
        let bound = match tau.at_bound {
            true => ", which lies on its bound",
            false => "",
        };
        format!(
            " of earlier times (low-passed with {:.2e} s{bound})",
            tau.value
        )
    });
    let mode = of
        .mode
        .map_or(String::new(), |mode| format!(" (of mode {mode} alone)"));
    let place = place_in_words(of.place);
    if !is_adequate {
        return format!(
            "No unknown function of one quantity explains the data to the noise either; the one that comes nearest acts on {place}{mode} and depends on {argument}{memory}."
        );
    }
    match is_flat(shape) {
        false => format!(
            "Most likely it acts on {place}{mode} and depends on {argument}{memory}; the curve {shape}."
        ),
        // The best of those that explain nothing is no lead.
        true => format!(
            "No unknown function tells where it acts: the nearest of those fitted acts on {place}{mode} and depends on {argument}{memory}, and its curve {shape}."
        ),
    }
}

/// Which share of the samples of the runs fitted lies in each of [`INTERVALS`] equal intervals over the curve: from, to, share.
fn samples(
    problem: &Problem,
    argument: &str,
    memory_s: Option<f64>,
    curve: &[[f64; 3]],
) -> Vec<[f64; 3]> {
    let (low, high) = (curve[0][0], curve[curve.len() - 1][0]);
    let fitted = (0..problem.campaign.runs.len()).filter(|r| !problem.held_out[*r]);
    let values: Vec<f64> = fitted
        .filter_map(|r| Some(course(problem, r, argument, memory_s)?.argument))
        .flatten()
        .collect();
    let width = (high - low) / INTERVALS as f64;
    let mut counts = [0usize; INTERVALS];
    for v in &values {
        let at = (v - low) / width;
        if (0.0..=INTERVALS as f64).contains(&at) {
            counts[(at as usize).min(INTERVALS - 1)] += 1;
        }
    }
    let share = |(i, n): (usize, &usize)| {
        let from = low + width * i as f64;
        [from, from + width, *n as f64 / values.len().max(1) as f64]
    };
    counts.iter().enumerate().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::model::unknown_function::unknown_functions;
    use crate::measurement::Campaign;
    use std::path::Path;

    #[test]
    fn a_flat_curve_is_no_lead() {
        let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo");
        let campaign = Campaign::load(&demo).unwrap();
        let functions = unknown_functions(&campaign, 80.0, 0.1, &[(-1e-3, 1e-3)]);
        let of = |curve: [[f64; 3]; 3]| in_words(&functions[0], &shape(&curve, "1"), None, true);
        let flat = of([[0.0, 1e-4, 0.02], [1.0, 2e-4, 0.02], [2.0, 0.0, 0.02]]);
        assert!(
            flat.starts_with("No unknown function tells where"),
            "{flat}"
        );
        let steep = of([[0.0, 0.0, 0.02], [1.0, 0.2, 0.02], [2.0, 0.4, 0.02]]);
        assert!(steep.starts_with("Most likely it acts on the coefficient of friction"));
        assert!(steep.contains("the curve rises from"), "{steep}");
    }
}
