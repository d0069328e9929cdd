//! What is said of physics that nobody wrote a term for: where it acts, what it depends on, and the curve.

use super::beyond_catalogue::{
    Acting, BeyondCatalogue, Candidate, argument_in_words, argument_unit, effect_of_library,
    place_in_words,
};
use super::hysteresis::{Loop, hysteresis};
use super::shape::{Nodes, is_flat};
use crate::diagnose::estimation::curve_estimate::CurveEstimate;
use crate::diagnose::explanation::argument::course;
use crate::diagnose::explanation::library_term::proposal;
use crate::diagnose::model::library::File;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{UnknownFunction, is_unknown_function, value_unit};
use crate::diagnose::selection::decision::log_posterior;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::thresholds::{SEARCHED, TIE};
use crate::diagnose::validation::estimate::{Estimate, estimate};
use crate::metric::half_width;
use serde::Serialize;
use std::collections::BTreeMap;

/// Effects of the library that are listed.
const NEAREST: usize = 3;
/// What is said of a factor on friction, ...
const OR_LOAD: &str = "The same factor on the normal force would move the tip in the same way";
/// ... and of a force that adds to the normal force.
const OR_FRICTION: &str =
    "A factor on friction that counts less at a higher load would move the tip in the same way";
/// What separates the two.
const WHICH: &str = "a load cell under the holder, read beside the displacement, separates them.";
/// Intervals of the histogram over a curve.
const INTERVALS: usize = 28;

/// Physics beyond the catalogue as fitted, in `diagnosis.json` as `unknown`.
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
    /// The effect of the library that explains the data best; `None` where an unknown function does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub library_effect: Option<String>,
    /// Time constant in s with which the argument is low-passed; `None` without a memory.
    pub memory_s: Option<f64>,
    /// Argument, value and standard deviation of the value at the nodes; empty where no unknown function was fitted in that place.
    pub curve: Vec<[f64; 3]>,
    /// Probability among the hypotheses beyond the catalogue that were fitted; small where none of them explains the data.
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
    pub file: Option<String>,
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

/// Another place and argument.
#[derive(Debug, Clone, Serialize)]
pub struct Alternative {
    /// Where it acts.
    pub target: String,
    /// What it depends on.
    pub argument: String,
    /// Probability among the hypotheses beyond the catalogue that were fitted.
    pub probability: f64,
    /// Whether it moves the tip exactly as the first one does, so that its probability is that of the first: one hypothesis read in two
    /// ways.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub is_same_motion: bool,
}

/// What a selection tells of physics beyond the catalogue; `None` where no hypothesis beyond it was fitted.
/// Where only several effects together explain the data, it is of the first of them, and its probability is that of the verdict.
pub fn unknown(problem: &Problem, selection: &Selection, probability: f64) -> Option<Unknown> {
    let beyond = BeyondCatalogue::of(problem, selection);
    let first = beyond.candidates.first()?;
    let odds = beyond.odds();
    let is_one_of_several = beyond.is_of_several;
    let known = if beyond.is_any_adequate {
        1.0
    } else {
        1.0 - SEARCHED
    };
    let total = odds.iter().map(|(_, odds)| odds).sum::<f64>() / known;
    let of_first = odds[0].1;
    let same = same_motion(problem, &first.acting).map(|acting| (acting, true, of_first));
    let tied = odds[1..].iter();
    let tied = tied.filter(|(_, odds)| (of_first / odds).ln() < TIE);
    let tied = tied.map(|(acting, odds)| ((*acting).clone(), false, *odds));
    let mut alternatives: Vec<Alternative> = Vec::new();
    for (acting, is_same_motion, odds) in same.iter().cloned().chain(tied) {
        let is_known = |a: &Alternative| a.target == acting.target && a.argument == acting.argument;
        if !is_one_of_several && !alternatives.iter().any(is_known) {
            alternatives.push(Alternative {
                target: acting.target,
                argument: acting.argument,
                probability: odds / total,
                is_same_motion,
            });
        }
    }
    // Beside other effects a curve fitted alone shows what these do too.
    let curve = beyond
        .curve()
        .filter(|_| !is_one_of_several || first.effect.is_none());
    let shown = curve.map(|(c, of, e)| Shown::new(problem, c, of, e));
    let shown = shown.unwrap_or_default();
    let memory = memory(problem, first);
    Some(Unknown {
        target: first.acting.target.clone(),
        mode: first.mode,
        argument: first.acting.argument.clone(),
        argument_unit: argument_unit(&first.acting.argument).to_owned(),
        library_effect: first.effect.map(str::to_owned),
        words: in_words(&Said {
            acting: &first.acting,
            mode: first.mode,
            effect: first.effect,
            memory: memory.as_ref(),
            shown: &shown,
            is_adequate: beyond.is_any_adequate || is_one_of_several,
            is_one_of_several,
            has_same_motion: same.is_some(),
        }),
        memory_s: memory.map(|m| m.value),
        shape: shown.shape,
        hysteresis: shown.hysteresis,
        samples: shown.samples,
        curve: shown.curve,
        probability: match is_one_of_several {
            true => probability,
            false => of_first / total,
        },
        alternatives,
        nearest_library_effects: nearest(problem, selection),
        value_unit: value_unit(&first.acting.target).to_owned(),
        formula: formula(problem, selection),
        file: shown.file,
    })
}

