//! The structure with the force as additional state, scaled and exactly discretised.

use super::{Mode, Structure};
use crate::measurement::Measurand;
use crate::observer::error::ObserverError;
use nalgebra::{DMatrix, DVector};

/// How the force is thought to move between samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ForceModel {
    /// `F' = white noise`: one force state; right when nothing is known of the force.
    #[default]
    RandomWalk,
    /// `F'' = white noise`: two force states `F, F'`; right for smooth forces, smears jumps more.
    IntegratedRandomWalk,
}

impl ForceModel {
    /// Number of force states.
    pub fn state_count(self) -> usize {
        match self {
            ForceModel::RandomWalk => 1,
            ForceModel::IntegratedRandomWalk => 2,
        }
    }
}

/// The scaled, exactly discretised model `z_(k+1) = A z_k + noise`, `w = c z`.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteModel {
    /// `A`, N x N.
    pub transition: DMatrix<f64>,
    /// Noise covariance for unit intensity (1 m^2/s) on each force state.
    pub noise: Vec<DMatrix<f64>>,
    /// `c` with `w_tip = c z`, N.
    pub output: DVector<f64>,
    /// Row with `w_tip' = row z`, N, in 1/s.
    pub velocity: DVector<f64>,
    /// Row of what is measured over the states, N.
    pub reading: DVector<f64>,
    /// What is measured.
    pub measures: Measurand,
    /// Index of the force state.
    pub force_index: usize,
    /// `z[force_index] = force_scale F`, in m/N.
    pub force_scale: f64,
    /// `z[force_index + 1] = slope_scale F'`, in m s/N.
    pub slope_scale: f64,
}

impl Mode {
    /// Free motion over `tau`: `[q, q'/w]` goes to `e [q, q'/w]` (2 x 2, row by row).
    fn free_motion(&self, tau: f64) -> [[f64; 2]; 2] {
        if self.is_free() {
            let x = self.damping_rate * tau;
            return [
                [1.0, self.rate() * tau * decay_integral(1, x)],
                [0.0, (-x).exp()],
            ];
        }
        let (w, ratio) = (self.angular_frequency(), self.whole_damping_ratio());
        let root = (1.0 - ratio.powi(2)).sqrt();
        let decay = (-ratio * w * tau).exp();
        let (sin, cos) = (w * root * tau).sin_cos();
        let (s, d) = (sin / root, ratio * sin / root);
        [
            [decay * (cos + d), decay * s],
            [-decay * s, decay * (cos - d)],
        ]
    }
}

/// What a decay with `exp(-x)` at its end leaves of `tau^n / n!`, the n-fold integral of 1 over a time `tau`, times `tau^-n`:
/// `phi_n(x) = sum_k (-x)^k / (k + n)!`, so `phi_1 = (1 - exp(-x))/x`, `phi_(n+1) = (1/n! - phi_n)/x`.
fn decay_integral(n: u32, x: f64) -> f64 {
    let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
    // The recursion cancels where x is small, the series alternates where it is large.
    if x < 1.0 {
        let mut term = 1.0 / factorial(n);
        let mut sum = term;
        for k in 1..20 {
            term *= -x / f64::from(k + n);
            sum += term;
        }
        return sum;
    }
    let first = -(-x).exp_m1() / x;
    (1..n).fold(first, |phi, n| (1.0 / factorial(n) - phi) / x)
}

impl Structure {
    /// The scaled state space, exactly discretised at `sample_interval` (s), with a sensor that measures so.
    pub fn discretise(
        &self,
        force_model: ForceModel,
        sample_interval: f64,
        measures: Measurand,
    ) -> Result<DiscreteModel, ObserverError> {
        self.check_sampling(sample_interval)?;
        let reading = match measures {
            Measurand::Displacement => self.output(force_model, Mode::sensor_value),
            Measurand::Velocity => self.velocity_output(force_model, Mode::sensor_value),
            Measurand::Acceleration => self.acceleration_output(force_model, Mode::sensor_value),
        };
        Ok(DiscreteModel {
            transition: self.transition(force_model, sample_interval),
            noise: self.noise(force_model, sample_interval),
            output: self.output(force_model, |mode| mode.tip_value),
            velocity: self.velocity_output(force_model, |mode| mode.tip_value),
            reading,
            measures,
            force_index: 2 * self.modes.len(),
            force_scale: self.force_scale(),
            slope_scale: self.force_scale() / self.modes[0].rate(),
        })
    }

