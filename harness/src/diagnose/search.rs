//! The fit of one hypothesis from several starts, so that a poor local minimum is not taken for a verdict.

use super::candidate::Role;
use super::fit::{Data, Effort, Fit, Fitter};
use super::hypothesis::{Choice, Hypothesis};
use super::predictor::{Point, Predictor};
use super::scan;
use super::session::Session;
use super::shot::Shot;
use super::unexplained;
use crate::error::Error;

/// Every how many-th sample is used while searching.
pub const STRIDE: usize = 2;
/// Jacobians for a first look at a start.
const LOOK: usize = 3;
/// Share of each shot for a first look: a short horizon is less easily caught in a local minimum.
const LOOK_SHARE: f64 = 0.4;
/// Jacobians for the starts that look best.
const CLIMB: usize = 10;
/// Starts that are followed to the end.
const FOLLOWED: usize = 2;
/// Lines of a periodic effect that are tried.
const LINES: usize = 3;
/// Natural frequencies that are tried, up to this factor off the typical one, ...
const RESONANCE_RANGE: f64 = 1.35;
/// ... on a grid of this ratio, ...
const RESONANCE_STEP: f64 = 1.012;
/// ... on every how many-th shot; ...
const RESONANCE_SHOTS: usize = 3;
/// ... and how many of them are looked at.
const RESONANCES: usize = 4;
/// A fit whose median error is below this many times the noise is about to arrive.
const FOUND: f64 = 1.5;
/// The same from the spectrum of the smoothed force.
const FORCE_LINES: usize = 5;

/// A hypothesis and the best fit found.
pub struct Trial {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// The fit.
    pub fit: Fit,
    /// Runs of the FMU that it took.
    pub simulations: u64,
}

/// The effort of a search.
pub fn effort(iterations: usize) -> Effort {
    Effort {
        iterations,
        stride: STRIDE,
        share: 1.0,
        tolerance: 1e-3,
        patience: 1,
        knobs: true,
        shared: true,
        revive: true,
    }
}

fn keep_better(best: &mut Option<Fit>, fit: Fit) {
    if best.as_ref().is_none_or(|b| fit.trimmed < b.trimmed) {
        *best = Some(fit);
    }
}

/// The fit of a smaller hypothesis as a point of a larger one, with the effects that it lacks as nearly off
/// as their parameters allow.
fn switched_off(session: &Session, h: &Hypothesis, base: &Trial, shots: &[Shot]) -> Point {
    let mut point = widen(base, h, &Point::centre(h, shots));
    for choice in h
        .choices
        .iter()
        .filter(|c| !base.hypothesis.choices.contains(c))
    {
        let effect = &session.catalogue[choice.effect];
        for p in effect
            .parameters
            .iter()
            .filter(|p| p.role == Role::Amplitude)
        {
            if let Some(i) = h.shared_index(&format!("{}.{}", effect.id, p.name)) {
                point.shared[i] = h.shared[i].clamp(0.0);
            }
        }
    }
    point
}

/// Fits a hypothesis from the fit of a smaller one with the effects that this lacks switched off.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn from_nested(
    session: &Session,
    choices: &[Choice],
    shots: &[Shot],
    base: &Trial,
) -> Result<Trial, Error> {
    let hypothesis = session.hypothesis(choices)?;
    let data = Data {
        shots,
        noise: &session.noise,
        weight: 1.0,
    };
    let mut predictor = Predictor::new(
        session.fmu,
        &session.references,
        &session.campaign.runs,
        &hypothesis,
    )?;
    let off = switched_off(session, &hypothesis, base, shots);
    let fit = Fitter::new(&mut predictor, &hypothesis, &data, effort(BRIEF.look)).run(off);
    let simulations = predictor.count;
    Ok(Trial {
        hypothesis,
        fit,
        simulations,
    })
}

/// How thorough a search is.
#[derive(Debug, Clone, Copy)]
pub struct Depth {
    /// Jacobians for a first look at a start.
    pub look: usize,
    /// Starts that are followed to the end.
    pub followed: usize,
    /// Jacobians for these.
    pub climb: usize,
    /// Whether periodic effects also start from the nominal nuisances, not only from the calibrated ones.
    pub fresh: bool,
}

/// Every start is looked at, the best two are followed to the end.
pub const THOROUGH: Depth = Depth {
    look: LOOK,
    followed: FOLLOWED,
    climb: CLIMB,
    fresh: true,
};
/// For hypotheses that a rival at the noise floor has all but ruled out, and for pairs.
pub const BRIEF: Depth = Depth {
    look: 2,
    followed: 1,
    climb: 5,
    fresh: false,
};

