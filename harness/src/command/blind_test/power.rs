//! What an ideal test could see of a hidden effect, from the truth.
//!
//! The power of an effect is its true strength over the standard deviation that the runs fitted
//! allow at best, with all other parameters and every start state free (Cramer-Rao bound),
//!
//! ```text
//! power = |a| / sqrt([I^-1]_aa)
//! ```
//!
//! with I the Fisher information of the true hypothesis at the truth. An ideal test finds a normal
//! variable of that mean and standard deviation 1, z, and names the effect where the likelihood
//! gained, z^2/2, exceeds the price: what the evidence pays for the parameters of the effect, what
//! an effect costs beforehand, and the odds with which one is named.
//!
//! The strength is the parameter that switches the effect off by degrees; of what yields, its
//! stiffness, whose inverse is the strength and has the same relative standard deviation. An added
//! mode and a profile along the belt have no one strength: of those, and of what the catalogue
//! lacks, nothing is told. Holds where the strength is seen within a few of its standard deviations
//! as in a linear model. Source: Kay, Fundamentals of Statistical Signal Processing I, 1993,
//! section 3.

use serde::{Deserialize, Serialize};

use super::answer::{Answer, is_outside};
use crate::command::pack;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::initialisation::multistart::{continued, settled};
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::library;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::variants::variants;
use crate::diagnose::selection::decision::log_prior;
use crate::diagnose::selection::full_refit::last_options;
use crate::diagnose::thresholds::{CLAIMED, FLOOR_MEDIAN};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::fmu::effect_card::{EffectCard, EffectParameter, Role};
use crate::measurement::Campaign;

/// Jacobians of the two fits from the truth, which is near: the first robust, the second as
/// compared.
const NEAR: usize = 6;

/// What an ideal test could see, of the hidden effect that shows least.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Power {
    /// Strength over its least standard deviation, 1.
    pub value: f64,
    /// Price of naming it, nats.
    pub price: f64,
}

impl Power {
    /// Probability that an ideal test names the effect: that a normal variable with mean `value`
    /// and standard deviation 1 exceeds `sqrt(2 price)`.
    pub fn ideal(&self) -> f64 {
        let least = (2.0 * self.price.max(0.0)).sqrt();
        0.5 * libm::erfc((least - self.value) / std::f64::consts::SQRT_2)
    }
}

/// The power of a campaign's hidden effects; `None` where one of them has none (see above), where
/// nothing is hidden, and where a fit from the truth does not come down to the noise, so that its
/// information is that of another place.
///
/// # Errors
/// An FMU that can't be run, or a campaign that can't be diagnosed.
pub fn power(fmu: &Fmu, campaign: &Campaign, answer: &Answer) -> Result<Option<Power>, Error> {
    if answer.effects.is_empty() || is_outside(&answer.effects) {
        return Ok(None);
    }
    let widened = pack::widened::with_effects(fmu, &library::FILES)?;
    let mut problem = Problem::new(widened.as_ref().unwrap_or(fmu), campaign)?;
    problem.trust_sensor();
    let of_effect = |id: &String| {
        let effect = problem.catalogue.iter().position(|c| c.id == *id)?;
        true_form(&problem, effect, answer)
    };
    let choices: Option<Vec<Choice>> = answer.effects.iter().map(of_effect).collect();
    let Some(choices) = choices else {
        return Ok(None);
    };
    let shows = |choice: &Choice| strength_of(&problem.catalogue[choice.effect]).is_some();
    if !choices.iter().all(shows) {
        return Ok(None);
    }
    let fitted = fitted_from_truth(&problem, &choices, answer)?;
    let of_each = choices.iter().map(|choice| {
        let card = &problem.catalogue[choice.effect];
        of_effect_in(&problem, card, &fitted, answer)
    });
    let all: Option<Vec<Power>> = of_each.collect();
    let all = all.unwrap_or_default();
    Ok(all.into_iter().min_by(|a, b| a.value.total_cmp(&b.value)))
}

/// The parameter whose relative standard deviation is that of an effect's strength.
fn strength_of(card: &EffectCard) -> Option<usize> {
    let is_stiffness = |p: &EffectParameter| p.role == Role::Shape && p.unit == "N/m";
    card.switch()
        .or_else(|| card.parameters.iter().position(is_stiffness))
}

/// The way to choose an effect in the form that is hidden; `None` where the model does not have it.
fn true_form(problem: &Problem, effect: usize, answer: &Answer) -> Option<Choice> {
    let card = &problem.catalogue[effect];
    let form = &answer.parameters[&card.id]["form"];
    let wanted = |choice: &Choice| {
        let mut settings = choice.settings.iter();
        settings.all(|&(_, value)| match form.as_str() {
            Some("log") => value == 1.0,
            Some("exp") => value == 0.0,
            _ => form.as_f64().is_none_or(|form| form == value),
        })
    };
    variants(problem, effect).into_iter().find(wanted)
}

