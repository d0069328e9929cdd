//! Dormand-Prince 8(5,3) with a seventh-order interpolant (Hairer, Norsett, Wanner 1993, II.5-II.6).

use super::dop853_coefficients::{A, B, C, D, E3, E5, STAGES, STAGES_EXTENDED};
use super::{LANES, MAX_STATES, Scales, Segment, State, System};
use crate::real::{Real, ZERO, value};

/// Safety factor of the step control.
const SAFETY: f64 = 0.9;
/// Bounds of the change of step from one step to the next.
const SHRINK: f64 = 0.333;
const GROW: f64 = 6.0;

/// One step and what is needed to interpolate it.
#[derive(Clone)]
pub struct Dop853 {
    stages: [State; STAGES_EXTENDED],
    /// Start time of the last accepted step in s.
    pub start: Real,
    /// Its length in s.
    pub length: f64,
    /// State at its start.
    pub x_start: State,
    /// State at its end.
    pub x_end: State,
    /// Step proposed for the next in s.
    pub next_length: f64,
    /// Evaluations of the rates since creation.
    pub evaluations: u64,
}

impl Default for Dop853 {
    fn default() -> Self {
        Self {
            stages: [[ZERO; MAX_STATES]; STAGES_EXTENDED],
            start: ZERO,
            length: 0.0,
            x_start: [ZERO; MAX_STATES],
            x_end: [ZERO; MAX_STATES],
            next_length: 0.0,
            evaluations: 0,
        }
    }
}

/// The step became too small: the right-hand side is not smooth or not finite.
#[derive(Debug)]
pub struct StepTooSmall;

impl Dop853 {
    /// Every number that the next steps depend on, in a fixed order, for saving and restoring.
    #[cfg(not(feature = "tangent"))]
    pub fn numbers_mut(&mut self) -> impl Iterator<Item = &mut Real> {
        self.stages
            .iter_mut()
            .flatten()
            .chain(&mut self.x_start)
            .chain(&mut self.x_end)
            .chain([&mut self.start, &mut self.length, &mut self.next_length])
    }

    /// Rates at the start of the last step.
    pub fn rates_at_start(&self) -> &State {
        &self.stages[0]
    }

    /// Rates at the end of the last accepted step.
    pub fn rates_at_end(&self) -> &State {
        &self.stages[STAGES]
    }

    /// Sets the start of a new piece of motion.
    pub fn restart(&mut self, system: &impl System, t: Real, x: &State) {
        self.start = t;
        self.length = 0.0;
        self.x_end = *x;
        system.rates(t, x, &mut self.stages[STAGES]);
        self.evaluations += 1;
    }

    /// Takes one step of the length proposed, shorter where the error asks for it.
    ///
    /// Error norm: `|e_i| <= tolerance (|x_i| + scale_i)` in the root-mean-square sense.
    ///
    /// # Errors
    /// [`StepTooSmall`] once the step falls below the resolution of time.
    pub fn step(
        &mut self,
        system: &impl System,
        tolerance: f64,
        scales: &Scales,
    ) -> Result<(), StepTooSmall> {
        let t = self.start + self.length;
        self.x_start = self.x_end;
        self.stages[0] = self.stages[STAGES];
        let mut h = self.next_length;
        let mut rejected = false;
        loop {
            if h.is_nan() || h <= 1e-15 + 8.0 * f64::EPSILON * value(t).abs() {
                return Err(StepTooSmall);
            }
            self.attempt(system, t, h);
            let error = self.error_norm(system.dimension(), h, tolerance, scales);
            if error <= 1.0 {
                self.start = t;
                self.length = h;
                let factor = (SAFETY * error.max(1e-12).powf(-0.125)).clamp(SHRINK, GROW);
                self.next_length = h * if rejected { factor.min(1.0) } else { factor };
                return Ok(());
            }
            rejected = true;
            // A non-finite error must shrink the step too.
            let factor = if error.is_finite() {
                SAFETY * error.powf(-0.125)
            } else {
                SHRINK
            };
            h *= factor.clamp(SHRINK, 0.95);
        }
    }

    /// A step of exactly `h` from the start of the last accepted step, without error control: the
    /// state at an event inside that step, to the order of the method.
    pub fn retake(&mut self, system: &impl System, h: f64) {
        self.attempt(system, self.start, h);
        self.length = h;
    }

    fn attempt(&mut self, system: &impl System, t: Real, h: f64) {
        let groups = system.dimension().div_ceil(LANES);
        let mut x = [ZERO; MAX_STATES];
        for i in 1..STAGES {
            self.combine(&A[i][..i], h, groups, &mut x);
            system.rates(t + C[i] * h, &x, &mut self.stages[i]);
        }
        self.combine(&B, h, groups, &mut x);
        system.rates(t + h, &x, &mut self.stages[STAGES]);
        self.x_end = x;
        self.evaluations += STAGES as u64;
    }

