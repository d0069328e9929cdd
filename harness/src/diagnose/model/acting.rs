//! Which effects can act in a campaign at all: friction does nothing where nothing is pressed on, a belt drive nothing where the
//! belt rests. Such an effect has no derivative, and its hypothesis would be the one without it at another price.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::parameter::Kind;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::references::{References, output_of};
use crate::diagnose::model::simulator::{Samples, Simulator};
use crate::diagnose::model::unknown_function::{is_unknown_function, loads};
use crate::error::Error;
use crate::fmu::effect_card::EffectCard;
use crate::measurement::Measurand;
use crate::metric::median;
use crate::observer::Mode;
use crate::parallel::parallel;
use Sensors::{All, First};

/// Value given to each number of a curve or profile for the test, in its own unit: a tenth, as such numbers are shares or units of
/// their spread.
const OF_A_CURVE: f64 = 0.1;
/// Change of a motion, in units of the noise, from which on an effect acts: far above the integrator's error, far below what data
/// can show.
const CHANGE: f64 = 1e-2;

/// The effect that only shifts where a structure with springs rests, as the offset of its sensor does.
const SHIFTS_ALONE: &str = "term_constant_force";
/// Effects that only scale the friction law where the normal force does not vary.
const SCALE_ALONE: [&str; 2] = [
    "term_friction_by_load",
    "term_unknown_friction_normal_force",
];

/// Tells the problem which effects can act, and says in a remark which can't for want of a sensor of displacements.
///
/// # Errors
/// An FMU that can't be run.
pub fn leave_out(problem: &mut Problem) -> Result<(), Error> {
    problem.acts = acting(problem)?;
    let structure = structure(problem.fmu, &problem.campaign.beam)?;
    if !structure.modes().iter().any(Mode::is_free) {
        for (acts, card) in problem.acts.iter_mut().zip(&problem.catalogue) {
            *acts &= card.id != SHIFTS_ALONE;
        }
    }
    let known = problem.campaign.uncertainty.normal_force_std;
    if !varies(loads(&problem.campaign), known) {
        for (acts, card) in problem.acts.iter_mut().zip(&problem.catalogue) {
            *acts &= !SCALE_ALONE.contains(&card.id.as_str());
        }
    }
    if problem.campaign.measurand() == Measurand::Displacement {
        return Ok(());
    }
    let blind = sensor_alone(problem)?;
    let effects = problem.catalogue.iter().zip(&blind);
    let ids: Vec<&str> = effects
        .filter(|(card, blind)| **blind && !is_beyond(card))
        .map(|(card, _)| card.id.as_str())
        .collect();
    let remark = format!(
        "Left out, since they act on a sensor of displacements alone and a{} was measured: {}.",
        match problem.campaign.measurand() {
            Measurand::Displacement => " displacement",
            Measurand::Velocity => " velocity",
            Measurand::Acceleration => "n acceleration",
        },
        ids.join(", ")
    );
    if !ids.is_empty() {
        problem.remarks.push(remark);
    }
    for (acts, blind) in problem.acts.iter_mut().zip(blind) {
        *acts &= !blind;
    }
    Ok(())
}

/// Whether loads from the least to the largest, N, differ by more than they are known, `std` as a share.
fn varies((least, most): (f64, f64), std: f64) -> bool {
    most - least > std * most
}

/// Whether an effect stands beyond the catalogue.
fn is_beyond(card: &EffectCard) -> bool {
    is_library_effect(&card.id) || is_unknown_function(&card.id)
}

/// Segments on which it is looked whether an effect moves the tip.
const LOOKED_AT: usize = 8;
/// A sensor of displacements shows an effect alone if it shows this many times what the change of velocity or acceleration can
/// make in the segment.
const BEYOND_MOTION: f64 = 10.0;