    /// Exact transition matrix over `tau` (s) of the scaled state
    /// `z = [q_1, q_1'/w_1, q_2, q_2'/w_2, ..., F x_s (, F' x_s / w_1)]`, all in m, with [`Mode::rate`] for `w_j`.
    ///
    /// With these scales (and time in `1/sqrt(w_1 w_2)`) the observability matrix of the paper's
    /// beam has condition 270; in SI units it has 1e19.
    pub fn transition(&self, force_model: ForceModel, tau: f64) -> DMatrix<f64> {
        let n = self.modes.len();
        let size = 2 * n + force_model.state_count();
        let x_s = self.force_scale();
        let w_1 = self.modes[0].rate();
        let mut a = DMatrix::identity(size, size);
        for (j, mode) in self.modes.iter().enumerate() {
            let e = mode.free_motion(tau);
            let w = mode.rate();
            let s = mode.modal_compliance() / x_s;
            let wt = w * tau;
            // Constant force: the motion is free about the static deflection (s, 0), or accelerates where no spring holds it.
            let held = if mode.is_free() {
                let x = mode.damping_rate * tau;
                [
                    wt * wt * s * decay_integral(2, x),
                    wt * s * decay_integral(1, x),
                ]
            } else {
                [(1.0 - e[0][0]) * s, -e[1][0] * s]
            };
            for row in 0..2 {
                a[(2 * j + row, 2 * j)] = e[row][0];
                a[(2 * j + row, 2 * j + 1)] = e[row][1];
                a[(2 * j + row, 2 * n)] = held[row];
            }
            if force_model == ForceModel::IntegratedRandomWalk && mode.is_free() {
                let x = mode.damping_rate * tau;
                a[(2 * j, 2 * n + 1)] = s * w_1 * tau * wt * wt * decay_integral(3, x);
                a[(2 * j + 1, 2 * n + 1)] = s * w_1 * tau * wt * decay_integral(2, x);
            } else if force_model == ForceModel::IntegratedRandomWalk {
                // Rising force: free about the ramp (s (f - 2 D f'/w), s f'/w), f' = w_1 g.
                let p = [-2.0 * mode.whole_damping_ratio() * s * w_1 / w, s * w_1 / w];
                a[(2 * j, 2 * n + 1)] = p[0] - e[0][0] * p[0] - e[0][1] * p[1] + s * w_1 * tau;
                a[(2 * j + 1, 2 * n + 1)] = p[1] - e[1][0] * p[0] - e[1][1] * p[1];
            }
        }
        if force_model == ForceModel::IntegratedRandomWalk {
            a[(2 * n, 2 * n + 1)] = w_1 * tau;
        }
        a
    }

    /// Covariance per interval `tau` (s) for white noise of intensity 1 m^2/s on each force
    /// state alone, last state last: `integral of Phi g g' Phi'` with `g` the unit vector of that
    /// state (van Loan 1978, here by Gauss-Legendre quadrature of the exact `Phi`).
    pub fn noise(&self, force_model: ForceModel, tau: f64) -> Vec<DMatrix<f64>> {
        let n = 2 * self.modes.len();
        (0..force_model.state_count())
            .map(|state| {
                let size = n + force_model.state_count();
                let mut q = DMatrix::zeros(size, size);
                for (node, weight) in GAUSS_LEGENDRE_8 {
                    for sign in [-1.0, 1.0] {
                        let at = 0.5 * tau * (1.0 + sign * node);
                        let phi = self.transition(force_model, at);
                        let column = phi.column(n + state);
                        q += 0.5 * tau * weight * column * column.transpose();
                    }
                }
                q
            })
            .collect()
    }

