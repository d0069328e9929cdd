//! Linear motion with constant coefficients, `x' = A x + b + c (t - t_0)`, exact to rounding.
//!
//! The Taylor series of the matrix exponential's action: its terms follow from one another by one
//! product with A, and it converges everywhere, so that the step is limited only by rounding.

use super::{LANES, MAX_DEGREE, MAX_STATES, Segment, State, System};

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
}

impl LinearSystem {
    /// Every coefficient, in a fixed order, for saving and restoring.
    pub fn numbers_mut(&mut self) -> impl Iterator<Item = &mut f64> {
        self.columns
            .iter_mut()
            .flatten()
            .chain(&mut self.constant)
            .chain([&mut self.step])
    }

    /// Reads the coefficients off a system that is known to be linear: `A e_i = f(e_i) - f(0)`.
    ///
    /// `frequency` is the highest angular frequency (or rate) in rad/s of the motion.
    pub fn probe(system: &impl System, t: f64, frequency: f64) -> Self {
        let dimension = system.dimension();
        let mut constant = [0.0; MAX_STATES];
        system.rates(t, &[0.0; MAX_STATES], &mut constant);
        let columns = (0..dimension)
            .map(|column| {
                let mut x = [0.0; MAX_STATES];
                let mut rates = [0.0; MAX_STATES];
                x[column] = 1.0;
                system.rates(t, &x, &mut rates);
                for (rate, at_rest) in rates.iter_mut().zip(&constant) {
                    *rate -= at_rest;
                }
                rates
            })
            .collect();
        Self {
            dimension,
            columns,
            constant,
            step: REACH / frequency,
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
        let groups = self.dimension.div_ceil(LANES);
        for power in 1..=DEGREE {
            let (done, rest) = out.coefficients.split_at_mut(power);
            let (last, next) = (&done[power - 1], &mut rest[0]);
            let factor = self.step / power as f64;
            for lane in (0..groups).map(|group| group * LANES) {
                let mut sum = [0.0; LANES];
                if power == 1 {
                    sum.copy_from_slice(&self.constant[lane..lane + LANES]);
                }
                for (column, value) in self.columns.iter().zip(last) {
                    let column: &[f64; LANES] =
                        column[lane..lane + LANES].try_into().expect("LANES wide");
                    for i in 0..LANES {
                        sum[i] += column[i] * value;
                    }
                }
                for i in 0..LANES {
                    next[lane + i] = factor * sum[i];
                }
            }
        }
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
        assert_relative_eq!(x[0], 0.25 + 0.75 * (2.0 * t).cos(), epsilon = 1e-12);
        assert_relative_eq!(x[2], 0.3 * t, epsilon = 1e-13);
    }
}
