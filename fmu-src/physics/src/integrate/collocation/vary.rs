//! The variational equation over a step: what a small difference at its begin has become.

use super::expand::end_states;
use super::iterate::{corrected, free_speed};
use super::nodes::{distance, largest};
use super::response::{Ladder, Response};
use super::{NODES, Nodes};
use crate::integrate::State;

/// Iterations at most; each brings the difference nearer by as much as those of the step itself.
const MAX_ITERATIONS: usize = 24;
/// Share of the largest difference that may be left.
const LEFT: f64 = 1e-10;

/// What a difference `x` of the states at the begin of a step has become at its `end`; the change of friction in N at the nodes.
///
/// With the slopes p'_i at the nodes of the step solved,
/// `du_i = s (A dx)_i - sum_j G_ij p'_j du_j`,
/// solved by fixed points about the linearised step. `sign` as in [`Begin`](super::Begin).
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn vary(
    ladder: &Ladder,
    response: &Response,
    slope: &Nodes,
    sign: f64,
    x: &State,
    end: &mut State,
) -> Nodes {
    let free = free_speed(response, x, sign, 0.0);
    let linear = response.linearised(slope[0], slope[NODES - 1], ladder.mobility());
    let mut u = free;
    let mut force = [0.0; NODES];
    for _ in 0..MAX_ITERATIONS {
        for i in 0..NODES {
            force[i] = slope[i] * u[i];
        }
        let next = corrected(linear, &free, &force, &u);
        let change = distance(&next, &u);
        u = next;
        if !(change > LEFT * largest(&u.map(f64::abs))) {
            break;
        }
    }
    end_states(response, x, sign, &force, end);
    force
}
