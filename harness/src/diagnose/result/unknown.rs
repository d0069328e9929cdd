//! What is said of physics that nobody wrote a term for: where it acts, what it depends on, and the curve.

use super::hysteresis::{Loop, hysteresis};
use super::shape::{is_flat, shape};
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::explanation::argument::course;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{
    NODES, UnknownFunction, is_unknown_function, latent_name, weight,
};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::select::Selection;
use crate::diagnose::thresholds::TIE;
use crate::diagnose::validation::estimate::estimate;
use serde::Serialize;

/// Effects of the library that are listed.
const NEAREST: usize = 3;
/// Intervals of the histogram over a curve.
const INTERVALS: usize = 28;

/// An unknown function as fitted, in `diagnosis.json` as `unknown`.
#[derive(Debug, Clone, Serialize)]
pub struct Unknown {
    /// Where it acts: `friction`, `normal_force`, `tip_force`, `frequency`, `damping`, `measurement` or `belt`.
    pub target: String,
    /// What it depends on.
    pub argument: String,
    /// Unit of the argument.
    pub argument_unit: String,
    /// Time constant in s with which the argument is low-passed; `None` without a memory.
    pub memory_s: Option<f64>,
    /// Argument, value and standard deviation of the value at the nodes.
    pub curve: Vec<[f64; 3]>,
    /// Probability among the unknown functions that were fitted.
    pub probability: f64,
    /// Others that the data can't tell from it.
    pub alternatives: Vec<Alternative>,
    /// Effects of the library that come nearest, best first.
    pub nearest_library_effects: Vec<String>,
    /// Unit of the value.
    pub value_unit: String,
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
    let all = selection.path.iter().chain(&selection.singles);
    let mut fitted: Vec<(&UnknownFunction, &FittedModel)> = all
        .filter_map(|model| Some((function(problem, model)?, model)))
        .collect();
    // As a search ranks them: what is adequate first, by its evidence.
    fitted.sort_by(|a, b| a.1.compare(b.1));
    let &(best, model) = fitted.first()?;
    let odds = |m: &FittedModel| (model.score() - m.score()).min(0.0).exp();
    let total: f64 = fitted.iter().map(|(_, m)| odds(m)).sum();
    let alternatives = fitted[1..]
        .iter()
        .filter(|(_, m)| m.score() - model.score() < TIE)
        .map(|(f, m)| Alternative {
            target: f.place.to_owned(),
            argument: f.argument.to_owned(),
            probability: odds(m) / total,
        })
        .collect();
    let curve = curve(problem, best, &model.fitted);
    let memory_s = best.remembers.then(|| {
        let h = &model.fitted.hypothesis;
        let i = h.shared_index(&format!("{}.tau", best.id));
        i.map_or(f64::NAN, |i| estimate(h, &model.fitted.fit, i).value)
    });
    let values: Vec<f64> = curve.iter().map(|c| c[1]).collect();
    let value_unit = match best.place {
        "tip_force" => "N",
        "measurement" => "m",
        _ => "1",
    };
    let shape = shape(&curve, value_unit);
    let hysteresis = memory_s.filter(|tau| *tau > 0.0).and_then(|tau| {
        let units = (value_unit, best.argument_unit);
        hysteresis(problem, best.argument, tau, &curve, units)
    });
    let mut words = in_words(best, &shape, memory_s);
    if let Some(found) = &hysteresis {
        let names = (place_in_words(best.place), argument_in_words(best.argument));
        words = format!("{words} {}", found.words(names.0, names.1));
    }
    Some(Unknown {
        target: best.place.to_owned(),
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
        file: best.file_with("unknown", &values, memory_s),
    })
}

fn function<'a>(problem: &'a Problem, model: &FittedModel) -> Option<&'a UnknownFunction> {
    let [choice] = &model.choices[..] else {
        return None;
    };
    let id = &problem.catalogue[choice.effect].id;
    problem.unknown_functions.iter().find(|f| f.id == *id)
}

/// Value and standard deviation at each node.
fn curve(problem: &Problem, of: &UnknownFunction, fitted: &FittedHypothesis) -> Vec<[f64; 3]> {
    let h = &fitted.hypothesis;
    let card = problem.catalogue.iter().find(|c| c.id == of.id);
    let strength = card.map_or(f64::NAN, |c| c.parameters[0].typical);
    let places: Vec<Option<usize>> = (0..NODES)
        .map(|k| h.shared_index(&latent_name(&of.id, k)))
        .collect();
    let covariance = fitted.fit.covariance.as_ref();
    let node = |(i, at): (usize, &f64)| {
        let known = || {
            places
                .iter()
                .enumerate()
                .filter_map(|(k, p)| Some((weight(k, i), (*p)?)))
        };
        let value: f64 = known().map(|(w, p)| w * fitted.fit.point.shared[p]).sum();
        let variance: f64 = known()
            .flat_map(|a| known().map(move |b| (a, b)))
            .map(|((u, p), (v, q))| covariance.map_or(f64::NAN, |c| u * v * c[(p, q)]))
            .sum();
        [*at, strength * value, strength * variance.max(0.0).sqrt()]
    };
    of.at.iter().enumerate().map(node).collect()
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
        "low_passed_power" => "the friction power",
        _ => "the deflection",
    }
}

/// Where it acts, what it depends on and what shape the curve has, in words.
fn in_words(of: &UnknownFunction, shape: &str, memory_s: Option<f64>) -> String {
    let argument = argument_in_words(of.argument);
    let memory = memory_s.map_or(String::new(), |tau| {
        format!(" of earlier times (low-passed with {tau:.2e} s)")
    });
    let place = place_in_words(of.place);
    match is_flat(shape) {
        false => format!(
            "Most likely it acts on {place} and depends on {argument}{memory}; the curve {shape}."
        ),
        // The best of those that explain nothing is no lead.
        true => format!(
            "No unknown function tells where it acts: the nearest of those fitted acts on {place} and depends on {argument}{memory}, and its curve {shape}."
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
        let functions = unknown_functions(&campaign, 80.0);
        let of = |curve: [[f64; 3]; 3]| in_words(&functions[0], &shape(&curve, "1"), None);
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