    fn output(&self, force_model: ForceModel, shape: fn(&Mode) -> f64) -> DVector<f64> {
        let mut c = DVector::zeros(2 * self.modes.len() + force_model.state_count());
        for (j, mode) in self.modes.iter().enumerate() {
            c[2 * j] = shape(mode);
        }
        c
    }

    fn velocity_output(&self, force_model: ForceModel, shape: fn(&Mode) -> f64) -> DVector<f64> {
        let mut c = DVector::zeros(2 * self.modes.len() + force_model.state_count());
        for (j, mode) in self.modes.iter().enumerate() {
            c[2 * j + 1] = shape(mode) * mode.rate();
        }
        c
    }

    /// `w'' = sum phi_j(s) (phi_j F / m_j - (2 D_j w_j + d_j) q_j' - w_j^2 q_j)` over the scaled state; the force passes through it at once.
    fn acceleration_output(
        &self,
        force_model: ForceModel,
        shape: fn(&Mode) -> f64,
    ) -> DVector<f64> {
        let force = 2 * self.modes.len();
        let mut c = DVector::zeros(force + force_model.state_count());
        for (j, mode) in self.modes.iter().enumerate() {
            let w = mode.angular_frequency();
            c[2 * j] = -shape(mode) * w * w;
            c[2 * j + 1] = -shape(mode) * mode.damping() * mode.rate();
        }
        let modes = self.modes.iter();
        let inverse_mass: f64 = modes.map(|m| shape(m) * m.tip_value / m.mass_kg).sum();
        c[force] = inverse_mass / self.force_scale();
        c
    }
}

/// Positive nodes and weights of the 8-point Gauss-Legendre rule on [-1, 1]
/// (Abramowitz and Stegun 1964, table 25.4).
const GAUSS_LEGENDRE_8: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

#[cfg(test)]
mod tests {
    use super::*;

    // Source: the equation of motion `q'' = phi F / m - 2 D w q' - w^2 q`, solved by hand for each state.
    #[test]
    fn val_the_row_of_an_acceleration_is_the_equation_of_motion() {
        let (phi, mass, frequencies, ratios) = ([2.0, -2.0], 0.427, [80.0, 510.0], [0.01, 0.02]);
        let structure = Structure::cantilever(&frequencies, &ratios, mass).unwrap();
        for force_model in [ForceModel::RandomWalk, ForceModel::IntegratedRandomWalk] {
            let model = structure.discretise(force_model, 1e-5, Measurand::Acceleration);
            let model = model.unwrap();
            let measured = |z: &DVector<f64>| model.reading.dot(z);
            let size = model.output.len();
            for j in 0..2 {
                let w = std::f64::consts::TAU * frequencies[j];
                // Let go from a deflection of 1 mm, and at 1 m/s through the middle.
                for (state, value, expected) in [
                    (2 * j, 1e-3, -phi[j] * w * w * 1e-3),
                    (2 * j + 1, 1.0 / w, -phi[j] * 2.0 * ratios[j] * w),
                ] {
                    let mut z = DVector::zeros(size);
                    z[state] = value;
                    let found = measured(&z);
                    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
                }
            }
            // A force of 10 N on the beam at rest accelerates the tip at once, ...
            let mut z = DVector::zeros(size);
            z[model.force_index] = 10.0 * model.force_scale;
            let expected = 10.0 * (phi[0] * phi[0] + phi[1] * phi[1]) / mass;
            assert!((measured(&z) / expected - 1.0).abs() < 1e-12);
            // ... and not where the deflection balances it.
            for (j, mode) in structure.modes().iter().enumerate() {
                z[2 * j] = 10.0 * mode.modal_compliance();
            }
            assert!(measured(&z).abs() < 1e-12 * expected);
            // Beside steps of the exact motion it is the slope of the velocity.
            let next = &model.transition * &z;
            let later = &model.transition * &next;
            let slope = (model.velocity.dot(&later) - model.velocity.dot(&z)) / 2e-5;
            assert!((slope - measured(&next)).abs() < 1e-6 * expected);
        }
    }

