//! The iteration that solves a step: fixed points about the linearised step.

use super::gauss::gauss;
use super::nodes::{distance, dot, largest, product};
use super::response::{Ladder, Linearised, Response};
use super::{Along, Begin, Characteristic, Goal, NODES, Nodes, Step};
use crate::integrate::State;

/// Iterations after which a step is too long.
const MAX_ITERATIONS: usize = 12;
/// Iterations after which each must bring the speeds nearer.
const SETTLED: usize = 5;
/// Least rate of convergence that is believed: the first iterations may come close by accident.
const LEAST_RATE: f64 = 0.05;
/// Most iterations about a step solved before, and how far from it they are tried, as a share of the speed over which the
/// characteristic changes most: as far as [`Characteristic::third_near`] holds.
const MAX_NEAR: usize = 6;
const NEAR: f64 = 0.5;
/// Times too rough, from which on a step is given up before it has converged.
const HOPELESS: f64 = 100.0;

/// A step, and where its iteration stands.
pub(super) struct Iteration<'a> {
    response: &'a Response,
    law: &'a Characteristic,
    goal: &'a Goal,
    mobility: f64,
    /// Change of speed over the step per constant force, in m/s per N.
    unit: f64,
    /// Sliding speed in m/s at the nodes without friction.
    free: Nodes,
    /// The linearised step.
    linear: &'a Linearised,
    /// Sliding speed in m/s at the nodes.
    u: Nodes,
    /// Its last change in m/s, and the rate at which changes shrink.
    change: f64,
    rate: f64,
}

impl<'a> Iteration<'a> {
    /// Starts from the linearised step with these slopes at the first and the last node, and these forces at these speeds.
    #[inline(always)]
    pub(super) fn start(
        (ladder, response): (&Ladder, &'a Response),
        begin: &Begin<'a>,
        goal: &'a Goal,
        [first, last]: [f64; 2],
        (force, speed): (&Nodes, &Nodes),
    ) -> Self {
        let free = free_speed(response, begin.state, begin.sign, begin.belt);
        let mobility = ladder.mobility();
        let linear = response.linearised(first, last, mobility);
        let u = corrected(linear, &free, force, speed);
        Self {
            response,
            law: begin.law,
            goal,
            mobility,
            unit: mobility * response.length,
            free,
            linear,
            u,
            change: distance(&u, speed),
            rate: 1.0,
        }
    }

    /// Whether the contact slides the other way by more than is allowed.
    #[inline(always)]
    pub(super) fn runs_over(&self) -> bool {
        !(largest(&self.u.map(|u| -u)) < self.goal.overshoot)
    }

    /// Iterates with the characteristic's Taylor polynomial of degree 2 about the speeds of a step solved before, up to what
    /// it leaves out, `|p'''| |u - u_known|^3 / 6`; true where that does not matter and the step is solved.
    #[inline(always)]
    pub(super) fn about(&mut self, known: &Along, renew: bool, step: &mut Step) -> bool {
        let third = known.third * self.unit / 6.0;
        let mut apart = self.change;
        if !(apart < NEAR * self.law.scale()) {
            return false;
        }
        for iteration in 1..=MAX_NEAR {
            let (mut force, mut slope) = (known.force, known.slope);
            for i in 0..NODES {
                let e = self.u[i] - known.speed[i];
                let rise = e * known.half_bend[i];
                force[i] = e.mul_add(slope[i] + rise, force[i]);
                slope[i] += 2.0 * rise;
            }
            let before = self.change;
            self.go_on(&force);
            if !(self.change < before) {
                return false;
            }
            self.rate = (self.change / before).max(LEAST_RATE);
            let left_out = third * apart * apart * apart;
            apart += self.change;
            if self.is_done(&force, step) {
                step.slope = slope;
                step.iterations = iteration;
                step.along = renew.then(|| self.along(self.u, self.law.at(&self.u)));
                return left_out < self.goal.speed;
            }
            if self.change * self.rate < left_out && left_out > self.goal.speed {
                return false;
            }
        }
        false
    }

    /// Iterates with the characteristic itself; true where the step is solved. A step of which little is known may be given
    /// up early, and has its slopes chosen anew.
    #[inline(always)]
    pub(super) fn iterate(&mut self, is_new: bool, step: &mut Step) -> bool {
        for iteration in 0..MAX_ITERATIONS {
            let (force, slope, half_bend) = self.law.at(&self.u);
            if is_new {
                // Far from rest the first speeds tell already how rough the step will be.
                if iteration == 1 && roughness(&force) * self.unit > HOPELESS * self.goal.roughness
                {
                    return false;
                }
                if iteration == 1 || iteration == 2 {
                    let (first, last) = (slope[0], slope[NODES - 1]);
                    self.linear = self.response.linearised(first, last, self.mobility);
                }
            }
            let (speed, before) = (self.u, self.change);
            self.go_on(&force);
            let shrinks = self.change < 0.5 * before || iteration < SETTLED;
            if !(shrinks && self.change.is_finite()) {
                return false;
            }
            // The change before the first was another kind of step.
            if iteration > 0 {
                self.rate = (self.change / before).max(LEAST_RATE);
            }
            if self.is_done(&force, step) {
                step.slope = slope;
                step.along = Some(self.along(speed, (force, slope, half_bend)));
                return true;
            }
        }
        false
    }

    #[inline(always)]
    fn along(&self, speed: Nodes, (force, slope, half_bend): (Nodes, Nodes, Nodes)) -> Along {
        Along {
            speed,
            force,
            slope,
            half_bend,
            third: self.law.third_near(&half_bend),
        }
    }

    /// The next speeds, from the forces at the present ones.
    #[inline(always)]
    fn go_on(&mut self, force: &Nodes) {
        let next = corrected(self.linear, &self.free, force, &self.u);
        self.change = distance(&next, &self.u);
        self.u = next;
    }

    /// Whether the speeds are as good as wanted. The forces belong to those before, whose error was the last change; the step
    /// takes off as much again.
    #[inline(always)]
    fn is_done(&self, force: &Nodes, step: &mut Step) -> bool {
        let error = self.change * self.rate;
        if !(error < self.goal.speed) {
            return false;
        }
        step.fastest = largest(&self.u.map(f64::abs));
        step.capacity = *force;
        step.roughness = roughness(force) * self.unit;
        error < self.goal.share * step.fastest
    }
}

/// The speeds of the linearised step where the forces at speeds `u` are given, and the speeds `free` without friction.
#[inline(always)]
pub(super) fn corrected(linear: &Linearised, free: &Nodes, force: &Nodes, u: &Nodes) -> Nodes {
    let mut pull = *force;
    for i in 0..NODES {
        pull[i] = linear.slopes[i].mul_add(free[i] - u[i], pull[i]);
    }
    let mut next = product(&linear.response, &pull);
    for i in 0..NODES {
        next[i] = free[i] - next[i];
    }
    next
}

/// Sliding speed at the nodes without friction.
#[inline(always)]
pub(super) fn free_speed(response: &Response, state: &State, sign: f64, belt: f64) -> Nodes {
    let mut free = [-sign * belt; NODES];
    for (column, x) in response.free.iter().zip(state) {
        let x = sign * x;
        for i in 0..NODES {
            free[i] = column.0[i].mul_add(x, free[i]);
        }
    }
    free
}

#[inline(always)]
fn roughness(force: &Nodes) -> f64 {
    let [a, b] = &gauss().tail;
    let (a, b) = (dot(a, force).abs(), dot(b, force).abs());
    if a > b { a } else { b }
}