/// Ways to choose an effect: one for each value of its settings that are switches.
pub fn variants(session: &Session, effect: usize) -> Vec<Choice> {
    let card = &session.catalogue[effect];
    let is_profile = card.parameters.iter().any(|p| p.role == Role::Node);
    let switch = card
        .parameters
        .iter()
        .position(|p| p.role == Role::Setting && p.min == 0.0 && p.max == 1.0);
    match switch {
        Some(index) if !is_profile => (0..2)
            .map(|v| Choice {
                effect,
                settings: vec![(index, f64::from(v))],
            })
            .collect(),
        _ => vec![Choice {
            effect,
            settings: Vec::new(),
        }],
    }
}

/// Fits the reference model with `known` effects and the last of `choices` newly added.
///
/// `base` is the fit without the new effect, on the same shots; the search starts from it with the effect
/// nearly off, and from the priors with the effect at practical strengths.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn search(
    session: &Session,
    choices: &[Choice],
    shots: &[Shot],
    base: &Trial,
    depth: Depth,
) -> Result<Trial, Error> {
    let hypothesis = session.hypothesis(choices)?;
    let new = choices.last().expect("a search adds an effect").effect;
    let data = Data {
        shots,
        noise: &session.noise,
        weight: 1.0,
    };
    let mut predictor = Predictor::new(
        session.fmu,
        &session.references,
        &session.campaign.runs,
        &hypothesis,
    )?;
    let starts = starts(
        session,
        &hypothesis,
        new,
        base,
        &data,
        &mut predictor,
        depth,
    );
    let look = Effort {
        share: LOOK_SHARE,
        revive: false,
        ..effort(depth.look)
    };
    let mut looks = Vec::new();
    let mut best: Option<Fit> = None;
    for start in starts {
        let seen = Fitter::new(&mut predictor, &hypothesis, &data, look).run(start);
        if data.quantile(&seen, 0.5) < FOUND {
            let fit = Fitter::new(&mut predictor, &hypothesis, &data, effort(depth.climb))
                .run(seen.point);
            let found = data.quantile(&fit, 0.75) < FOUND;
            keep_better(&mut best, fit);
            if found {
                break;
            }
        } else {
            looks.push(seen);
        }
    }
    let found = best
        .as_ref()
        .is_some_and(|b| data.quantile(b, 0.75) < FOUND);
    if !found {
        looks.sort_by(|a, b| a.trimmed.total_cmp(&b.trimmed));
        for look in looks.into_iter().take(depth.followed) {
            let fit = Fitter::new(&mut predictor, &hypothesis, &data, effort(depth.climb))
                .run(look.point);
            keep_better(&mut best, fit);
        }
    }
    // Never worse than without the effect.
    if best.as_ref().is_none_or(|b| b.trimmed > base.fit.trimmed) {
        let off = switched_off(session, &hypothesis, base, shots);
        let fit = Fitter::new(&mut predictor, &hypothesis, &data, effort(depth.look)).run(off);
        keep_better(&mut best, fit);
    }
    let fit = best.expect("there is at least one start");
    let simulations = predictor.count;
    Ok(Trial {
        hypothesis,
        fit,
        simulations,
    })
}

/// The fit of the reference model itself.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn baseline(session: &Session, shots: &[Shot]) -> Result<Trial, Error> {
    let hypothesis = session.hypothesis(&[])?;
    let data = Data {
        shots,
        noise: &session.noise,
        weight: 1.0,
    };
    let mut predictor = Predictor::new(
        session.fmu,
        &session.references,
        &session.campaign.runs,
        &hypothesis,
    )?;
    let start = Point::centre(&hypothesis, shots);
    let look = Effort {
        share: LOOK_SHARE,
        revive: false,
        ..effort(LOOK)
    };
    let seen = Fitter::new(&mut predictor, &hypothesis, &data, look).run(start);
    let mut fitter = Fitter::new(&mut predictor, &hypothesis, &data, effort(CLIMB));
    let settled = fitter.settle(seen.point);
    let fit = fitter.run(settled.point);
    let simulations = predictor.count;
    Ok(Trial {
        hypothesis,
        fit,
        simulations,
    })
}

