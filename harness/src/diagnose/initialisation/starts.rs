//! Where the fit of a new effect starts from: nuisances calibrated or nominal, strengths and shapes spread over what
//! is plausible, and for what repeats or resonates the places where a spectrum or a grid shows something.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::{FitOptions, STRIDE};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::nesting::widen;
use crate::diagnose::initialisation::force_spectrum;
use crate::diagnose::initialisation::response_spectrum::ResponseSpectrum;
use crate::diagnose::initialisation::search_options::{FIRST_FIT_SHARE, Nuisances, SearchOptions};
use crate::diagnose::initialisation::shape_grid::shape_grid;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::periodic::{Line, argument, periodic};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::predictor::Predictor;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::profile_values::{follow_profile, values_along};
use crate::diagnose::model::unknown_function::latent_name;
use crate::fmu::effect_card::{EffectCard, Role};

/// Latent value of a curve that starts, in standard deviations: quite off it has no derivatives.
const BARELY_ON: f64 = 1e-3;
/// Lines of a periodic effect that are tried.
const LINES: usize = 3;
/// The same from the spectrum of the smoothed force.
const FORCE_LINES: usize = 5;
/// Lines at which also the nominal nuisances are tried, unless all else explains the data: those calibrated without an effect
/// that is plain in the force itself have been bent in its place.
const FRESH_LINES: usize = 2;
/// Natural frequencies that are tried, up to this factor off the typical one, ...
const RESONANCE_RANGE: f64 = 1.35;
/// ... on a grid of this ratio, ...
const RESONANCE_STEP: f64 = 1.012;
/// ... with so few Jacobians for the start states, all in step: fitted each to its end, wrong frequencies are imitated as well
/// (a third mode of 1400 Hz was looked for at 1800 Hz), ...
const RESONANCE_FIRST_FIT: usize = 2;
/// ... on every how many-th segment; ...
const RESONANCE_SEGMENTS: usize = 3;
/// ..., where all else explains the data already; ...
const RESONANCE_SEGMENTS_NEAR: usize = 9;
/// ... and how many of them are looked at.
const RESONANCES: usize = 4;

/// Points of hypothesis `h` from which to look for its effect with index `new`, given the fit without it.
pub(crate) fn starts<'a>(
    problem: &Problem,
    h: &'a Hypothesis,
    new: usize,
    base: &FittedHypothesis,
    data: &Observations,
    predictor: &mut Predictor<'a>,
    search: SearchOptions,
) -> Vec<Point> {
    let effect = &problem.catalogue[new];
    let centre = Point::centre(h, data.segments);
    let from_base = widen(base, h, &centre);
    // Effects known already keep their fitted values also where all else starts from the priors.
    let mut fresh = centre.clone();
    for (i, parameter) in h.shared.iter().enumerate() {
        if base.hypothesis.shared_index(&parameter.name).is_some()
            && parameter
                .name
                .split_once('.')
                .is_some_and(|(id, _)| problem.catalogue.iter().any(|c| c.id == id))
        {
            fresh.shared[i] = from_base.shared[i];
        }
    }
    fresh.per_run.clone_from(&from_base.per_run);
    let index = |name: &str| h.shared_index(&format!("{}.{name}", effect.id));
    let with = |point: &Point, values: &[(usize, f64)]| {
        let mut p = point.clone();
        for &(i, v) in values {
            p.shared[i] = h.shared[i].clamp(h.shared[i].position(v));
        }
        p
    };
    if effect.repeats() {
        let fresh_lines = match search.nuisances {
            Nuisances::All => usize::MAX,
            Nuisances::Some => FRESH_LINES,
            Nuisances::Calibrated => 0,
        };
        let origins = (&fresh, fresh_lines, &from_base);
        return periodic_starts(problem, h, effect, data, predictor, origins);
    }
    let near = search.nuisances == Nuisances::Calibrated;
    let amplitude = effect.find_role(Role::Amplitude);
    if let Some(f) = effect.resonance() {
        let name = index(&effect.parameters[f].name);
        return name.map_or(vec![from_base.clone()], |i| {
            let origins: &[&Point] = if near {
                &[&from_base]
            } else {
                &[&fresh, &from_base]
            };
            // The structure as believed, unless all else explains the data: calibrated without the mode it has been bent.
            let grid = if near { &from_base } else { &fresh };
            resonance_starts(h, i, data, predictor, grid, origins, near)
        });
    }
    let shapes: Vec<usize> = (0..effect.parameters.len())
        .filter(|&i| effect.parameters[i].role == Role::Shape)
        .collect();
    let mut out = Vec::new();
    let grid = shape_grid(problem, new, &shapes);
    if let Some(curve) = h.shared_index(&latent_name(&effect.id, 0)) {
        // A curve may have any shape: barely on, in each of its time constants.
        for shape in &grid {
            let shapes = shapes.iter().zip(shape);
            let values =
                shapes.filter_map(|(&i, v)| Some((index(&effect.parameters[i].name)?, *v)));
            let values: Vec<(usize, f64)> = values.chain([(curve, BARELY_ON)]).collect();
            out.push(with(&from_base, &values));
            if !near {
                out.push(with(&fresh, &values));
            }
        }
        return out;
    }
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
                if !near {
                    out.push(with(&fresh, &values));
                }
                // From the calibrated model, with the effect barely on.
                if sign == 0 {
                    values.pop();
                    values.push((i, search.barely_on * strength));
                    out.push(with(&from_base, &values));
                }
            } else {
                out.push(with(if near { &from_base } else { &fresh }, &values));
            }
        }
    }
    if out.is_empty() {
        out.push(from_base.clone());
    }
    if let Some(mapped) = with_place_map(problem, h, &from_base) {
        out.push(mapped);
    }
    out
}

