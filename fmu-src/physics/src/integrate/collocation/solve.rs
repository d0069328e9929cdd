//! The step itself: the force at the nodes by a fixed-point iteration about the linearised step.

use super::chebyshev::Chebyshev;
use super::gauss::gauss;
use super::response::{Ladder, Linearised, Response};
use super::{Characteristic, NODES, Nodes, TERMS};
use crate::integrate::State;

/// Iterations after which a step is too long.
const MAX_ITERATIONS: usize = 12;
/// Iterations after which each must bring the speeds nearer.
const SETTLED: usize = 5;
/// Least rate of convergence that is believed: the first iterations may come close by accident.
const LEAST_RATE: f64 = 0.05;
/// Times too rough, from which on a step is given up before it has converged.
const HOPELESS: f64 = 100.0;

/// How exact a step must be, and how far it may go.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    /// Speed in m/s that counts as nothing.
    pub speed: f64,
    /// The same as a share of the largest speed in the step.
    pub share: f64,
    /// Largest [`Step::roughness`] in m/s.
    pub roughness: f64,
    /// Speed in m/s by which a step may run beyond u = 0.
    pub overshoot: f64,
}

/// The tangent of the characteristic at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    /// The speed in m/s.
    pub speed: f64,
    /// The force in N.
    pub force: f64,
    /// The slope in N s/m.
    pub slope: f64,
}

/// What a step starts from, and what acts.
#[derive(Debug, Clone, Copy)]
pub struct Begin<'a> {
    /// The states.
    pub state: &'a State,
    /// Sign s of the sliding speed.
    pub sign: f64,
    /// Velocity v0 in m/s.
    pub belt: f64,
    /// The characteristic.
    pub law: &'a Characteristic,
    /// Its tangent at the begin or near it.
    pub tangent: Tangent,
}

/// A step solved.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Force p in N at the nodes.
    pub capacity: Nodes,
    /// Tangent of the characteristic at the last node.
    pub tangent: Tangent,
    /// Largest sliding speed in m/s at the nodes.
    pub fastest: f64,
    /// The larger of the two last Legendre coefficients of p, as the change of speed in m/s that it would make over the step
    /// as a constant force.
    pub roughness: f64,
}

/// The force at the nodes of a step; `None` where the iteration does not converge, or where the step is far too rough or runs
/// too far beyond u = 0.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn solve(ladder: &Ladder, response: &Response, begin: &Begin, goal: &Goal) -> Option<Step> {
    solve_in_any(ladder, response, begin, goal)
}

#[inline(always)]
fn solve_in_any(ladder: &Ladder, response: &Response, begin: &Begin, goal: &Goal) -> Option<Step> {
    let (law, mobility) = (begin.law, ladder.mobility());
    let free = free_speed(response, begin);
    let Tangent {
        speed,
        force,
        slope,
    } = begin.tangent;
    let mut linear = response.linearised(slope, slope, mobility);
    let mut base = product(&linear.inverse, &free);
    let mut u = corrected(linear, &base, &[force; NODES], &[speed; NODES]);
    if !(largest(&u.map(|u| -u)) < goal.overshoot) {
        return None;
    }
    let mut before = f64::INFINITY;
    for iteration in 0..MAX_ITERATIONS {
        let (force, slope) = law.at(&u);
        let rough = || roughness(&force) * mobility * response.length;
        // Far from rest the first speeds tell already how rough the step will be.
        if iteration == 1 && rough() > HOPELESS * goal.roughness {
            return None;
        }
        if iteration == 1 || iteration == 2 {
            let nearer = response.linearised(slope[0], slope[NODES - 1], mobility);
            if !std::ptr::eq(nearer, linear) {
                linear = nearer;
                base = product(&linear.inverse, &free);
            }
        }
        let next = corrected(linear, &base, &force, &u);
        let mut changes = next;
        for i in 0..NODES {
            changes[i] = (changes[i] - u[i]).abs();
        }
        let change = largest(&changes);
        let last = u[NODES - 1];
        u = next;
        let shrinks = change < 0.5 * before || iteration < SETTLED;
        if !(shrinks && change.is_finite()) {
            return None;
        }
        // The forces belong to the speeds before, whose error was this change; the step takes off as much again.
        let rate = if iteration == 0 {
            1.0
        } else {
            (change / before).max(LEAST_RATE)
        };
        if change * rate < goal.speed {
            let fastest = largest(&u.map(f64::abs));
            if change * rate < goal.share * fastest {
                return Some(Step {
                    capacity: force,
                    tangent: Tangent {
                        speed: last,
                        force: force[NODES - 1],
                        slope: slope[NODES - 1],
                    },
                    fastest,
                    roughness: rough(),
                });
            }
        }
        before = change;
    }
    None
}

/// The speeds of the linearised step where the forces at speeds `u` are given.
#[inline(always)]
fn corrected(linear: &Linearised, base: &Nodes, force: &Nodes, u: &Nodes) -> Nodes {
    let mut rest = *force;
    for i in 0..NODES {
        rest[i] = (-linear.slopes[i]).mul_add(u[i], rest[i]);
    }
    let mut next = product(&linear.response, &rest);
    for i in 0..NODES {
        next[i] = base[i] - next[i];
    }
    next
}

/// Sliding speed at the nodes without friction.
#[inline(always)]
fn free_speed(response: &Response, begin: &Begin) -> Nodes {
    let mut free = [-begin.sign * begin.belt; NODES];
    for (column, x) in response.free.iter().zip(begin.state) {
        let x = begin.sign * x;
        for i in 0..NODES {
            free[i] = column[i].mul_add(x, free[i]);
        }
    }
    free
}

