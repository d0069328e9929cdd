//! The ways in which an effect of the model can be chosen.

use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::is_unknown_function;
use crate::fmu::effect_card::{EffectCard, Role};

/// Ways to choose an effect: one for each value of its settings that are switches.
pub fn variants(problem: &Problem, effect: usize) -> Vec<Choice> {
    let card = &problem.catalogue[effect];
    let is_profile = card.parameters.iter().any(|p| p.role == Role::Node);
    let switch = card
        .parameters
        .iter()
        .position(|p| p.role == Role::Setting && p.min == 0.0 && p.max == 1.0);
    match switch {
        Some(index) if !is_profile => (0..2)
            .map(|v| Choice {
                settings: vec![(index, f64::from(v))],
                ..Choice::of(effect)
            })
            .collect(),
        _ => vec![Choice::of(effect)],
    }
}

/// All ways to choose one effect of the catalogue.
pub fn all_variants(problem: &Problem) -> Vec<Choice> {
    variants_of(problem, |effect| !is_library_effect(&effect.id))
}

/// All ways to choose one of the effects `wanted` that can act in the campaign.
pub fn variants_of(problem: &Problem, wanted: impl Fn(&EffectCard) -> bool) -> Vec<Choice> {
    (0..problem.catalogue.len())
        .filter(|&effect| problem.acts[effect] && wanted(&problem.catalogue[effect]))
        .flat_map(|effect| variants(problem, effect))
        .collect()
}

/// All effects of the library, where the problem's FMU has them.
pub fn library(problem: &Problem) -> Vec<Choice> {
    variants_of(problem, |effect| {
        is_library_effect(&effect.id) && !is_unknown_function(&effect.id)
    })
}

/// All unknown functions, likewise.
pub fn unknown(problem: &Problem) -> Vec<Choice> {
    variants_of(problem, |effect| is_unknown_function(&effect.id))
}
