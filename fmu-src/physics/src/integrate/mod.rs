//! Integration of smooth pieces of motion; knows only its own trait [`System`].

#[cfg(feature = "tangent")]
use crate::real::polynomial;
use crate::real::{Real, ZERO, real};
#[cfg(not(feature = "tangent"))]
pub mod collocation;
pub mod dop853;
mod dop853_coefficients;
pub mod linear;
pub mod roots;
pub mod series;
pub mod taylor;

/// Most states a model may have; a multiple of [`LANES`].
pub const MAX_STATES: usize = if cfg!(feature = "tangent") {
    // Derivatives make a state nine times as large, and every step copies some.
    12
} else {
    24
};
/// States are processed in groups of this size, so that the compiler can use vector instructions.
pub const LANES: usize = 4;
/// A state vector; entries beyond the dimension are zero.
pub type State = [Real; MAX_STATES];
/// Magnitudes of the states.
pub type Scales = [f64; MAX_STATES];

/// A smooth system `x' = f(t, x)`.
pub trait System {
    /// Number of states.
    fn dimension(&self) -> usize;
    /// Writes the rates f(t, x).
    fn rates(&self, t: Real, x: &State, rates: &mut State);
}

/// A quantity that is linear in the state, `offset + row x`, read off its values.
pub fn row_of(dimension: usize, quantity: impl Fn(&State) -> Real) -> (State, Real) {
    let mut probe = [ZERO; MAX_STATES];
    let offset = quantity(&probe);
    let mut row = [ZERO; MAX_STATES];
    for i in 0..dimension {
        probe[i] = real(1.0);
        row[i] = quantity(&probe) - offset;
        probe[i] = ZERO;
    }
    (row, offset)
}

/// Highest degree of a segment's polynomials.
pub const MAX_DEGREE: usize = 20;

/// A piece of motion on [start, end] as polynomials in `theta = (t - start) / length`.
#[derive(Debug, Clone)]
pub struct Segment {
    /// Start time in s.
    pub start: Real,
    /// End time in s up to which the segment is to be used.
    pub end: Real,
    /// Length in s on which theta runs from 0 to 1; `end - start` or more.
    pub length: f64,
    /// Degree of the polynomials.
    pub degree: usize,
    /// Number of states.
    pub dimension: usize,
    /// Coefficients, power by power.
    pub coefficients: [State; MAX_DEGREE + 1],
}

impl Segment {
    /// A segment of no length at a given state.
    pub fn point(t: Real, x: &State, dimension: usize) -> Self {
        let mut coefficients = [[ZERO; MAX_STATES]; MAX_DEGREE + 1];
        coefficients[0] = *x;
        Self {
            start: t,
            end: t,
            length: 1.0,
            degree: 0,
            dimension,
            coefficients,
        }
    }

    /// The normalised time of `t`.
    #[inline]
    pub fn theta(&self, t: Real) -> Real {
        (t - self.start) / self.length
    }

    /// State at normalised time `theta`: of the place, its derivative alone is needed.
    #[cfg(feature = "tangent")]
    pub fn state_at(&self, theta: Real, x: &mut State) {
        for i in 0..self.dimension {
            let coefficients = self.coefficients[..=self.degree].iter();
            x[i] = polynomial(coefficients.map(|row| &row[i]), theta);
        }
    }

    /// State at normalised time `theta`, by Horner's rule on the even and the odd powers.
    #[cfg(not(feature = "tangent"))]
    #[inline]
    pub fn state_at(&self, theta: Real, x: &mut State) {
        let square = theta * theta;
        for group in 0..self.dimension.div_ceil(LANES) {
            let lane = group * LANES;
            let coefficient = |power: usize| -> &[Real; LANES] {
                let c = &self.coefficients[power][lane..lane + LANES];
                c.try_into().expect("LANES wide")
            };
            let (mut even, mut odd) = ([ZERO; LANES], [ZERO; LANES]);
            let pairs = self.degree.div_ceil(2);
            if self.degree.is_multiple_of(2) {
                even = *coefficient(self.degree);
            }
            for pair in (0..pairs).rev() {
                let (low, high) = (coefficient(2 * pair), coefficient(2 * pair + 1));
                for i in 0..LANES {
                    even[i] = even[i] * square + low[i];
                    odd[i] = odd[i] * square + high[i];
                }
            }
            for i in 0..LANES {
                x[lane + i] = even[i] + theta * odd[i];
            }
        }
    }

    /// The polynomial of `offset(theta) + sum_i row_i x_i`, for an offset given by its coefficients; the row may be
    /// longer than there are states.
    pub fn combine(&self, row: &[Real], offset: &[Real]) -> [Real; MAX_DEGREE + 1] {
        let mut out = [ZERO; MAX_DEGREE + 1];
        out[..offset.len()].copy_from_slice(offset);
        for (i, r) in row.iter().enumerate().take(self.dimension) {
            if *r == 0.0 {
                continue;
            }
            for (sum, c) in out.iter_mut().zip(&self.coefficients).take(self.degree + 1) {
                *sum += r * c[i];
            }
        }
        out
    }
}
