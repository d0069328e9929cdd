//! Hypotheses beyond the catalogue that were fitted: where each acts, what it depends on, how probable it is.
//!
//! An effect of the library and an unknown function are hypotheses of one kind here: each acts on one target and depends on one
//! argument. Those of the same target and argument share what is said of it.

use super::curve_formula::function_of;
use crate::diagnose::estimation::curve_estimate::{CurveEstimate, curve_estimate};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::{File, is_library_effect};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::UnknownFunction;
use crate::diagnose::selection::decision::log_posterior;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::outcome::Selection;

/// Where physics acts and what it depends on, as `diagnosis.json` names both.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Acting {
    /// Where it acts.
    pub target: String,
    /// What it depends on.
    pub argument: String,
}

/// A hypothesis beyond the catalogue that was fitted.
pub(crate) struct Candidate<'a> {
    /// Where it acts and what it depends on.
    pub acting: Acting,
    /// The mode, from 1, where it acts on one alone.
    pub mode: Option<usize>,
    /// The fit.
    pub model: &'a FittedModel,
    /// The effect of the library that it is; `None` for an unknown function.
    pub effect: Option<&'a str>,
    /// The unknown function that it is, with its curve where the fit has a covariance.
    pub curve: Option<(&'a UnknownFunction, Option<CurveEstimate>)>,
    /// Logarithm of its posterior, of a curve with its smoothness fitted too, nats.
    pub log_posterior: f64,
}

impl<'a> Candidate<'a> {
    /// A fit with the logarithm of its posterior; `None` for one of the catalogue, or of several effects.
    fn new(problem: &'a Problem, model: &'a FittedModel, log_posterior: f64) -> Option<Self> {
        if let Some(function) = function_of(problem, model) {
            let estimate = curve_estimate(problem, function, &model.fitted);
            let price = estimate.as_ref().map_or(0.0, |e| e.price);
            return Some(Self {
                acting: Acting {
                    target: function.place.to_owned(),
                    argument: function.argument.to_owned(),
                },
                mode: function.mode,
                model,
                effect: None,
                curve: Some((function, estimate)),
                log_posterior: price + log_posterior,
            });
        }
        let id = effect_of_library(problem, model)?;
        let file = File::of_library(id)?;
        Some(Self {
            acting: Acting {
                target: file.place().to_owned(),
                argument: file.argument,
            },
            mode: file.mode,
            model,
            effect: Some(id),
            curve: None,
            log_posterior,
        })
    }
}

/// The effect of the library that a hypothesis consists of.
pub(crate) fn effect_of_library<'a>(
    problem: &'a Problem,
    model: &'a FittedModel,
) -> Option<&'a str> {
    let [choice] = &model.choices[..] else {
        return None;
    };
    let id = problem.catalogue[choice.effect].id.as_str();
    is_library_effect(id).then_some(id)
}

/// The first effect beyond the catalogue of several that explain the data together.
fn first_of_several<'a>(problem: &Problem, selection: &'a Selection) -> Option<&'a Choice> {
    let explains = selection.path.last().filter(|_| selection.explained);
    let choices = &explains?.choices;
    let is_beyond = |c: &&Choice| is_library_effect(&problem.catalogue[c.effect].id);
    choices.iter().find(is_beyond).filter(|_| choices.len() > 1)
}

/// Hypotheses beyond the catalogue that were fitted.
pub(crate) struct BeyondCatalogue<'a> {
    /// The hypotheses, best first.
    pub candidates: Vec<Candidate<'a>>,
    /// Whether any of them is adequate. Then these alone are held, and the first of several.
    pub is_any_adequate: bool,
    /// Whether several effects explain the data together, of which the first of these is one.
    pub is_of_several: bool,
}

impl<'a> BeyondCatalogue<'a> {
    /// Those of a selection.
    pub fn of(problem: &'a Problem, selection: &'a Selection) -> Self {
        // Only some were fitted to all segments: on those compared all are told by the same data.
        let all = selection.path.iter().chain(&selection.singles);
        let mut candidates: Vec<Candidate> = all
            .filter_map(|model| Candidate::new(problem, model, log_posterior(problem, model)))
            .collect();
        let is_any_adequate = candidates.iter().any(|c| c.model.reaches_floor());
        let first = first_of_several(problem, selection);
        let is_first = |c: &Candidate| first.is_some() && c.model.choices.first() == first;
        candidates.retain(|c| !is_any_adequate || c.model.reaches_floor() || is_first(c));
        // Once fits count with what nobody modelled as noise, evidence compares what is not down to the sensor's too.
        let has_evidence = is_any_adequate || selection.is_incomplete;
        candidates.sort_by(|a, b| match has_evidence {
            true => b.log_posterior.total_cmp(&a.log_posterior),
            false => a.model.compare(b.model),
        });
        let place = candidates.iter().position(is_first);
        if let Some(place) = place {
            candidates[..=place].rotate_right(1);
        }
        Self {
            candidates,
            is_any_adequate,
            is_of_several: place.is_some(),
        }
    }

    /// Odds of each place and argument against the best hypothesis, that of this hypothesis first.
    pub fn odds(&self) -> Vec<(&Acting, f64)> {
        let mut kinds: Vec<(&Acting, f64)> = Vec::new();
        let Some(best) = self.candidates.first() else {
            return kinds;
        };
        for candidate in &self.candidates {
            let odds = (candidate.log_posterior - best.log_posterior)
                .min(0.0)
                .exp();
            let known = kinds.iter_mut().find(|kind| *kind.0 == candidate.acting);
            match known {
                Some(kind) => kind.1 += odds,
                None => kinds.push((&candidate.acting, odds)),
            }
        }
        kinds
    }

    /// The unknown function that has the place and the argument of the best hypothesis; `None` where none of them counts.
    pub fn curve(&self) -> Option<(&Candidate<'a>, &'a UnknownFunction, &CurveEstimate)> {
        let acting = &self.candidates.first()?.acting;
        self.candidates.iter().find_map(|c| match &c.curve {
            Some((function, Some(estimate))) if c.acting == *acting => {
                Some((c, *function, estimate))
            }
            _ => None,
        })
    }
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
        "clamp" => "the acceleration of the clamp",
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
        "friction_force" => "the friction force",
        "slip_distance" => "the distance slid",
        "place" => "the place along the belt",
        "constant" => "nothing, a constant",
        _ => "the deflection",
    }
}

/// Unit of an argument.
pub(crate) fn argument_unit(argument: &str) -> &'static str {
    match argument {
        "w_dot" | "v_r" | "low_passed_v_r" => "m/s",
        "time" | "dwell" => "s",
        "normal_force" | "friction_force" => "N",
        "low_passed_power" => "W",
        "constant" => "1",
        _ => "m",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::model::library::FILES;
    use std::collections::BTreeSet;

    #[test]
    fn every_effect_of_the_library_says_where_it_acts_and_on_what_it_depends() {
        let places = [
            "friction",
            "normal_force",
            "tip_force",
            "frequency",
            "damping",
            "measurement",
            "belt",
            "clamp",
        ];
        let mut said = BTreeSet::new();
        for text in FILES {
            let file: File = toml::from_str(text).unwrap();
            assert!(
                places.contains(&file.place()),
                "{}: {}",
                file.id,
                file.place()
            );
            let known = argument_in_words(&file.argument) != "the deflection";
            assert!(
                known || file.argument == "low_passed_w",
                "{}: {}",
                file.id,
                file.argument
            );
            said.insert((file.place(), file.argument));
        }
        assert!(said.len() > 10, "{said:?}");
    }
}