/// A point of the larger hypothesis that agrees with a point of the smaller one.
pub fn widen(base: &Trial, hypothesis: &Hypothesis, point: &Point) -> Point {
    let mut out = point.clone();
    for (i, knob) in base.hypothesis.shared.iter().enumerate() {
        if let Some(j) = hypothesis.shared_index(&knob.name) {
            out.shared[j] = base.fit.point.shared[i];
        }
    }
    for (run, knobs) in base.hypothesis.own.iter().enumerate() {
        for (i, knob) in knobs.iter().enumerate() {
            if let Some(j) = hypothesis.own[run].iter().position(|k| k.name == knob.name) {
                out.own[run][j] = base.fit.point.own[run][i];
            }
        }
    }
    let modal = 2 * hypothesis.modes;
    for (k, state) in out.states.iter_mut().enumerate() {
        state[..modal].copy_from_slice(&base.fit.point.states[k][..modal]);
        for (i, (reference, _)) in base.hypothesis.extra_states.iter().enumerate() {
            if let Some(j) = hypothesis
                .extra_states
                .iter()
                .position(|s| s.0 == *reference)
            {
                state[modal + j] = base.fit.point.states[k][modal + i];
            }
        }
    }
    out.stuck.clone_from(&base.fit.point.stuck);
    out
}

fn starts<'a>(
    session: &Session,
    h: &'a Hypothesis,
    new: usize,
    base: &Trial,
    data: &Data,
    predictor: &mut Predictor<'a>,
    depth: Depth,
) -> Vec<Point> {
    let effect = &session.catalogue[new];
    let centre = Point::centre(h, data.shots);
    let from_base = widen(base, h, &centre);
    // Effects known already keep their fitted values also where all else starts from the priors.
    let mut fresh = centre.clone();
    for (i, knob) in h.shared.iter().enumerate() {
        if base.hypothesis.shared_index(&knob.name).is_some()
            && knob
                .name
                .split_once('.')
                .is_some_and(|(id, _)| session.catalogue.iter().any(|c| c.id == id))
        {
            fresh.shared[i] = from_base.shared[i];
        }
    }
    fresh.own.clone_from(&from_base.own);
    let index = |name: &str| h.shared_index(&format!("{}.{name}", effect.id));
    let with = |point: &Point, values: &[(usize, f64)]| {
        let mut p = point.clone();
        for &(i, v) in values {
            p.shared[i] = h.shared[i].clamp(h.shared[i].position(v));
        }
        p
    };
    if effect.find_role(Role::Phase).is_some() {
        let origins = if depth.fresh {
            vec![&fresh, &from_base]
        } else {
            vec![&from_base]
        };
        return periodic_starts(session, h, effect, data, predictor, &from_base, &origins);
    }
    let amplitude = effect.find_role(Role::Amplitude);
    if let Some(f) = effect.resonance() {
        let name = index(&effect.parameters[f].name);
        return name.map_or(vec![from_base.clone()], |i| {
            resonance_starts(h, i, data, predictor, &from_base, &fresh)
        });
    }
    let shapes: Vec<usize> = (0..effect.parameters.len())
        .filter(|&i| effect.parameters[i].role == Role::Shape)
        .collect();
    let mut out = Vec::new();
    let grid = shape_grid(session, new, &shapes);
    let strengths: Vec<f64> = match amplitude {
        None => vec![f64::NAN],
        Some(a) if effect.parameters[a].min < 0.0 => {
            vec![effect.parameters[a].typical, -effect.parameters[a].typical]
        }
        Some(a) => vec![effect.parameters[a].typical],
    };
    for shape in &grid {
        for (sign, &strength) in strengths.iter().enumerate() {
            let mut values: Vec<(usize, f64)> = shapes
                .iter()
                .zip(shape)
                .filter_map(|(&i, v)| Some((index(&effect.parameters[i].name)?, *v)))
                .collect();
            if let (Some(a), true) = (amplitude, strength.is_finite()) {
                let Some(i) = index(&effect.parameters[a].name) else {
                    continue;
                };
                values.push((i, strength));
                out.push(with(&fresh, &values));
                // From the calibrated model, with the effect barely on.
                if sign == 0 {
                    values.pop();
                    values.push((i, 0.02 * strength));
                    out.push(with(&from_base, &values));
                }
            } else {
                out.push(with(&fresh, &values));
            }
        }
    }
    if out.is_empty() {
        out.push(from_base);
    }
    out
}

