//! What is said of physics that nobody wrote a term for: where it acts, what it depends on, and the curve.

use crate::diagnose::explanation::curve_estimate::{CurveEstimate, curve_estimate};
use crate::diagnose::explanation::library_term::proposal;
use crate::diagnose::model::library::{File, is_library_effect};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{UnknownFunction, is_unknown_function};
use crate::diagnose::result::curve_formula::function_of;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::select::Selection;
use crate::diagnose::thresholds::TIE;
use crate::diagnose::validation::estimate::{Estimate, estimate};
use serde::Serialize;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Effects of the library that are listed.
const NEAREST: usize = 3;

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
    /// A short formula that took the curve's place; `None` where none explains as much.
    pub formula: Option<Formula>,
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
    let all = selection.path.iter().chain(&selection.singles);
    let mut fitted: Vec<Candidate> = all
        .filter_map(|model| Candidate::new(problem, model))
        .collect();
    // What is adequate first, by its evidence.
    fitted.sort_by(|a, b| {
        let order = |c: &Candidate| (!c.model.reaches_floor(), -c.log_evidence);
        order(a).partial_cmp(&order(b)).unwrap_or(Ordering::Equal)
    });
    let first = fitted.first()?;
    let (best, model) = (first.function, first.model);
    let odds = |c: &Candidate| (c.log_evidence - first.log_evidence).min(0.0).exp();
    let total: f64 = fitted.iter().map(odds).sum();
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
    let memory_s = best.remembers.then(|| {
        let h = &model.fitted.hypothesis;
        let i = h.shared_index(&format!("{}.tau", best.id));
        i.map_or(f64::NAN, |i| estimate(h, &model.fitted.fit, i).value)
    });
    let values: Vec<f64> = curve.iter().map(|c| c[1]).collect();
    Some(Unknown {
        target: best.place.to_owned(),
        argument: best.argument.to_owned(),
        argument_unit: best.argument_unit.to_owned(),
        memory_s,
        words: in_words(best, &curve, memory_s),
        curve,
        probability: 1.0 / total,
        alternatives,
        nearest_library_effects: nearest(problem, selection),
        value_unit: best.value_unit().to_owned(),
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
    let all = selection.path.iter().chain(&selection.singles);
    let fitted = all.filter_map(|model| Candidate::new(problem, model));
    let mut adequate: Vec<Candidate> = fitted.filter(|c| c.model.reaches_floor()).collect();
    adequate.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    let Some(best) = adequate.first().map(|c| c.log_evidence) else {
        return Vec::new();
    };
    adequate.retain(|c| best - c.log_evidence < TIE);
    adequate.into_iter().map(|c| c.model).collect()
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

/// Where it acts, what it depends on and what shape the curve has, in words.
fn in_words(of: &UnknownFunction, curve: &[[f64; 3]], memory_s: Option<f64>) -> String {
    let place = match of.place {
        "friction" => "the coefficient of friction",
        "normal_force" => "the normal force",
        "tip_force" => "a force on the tip",
        "frequency" => "the natural frequencies",
        "damping" => "the damping",
        "measurement" => "the reading of the sensor",
        _ => "the velocity of the belt",
    };
    let argument = match of.argument {
        "w" => "the tip displacement",
        "w_dot" => "the tip velocity",
        "v_r" => "the sliding speed",
        "time" => "the time since the start of a run",
        "dwell" => "the time since stick began",
        "low_passed_v_r" => "the sliding speed of earlier times",
        "low_passed_power" => "the friction power of earlier times",
        _ => "the deflection of earlier times",
    };
    let memory = memory_s.map_or(String::new(), |tau| {
        format!(" (low-passed with {tau:.2e} s)")
    });
    format!(
        "Most likely it acts on {place} and depends on {argument}{memory}; the curve {}.",
        shape(curve)
    )
}

/// What shape a curve has, as far as it is known: nodes of which the value is uncertain by more than the curve's range don't count.
fn shape(curve: &[[f64; 3]]) -> String {
    let range = |list: &[&[f64; 3]]| {
        let values = || list.iter().map(|c| c[1]);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let all: Vec<&[f64; 3]> = curve.iter().collect();
    let span = range(&all);
    let known: Vec<&[f64; 3]> = curve.iter().filter(|c| c[2] < 0.5 * span).collect();
    if known.len() < 3 {
        return "is not determined well enough to name a shape".to_owned();
    }
    let steps: Vec<f64> = known.windows(2).map(|p| p[1][1] - p[0][1]).collect();
    let spread = |p: &[&[f64; 3]]| p[0][2].hypot(p[1][2]);
    let rises = |sign: f64| {
        let pairs = known.windows(2).zip(&steps);
        pairs.clone().all(|(p, s)| sign * s > -2.0 * spread(p))
    };
    let (first, last) = (steps[0].abs(), steps[steps.len() - 1].abs());
    let bend = if first < 0.25 * last {
        ", slowly at first"
    } else if last < 0.25 * first {
        ", and saturates"
    } else {
        ""
    };
    let (from, to) = (known[0][1], known[known.len() - 1][1]);
    match (rises(1.0), rises(-1.0)) {
        (true, true) => format!("is flat within its uncertainty, about {from:.2e}"),
        (true, false) => format!("rises from {from:.2e} to {to:.2e}{bend}"),
        (false, true) => format!("falls from {from:.2e} to {to:.2e}{bend}"),
        (false, false) => {
            let low = known.iter().min_by(|a, b| a[1].total_cmp(&b[1]));
            let high = known.iter().max_by(|a, b| a[1].total_cmp(&b[1]));
            let (low, high) = (low.expect("three"), high.expect("three"));
            format!(
                "has its least value {:.2e} at {:.2e} and its largest {:.2e} at {:.2e}",
                low[1], low[0], high[1], high[0]
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_are_named_by_what_is_certain() {
        let of = |f: &dyn Fn(f64) -> f64, std: f64| {
            let node = |i: i32| [f64::from(i), f(f64::from(i)), std];
            shape(&(0..8).map(node).collect::<Vec<_>>())
        };
        assert!(of(&|x| x, 0.01).starts_with("rises from 0.00e0 to 7.00e0"));
        assert!(of(&|x| -x * x, 0.01).contains("falls from"));
        assert!(of(&|x| -x * x, 0.01).contains("slowly at first"));
        assert!(of(&|x| 1.0 - (-x).exp(), 1e-3).contains("saturates"));
        assert!(of(&|x| (x - 3.0).powi(2), 0.01).contains("least value 0.00e0 at 3.00e0"));
        assert!(of(&|x| x, 10.0).contains("not determined"));
    }
}
