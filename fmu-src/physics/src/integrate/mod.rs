//! Integration of smooth pieces of motion; knows only its own trait [`System`].

pub mod dop853;
mod dop853_coefficients;
pub mod linear;
pub mod roots;
pub mod series;
pub mod taylor;

/// Most states a model may have; a multiple of [`LANES`].
pub const MAX_STATES: usize = 24;
/// States are processed in groups of this size, so that the compiler can use vector instructions.
pub const LANES: usize = 4;
/// A state vector; entries beyond the dimension are zero.
pub type State = [f64; MAX_STATES];

/// A smooth system `x' = f(t, x)`.
pub trait System {
    /// Number of states.
    fn dimension(&self) -> usize;
    /// Writes the rates f(t, x).
    fn rates(&self, t: f64, x: &State, rates: &mut State);
}

/// Highest degree of a segment's polynomials.
pub const MAX_DEGREE: usize = 20;

/// A piece of motion on [start, end] as polynomials in `theta = (t - start) / length`.
#[derive(Debug, Clone)]
pub struct Segment {
    /// Start time in s.
    pub start: f64,
    /// End time in s up to which the segment is to be used.
    pub end: f64,
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
    pub fn point(t: f64, x: &State, dimension: usize) -> Self {
        let mut coefficients = [[0.0; MAX_STATES]; MAX_DEGREE + 1];
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
    pub fn theta(&self, t: f64) -> f64 {
        (t - self.start) / self.length
    }

    /// State at normalised time `theta`, by Horner's rule on the even and the odd powers.
    #[inline]
    pub fn state_at(&self, theta: f64, x: &mut State) {
        let square = theta * theta;
        for group in 0..self.dimension.div_ceil(LANES) {
            let lane = group * LANES;
            let coefficient = |power: usize| -> &[f64; LANES] {
                let c = &self.coefficients[power][lane..lane + LANES];
                c.try_into().expect("LANES wide")
            };
            let (mut even, mut odd) = ([0.0; LANES], [0.0; LANES]);
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
    pub fn combine(&self, row: &[f64], offset: &[f64]) -> [f64; MAX_DEGREE + 1] {
        let mut out = [0.0; MAX_DEGREE + 1];
        out[..offset.len()].copy_from_slice(offset);
        for (sum, c) in out.iter_mut().zip(&self.coefficients).take(self.degree + 1) {
            for (r, x) in row.iter().zip(&c[..self.dimension]) {
                *sum += r * x;
            }
        }
        out
    }
}
