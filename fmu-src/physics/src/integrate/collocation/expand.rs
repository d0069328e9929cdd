//! What a step solved says of the motion along it.

use super::chebyshev::{dot, spread};
use super::nodes::apart;
use super::response::{BLOCK, Response};
use super::{Begin, Chebyshev, NODES, Nodes, TERMS};
use crate::integrate::{MAX_STATES, State};

/// The motion along a step.
#[derive(Debug, Clone, PartialEq)]
#[repr(C, align(64))]
pub struct Course {
    /// Sliding speed in m/s.
    pub speed: Chebyshev,
    /// The states at the end.
    pub end: State,
    /// How far in m/s the speed can be from its mean.
    pub spread: f64,
    /// Speed in m/s at the end, and its derivative by theta.
    pub last: [f64; 2],
}

impl Course {
    /// No motion at all.
    pub const REST: Self = Self {
        speed: [0.0; TERMS],
        spread: 0.0,
        last: [0.0; 2],
        end: [0.0; MAX_STATES],
    };
}

/// `2 k^2`, the derivative of T_k by theta at theta = 1.
const STEEPNESS: Chebyshev = {
    let mut s = [0.0; TERMS];
    let mut k = 0;
    while k < TERMS {
        s[k] = (2 * k * k) as f64;
        k += 1;
    }
    s
};

/// The motion along a step with the force p in N at its nodes, into `course`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn expand(response: &Response, begin: &Begin, capacity: &Nodes, course: &mut Course) {
    expand_in_any(response, begin, capacity, course);
}

#[inline(always)]
pub(super) fn expand_in_any(
    response: &Response,
    begin: &Begin,
    capacity: &Nodes,
    course: &mut Course,
) {
    let (x, sign) = (begin.state, begin.sign);
    // Two sums side by side, so that none waits long for the one before.
    let (mut even, mut odd) = ([0.0; TERMS], [0.0; TERMS]);
    even[0] = -sign * begin.belt;
    for (columns, x) in response.free_series.chunks_exact(2).zip(x.chunks_exact(2)) {
        let (a, b) = (sign * x[0], sign * x[1]);
        for k in 0..TERMS {
            even[k] = columns[0].0[k].mul_add(a, even[k]);
            odd[k] = columns[1].0[k].mul_add(b, odd[k]);
        }
    }
    let forced = &response.forced_series.0;
    for (columns, p) in forced.chunks_exact(2).zip(capacity.chunks_exact(2)) {
        for k in 0..TERMS {
            even[k] = columns[0][k].mul_add(-p[0], even[k]);
            odd[k] = columns[1][k].mul_add(-p[1], odd[k]);
        }
    }
    for k in 0..TERMS {
        even[k] += odd[k];
    }
    let speed = apart(even);
    course.speed = speed;
    course.spread = spread(&speed);
    course.last = [dot(&speed, &[1.0; TERMS]), dot(&speed, &STEEPNESS)];
    end_states(response, x, sign, capacity, &mut course.end);
}

/// The states at the end of a step from `x` with the forces `-sign capacity` at the nodes.
#[inline(always)]
pub(super) fn end_states(
    response: &Response,
    x: &State,
    sign: f64,
    capacity: &Nodes,
    end: &mut State,
) {
    for (b, block) in response.end.iter().enumerate() {
        let (mut even, mut odd) = ([0.0; BLOCK], [0.0; BLOCK]);
        for node in (0..NODES).step_by(2) {
            for i in 0..BLOCK {
                even[i] = block.forced.0[node][i].mul_add(capacity[node], even[i]);
                odd[i] = block.forced.0[node + 1][i].mul_add(capacity[node + 1], odd[i]);
            }
        }
        let from = b * BLOCK;
        for i in 0..BLOCK {
            // q and q' of one oscillator are neighbours.
            let free = block.own[i].mul_add(x[from + i], block.other[i] * x[from + (i ^ 1)]);
            end[from + i] = free - sign * (even[i] + odd[i]);
        }
    }
}
