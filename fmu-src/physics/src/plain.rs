//! The whole base model once more, in obvious lines: fixed small Runge-Kutta steps and bisection.
//!
//! Shares no code with the rest of the crate. Stelter 1992, eqs. (1)-(7); stick and slip as in its section 3.

/// One mode: angular frequency in rad/s, damping ratio, mass in kg, tip value.
pub type PlainMode = (f64, f64, f64, f64);

pub struct Plain<'a> {
    pub modes: Vec<PlainMode>,
    /// Coefficient of friction over the sliding speed in m/s, and its static value.
    pub mu: fn(f64) -> f64,
    pub mu_0: f64,
    /// Belt velocity in m/s, its rate, and normal force in N, over time in s.
    pub belt: &'a dyn Fn(f64) -> f64,
    pub belt_rate: f64,
    pub normal: &'a dyn Fn(f64) -> f64,
    /// Force on the tip beside friction in N over time in s.
    pub push: &'a dyn Fn(f64) -> f64,
    /// Acceleration of the clamp in m/s^2 over time in s.
    pub clamp: &'a dyn Fn(f64) -> f64,
}

/// Mean over the length of a cantilever's first mode shapes that are 2, -2, 2 at the tip: `2 sigma_j / k_j` (Blevins 1979,
/// Formulas for Natural Frequency and Mode Shape, table 8-1).
const MEAN_SHAPES: [f64; 3] = [
    2.0 * 0.734_095_514 / 1.875_104_07,
    2.0 * 1.018_467_319 / 4.694_091_13,
    2.0 * 0.999_224_497 / 7.854_757_44,
];

/// Step in s.
const H: f64 = 1e-6;

impl Plain<'_> {
    fn tip_velocity(&self, x: &[f64]) -> f64 {
        (0..self.modes.len())
            .map(|j| self.modes[j].3 * x[2 * j + 1])
            .sum()
    }

    fn relative(&self, t: f64, x: &[f64]) -> f64 {
        self.tip_velocity(x) - (self.belt)(t)
    }

    fn free(&self, t: f64, j: usize, x: &[f64]) -> f64 {
        let (w, d, m, phi) = self.modes[j];
        let inertia = MEAN_SHAPES[j] * (self.clamp)(t);
        phi * (self.push)(t) / m - inertia - 2.0 * d * w * x[2 * j + 1] - w * w * x[2 * j]
    }

    /// Force that keeps the tip at the belt's velocity.
    fn constraint(&self, t: f64, x: &[f64]) -> f64 {
        let tip: f64 = (0..self.modes.len())
            .map(|j| self.modes[j].3 * self.free(t, j, x))
            .sum();
        let mobility: f64 = self.modes.iter().map(|(_, _, m, phi)| phi * phi / m).sum();
        (self.belt_rate - tip) / mobility
    }

    fn force(&self, t: f64, x: &[f64], mode: f64) -> f64 {
        if mode == 0.0 {
            self.constraint(t, x)
        } else {
            -mode * (self.mu)(mode * self.relative(t, x)) * (self.normal)(t)
        }
    }

    fn rates(&self, t: f64, x: &[f64], mode: f64) -> Vec<f64> {
        let force = self.force(t, x, mode);
        let rate = |(j, (_, _, m, phi)): (usize, &PlainMode)| {
            [x[2 * j + 1], self.free(t, j, x) + phi * force / m]
        };
        self.modes.iter().enumerate().flat_map(rate).collect()
    }

    /// One step of the classical Runge-Kutta method.
    fn step(&self, t: f64, h: f64, x: &[f64], mode: f64) -> Vec<f64> {
        let ahead =
            |k: &[f64], h: f64| -> Vec<f64> { x.iter().zip(k).map(|(x, k)| x + h * k).collect() };
        let k1 = self.rates(t, x, mode);
        let k2 = self.rates(t + h / 2.0, &ahead(&k1, h / 2.0), mode);
        let k3 = self.rates(t + h / 2.0, &ahead(&k2, h / 2.0), mode);
        let k4 = self.rates(t + h, &ahead(&k3, h), mode);
        let sum = |i: usize| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        (0..x.len()).map(sum).collect()
    }

    /// Positive inside a mode: what is left of the static limit, or of the sliding speed.
    fn margin(&self, t: f64, x: &[f64], mode: f64) -> f64 {
        if mode == 0.0 {
            self.mu_0 * (self.normal)(t) - self.constraint(t, x).abs()
        } else {
            mode * self.relative(t, x)
        }
    }

    /// The mode that follows where v_r = 0.
    pub fn mode_at_rest(&self, t: f64, x: &[f64]) -> f64 {
        if self.margin(t, x, 0.0) >= 0.0 {
            0.0
        } else {
            -self.constraint(t, x).signum()
        }
    }

    /// Runs from `t` in `mode` to `end`; returns the transitions (time, mode left) and the last mode.
    pub fn run(
        &self,
        mut t: f64,
        x: &mut Vec<f64>,
        mut mode: f64,
        end: f64,
    ) -> (Vec<(f64, f64)>, f64) {
        let mut transitions = Vec::new();
        while t < end {
            let h = H.min(end - t);
            let next = self.step(t, h, x, mode);
            // A slip that begins at rest is not yet an arrival.
            let inside = mode == 0.0 || self.margin(t, x, mode) > 1e-11;
            if self.margin(t + h, &next, mode) >= 0.0 || !inside {
                (t, *x) = (t + h, next);
                continue;
            }
            let (mut low, mut high) = (0.0, h);
            while high - low > 1e-15 {
                let middle = (low + high) / 2.0;
                let inside = self.margin(t + middle, &self.step(t, middle, x, mode), mode) >= 0.0;
                *(if inside { &mut low } else { &mut high }) = middle;
            }
            *x = self.step(t, high, x, mode);
            t += high;
            transitions.push((t, mode));
            mode = if mode == 0.0 {
                -self.constraint(t, x).signum()
            } else {
                self.mode_at_rest(t, x)
            };
        }
        (transitions, mode)
    }
}
