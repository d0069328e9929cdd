//! A periodic motion followed along a parameter, through folds, with the kinds of its bifurcations.

use super::super::Subject;
use super::return_map::ReturnMap;
use super::shooting::{Orbit, OrbitError, derivative, half, orbit, shoot};
use crate::error::PhysicsError;
use nalgebra::{DMatrix, DVector};

/// Steps along the branch, in units of the parameter's range and of the amplitude.
const FIRST: f64 = 0.005;
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 1e-6;
/// Newton steps per orbit, and those after which the next step is longer.
const STEPS: usize = 8;
const EASY: usize = 4;
/// Residual as a share of the amplitude.
const CLOSED: f64 = 1e-10;
/// Difference of the parameter for its derivative, as a share of the range, and of coordinates, as one of the amplitude.
const DIFFERENCE: f64 = 1e-6;
const COORDINATE_DIFFERENCE: f64 = 2e-5;
/// Orbits after which a branch is long enough.
const MOST: usize = 3000;

/// A model at a value of the parameter.
pub type At<'a> = dyn Fn(f64) -> Result<Subject, PhysicsError> + Sync + 'a;

/// An orbit with its parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchPoint {
    /// Value of the parameter.
    pub parameter: f64,
    /// The orbit there.
    pub orbit: Orbit,
}

/// What happens to an orbit as the parameter changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BranchKind {
    /// A multiplier +1: the branch turns back (or meets another).
    Fold,
    /// A multiplier -1: a motion of twice the period branches off.
    Flip,
    /// A complex pair of magnitude one: a motion with a second frequency branches off.
    NeimarkSacker,
    /// The sequence of stick and slip changes: the motion grazes a border of stick, and its multipliers may jump.
    Grazing {
        /// The sequences before and after.
        from: String,
        /// After.
        to: String,
        /// Whether the motion becomes stable or unstable there.
        changes_stability: bool,
    },
}

impl BranchKind {
    /// The word for files.
    pub fn word(&self) -> &'static str {
        match self {
            BranchKind::Fold => "fold",
            BranchKind::Flip => "flip",
            BranchKind::NeimarkSacker => "neimark_sacker",
            BranchKind::Grazing { .. } => "grazing",
        }
    }
}

/// A bifurcation between two orbits of a branch.
#[derive(Debug, Clone, PartialEq)]
pub struct Bifurcation {
    /// Its kind.
    pub kind: BranchKind,
    /// Value of the parameter, by interpolation.
    pub parameter: f64,
    /// Distance of the two orbits in the parameter.
    pub within: f64,
    /// Tip displacement at the peak, in m.
    pub displacement: f64,
}

/// Why a branch ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BranchEnd {
    /// The range of the parameter does.
    Range,
    /// No orbit is found beyond, however short the step: the motion meets a border where it ceases to exist.
    BreaksOff,
    /// It is long enough.
    Long,
}

/// A branch, in the order of its course.
#[derive(Debug, Clone, PartialEq)]
pub struct Branch {
    /// Its orbits.
    pub points: Vec<BranchPoint>,
    /// Where something happens.
    pub bifurcations: Vec<Bifurcation>,
    /// Why it ends, at its begin and at its end.
    pub ends: (BranchEnd, BranchEnd),
}

/// Follows the orbit near `guess` at `parameter` both ways within `range`.
///
/// # Errors
/// No orbit at the begin.
pub fn continue_branch(
    at: &At,
    parameter: f64,
    guess: &crate::integrate::State,
    returns: usize,
    range: (f64, f64),
) -> Result<Branch, OrbitError> {
    let first = BranchPoint {
        orbit: shoot(&at(parameter)?, guess, returns)?,
        parameter,
    };
    let (mut down, end_down) = half_branch(at, &first, returns, range, -1.0);
    let (up, end_up) = half_branch(at, &first, returns, range, 1.0);
    down.reverse();
    let mut points = down;
    points.push(first);
    points.extend(up);
    Ok(Branch {
        bifurcations: bifurcations(&points),
        points,
        ends: (end_down, end_up),
    })
}

/// The orbits from `first` on in one direction.
fn half_branch(
    at: &At,
    first: &BranchPoint,
    returns: usize,
    range: (f64, f64),
    direction: f64,
) -> (Vec<BranchPoint>, BranchEnd) {
    let mut points: Vec<BranchPoint> = Vec::new();
    let width = range.1 - range.0;
    let mut length = FIRST;
    let mut before: Option<DVector<f64>> = None;
    let scale = first.orbit.amplitude;
    loop {
        let last = points.last().unwrap_or(first);
        if points.len() == MOST {
            return (points, BranchEnd::Long);
        }
        let Ok(subject) = at(last.parameter) else {
            return (points, BranchEnd::Range);
        };
        let Ok(map) = ReturnMap::new(&subject, returns) else {
            return (points, BranchEnd::BreaksOff);
        };
        let here = place(&map, last, width, scale);
        // The direction of the last step, at the begin the parameter's.
        let n = here.len();
        let tangent = match &before {
            Some(before) => (&here - before).normalize(),
            None => DVector::from_fn(n, |i, _| if i + 1 == n { direction } else { 0.0 }),
        };
        let mut found = None;
        while length >= SHORTEST {
            let guess = &here + length * &tangent;
            if let Some((next, steps)) = correct(at, &guess, &tangent, returns, width, scale) {
                let jump = (place(&map, &next, width, scale) - &here).norm();
                // A correction far from the prediction has landed on another branch.
                if jump < 2.0 * length {
                    found = Some((next, steps));
                    break;
                }
            }
            length *= 0.5;
        }
        let Some((next, steps)) = found else {
            return (points, BranchEnd::BreaksOff);
        };
        if next.parameter < range.0 || next.parameter > range.1 {
            return (points, BranchEnd::Range);
        }
        if steps <= EASY {
            length = (1.4 * length).min(LONGEST);
        }
        before = Some(here);
        points.push(next);
    }
}

