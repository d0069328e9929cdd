//! One nonlinear force on a linear structure, by collocation: long steps of lengths whose responses are known beforehand.
//!
//! Structure: oscillators `q_j'' + 2 D_j w_j q_j' + w_j^2 q_j = g_j F(t)` seen at one place, `V = sum phi_j q_j'` in m/s. The
//! force is `F = -s p(u)` with the sliding speed `u = s (V - v0)`, its sign s and a characteristic p in N ([`Characteristic`]).
//! Over a step of length h, p along the motion is replaced by its polynomial through the Gauss-Legendre nodes
//! `theta_i h`. What each node's force does to V and to the states is a property of structure and length alone
//! ([`Response`]), so that a step is the solution of
//!
//! `u_i = s (A x)_i - s v0 - sum_j G_ij p(u_j)`,   `G_ij = integral of g(theta_i h - t) L_j(t) dt` from 0 to theta_i h,
//!
//! with `A x` the free motion of V from the states x, g the velocity V after a unit impulse, and L_j the Lagrange polynomials of
//! the nodes. The linear part is exact; at the end of the step the nodes of Gauss make the error of the force's
//! polynomial count about twice in digits (superconvergence: Hairer, Norsett, Wanner 1993, sect. II.7; for
//! the exact linear part: Hochbruck and Ostermann 2005, Appl. Numer. Math. 53:323).
//!
//! All loops run over whole lists of nodes, element by element: processors with wider
//! vectors are quicker and find the same digits.

mod characteristic;
mod chebyshev;
mod expand;
mod gauss;
mod iterate;
mod nodes;
mod oscillator;
mod response;
mod solve;
mod vary;

pub use characteristic::Characteristic;
pub use chebyshev::{
    Chebyshev, first_below_zero, from_values, integral_to, places, spread, value, value_in_any,
    without_first_root,
};
pub use expand::{Course, expand};
pub use oscillator::Oscillator;
pub use response::{LEVELS, Ladder, Response};
pub use solve::{Along, Begin, Expected, Goal, Step, Tangent, solve};
pub use vary::vary;

/// Nodes of a step.
pub const NODES: usize = 16;
/// Terms of the Chebyshev series of a step: enough for the oscillation of the structure besides the force's polynomial.
pub const TERMS: usize = 24;
/// A quantity at the nodes.
pub type Nodes = [f64; NODES];
