//! Linear motion with constant coefficients, `x' = A x + b + c (t - t_0)`, exact to rounding.
//!
//! The Taylor series of the matrix exponential's action: its terms follow from one another by one
//! product with A, and it converges everywhere, so that the step is limited only by rounding.

use super::series::Series;
use super::{LANES, MAX_DEGREE, MAX_STATES, Segment, State, System};
use crate::real::{Real, ZERO, real, value};

/// Degree at which the series is cut.
const DEGREE: usize = MAX_DEGREE;
/// Step times highest frequency; the first term left out is `2^21/21!`, 4e-14 of the amplitude, and
/// less in stick, whose frequencies lie below the structure's highest.
const REACH: f64 = 2.0;

/// Coefficients of a linear system.
#[derive(Clone)]
pub struct LinearSystem {
    dimension: usize,
    /// Columns of A.
    columns: Vec<State>,
    constant: State,
    /// Step in s for which the cut series is exact to rounding.
    step: f64,
    /// One step from each unit state without the constant, and from zero with it.
    response: Vec<Segment>,
    /// The state after one step: columns of the matrix exponential, and what starts from zero.
    end_columns: Vec<State>,
    end_constant: State,
}

/// A quantity that is linear in the state, `offset + row x`, as a polynomial over one step.
#[derive(Clone)]
pub struct LinearOutput {
    /// Coefficients per state.
    columns: Vec<Series>,
    constant: Series,
}

impl LinearOutput {
    /// Largest magnitude that the polynomial over the step from `x` can have: the sum of its coefficients' magnitudes.
    #[inline]
    pub fn bound(&self, x: &State) -> f64 {
        let mut sum: [f64; MAX_DEGREE + 1] = self.constant.map(value);
        for (column, x) in self.columns.iter().zip(x) {
            for (s, c) in sum.iter_mut().zip(column) {
                *s += value(*c) * value(*x);
            }
        }
        sum.iter().rev().fold(0.0, |sum, c| sum + c.abs())
    }

    /// The polynomial over the step that starts from `x`.
    #[inline]
    pub fn polynomial(&self, x: &State) -> Series {
        let mut sum = self.constant;
        for (column, value) in self.columns.iter().zip(x) {
            for (s, c) in sum.iter_mut().zip(column) {
                *s += c * value;
            }
        }
        sum
    }
}

impl LinearSystem {
    /// Every coefficient, in a fixed order, for saving and restoring; after a change
    /// [`LinearSystem::prepare`] is due.
    #[cfg(not(feature = "tangent"))]
    pub fn numbers_mut(&mut self) -> impl Iterator<Item = &mut Real> {
        self.columns
            .iter_mut()
            .flatten()
            .chain(&mut self.constant)
            .chain([&mut self.step])
    }

    /// Reads the coefficients off a system that is known to be linear: `A e_i = f(e_i) - f(0)`.
    ///
    /// `frequency` is the highest angular frequency (or rate) in rad/s of the motion.
    pub fn probe(system: &impl System, t: Real, frequency: f64) -> Self {
        let dimension = system.dimension();
        let mut constant = [ZERO; MAX_STATES];
        system.rates(t, &[ZERO; MAX_STATES], &mut constant);
        let columns = (0..dimension)
            .map(|column| {
                let mut x = [ZERO; MAX_STATES];
                let mut rates = [ZERO; MAX_STATES];
                x[column] = real(1.0);
                system.rates(t, &x, &mut rates);
                for (rate, at_rest) in rates.iter_mut().zip(&constant) {
                    *rate -= at_rest;
                }
                rates
            })
            .collect();
        let mut system = Self {
            dimension,
            columns,
            constant,
            step: REACH / frequency,
            response: Vec::with_capacity(dimension + 1),
            end_columns: vec![[ZERO; MAX_STATES]; dimension],
            end_constant: [ZERO; MAX_STATES],
        };
        system.prepare();
        system
    }

    /// Works out what one step does.
    pub fn prepare(&mut self) {
        let zero = [ZERO; MAX_STATES];
        self.response.clear();
        for i in 0..=self.dimension {
            let mut motion = Segment::point(ZERO, &zero, self.dimension);
            let mut unit = zero;
            if i < self.dimension {
                unit[i] = real(1.0);
                self.expand(&unit, &zero, &mut motion);
                motion.state_at(real(1.0), &mut self.end_columns[i]);
            } else {
                self.expand(&zero, &self.constant, &mut motion);
                motion.state_at(real(1.0), &mut self.end_constant);
            }
            self.response.push(motion);
        }
    }

