//! A model as the page turns it: effects that are on, and values by name.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::diagnose::estimation::nesting::widen_state;
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::error::Error;
use crate::fmu::effect_card::{EffectCard, Role};

/// Values by parameter name, in the parameter's unit.
pub type Values = BTreeMap<String, f64>;

/// A model: the reference model with effects on and values given; what is not named stands where it is believed to be.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Draft {
    /// Effects that are on, by identifier, each with the values of its settings.
    pub effects: BTreeMap<String, Values>,
    /// Values common to all runs.
    pub shared: Values,
    /// Values of each run on its own, by the run's name.
    pub own: BTreeMap<String, Values>,
}

/// Where every segment starts: modal states in m and m/s with those of effects behind them, and whether it starts in stick.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Starts {
    /// States of each segment.
    pub states: Vec<Vec<f64>>,
    /// Whether it starts in stick.
    pub stuck: Vec<bool>,
}

/// The hypothesis that a draft stands for.
///
/// # Errors
/// An effect that the FMU does not have.
pub fn hypothesis(problem: &Problem, draft: &Draft) -> Result<Hypothesis, Error> {
    problem.hypothesis(&choices(problem, draft)?)
}

fn choices(problem: &Problem, draft: &Draft) -> Result<Vec<Choice>, Error> {
    let of = |(id, values): (&String, &Values)| {
        let effect = super::super::effects::find(&problem.catalogue, id, problem.fmu.path())?;
        let card = &problem.catalogue[effect];
        let setting = |(name, value): (&String, &f64)| {
            let index = card.parameters.iter().position(|p| p.name == *name);
            let index = index.filter(|i| card.parameters[*i].role == Role::Setting);
            let index = index.ok_or_else(|| unknown(problem, &format!("{id}.{name}")))?;
            let p = &card.parameters[index];
            within(&format!("{id}.{name}"), *value, (p.min, p.max), &p.unit)?;
            Ok((index, *value))
        };
        let settings: Result<Vec<(usize, f64)>, Error> = values.iter().map(setting).collect();
        Ok(Choice {
            settings: settings?,
            ..Choice::of(effect)
        })
    };
    let found: Result<Vec<Choice>, Error> = draft.effects.iter().map(of).collect();
    let mut found = found?;
    found.sort_by_key(|choice| choice.effect);
    Ok(found)
}

fn unknown(problem: &Problem, name: &str) -> Error {
    Error::UnknownVariable {
        path: problem.fmu.path().to_owned(),
        name: name.to_owned(),
        nearest: Vec::new(),
    }
}

/// Refuses a value outside its bounds.
fn within(name: &str, value: f64, (min, max): (f64, f64), unit: &str) -> Result<(), Error> {
    let slack = 1e-9 * (max - min).abs();
    if value >= min - slack && value <= max + slack {
        return Ok(());
    }
    Err(Error::StudioValue {
        name: name.to_owned(),
        value,
        min,
        max,
        unit: unit.to_owned(),
    })
}

/// Bounds of a parameter's value on the page; a phase goes once round.
pub fn bounds(parameter: &Parameter) -> (f64, f64) {
    if parameter.is_phase() {
        (-std::f64::consts::PI, std::f64::consts::PI)
    } else {
        (parameter.min, parameter.max)
    }
}

/// Value of a parameter that is not given: an effect that is switched on acts as it does in practice.
pub fn usual(catalogue: &[EffectCard], parameter: &Parameter) -> f64 {
    let of_card = parameter.name.split_once('.').and_then(|(id, name)| {
        let card = catalogue.iter().find(|card| card.id == id)?;
        card.parameters.iter().find(|p| p.name == name)
    });
    let (min, max) = bounds(parameter);
    match of_card {
        Some(p) if matches!(p.role, Role::Amplitude | Role::Shape) => p.typical.clamp(min, max),
        _ => parameter.prior,
    }
}

/// The point of a hypothesis at the draft's values, its segments starting where `from` starts them.
///
/// # Errors
/// A value outside its bounds.
pub fn point(
    problem: &Problem,
    h: &Hypothesis,
    draft: &Draft,
    from: Option<(&Hypothesis, &Starts)>,
) -> Result<Point, Error> {
    let mut point = Point::centre(h, &problem.segments);
    let position = |parameter: &Parameter, given: Option<&f64>| -> Result<f64, Error> {
        let value = match given {
            Some(value) => {
                within(&parameter.name, *value, bounds(parameter), &parameter.unit)?;
                *value
            }
            None => usual(&problem.catalogue, parameter),
        };
        Ok(parameter.clamp(parameter.position(value)))
    };
    for (parameter, place) in h.shared.iter().zip(&mut point.shared) {
        *place = position(parameter, draft.shared.get(&parameter.name))?;
    }
    let runs = problem.campaign.runs.iter();
    for ((run, parameters), places) in runs.zip(&h.per_run).zip(&mut point.per_run) {
        let given = draft.own.get(&run.name);
        for (parameter, place) in parameters.iter().zip(places) {
            let value = given.and_then(|values| values.get(&name_of(parameter)));
            *place = position(parameter, value)?;
        }
    }
    if let Some((smaller, starts)) = from
        && starts.states.len() == point.states.len()
    {
        for (state, known) in point.states.iter_mut().zip(&starts.states) {
            widen_state(smaller, known, h, state);
        }
        point.stuck.clone_from(&starts.stuck);
    }
    Ok(point)
}

/// Name of a parameter that is a run's own; values along the belt share theirs and are told apart by their place.
fn name_of(parameter: &Parameter) -> String {
    match parameter.support {
        Some((low, high)) => format!("{} {low:?} {high:?}", parameter.name),
        None => parameter.name.clone(),
    }
}

/// The draft that stands for a point.
pub fn draft(problem: &Problem, h: &Hypothesis, point: &Point) -> Draft {
    let value = |parameter: &Parameter, position: f64| {
        let value = parameter.value(position);
        let (min, max) = bounds(parameter);
        if parameter.is_phase() {
            let turn = std::f64::consts::TAU;
            value - turn * (value / turn).round()
        } else {
            value.clamp(min, max)
        }
    };
    let effects = h.choices.iter().map(|choice| {
        let card = &problem.catalogue[choice.effect];
        let settings = choice.settings.iter();
        let settings = settings.map(|&(i, v)| (card.parameters[i].name.clone(), v));
        (card.id.clone(), settings.collect())
    });
    let shared = h.shared.iter().zip(&point.shared);
    let own = problem.campaign.runs.iter().enumerate().map(|(r, run)| {
        let values = h.per_run[r].iter().zip(&point.per_run[r]);
        let values = values.map(|(p, u)| (name_of(p), value(p, *u)));
        (run.name.clone(), values.collect())
    });
    Draft {
        effects: effects.collect(),
        shared: shared
            .map(|(p, u)| (p.name.clone(), value(p, *u)))
            .collect(),
        own: own.collect(),
    }
}