/// What moves the tip exactly as this does: the contact force is the product of coefficient of friction and normal force, so that a factor
/// on one is a factor on the other, and a force that adds to the normal force a factor on friction that counts less at a higher load.
/// `None` for other places, and where the normal force was measured all along.
fn same_motion(problem: &Problem, acting: &Acting) -> Option<Acting> {
    let target = match acting.target.as_str() {
        "friction" => "normal_force",
        "normal_force" => "friction",
        _ => return None,
    };
    let mut runs = problem.campaign.runs.iter();
    let is_measured = runs.all(|run| run.inputs.normal_force.is_some());
    (!is_measured).then(|| Acting {
        target: target.to_owned(),
        argument: acting.argument.clone(),
    })
}

/// What the curve of an unknown function shows; nothing where none was fitted.
#[derive(Default)]
struct Shown {
    curve: Vec<[f64; 3]>,
    shape: String,
    /// How far a factor on friction lies higher in forward than in backward motion of the tip, with the standard deviation, where that
    /// is certain.
    direction: Option<(f64, f64)>,
    hysteresis: Option<Loop>,
    samples: Vec<[f64; 3]>,
    file: Option<String>,
}

impl Shown {
    fn new(
        problem: &Problem,
        candidate: &Candidate,
        of: &UnknownFunction,
        estimate: &CurveEstimate,
    ) -> Self {
        let curve = curve(of, estimate);
        let memory_s = memory(problem, candidate).map(|m| m.value);
        let values: Vec<f64> = curve.iter().map(|c| c[1]).collect();
        let nodes = Nodes {
            at: &of.at,
            values: &estimate.values,
            covariance: &estimate.covariance,
        };
        let hysteresis = memory_s.filter(|tau| *tau > 0.0).and_then(|tau| {
            let units = (of.value_unit(), of.argument_unit);
            hysteresis(problem, of.argument, tau, &curve, units)
        });
        Self {
            shape: nodes.shape(of.value_unit()),
            direction: match (of.place, of.argument) {
                ("friction" | "normal_force", "w_dot") => nodes.difference_of_sides(),
                _ => None,
            },
            hysteresis,
            samples: samples(problem, of.argument, memory_s, &curve),
            curve,
            file: Some(of.file_with("unknown", &values, memory_s)),
        }
    }
}

/// Time constant in s with which the argument of a hypothesis is low-passed; `None` without a memory of that kind.
fn memory(problem: &Problem, of: &Candidate) -> Option<Estimate> {
    let choice = of.model.choices.first()?;
    // A curve is that of the segments compared.
    let on_all = of.model.full_refit.as_ref().filter(|_| of.effect.is_some());
    let fitted = on_all.unwrap_or(&of.model.fitted);
    let name = format!("{}.tau", problem.catalogue[choice.effect].id);
    let i = fitted.hypothesis.shared_index(&name)?;
    let remembers = of.acting.argument.starts_with("low_passed_");
    remembers.then(|| estimate(&fitted.hypothesis, &fitted.fit, i))
}

/// Hypotheses beyond the catalogue that the data can't tell from the best one, that one first; of each place and argument the best.
pub fn unknown_rivals<'a>(problem: &'a Problem, selection: &'a Selection) -> Vec<&'a FittedModel> {
    let beyond = BeyondCatalogue::of(problem, selection);
    if !beyond.is_any_adequate {
        return Vec::new();
    }
    let best = beyond
        .candidates
        .first()
        .map_or(f64::NAN, |c| c.log_posterior);
    let mut tied: Vec<&Candidate> = Vec::new();
    for candidate in &beyond.candidates {
        let is_tied = best - candidate.log_posterior < TIE;
        if is_tied && tied.iter().all(|t| t.acting != candidate.acting) {
            tied.push(candidate);
        }
    }
    tied.into_iter().map(|c| c.model).collect()
}

/// The formula that a selection ends with in place of a curve, as fitted.
fn formula(problem: &Problem, selection: &Selection) -> Option<Formula> {
    let model = selection.path.last()?;
    let choice = model.choices.last()?;
    let fitted = model.full_refit.as_ref().unwrap_or(&model.fitted);
    let formulas = problem.formula_files.iter().map(String::as_str);
    File::among(formulas, &problem.catalogue[choice.effect].id)?;
    let term = proposal(problem, choice, fitted, f64::NAN)?;
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
        .filter_map(|m| Some((m, effect_of_library(problem, m)?)))
        .filter(|(_, id)| !is_unknown_function(id))
        .collect();
    // Evidence compares what is not down to the noise once that is what nobody modelled.
    of_library.sort_by(|a, b| match selection.is_incomplete {
        true => log_posterior(problem, b.0).total_cmp(&log_posterior(problem, a.0)),
        false => a.0.compare(b.0),
    });
    of_library
        .iter()
        .take(NEAREST)
        .map(|(_, id)| (*id).to_owned())
        .collect()
}

