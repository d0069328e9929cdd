//! What a step solved says of the motion along it.

use super::nodes::dot;
use super::{Begin, Chebyshev, Nodes, Response, TERMS};
use crate::integrate::State;

/// The sliding speed over a step as a series in `speed`, and the states at its end in `end`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn expand(
    response: &Response,
    begin: &Begin,
    capacity: &Nodes,
    speed: &mut Chebyshev,
    end: &mut State,
) {
    expand_in_any(response, begin, capacity, speed, end);
}

#[inline(always)]
pub(super) fn expand_in_any(
    response: &Response,
    begin: &Begin,
    capacity: &Nodes,
    speed: &mut Chebyshev,
    end: &mut State,
) {
    let (x, sign) = (begin.state, begin.sign);
    // Two sums side by side, so that none waits long for the one before.
    let (mut even, mut odd) = ([0.0; TERMS], [0.0; TERMS]);
    even[0] = -sign * begin.belt;
    for (columns, x) in response.free_series.chunks_exact(2).zip(x.chunks_exact(2)) {
        let (a, b) = (sign * x[0], sign * x[1]);
        for k in 0..TERMS {
            even[k] = columns[0][k].mul_add(a, even[k]);
            odd[k] = columns[1][k].mul_add(b, odd[k]);
        }
    }
    for (columns, p) in response
        .forced_series
        .chunks_exact(2)
        .zip(capacity.chunks_exact(2))
    {
        for k in 0..TERMS {
            even[k] = columns[0][k].mul_add(-p[0], even[k]);
            odd[k] = columns[1][k].mul_add(-p[1], odd[k]);
        }
    }
    for k in 0..TERMS {
        speed[k] = even[k] + odd[k];
    }
    end_states(response, x, sign, capacity, end);
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
    for (j, own) in response.end.iter().enumerate() {
        for what in 0..2 {
            let forced = sign * dot(&response.forced_end[2 * j + what], capacity);
            end[2 * j + what] = own[0][what] * x[2 * j] + own[1][what] * x[2 * j + 1] - forced;
        }
    }
}
