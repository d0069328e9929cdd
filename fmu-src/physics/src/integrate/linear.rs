//! Linear motion with constant coefficients, `x' = A x + b + c (t - t_0)`, exact to rounding.
//!
//! The Taylor series of the matrix exponential's action: its terms follow from one another by one
//! product with A, and it converges everywhere, so that the step is limited only by rounding.

use super::{MAX_DEGREE, MAX_STATES, Segment, State, System};

/// Degree at which the series is cut.
const DEGREE: usize = 16;

/// Coefficients of a linear system.
#[derive(Clone)]
pub struct LinearSystem {
    dimension: usize,
    /// Rows of A as (row, column, value) of the entries that are not zero.
    entries: Vec<(u8, u8, f64)>,
    constant: State,
    /// Longest step in s for which the cut series is exact to rounding.
    step: f64,
}

impl LinearSystem {
    /// Reads the coefficients off a system that is known to be linear: `A e_i = f(e_i) - f(0)`.
    ///
    /// `frequency` is the highest angular frequency (or rate) in rad/s of the motion.
    pub fn probe(system: &impl System, t: f64, frequency: f64) -> Self {
        let dimension = system.dimension();
        let mut constant = [0.0; MAX_STATES];
        system.rates(t, &[0.0; MAX_STATES], &mut constant);
        let mut entries = Vec::with_capacity(dimension * dimension);
        for column in 0..dimension {
            let mut x = [0.0; MAX_STATES];
            let mut rates = [0.0; MAX_STATES];
            x[column] = 1.0;
            system.rates(t, &x, &mut rates);
            for row in 0..dimension {
                let value = rates[row] - constant[row];
                if value != 0.0 {
                    entries.push((row as u8, column as u8, value));
                }
            }
        }
        entries.sort_unstable_by_key(|e| e.0);
        Self {
            dimension,
            entries,
            constant,
            step: 1.0 / frequency,
        }
    }

    /// The motion from state `x` at time `t` as a segment of one step.
    pub fn segment(&self, t: f64, x: &State, out: &mut Segment) {
        out.start = t;
        out.end = t + self.step;
        out.length = self.step;
        out.degree = DEGREE;
        out.dimension = self.dimension;
        out.coefficients[0] = *x;
        for power in 1..=DEGREE {
            let (done, rest) = out.coefficients.split_at_mut(power);
            let next = &mut rest[0];
            *next = if power == 1 {
                self.constant
            } else {
                [0.0; MAX_STATES]
            };
            for &(row, column, value) in &self.entries {
                next[row as usize] += value * done[power - 1][column as usize];
            }
            let factor = self.step / power as f64;
            for value in &mut next[..self.dimension] {
                *value *= factor;
            }
        }
        debug_assert!(DEGREE <= MAX_DEGREE);
    }
}

#[cfg(test)]
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
        for _ in 0..40 {
            system.segment(segment.end, &x, &mut segment);
            segment.state_at(1.0, &mut x);
        }
        let t = segment.end;
        assert_relative_eq!(x[0], 0.25 + 0.75 * (2.0 * t).cos(), epsilon = 1e-13);
        assert_relative_eq!(x[2], 0.3 * t, epsilon = 1e-13);
    }
}