/// Matrix, given by its columns, times a list. Four sums side by side, so that none waits long for the one before.
#[inline(always)]
fn product(columns: &[Nodes; NODES], x: &Nodes) -> Nodes {
    let x = apart(*x);
    let (mut a, mut b) = ([0.0; NODES], [0.0; NODES]);
    let (mut c, mut d) = ([0.0; NODES], [0.0; NODES]);
    for j in (0..NODES).step_by(4) {
        for i in 0..NODES {
            a[i] = columns[j][i].mul_add(x[j], a[i]);
            b[i] = columns[j + 1][i].mul_add(x[j + 1], b[i]);
            c[i] = columns[j + 2][i].mul_add(x[j + 2], c[i]);
            d[i] = columns[j + 3][i].mul_add(x[j + 3], d[i]);
        }
    }
    for i in 0..NODES {
        a[i] = (a[i] + b[i]) + (c[i] + d[i]);
    }
    apart(a)
}

/// Keeps a sum of columns apart from what is done with it: together, the compiler forms vectors of two for the reductions
/// that follow, and the sums with them.
#[inline(always)]
fn apart(values: Nodes) -> Nodes {
    std::hint::black_box(values)
}

#[inline(always)]
fn roughness(force: &Nodes) -> f64 {
    let [a, b] = gauss().tail.each_ref().map(|row| {
        let mut parts = *row;
        for i in 0..NODES {
            parts[i] *= force[i];
        }
        total(&parts).abs()
    });
    a.max(b)
}

/// The sum, halves added to halves: an order that vectors of any width keep.
#[inline(always)]
pub(super) fn total(values: &Nodes) -> f64 {
    halves(values, |a, b| a + b)
}

#[inline(always)]
fn largest(values: &Nodes) -> f64 {
    halves(values, |a, b| if a > b { a } else { b })
}

#[inline(always)]
fn halves(values: &Nodes, join: impl Fn(f64, f64) -> f64) -> f64 {
    let mut v = *values;
    let mut n = NODES / 2;
    while n > 0 {
        for i in 0..n {
            v[i] = join(v[i], v[i + n]);
        }
        n /= 2;
    }
    v[0]
}

/// The sliding speed over a step as a series, and the states at its end in `end`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn expand(response: &Response, begin: &Begin, capacity: &Nodes, end: &mut State) -> Chebyshev {
    expand_in_any(response, begin, capacity, end)
}

#[inline(always)]
fn expand_in_any(
    response: &Response,
    begin: &Begin,
    capacity: &Nodes,
    end: &mut State,
) -> Chebyshev {
    let (x, sign) = (begin.state, begin.sign);
    let mut speed = [0.0; TERMS];
    speed[0] = -sign * begin.belt;
    for (column, x) in response.free_series.iter().zip(x) {
        let x = sign * x;
        for k in 0..TERMS {
            speed[k] = column[k].mul_add(x, speed[k]);
        }
    }
    for (column, p) in response.forced_series.iter().zip(capacity) {
        for k in 0..TERMS {
            speed[k] = column[k].mul_add(-p, speed[k]);
        }
    }
    for (j, own) in response.end.iter().enumerate() {
        for what in 0..2 {
            let row = &response.forced_end[2 * j + what];
            let mut parts = *capacity;
            for i in 0..NODES {
                parts[i] *= row[i];
            }
            let forced = sign * total(&parts);
            end[2 * j + what] = own[0][what] * x[2 * j] + own[1][what] * x[2 * j + 1] - forced;
        }
    }
    speed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::MAX_STATES;
    use crate::integrate::collocation::Oscillator;

    // Source: the same functions compiled for the least processor, where every product is fused by the library.
    #[test]
    fn val_vectors_of_any_width_find_the_same_digits() {
        let oscillator = |frequency, seen: f64| Oscillator {
            frequency,
            damping: 0.001,
            seen,
            gain: seen / 0.4,
        };
        let ladder = Ladder::new(vec![oscillator(500.0, 2.0), oscillator(3200.0, -2.0)]);
        let law = Characteristic {
            constant: 16.5,
            linear: 0.3,
            weight: [16.5, 16.5, 16.5],
            rate: [50.0, 0.25],
            squared: false,
        };
        let goal = Goal {
            speed: 1e-12,
            share: 1e-8,
            roughness: 1e-6,
            overshoot: 0.01,
        };
        let mut solved = 0;
        for level in 0..8 {
            for i in 0..40 {
                let mut state = [0.0; MAX_STATES];
                state[0] = 1e-3 - 5e-5 * f64::from(i);
                state[1] = -0.02 * f64::from(i);
                state[3] = 0.01 * f64::from(i % 7);
                let speed = 0.1 - 2.0 * state[1] + 2.0 * state[3];
                let begin = Begin {
                    state: &state,
                    sign: -1.0,
                    belt: 0.1,
                    law: &law,
                    tangent: law.tangent(speed),
                };
                let response = ladder.response(level);
                let here = solve(&ladder, response, &begin, &goal);
                assert_eq!(here, solve_in_any(&ladder, response, &begin, &goal));
                let Some(step) = here else { continue };
                solved += 1;
                let (mut a, mut b) = ([0.0; MAX_STATES], [0.0; MAX_STATES]);
                let wide = expand(response, &begin, &step.capacity, &mut a);
                let narrow = expand_in_any(response, &begin, &step.capacity, &mut b);
                assert_eq!((wide, a), (narrow, b));
            }
        }
        assert!(solved > 100, "{solved}");
    }
}