    #[inline]
    fn combine(&self, weights: &[f64], h: f64, groups: usize, x: &mut State) {
        for group in 0..groups {
            let lane = group * LANES;
            let mut sum = [ZERO; LANES];
            for (w, stage) in weights.iter().zip(&self.stages) {
                if *w != 0.0 {
                    let k: &[Real; LANES] =
                        stage[lane..lane + LANES].try_into().expect("LANES wide");
                    for i in 0..LANES {
                        sum[i] += w * k[i];
                    }
                }
            }
            for i in 0..LANES {
                x[lane + i] = self.x_start[lane + i] + h * sum[i];
            }
        }
    }

    fn error_norm(&self, dimension: usize, h: f64, tolerance: f64, scales: &Scales) -> f64 {
        let (mut five, mut three) = (0.0, 0.0);
        for i in 0..dimension {
            let (mut e5, mut e3) = (0.0, 0.0);
            for (s, stage) in self.stages[..=STAGES].iter().enumerate() {
                e5 += E5[s] * value(stage[i]);
                e3 += E3[s] * value(stage[i]);
            }
            let scale = tolerance
                * (value(self.x_start[i]).abs().max(value(self.x_end[i]).abs()) + scales[i]);
            five += (e5 / scale).powi(2);
            three += (e3 / scale).powi(2);
        }
        let denominator = five + 0.01 * three;
        if denominator == 0.0 {
            return 0.0;
        }
        h.abs() * five / (denominator * dimension as f64).sqrt()
    }

    /// The interpolant of the last step as a segment.
    pub fn segment(&mut self, system: &impl System, out: &mut Segment) {
        let (t, h) = (self.start, self.length);
        let dimension = system.dimension();
        let groups = dimension.div_ceil(LANES);
        let mut x = [ZERO; MAX_STATES];
        for i in STAGES + 1..STAGES_EXTENDED {
            self.combine(&A[i][..i], h, groups, &mut x);
            system.rates(t + C[i] * h, &x, &mut self.stages[i]);
        }
        self.evaluations += 3;
        out.start = t;
        out.end = t + h;
        out.length = h;
        out.degree = 7;
        out.dimension = dimension;
        for i in 0..dimension {
            let delta = self.x_end[i] - self.x_start[i];
            let mut f = [
                self.x_start[i],
                delta,
                h * self.stages[0][i] - delta,
                2.0 * delta - h * (self.stages[STAGES][i] + self.stages[0][i]),
                ZERO,
                ZERO,
                ZERO,
                ZERO,
            ];
            for (row, value) in D.iter().zip(&mut f[4..]) {
                *value = h * row
                    .iter()
                    .zip(&self.stages)
                    .map(|(d, k)| d * k[i])
                    .sum::<Real>();
            }
            for (power, c) in to_monomials(&f).into_iter().enumerate() {
                out.coefficients[power][i] = c;
            }
        }
    }
}

/// Turns Hairer's nested form `f0 + s (f1 + (1-s) (f2 + s (f3 + ...)))` into powers of s.
fn to_monomials(f: &[Real; 8]) -> [Real; 8] {
    let mut p = [ZERO; 8];
    for k in (1..8).rev() {
        p[0] += f[k];
        // Multiply by s for odd k and by 1 - s for even k, from the highest power down.
        for i in (1..8).rev() {
            p[i] = if k % 2 == 1 {
                p[i - 1]
            } else {
                p[i] - p[i - 1]
            };
        }
        if k % 2 == 1 {
            p[0] = ZERO;
        }
    }
    p[0] += f[0];
    p
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    struct Oscillator;
    impl System for Oscillator {
        fn dimension(&self) -> usize {
            2
        }
        fn rates(&self, _t: f64, x: &State, rates: &mut State) {
            rates[0] = x[1];
            rates[1] = -x[0];
        }
    }

    #[test]
    fn val_oscillator_and_its_interpolant_follow_the_cosine() {
        // Source: closed form x = cos t.
        let mut x = [0.0; MAX_STATES];
        x[0] = 1.0;
        let mut rk = Dop853 {
            next_length: 0.1,
            ..Dop853::default()
        };
        rk.restart(&Oscillator, 0.0, &x);
        let mut segment = Segment::point(0.0, &x, 2);
        while rk.start + rk.length < 20.0 {
            rk.step(&Oscillator, 1e-12, &[1.0; MAX_STATES]).unwrap();
            rk.segment(&Oscillator, &mut segment);
            for i in 0..=4 {
                let theta = i as f64 / 4.0;
                let mut at = [0.0; MAX_STATES];
                segment.state_at(theta, &mut at);
                let t: f64 = segment.start + theta * segment.length;
                assert_relative_eq!(at[0], t.cos(), epsilon = 2e-10);
                assert_relative_eq!(at[1], -t.sin(), epsilon = 2e-10);
            }
        }
    }
}
