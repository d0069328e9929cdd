//! Which effects can act in a campaign at all: friction does nothing where nothing is pressed on, a belt drive nothing where the
//! belt rests. Such an effect has no derivative, and its hypothesis would be the one without it at another price.

use crate::diagnose::model::effect_card::EffectCard;
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::parameter::Kind;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::simulator::{Samples, Simulator};
use crate::error::Error;
use crate::parallel::parallel;

/// Value given to each number of a curve or profile for the test, in its own unit: a tenth, as such numbers are shares or units of
/// their spread.
const OF_A_CURVE: f64 = 0.1;
/// Change of a motion, in units of the noise, from which on an effect acts: far above the integrator's error, far below what data
/// can show.
const CHANGE: f64 = 1e-2;

/// For each effect of the catalogue, whether the motions that the runs begin with change with it at its typical strength. Where some run
/// keeps itself going by friction on a moving belt, all are taken to act.
///
/// # Errors
/// An FMU that can't be run.
pub fn acting(problem: &Problem) -> Result<Vec<bool>, Error> {
    let effects: Vec<usize> = (0..problem.catalogue.len()).collect();
    let rubs = |r: &crate::measurement::Run| r.sustains_itself() && r.normal_force > 0.0;
    if problem.campaign.runs.iter().any(rubs) {
        return Ok(vec![true; effects.len()]);
    }
    let plain = motions(problem, &[])?;
    parallel(&effects, |&effect| {
        let choice = Choice {
            effect,
            settings: Vec::new(),
        };
        let with = motions(problem, &[choice])?;
        let differs = |(k, (a, b)): (usize, (&Vec<f64>, &Vec<f64>))| {
            let noise = problem.noise[problem.segments[k].run];
            a.len() != b.len() || a.iter().zip(b).any(|(a, b)| (a - b).abs() > CHANGE * noise)
        };
        Ok(plain.iter().zip(&with).enumerate().any(differs))
    })
}

/// The motion over each segment, from the smoothed start states; empty where it can't be followed.
fn motions(problem: &Problem, choices: &[Choice]) -> Result<Vec<Vec<f64>>, Error> {
    let h = problem.hypothesis(choices)?;
    let mut point = Point::centre(&h, &problem.segments);
    if let Some(choice) = choices.first() {
        switch_on(&h, &problem.catalogue[choice.effect], &mut point);
    }
    let mut predictor = problem.predictor(&h)?;
    let mut out = Vec::with_capacity(problem.segments.len());
    for (k, segment) in problem.segments.iter().enumerate() {
        let mut motion = Vec::new();
        let values = point.values(k, segment.run);
        let done = predictor.predict(segment, values, Samples::all(segment), &mut motion);
        if !matches!(done, Ok(true)) {
            motion.clear();
        }
        out.push(motion);
    }
    Ok(out)
}

/// Gives an effect its typical strength.
fn switch_on(h: &Hypothesis, card: &EffectCard, point: &mut Point) {
    let strength = |name: &str, kind: Kind| {
        let own = name.strip_prefix(&format!("{}.", card.id))?;
        match kind {
            Kind::Node | Kind::Latent => Some(OF_A_CURVE),
            Kind::Amplitude | Kind::Shape => {
                let of_card = card.parameters.iter().find(|p| p.name == own);
                Some(of_card.map_or(OF_A_CURVE, |p| p.typical))
            }
            _ => None,
        }
    };
    for (parameter, position) in h.shared.iter().zip(&mut point.shared) {
        if let Some(value) = strength(&parameter.name, parameter.kind) {
            *position = parameter.clamp(parameter.position(value));
        }
    }
    for (parameters, positions) in h.per_run.iter().zip(&mut point.per_run) {
        for (parameter, position) in parameters.iter().zip(positions) {
            if let Some(value) = strength(&parameter.name, parameter.kind) {
                *position = parameter.clamp(parameter.position(value));
            }
        }
    }
}