/// Mean fall of the error of predicting break-aways by the place from which a map of them is a start.
const MAPPED: f64 = 0.2;

/// A point with the values of a profile along the belt as the break-aways have them; `None` if nothing depends on the place.
fn with_place_map(problem: &Problem, h: &Hypothesis, origin: &Point) -> Option<Point> {
    let maps = || problem.tracks.iter().map(|t| t.map.as_ref());
    let falls: Vec<f64> = maps().flatten().map(|m| m.fall.max(0.0)).collect();
    let mean = falls.iter().sum::<f64>() / falls.len() as f64;
    if !(mean >= MAPPED) {
        return None;
    }
    let mut point = origin.clone();
    let mut any = false;
    for (run, map) in maps().enumerate() {
        let Some(map) = map.filter(|m| m.fall >= MAPPED) else {
            continue;
        };
        let own = &mut point.per_run[run];
        let mut profile = values_along(&h.per_run[run], own);
        any |= !profile.is_empty();
        profile.iter_mut().for_each(|(s, g)| *g = map.at(*s));
        follow_profile(&h.per_run[run], &profile, own);
    }
    any.then_some(point)
}

/// Natural frequencies that are tried, over the typical one.
pub(crate) fn resonance_ratios() -> impl Iterator<Item = f64> {
    let all = std::iter::successors(Some(1.0 / RESONANCE_RANGE), |r| Some(r * RESONANCE_STEP));
    all.take_while(|&ratio| ratio < RESONANCE_RANGE)
}

/// Starts for a natural frequency: known to tens of percent at best, it must be met to a cycle within
/// a segment. On a fine grid only the start states are fitted, to the beginnings of some of the segments.
fn resonance_starts<'a>(
    h: &'a Hypothesis,
    parameter: usize,
    data: &Observations,
    predictor: &mut Predictor<'a>,
    grid: &Point,
    origins: &[&Point],
    near: bool,
) -> Vec<Point> {
    let every = if near {
        RESONANCE_SEGMENTS_NEAR
    } else {
        RESONANCE_SEGMENTS
    };
    let chosen: Vec<usize> = (0..data.segments.len()).step_by(every).collect();
    let segments: Vec<Segment> = chosen.iter().map(|&k| data.segments[k].clone()).collect();
    let some = Observations {
        segments: &segments,
        noise: data.noise,
        work: data.work,
    };
    let typical = h.shared[parameter].prior;
    let mut tried: Vec<(f64, f64)> = Vec::new();
    for ratio in resonance_ratios() {
        let mut point = grid.clone();
        point.shared[parameter] =
            h.shared[parameter].clamp(h.shared[parameter].position(ratio * typical));
        let point = Point {
            states: chosen.iter().map(|&k| point.states[k].clone()).collect(),
            stuck: chosen.iter().map(|&k| point.stuck[k]).collect(),
            ..point
        };
        let position = point.shared[parameter];
        let quick = FitOptions {
            share: FIRST_FIT_SHARE,
            reinitialise: false,
            parameters: false,
            ..FitOptions::search(RESONANCE_FIRST_FIT)
        };
        let fit = Fitter::new(predictor, h, &some, quick).run(point);
        tried.push((fit.trimmed, position));
    }
    tried.sort_by(|a, b| a.0.total_cmp(&b.0));
    tried
        .iter()
        .take(if near { 1 } else { RESONANCES })
        .flat_map(|&(_, position)| origins.iter().map(move |origin| (*origin, position)))
        .map(|(origin, position)| {
            let mut point = origin.clone();
            point.shared[parameter] = position;
            point
        })
        .collect()
}

/// A point in which a periodic effect stands at a line.
pub(crate) fn at(
    h: &Hypothesis,
    effect: &EffectCard,
    origin: &Point,
    line: &Line,
) -> Option<Point> {
    let name = |role: Role| {
        let parameter = &effect.parameters[effect.find_role(role)?];
        Some(format!("{}.{}", effect.id, parameter.name))
    };
    let a = h.shared_index(&name(Role::Amplitude)?)?;
    let f = h.shared_index(&name(Role::Shape)?)?;
    let p = name(Role::Phase)?;
    let mut point = origin.clone();
    point.shared[a] = h.shared[a].clamp(line.amplitude);
    point.shared[f] = h.shared[f].clamp(h.shared[f].position(line.value));
    for (run, parameters) in h.per_run.iter().enumerate() {
        if let Some(i) = parameters.iter().position(|k| k.name == p) {
            point.per_run[run][i] = line.phase[run];
        }
    }
    Some(point)
}

fn periodic_starts(
    problem: &Problem,
    h: &Hypothesis,
    effect: &EffectCard,
    data: &Observations,
    predictor: &mut Predictor,
    (fresh, fresh_lines, from_base): (&Point, usize, &Point),
) -> Vec<Point> {
    let mut lines = Vec::new();
    // A factor on friction shows in the smoothed force itself, however far the reference model is off.
    if let (Some((amplitude, shape)), Some(argument)) = (periodic(effect), argument(effect))
        && effect.parameters[amplitude].unit == "1"
    {
        let range = (effect.parameters[shape].min, effect.parameters[shape].max);
        lines = force_spectrum::lines(problem, argument, range, FORCE_LINES);
    }
    let spectrum = ResponseSpectrum::new(predictor, h, effect, data, from_base, STRIDE);
    lines.extend(spectrum.map_or(Vec::new(), |mut s| s.strongest(LINES)));
    let mut out = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        if i < fresh_lines {
            out.extend(at(h, effect, fresh, line));
        }
        out.extend(at(h, effect, from_base, line));
    }
    if out.is_empty() {
        out.push(from_base.clone());
    }
    out
}
