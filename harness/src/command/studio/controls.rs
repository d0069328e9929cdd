//! What the page offers to turn: switches and sliders, read off the FMU's cards and the priors of the campaign.

use serde::Serialize;

use super::model::{bounds, usual};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::parameter::{Parameter, Scale};
use crate::diagnose::model::problem::Problem;
use crate::error::Error;
use crate::fmu::effect_card::{EffectCard, EffectParameter, Role};

/// A number that can be turned.
#[derive(Debug, Serialize)]
pub struct Control {
    /// Name of the parameter.
    pub name: String,
    /// Unit symbol.
    pub unit: String,
    /// What it is.
    pub description: String,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// Value where none is given.
    pub usual: f64,
    /// Whether its logarithm is turned.
    pub log: bool,
    /// Whether each run has a value of its own.
    pub own: bool,
}

/// An effect that can be switched on.
#[derive(Debug, Serialize)]
pub struct Switch {
    /// Identifier.
    pub id: String,
    /// Title in a few words.
    pub title: String,
    /// The equation in plain text.
    pub equation: String,
    /// What happens physically.
    pub description: String,
    /// Whether it is a term of the library.
    pub library: bool,
    /// Settings: choices that no fit turns.
    pub settings: Vec<Control>,
    /// Sliders.
    pub parameters: Vec<Control>,
    /// Values along the belt that only a fit turns.
    pub nodes: usize,
}

/// Everything that can be turned.
#[derive(Debug, Serialize)]
pub struct Controls {
    /// Calibration parameters of the reference model.
    pub nuisances: Vec<Control>,
    /// Effects in the FMU's order.
    pub effects: Vec<Switch>,
}

/// The controls of a campaign.
///
/// # Errors
/// An FMU without the variables needed.
pub fn controls(problem: &Problem) -> Result<Controls, Error> {
    let plain = problem.hypothesis(&[])?;
    let shared = plain.shared.iter().map(|p| control(problem, p, false));
    let own = plain.per_run.first().into_iter().flatten();
    let own = own.map(|p| control(problem, p, true));
    let nuisances = shared.chain(own).collect();
    let effects = (0..problem.catalogue.len()).map(|effect| switch(problem, effect));
    Ok(Controls {
        nuisances,
        effects: effects.collect::<Result<_, Error>>()?,
    })
}

fn switch(problem: &Problem, effect: usize) -> Result<Switch, Error> {
    let card: &EffectCard = &problem.catalogue[effect];
    let choice = Choice::of(effect);
    let h = problem.hypothesis(&[choice])?;
    let prefix = format!("{}.", card.id);
    let is_own = |p: &&Parameter| p.name.starts_with(&prefix);
    let along_belt = |p: &&Parameter| p.support.is_some();
    let shared = h.shared.iter().filter(is_own);
    let own = || h.per_run.first().into_iter().flatten().filter(is_own);
    let nodes = own().filter(along_belt).count();
    let own_ones = own().filter(|p| p.support.is_none());
    Ok(Switch {
        id: card.id.clone(),
        title: card.title.clone(),
        equation: card.equation.clone(),
        description: card.description.clone(),
        library: is_library_effect(&card.id),
        settings: card
            .parameters
            .iter()
            .filter(|p| p.role == Role::Setting)
            .map(setting)
            .collect(),
        parameters: shared
            .map(|p| control(problem, p, false))
            .chain(own_ones.map(|p| control(problem, p, true)))
            .collect(),
        nodes,
    })
}

fn setting(p: &EffectParameter) -> Control {
    Control {
        name: p.name.clone(),
        unit: p.unit.clone(),
        description: p.description.clone(),
        min: p.min,
        max: p.max,
        usual: p.start,
        log: false,
        own: false,
    }
}

fn control(problem: &Problem, parameter: &Parameter, own: bool) -> Control {
    let (min, max) = bounds(parameter);
    let described = problem.catalogue.iter().find_map(|card| {
        let name = parameter.name.strip_prefix(&format!("{}.", card.id))?;
        card.parameters.iter().find(|p| p.name == name)
    });
    let of_fmu = problem.fmu.variable(&parameter.name).ok();
    let description = match (described, of_fmu) {
        (Some(p), _) => p.description.clone(),
        (None, Some(variable)) => variable.description.clone(),
        (None, None) => "factor on what campaign.toml states".to_owned(),
    };
    Control {
        name: parameter.name.clone(),
        unit: parameter.unit.clone(),
        description,
        min,
        max,
        usual: usual(&problem.catalogue, parameter),
        log: parameter.scale == Scale::Log,
        own,
    }
}