/// What is said of the best hypothesis beyond the catalogue.
struct Said<'a> {
    acting: &'a Acting,
    mode: Option<usize>,
    effect: Option<&'a str>,
    memory: Option<&'a Estimate>,
    shown: &'a Shown,
    is_adequate: bool,
    is_one_of_several: bool,
    has_same_motion: bool,
}

/// Where the best hypothesis acts, what it depends on and what shape its curve has, in words.
fn in_words(said: &Said) -> String {
    let argument = argument_in_words(&said.acting.argument);
    let place = place_in_words(&said.acting.target);
    let memory = said.memory.map_or(String::new(), |tau| {
        let bound = match tau.at_bound {
            true => ", which lies on its bound",
            false => "",
        };
        format!(
            " of earlier times (low-passed with {:.2e} s{bound})",
            tau.value
        )
    });
    let mode = said
        .mode
        .map_or(String::new(), |mode| format!(" (of mode {mode} alone)"));
    let acts = format!("acts on {place}{mode} and depends on {argument}{memory}");
    let shape = &said.shown.shape;
    let direction = said.shown.direction.map_or(String::new(), in_direction);
    let same = match (said.has_same_motion, said.acting.target.as_str()) {
        (false, _) => String::new(),
        (true, "friction") => format!(" {OR_LOAD}: {WHICH}"),
        (true, _) => format!(" {OR_FRICTION}: {WHICH}"),
    };
    let by = said
        .effect
        .map_or(String::new(), |id| format!(", as {id} does"));
    if !said.is_adequate {
        let shape = match shape.as_str() {
            "" => String::new(),
            flat if is_flat(flat) => String::new(),
            shape => format!("; its curve {shape}"),
        };
        return format!(
            "Nothing that was tried beyond the catalogue explains the data to the noise either; what comes nearest {acts}{by}{shape}.{direction}{same}"
        );
    }
    if said.effect.is_none() && is_flat(shape) {
        // The best of those that explain nothing is no lead.
        return format!(
            "No unknown function shows where it acts: the nearest of those fitted {acts}, and its curve {shape}."
        );
    }
    let shape = match shape.as_str() {
        "" => String::new(),
        shape => format!("; the curve {shape}"),
    };
    let looped = said
        .shown
        .hysteresis
        .as_ref()
        .map_or(String::new(), |found| {
            format!(" {}", found.words(place, argument))
        });
    match said.is_one_of_several {
        true => format!(
            "Of these, {} {acts}{shape}.{direction}{looped}",
            said.effect.unwrap_or("the curve")
        ),
        false => format!("Most likely it {acts}{by}{shape}.{direction}{looped}{same}"),
    }
}

/// That a factor on friction depends on the direction of motion, from how far it lies higher in forward motion.
fn in_direction((difference, std): (f64, f64)) -> String {
    let less = if difference > 0.0 { "more" } else { "less" };
    format!(
        " It depends on the direction: in forward motion the factor is {less} by {:.3} +- {:.3} (95 %) on average than in backward motion.",
        difference.abs(),
        half_width(std)
    )
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
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn a_flat_curve_is_no_lead() {
        let acting = Acting {
            target: "friction".to_owned(),
            argument: "time".to_owned(),
        };
        let of = |curve: [[f64; 3]; 3], effect: Option<&str>| {
            let nodes = Nodes {
                at: &curve.map(|c| c[0]),
                values: &DVector::from_row_slice(&curve.map(|c| c[1])),
                covariance: &DMatrix::from_diagonal(&DVector::from_row_slice(
                    &curve.map(|c| c[2] * c[2]),
                )),
            };
            let shown = Shown {
                shape: nodes.shape("1"),
                direction: nodes.difference_of_sides(),
                ..Shown::default()
            };
            in_words(&Said {
                acting: &acting,
                mode: None,
                effect,
                memory: None,
                shown: &shown,
                is_adequate: true,
                is_one_of_several: false,
                has_same_motion: true,
            })
        };
        let flat = [[0.0, 1e-4, 0.02], [1.0, 2e-4, 0.02], [2.0, 0.0, 0.02]];
        let words = of(flat, None);
        assert!(
            words.starts_with("No unknown function shows where"),
            "{words}"
        );
        // What has a formula acts where it acts.
        let words = of(flat, Some("term_wear"));
        assert!(words.starts_with("Most likely"), "{words}");
        let words = of([[0.0, 0.0, 0.02], [1.0, 0.2, 0.02], [2.0, 0.4, 0.02]], None);
        assert!(words.starts_with("Most likely it acts on the coefficient of friction"));
        assert!(words.contains("the curve rises from"), "{words}");
        assert!(words.contains("load cell under the holder"), "{words}");
        assert!(!words.contains("direction"), "{words}");
        let words = of(
            [[-1.0, 0.3, 0.02], [0.1, 0.2, 0.02], [1.0, 0.1, 0.02]],
            None,
        );
        let direction = "in forward motion the factor is less by 0.150 +- 0.048 (95 %) on average";
        assert!(words.contains(direction), "{words}");
    }
}