/// For each effect of the catalogue, whether a sensor of displacements shows it at its typical strength and the motion does
/// not: from the same start the displacement changes by no more than the time times the change of velocity, or half the square of
/// the time times that of acceleration.
fn sensor_alone(problem: &Problem) -> Result<Vec<bool>, Error> {
    let effects: Vec<usize> = (0..problem.catalogue.len()).collect();
    let step = (problem.segments.len() / LOOKED_AT).max(1);
    let some: Vec<usize> = (0..problem.segments.len()).step_by(step).collect();
    let displacement = output_of(problem.fmu, Measurand::Displacement)?;
    let sensor = problem.references.observing(displacement.reference);
    let both = |choices: &[Choice]| -> Result<[Vec<Vec<f64>>; 2], Error> {
        Ok([
            motions(problem, choices, &problem.references, &some, First)?,
            motions(problem, choices, &sensor, &some, First)?,
        ])
    };
    let plain = both(&[])?;
    parallel(&effects, |&effect| {
        let choice = Choice::of(effect);
        let with = both(&[choice])?;
        let largest = |of: usize, i: usize| -> f64 {
            let pairs = plain[of][i].iter().zip(&with[of][i]);
            pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
        };
        let (mut moved, mut shown) = (Vec::new(), Vec::new());
        for (i, &k) in some.iter().enumerate() {
            let segment = &problem.segments[k];
            let duration = segment.time[segment.time.len() - 1] - segment.time[0];
            moved.push(largest(0, i) / problem.noise[segment.run]);
            let reach = match problem.campaign.measurand() {
                Measurand::Displacement => 1.0,
                Measurand::Velocity => duration,
                Measurand::Acceleration => 0.5 * duration * duration,
            };
            shown.push(largest(1, i) - BEYOND_MOTION * reach * largest(0, i));
        }
        Ok(median(&mut moved) < CHANGE && median(&mut shown) > 0.0)
    })
}

/// For each effect of the catalogue, whether the motions that the runs begin with change with it at its typical strength. Where some run
/// keeps itself going by friction on a moving belt, all are taken to act.
///
/// # Errors
/// An FMU that can't be run.
fn acting(problem: &Problem) -> Result<Vec<bool>, Error> {
    let effects: Vec<usize> = (0..problem.catalogue.len()).collect();
    let rubs = |r: &crate::measurement::Run| r.sustains_itself() && r.normal_force > 0.0;
    if problem.campaign.runs.iter().any(rubs) {
        return Ok(vec![true; effects.len()]);
    }
    let all: Vec<usize> = (0..problem.segments.len()).collect();
    let plain = motions(problem, &[], &problem.references, &all, All)?;
    parallel(&effects, |&effect| {
        let choice = Choice::of(effect);
        let with = motions(problem, &[choice], &problem.references, &all, All)?;
        let differs = |(k, (a, b)): (usize, (&Vec<f64>, &Vec<f64>))| {
            let noise = problem.noise[problem.segments[k].run];
            a.len() != b.len() || a.iter().zip(b).any(|(a, b)| (a - b).abs() > CHANGE * noise)
        };
        Ok(plain.iter().zip(&with).enumerate().any(differs))
    })
}

/// Whose readings are looked at.
#[derive(Clone, Copy)]
enum Sensors {
    First,
    All,
}

/// The motion over each of some segments, from the smoothed start states, as the output of `references` shows it; empty where it
/// can't be followed.
fn motions(
    problem: &Problem,
    choices: &[Choice],
    references: &References,
    some: &[usize],
    sensors: Sensors,
) -> Result<Vec<Vec<f64>>, Error> {
    let h = problem.hypothesis(choices)?;
    let mut point = Point::centre(&h, &problem.segments);
    if let Some(choice) = choices.first() {
        switch_on(&h, &problem.catalogue[choice.effect], &mut point);
    }
    let runs = &problem.campaign.runs;
    let mut predictor = Predictor::new(problem.fmu, references, runs, &h, &problem.work)?;
    // Another output must not be compared with what was measured.
    let is_other = references.measured != problem.references.measured;
    let mut out = Vec::with_capacity(some.len());
    for &k in some {
        let segment = &problem.segments[k];
        let free = is_other.then(|| Segment {
            measured: vec![f64::NAN; segment.measured.len()],
            ..segment.clone()
        });
        let segment = free.as_ref().unwrap_or(segment);
        let mut motion = Vec::new();
        let values = point.values(k, segment.run);
        let samples = match sensors {
            First => Samples::all(segment),
            All => Samples::all(segment).of_all_sensors(),
        };
        let done = predictor.predict(segment, values, samples, &mut motion);
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

#[cfg(test)]
mod tests {
    use super::varies;

    #[test]
    fn loads_vary_where_they_differ_by_more_than_they_are_known() {
        assert!(varies((36.0, 120.0), 0.025));
        assert!(!varies((80.0, 80.0), 0.025));
        // A column of a load that is held: it wanders by 1 %.
        assert!(!varies((79.6, 80.4), 0.025));
        // Nothing is pressed on.
        assert!(!varies((0.0, 0.0), 0.025));
    }
}