    // Source: closed forms of `q'' + d q' = phi F / m` with F = F_0 + F_1 t from rest, and of its velocity that decays.
    #[test]
    fn val_a_free_mass_with_a_damper_moves_as_the_closed_forms_say() {
        let (mass, f_0, f_1) = (0.5, 3.0, -7.0);
        for rate in [0.0, 1e-6, 2.0, 999.0, 1001.0, 4e4] {
            let structure = Structure::single(0.0, 0.0, mass).unwrap();
            let structure = structure.with_damping_rates(&[rate]).unwrap();
            let mode = structure.modes()[0];
            let tau = 1e-3;
            let a = structure.transition(ForceModel::IntegratedRandomWalk, tau);
            let x_s = structure.force_scale();
            let z = DVector::from_vec(vec![0.0, 0.0, f_0 * x_s, f_1 * x_s / mode.rate()]);
            let end = &a * z;
            let x: f64 = rate * tau;
            let (q, v) = if x < 1e-3 {
                // To second order in x, whose fourth is below the last digit.
                let held = f_0 * tau * tau * (0.5 - x / 6.0 + x * x / 24.0);
                let rising = f_1 * tau.powi(3) * (1.0 / 6.0 - x / 24.0 + x * x / 120.0);
                let v = f_0 * tau * (1.0 - x / 2.0 + x * x / 6.0);
                let of_rising = f_1 * tau * tau * (0.5 - x / 6.0 + x * x / 24.0);
                (held + rising, v + of_rising)
            } else {
                let e = (-x).exp();
                let v = f_0 / rate * (1.0 - e) + f_1 / rate * (tau - (1.0 - e) / rate);
                let q = f_0 / rate * (tau - (1.0 - e) / rate)
                    + f_1 / rate * (0.5 * tau * tau - (tau - (1.0 - e) / rate) / rate);
                (q, v)
            };
            let found = [end[0], end[1] * mode.rate()];
            for (found, expected) in found.into_iter().zip([q / mass, v / mass]) {
                assert!(
                    (found / expected - 1.0).abs() < 1e-9,
                    "{rate}: {found} {expected}"
                );
            }
            let coasting = &a * DVector::from_vec(vec![0.0, 1.0, 0.0, 0.0]);
            assert!((coasting[1] / (-x).exp() - 1.0).abs() < 1e-12);
        }
    }

    // Source: a damper d beside a damping ratio D acts as the ratio D + d/(2 w) does.
    #[test]
    fn val_a_damper_beside_a_spring_is_a_damping_ratio() {
        let w = std::f64::consts::TAU * 80.0;
        let plain = Structure::single(80.0, 0.01 + 3.0 / (2.0 * w), 0.427).unwrap();
        let damper = Structure::single(80.0, 0.01, 0.427).unwrap();
        let damper = damper.with_damping_rates(&[3.0]).unwrap();
        for measured in [Measurand::Displacement, Measurand::Acceleration] {
            let model =
                |s: &Structure| s.discretise(ForceModel::default(), 1e-4, measured).unwrap();
            let (plain, damper) = (model(&plain), model(&damper));
            assert!((plain.transition - damper.transition).amax() < 1e-13);
            let size = plain.reading.amax();
            assert!((plain.reading - damper.reading).amax() < 1e-13 * size);
        }
        for rate in [-1.0, f64::NAN, 2.0 * w] {
            let refused = damper.with_damping_rates(&[rate]).unwrap_err();
            assert!(refused.to_string().contains("damping rate"), "{refused}");
        }
    }
}