/// Points of the shape parameters to start from: the typical one, and others spread over the plausible range.
fn shape_grid(session: &Session, effect: usize, shapes: &[usize]) -> Vec<Vec<f64>> {
    let parameters = &session.catalogue[effect].parameters;
    let typical: Vec<f64> = shapes.iter().map(|&i| parameters[i].typical).collect();
    let mut grid = vec![typical.clone()];
    let factors: &[f64] = match shapes.len() {
        0 => &[],
        1 => &[0.2, 5.0],
        _ => &[0.3, 3.0],
    };
    for (axis, &i) in shapes.iter().enumerate() {
        for factor in factors {
            let value = typical[axis] * factor;
            if value >= parameters[i].min && value <= parameters[i].max {
                let mut point = typical.clone();
                point[axis] = value;
                grid.push(point);
            }
        }
    }
    grid
}

/// Starts for a natural frequency: known to tens of percent at best, it must be met to a cycle within
/// a shot. On a fine grid only the start states are fitted, to the beginnings of some of the shots.
fn resonance_starts<'a>(
    h: &'a Hypothesis,
    knob: usize,
    data: &Data,
    predictor: &mut Predictor<'a>,
    from_base: &Point,
    fresh: &Point,
) -> Vec<Point> {
    let chosen: Vec<usize> = (0..data.shots.len()).step_by(RESONANCE_SHOTS).collect();
    let shots: Vec<Shot> = chosen.iter().map(|&k| data.shots[k].clone()).collect();
    let some = Data {
        shots: &shots,
        noise: data.noise,
        weight: data.weight,
    };
    let typical = h.shared[knob].prior;
    let mut tried: Vec<(f64, f64)> = Vec::new();
    let mut ratio: f64 = 1.0 / RESONANCE_RANGE;
    while ratio < RESONANCE_RANGE {
        let mut point = from_base.clone();
        point.shared[knob] = h.shared[knob].clamp(h.shared[knob].position(ratio * typical));
        let point = Point {
            states: chosen.iter().map(|&k| point.states[k].clone()).collect(),
            stuck: chosen.iter().map(|&k| point.stuck[k]).collect(),
            ..point
        };
        let position = point.shared[knob];
        let quick = Effort {
            knobs: false,
            share: LOOK_SHARE,
            revive: false,
            ..effort(2)
        };
        let fit = Fitter::new(predictor, h, &some, quick).run(point);
        tried.push((fit.trimmed, position));
        ratio *= RESONANCE_STEP;
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried
        .iter()
        .take(RESONANCES)
        .flat_map(|&(_, position)| [(fresh, position), (from_base, position)])
        .map(|(origin, position)| {
            let mut point = origin.clone();
            point.shared[knob] = position;
            point
        })
        .collect()
}

fn periodic_starts(
    session: &Session,
    h: &Hypothesis,
    effect: &super::candidate::Candidate,
    data: &Data,
    predictor: &mut Predictor,
    from_base: &Point,
    origins: &[&Point],
) -> Vec<Point> {
    let mut out = Vec::new();
    let name = |role: Role| {
        effect
            .find_role(role)
            .map(|i| format!("{}.{}", effect.id, effect.parameters[i].name))
    };
    let (Some(a), Some(f), Some(p)) = (name(Role::Amplitude), name(Role::Shape), name(Role::Phase))
    else {
        return vec![from_base.clone()];
    };
    let (Some(a), Some(f)) = (h.shared_index(&a), h.shared_index(&f)) else {
        return vec![from_base.clone()];
    };
    let mut lines = Vec::new();
    // A factor on friction shows in the smoothed force itself, however far the reference model is off.
    if let (Some((amplitude, shape)), Some(argument)) =
        (scan::periodic(effect), scan::argument(effect))
        && effect.parameters[amplitude].unit == "1"
    {
        let range = (effect.parameters[shape].min, effect.parameters[shape].max);
        lines = unexplained::lines(session, argument, range, FORCE_LINES);
    }
    lines.extend(scan::lines(
        predictor, h, effect, data, from_base, STRIDE, LINES,
    ));
    for line in lines {
        for &origin in origins {
            let mut point = origin.clone();
            point.shared[a] = h.shared[a].clamp(line.amplitude);
            point.shared[f] = h.shared[f].clamp(h.shared[f].position(line.value));
            for (run, knobs) in h.own.iter().enumerate() {
                if let Some(i) = knobs.iter().position(|k| k.name == p) {
                    point.own[run][i] = line.phase[run];
                }
            }
            out.push(point);
        }
    }
    if out.is_empty() {
        out.push(from_base.clone());
    }
    out
}