/// An orbit as a point: coordinates over the amplitude, parameter over the range.
fn place(map: &ReturnMap, point: &BranchPoint, width: f64, scale: f64) -> DVector<f64> {
    let y = map.coordinates(&point.orbit.state) / scale;
    y.push(point.parameter / width)
}

/// Newton's method on the plane through `guess` across `tangent`; the orbit and the steps taken.
fn correct(
    at: &At,
    guess: &DVector<f64>,
    tangent: &DVector<f64>,
    returns: usize,
    width: f64,
    scale: f64,
) -> Option<(BranchPoint, usize)> {
    let n = guess.len() - 1;
    let mut z = guess.clone();
    for step in 0..STEPS {
        let parameter = z[n] * width;
        let mut map = ReturnMap::new(&at(parameter).ok()?, returns).ok()?;
        let y = z.rows(0, n) * scale;
        let image = map.apply(&map.state(&y)).ok()?;
        let residual = (map.coordinates(&image.state) - &y) / scale;
        if residual.norm() < CLOSED && (step > 0) {
            let orbit = orbit(&mut map, &y, &image).ok()?;
            return Some((BranchPoint { parameter, orbit }, step));
        }
        let slope = derivative(&mut map, &y, COORDINATE_DIFFERENCE * half(&image)).ok()?;
        let shifted = |by: f64| {
            let mut map = ReturnMap::new(&at((z[n] + by) * width).ok()?, returns).ok()?;
            let image = map.apply(&map.state(&y)).ok()?;
            Some(map.coordinates(&image.state) / scale)
        };
        let by_parameter = (shifted(DIFFERENCE)? - shifted(-DIFFERENCE)?) / (2.0 * DIFFERENCE);
        let mut system = DMatrix::zeros(n + 1, n + 1);
        system
            .view_mut((0, 0), (n, n))
            .copy_from(&(DMatrix::identity(n, n) - slope));
        system.view_mut((0, n), (n, 1)).copy_from(&-by_parameter);
        system
            .view_mut((n, 0), (1, n + 1))
            .copy_from(&tangent.transpose());
        let across = tangent.dot(&(guess - &z));
        z += system.lu().solve(&residual.push(across))?;
    }
    None
}

/// How many multipliers lie outside the unit circle: real above +1, real below -1, others.
fn outside(orbit: &Orbit) -> (usize, usize, usize) {
    let count = |f: &dyn Fn(f64, f64) -> bool| {
        let all = orbit.multipliers.iter();
        all.filter(|m| m.norm() > 1.0 && f(m.re, m.im)).count()
    };
    let real = |im: f64| im.abs() < 1e-9;
    (
        count(&|re, im| real(im) && re > 0.0),
        count(&|re, im| real(im) && re < 0.0),
        count(&|_, im| !real(im)),
    )
}

/// What happens between the orbits of a branch.
fn bifurcations(points: &[BranchPoint]) -> Vec<Bifurcation> {
    let mut found = Vec::new();
    for (i, pair) in points.windows(2).enumerate() {
        let (a, b) = (&pair[0], &pair[1]);
        let (la, lb) = (a.orbit.largest() - 1.0, b.orbit.largest() - 1.0);
        let share = if la * lb < 0.0 { la / (la - lb) } else { 0.5 };
        let between = |x: f64, y: f64| x + share * (y - x);
        let mut add = |kind: BranchKind| {
            found.push(Bifurcation {
                kind,
                parameter: between(a.parameter, b.parameter),
                within: (b.parameter - a.parameter).abs(),
                displacement: between(a.orbit.displacement, b.orbit.displacement),
            });
        };
        let (pa, ma, ca) = outside(&a.orbit);
        let (pb, mb, cb) = outside(&b.orbit);
        let changes = (pa + ma + ca) != (pb + mb + cb);
        if a.orbit.sequence != b.orbit.sequence {
            add(BranchKind::Grazing {
                from: a.orbit.sequence.clone(),
                to: b.orbit.sequence.clone(),
                changes_stability: changes,
            });
            continue;
        }
        let turns =
            i > 0 && (b.parameter - a.parameter) * (a.parameter - points[i - 1].parameter) < 0.0;
        if turns {
            add(BranchKind::Fold);
        } else if changes {
            let difference = (pa + ma + ca).abs_diff(pb + mb + cb);
            if difference == 2 && pa == pb && ma == mb {
                add(BranchKind::NeimarkSacker);
            } else if ma != mb {
                add(BranchKind::Flip);
            } else if pa != pb && !next_turns(points, i) {
                add(BranchKind::Fold);
            }
        }
    }
    found
}

/// Whether the branch turns back one orbit later, where the fold is counted.
fn next_turns(points: &[BranchPoint], i: usize) -> bool {
    match points.get(i + 2) {
        Some(c) => {
            (c.parameter - points[i + 1].parameter)
                * (points[i + 1].parameter - points[i].parameter)
                < 0.0
        }
        None => false,
    }
}