/// The true hypothesis, fitted to the runs fitted from the true parameters.
fn fitted_from_truth(
    problem: &Problem,
    choices: &[Choice],
    answer: &Answer,
) -> Result<FittedHypothesis, Error> {
    let h = problem.hypothesis(choices)?;
    let segments = problem.copies(&problem.fit_segments(1));
    let mut start = Point::centre(&h, &segments);
    put_truth(&h, answer, &mut start);
    let near = settled(problem, h, &segments, start, FitOptions::search(NEAR))?;
    let options = FitOptions {
        iterations: NEAR,
        ..last_options()
    };
    continued(problem, near.hypothesis, &segments, near.fit.point, options)
}

/// Sets what truth.json tells of the parameters; the others stay as believed.
fn put_truth(h: &Hypothesis, answer: &Answer, point: &mut Point) {
    let of_law = |name: &str| answer.true_law.get(name).copied();
    let of_mode = |list: &[f64], mode: &str| {
        let mode: usize = mode.parse().ok()?;
        list.get(mode.checked_sub(1)?).copied()
    };
    let truth = |name: &str| match name.split_once('.')? {
        ("friction", "mu_0") => of_law("mus"),
        ("friction", item) => of_law(item),
        (owner, item) => match owner
            .strip_prefix("mode[")
            .and_then(|m| m.strip_suffix(']'))
        {
            Some(mode) if item == "frequency" => of_mode(&answer.true_f_hz, mode),
            Some(mode) if item == "damping_ratio" => of_mode(&answer.true_d, mode),
            Some(_) => None,
            None => answer.parameter(owner, item),
        },
    };
    for (parameter, position) in h.shared.iter().zip(&mut point.shared) {
        if let Some(value) = truth(&parameter.name) {
            *position = parameter.clamp(parameter.position(value));
        }
    }
    for ((parameters, positions), run) in h.per_run.iter().zip(&mut point.per_run).zip(&answer.runs)
    {
        let own = |name: &str| {
            let (effect, item) = name.split_once('.')?;
            run.own.get(effect)?.get(item)?.as_f64()
        };
        for (parameter, position) in parameters.iter().zip(positions) {
            let value = match parameter.name.as_str() {
                "friction.level" => Some(run.friction_level),
                name => own(name),
            };
            if let Some(value) = value {
                *position = parameter.clamp(parameter.position(value));
            }
        }
    }
}

/// The power of one of the hidden effects.
fn of_effect_in(
    problem: &Problem,
    card: &EffectCard,
    fitted: &FittedHypothesis,
    answer: &Answer,
) -> Option<Power> {
    let (h, fit) = (&fitted.hypothesis, &fitted.fit);
    let segments = problem.copies(&problem.fit_segments(1));
    if !(fit.error_quantile(&problem.data(&segments), 0.5) <= FLOOR_MEDIAN) {
        return None;
    }
    let covariance = fit.covariance.as_ref()?;
    let strength = &card.parameters[strength_of(card)?].name;
    let truth = answer.parameter(&card.id, strength)?;
    let is_of_effect = |name: &str| {
        name.split_once('.')
            .is_some_and(|(owner, _)| owner == card.id)
    };
    let std = |c: usize| covariance[(c, c)].sqrt();
    let c = h.shared_index(&format!("{}.{strength}", card.id))?;
    let u = fit.point.shared[c];
    let value = truth.abs() / (std(c) * h.shared[c].slope(u).abs());
    // What the evidence pays for one parameter of which so much was believed.
    let pays = |believed: f64, std: f64| 0.5 * (believed / std).powi(2).ln_1p();
    let shared = (0..h.shared.len()).filter(|&i| is_of_effect(&h.shared[i].name));
    let of_shared: f64 = shared.map(|i| pays(h.shared[i].volume_std(), std(i))).sum();
    // The phase of each run, whose standard deviation is that of its amplitude over the amplitude.
    let runs = (0..h.per_run.len()).filter(|&run| !problem.held_out[run]);
    let root = (problem.fitted_runs() as f64).sqrt();
    let phases = runs.flat_map(|run| h.per_run[run].iter());
    let phases = phases.filter(|p| p.is_phase() && is_of_effect(&p.name));
    let of_phases: f64 = phases.map(|p| pays(p.volume_std(), root / value)).sum();
    let others = h.choices.len() - 1;
    let beforehand = log_prior(problem, others) - log_prior(problem, others + 1);
    value.is_finite().then(|| Power {
        value,
        price: of_shared + of_phases + beforehand + CLAIMED.ln(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Source: tables of the normal distribution, P(z > 1.959964) = 0.025.
    #[test]
    fn val_an_ideal_test_names_as_often_as_a_normal_variable_exceeds_the_price() {
        let ideal = |value: f64| Power { value, price: 8.0 }.ideal();
        assert!((ideal(4.0) - 0.5).abs() < 1e-12);
        assert!((ideal(4.0 - 1.959_963_985) - 0.025).abs() < 1e-9);
        assert!((ideal(4.0 + 1.959_963_985) - 0.975).abs() < 1e-9);
    }
}