    /// The state one step after `x`.
    #[inline]
    pub fn end_of_step(&self, x: &State) -> State {
        let mut end = self.end_constant;
        for lane in (0..self.dimension.div_ceil(LANES)).map(|group| group * LANES) {
            for (column, value) in self.end_columns.iter().zip(x) {
                for i in lane..lane + LANES {
                    end[i] += column[i] * value;
                }
            }
        }
        end
    }

    /// The quantity `offset + row x` over a step.
    pub fn output(&self, row: &State, offset: Real) -> LinearOutput {
        let (units, forced) = self.response.split_at(self.dimension);
        LinearOutput {
            columns: units.iter().map(|unit| unit.combine(row, &[])).collect(),
            constant: forced[0].combine(row, &[offset]),
        }
    }

    /// Begins a segment of one step without its polynomials, which [`LinearSystem::segment`] works out.
    pub fn begin(&self, t: Real, x: &State, out: &mut Segment) {
        out.start = t;
        out.end = t + self.step;
        out.length = self.step;
        out.degree = DEGREE;
        out.dimension = self.dimension;
        out.coefficients[0] = *x;
    }

    /// The motion from state `x` at time `t` as a segment of one step.
    pub fn segment(&self, t: Real, x: &State, out: &mut Segment) {
        self.begin(t, x, out);
        for lane in (0..self.dimension.div_ceil(LANES)).map(|group| group * LANES) {
            for (power, next) in out.coefficients.iter_mut().enumerate().skip(1) {
                let mut sum = lanes(&self.response[self.dimension].coefficients[power], lane);
                for (unit, value) in self.response.iter().zip(&x[..self.dimension]) {
                    let column = lanes(&unit.coefficients[power], lane);
                    for i in 0..LANES {
                        sum[i] += column[i] * value;
                    }
                }
                next[lane..lane + LANES].copy_from_slice(&sum);
            }
        }
    }

    /// The series from state `x`: each term follows from the one before by a product with A.
    fn expand(&self, x: &State, constant: &State, out: &mut Segment) {
        self.begin(ZERO, x, out);
        for power in 1..=DEGREE {
            let (done, rest) = out.coefficients.split_at_mut(power);
            let (last, next) = (&done[power - 1], &mut rest[0]);
            let factor = self.step / power as f64;
            *next = if power == 1 {
                *constant
            } else {
                [ZERO; MAX_STATES]
            };
            for (column, value) in self.columns.iter().zip(last) {
                for i in 0..self.dimension {
                    next[i] += column[i] * value;
                }
            }
            next.iter_mut().for_each(|x| *x *= factor);
        }
    }
}

#[inline]
fn lanes(x: &State, lane: usize) -> [Real; LANES] {
    x[lane..lane + LANES].try_into().expect("LANES wide")
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    struct Drifting;
    impl System for Drifting {
        fn dimension(&self) -> usize {
            3
        }
        fn rates(&self, _t: f64, x: &State, rates: &mut State) {
            rates[0] = x[1];
            rates[1] = -4.0 * x[0] + 1.0;
            rates[2] = 0.3;
        }
    }

    #[test]
    fn val_forced_oscillator_is_exact_to_rounding() {
        // Source: closed form x = 1/4 + (x0 - 1/4) cos 2t, and a uniform drift.
        let system = LinearSystem::probe(&Drifting, 0.0, 2.0);
        let mut x = [0.0; MAX_STATES];
        x[0] = 1.0;
        let mut segment = Segment::point(0.0, &x, 3);
        let mut row = [0.0; MAX_STATES];
        (row[0], row[1]) = (3.0, -1.0);
        for _ in 0..40 {
            system.segment(segment.end, &x, &mut segment);
            let end = system.end_of_step(&x);
            let position = system.output(&row, 0.5).polynomial(&x);
            segment.state_at(1.0, &mut x);
            assert_relative_eq!(end[0], x[0], epsilon = 1e-14);
            assert_relative_eq!(end[2], x[2], epsilon = 1e-14);
            let sum: f64 = position.iter().sum();
            assert_relative_eq!(sum, 0.5 + 3.0 * x[0] - x[1], epsilon = 1e-13);
        }
        let t = segment.end;
        assert_relative_eq!(x[0], 0.25 + 0.75 * (2.0 * t).cos(), epsilon = 1e-12);
        assert_relative_eq!(x[2], 0.3 * t, epsilon = 1e-13);
    }
}
