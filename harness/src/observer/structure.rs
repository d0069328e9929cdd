//! The linear part of the rig: vibration modes driven and measured at the tip.
//!
//! `q_j'' + 2 D_j w_j q_j' + w_j^2 q_j = phi_j F / m_j`, `w_tip = sum_j phi_j q_j`
//! (Stelter 1992, eqs. 2, 3; `phi_j = phi_j(1)`), with the contact force as additional state:
//! `F' = 0` (his eq. 10), or driven by white noise for the Kalman filter.

use super::error::ObserverError;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Largest number of modes.
pub const MODE_LIMIT: usize = 16;

/// Least number of samples per period of the highest mode.
const SAMPLES_PER_PERIOD: f64 = 2.5;

/// One vibration mode as seen at the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// Natural frequency `f_j` in Hz.
    pub frequency_hz: f64,
    /// Damping ratio `D_j` (1), at least 0 and below 1.
    pub damping_ratio: f64,
    /// Modal mass `m_j` in kg.
    pub mass_kg: f64,
    /// Value of the mode shape at the tip, `phi_j(1)` (1).
    pub tip_value: f64,
}

impl Mode {
    /// Natural angular frequency `w_j = 2 pi f_j` in rad/s.
    pub fn angular_frequency(&self) -> f64 {
        2.0 * PI * self.frequency_hz
    }

    /// Static modal deflection per force at the tip, `phi_j / (m_j w_j^2)` in m/N.
    pub fn modal_compliance(&self) -> f64 {
        self.tip_value / (self.mass_kg * self.angular_frequency().powi(2))
    }

    /// Free motion over `tau`: `[q, q'/w]` goes to `e [q, q'/w]` (2 x 2, row by row).
    fn free_motion(&self, tau: f64) -> [[f64; 2]; 2] {
        let w = self.angular_frequency();
        let root = (1.0 - self.damping_ratio.powi(2)).sqrt();
        let decay = (-self.damping_ratio * w * tau).exp();
        let (sin, cos) = (w * root * tau).sin_cos();
        let (s, d) = (sin / root, self.damping_ratio * sin / root);
        [
            [decay * (cos + d), decay * s],
            [-decay * s, decay * (cos - d)],
        ]
    }
}

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

/// A linear modal structure with a force at the tip and the displacement measured there.
///
/// Holds for small deflections, light viscous damping, real modes (any number up to
/// [`MODE_LIMIT`]). A mode that is left out spoils the force in its band: test the whiteness of
/// the innovation before believing it.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    modes: Vec<Mode>,
}

impl Structure {
    /// Checks the modal data.
    ///
    /// Modes are kept in the order given.
    pub fn new(modes: Vec<Mode>) -> Result<Self, ObserverError> {
        if modes.is_empty() {
            return Err(ObserverError::NoModes);
        }
        if modes.len() > MODE_LIMIT {
            return Err(ObserverError::TooManyModes {
                count: modes.len(),
                limit: MODE_LIMIT,
            });
        }
        for (index, mode) in modes.iter().enumerate() {
            check_mode(index + 1, mode)?;
            if let Some(other) = modes[..index]
                .iter()
                .position(|m| m.frequency_hz == mode.frequency_hz)
            {
                return Err(ObserverError::EqualFrequencies {
                    first: other + 1,
                    second: index + 1,
                    frequency_hz: mode.frequency_hz,
                });
            }
        }
        Ok(Self { modes })
    }

    /// A uniform cantilever: all modal masses `mass_kg = rho A l`, tip values +2, -2, +2, ...
    /// (eigenfunctions of Stelter 1992, eq. 6).
    pub fn cantilever(
        frequencies_hz: &[f64],
        damping_ratios: &[f64],
        mass_kg: f64,
    ) -> Result<Self, ObserverError> {
        let tip_values: Vec<f64> = (0..frequencies_hz.len())
            .map(|j| if j % 2 == 0 { 2.0 } else { -2.0 })
            .collect();
        let masses = vec![mass_kg; frequencies_hz.len()];
        Self::from_lists(frequencies_hz, damping_ratios, &masses, &tip_values)
    }

    /// From lists with one entry per mode.
    pub fn from_lists(
        frequencies_hz: &[f64],
        damping_ratios: &[f64],
        masses_kg: &[f64],
        tip_values: &[f64],
    ) -> Result<Self, ObserverError> {
        let expected = frequencies_hz.len();
        for (what, found) in [
            ("damping ratio", damping_ratios.len()),
            ("modal mass", masses_kg.len()),
            ("tip value", tip_values.len()),
        ] {
            if found != expected {
                return Err(ObserverError::ModeCountMismatch {
                    what,
                    expected,
                    found,
                });
            }
        }
        Self::new(
            (0..expected)
                .map(|j| Mode {
                    frequency_hz: frequencies_hz[j],
                    damping_ratio: damping_ratios[j],
                    mass_kg: masses_kg[j],
                    tip_value: tip_values[j],
                })
                .collect(),
        )
    }

    /// A spring with a mass, `m y'' + d y' + k y = F`: one mode with tip value 1.
    pub fn single(
        frequency_hz: f64,
        damping_ratio: f64,
        mass_kg: f64,
    ) -> Result<Self, ObserverError> {
        Self::new(vec![Mode {
            frequency_hz,
            damping_ratio,
            mass_kg,
            tip_value: 1.0,
        }])
    }

    /// The modes.
    pub fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// The same structure with other natural frequencies (Hz, one per mode).
    pub fn with_frequencies(&self, frequencies_hz: &[f64]) -> Result<Self, ObserverError> {
        if frequencies_hz.len() != self.modes.len() {
            return Err(ObserverError::ModeCountMismatch {
                what: "new frequency",
                expected: self.modes.len(),
                found: frequencies_hz.len(),
            });
        }
        Self::new(
            self.modes
                .iter()
                .zip(frequencies_hz)
                .map(|(mode, &frequency_hz)| Mode {
                    frequency_hz,
                    ..*mode
                })
                .collect(),
        )
    }

    /// Static tip deflection per force, `sum phi_j^2 / (m_j w_j^2)` in m/N.
    pub fn static_compliance(&self) -> f64 {
        self.modes
            .iter()
            .map(|m| m.tip_value * m.modal_compliance())
            .sum()
    }

    /// Tip acceleration per force, `sum phi_j^2 / m_j` in 1/kg.
    pub fn inverse_tip_mass(&self) -> f64 {
        self.modes
            .iter()
            .map(|m| m.tip_value.powi(2) / m.mass_kg)
            .sum()
    }

    /// Force that holds the tip at constant velocity in the given state, in N:
    /// `F_c = sum phi_j (2 D_j w_j q_j' + w_j^2 q_j) / sum(phi_j^2 / m_j)` (constant belt speed).
    ///
    /// `q` in m and `q_dot` in m/s, one value per mode.
    pub fn constraint_force(&self, q: &[f64], q_dot: &[f64]) -> f64 {
        self.elastic_acceleration(q, q_dot) / self.inverse_tip_mass()
    }

    /// `sum phi_j (2 D_j w_j q_j' + w_j^2 q_j)` in m/s^2; the tip acceleration is
    /// [`Self::inverse_tip_mass`] `* F` less this.
    pub fn elastic_acceleration(&self, q: &[f64], q_dot: &[f64]) -> f64 {
        self.modes
            .iter()
            .zip(q.iter().zip(q_dot))
            .map(|(m, (q, v))| {
                let w = m.angular_frequency();
                m.tip_value * (2.0 * m.damping_ratio * w * v + w * w * q)
            })
            .sum()
    }

    /// Displacement per unit of the scaled force state, `x_s = phi_1 / (m_1 w_1^2)` in m/N.
    pub fn force_scale(&self) -> f64 {
        self.modes[0].modal_compliance()
    }

    /// Checks that the sample interval (s) resolves every mode.
    pub fn check_sampling(&self, sample_interval: f64) -> Result<(), ObserverError> {
        if !(sample_interval > 0.0 && sample_interval.is_finite()) {
            return Err(ObserverError::BadSampleInterval {
                value: sample_interval,
            });
        }
        for (index, mode) in self.modes.iter().enumerate() {
            let needed_hz = SAMPLES_PER_PERIOD * mode.frequency_hz;
            if 1.0 / sample_interval < needed_hz {
                return Err(ObserverError::SamplingTooSlow {
                    sample_rate_hz: 1.0 / sample_interval,
                    mode: index + 1,
                    frequency_hz: mode.frequency_hz,
                    needed_hz,
                });
            }
        }
        Ok(())
    }

    /// The scaled state space, exactly discretised at `sample_interval` (s).
    pub fn discretise(
        &self,
        force_model: ForceModel,
        sample_interval: f64,
    ) -> Result<DiscreteModel, ObserverError> {
        self.check_sampling(sample_interval)?;
        Ok(DiscreteModel {
            transition: self.transition(force_model, sample_interval),
            noise: self.noise(force_model, sample_interval),
            output: self.output(force_model),
            velocity: self.velocity_output(force_model),
            force_index: 2 * self.modes.len(),
            force_scale: self.force_scale(),
            slope_scale: self.force_scale() / self.modes[0].angular_frequency(),
        })
    }

    /// Exact transition matrix over `tau` (s) of the scaled state
    /// `z = [q_1, q_1'/w_1, q_2, q_2'/w_2, ..., F x_s (, F' x_s / w_1)]`, all in m.
    ///
    /// With these scales (and time in `1/sqrt(w_1 w_2)`) the observability matrix of the paper's
    /// beam has condition 270; in SI units it has 1e19.
    pub fn transition(&self, force_model: ForceModel, tau: f64) -> DMatrix<f64> {
        let n = self.modes.len();
        let size = 2 * n + force_model.state_count();
        let x_s = self.force_scale();
        let w_1 = self.modes[0].angular_frequency();
        let mut a = DMatrix::identity(size, size);
        for (j, mode) in self.modes.iter().enumerate() {
            let e = mode.free_motion(tau);
            let w = mode.angular_frequency();
            let s = mode.modal_compliance() / x_s;
            // Constant force: the motion is free about the static deflection (s, 0).
            let held = [(1.0 - e[0][0]) * s, -e[1][0] * s];
            for row in 0..2 {
                a[(2 * j + row, 2 * j)] = e[row][0];
                a[(2 * j + row, 2 * j + 1)] = e[row][1];
                a[(2 * j + row, 2 * n)] = held[row];
            }
            if force_model == ForceModel::IntegratedRandomWalk {
                // Rising force: free about the ramp (s (f - 2 D f'/w), s f'/w), f' = w_1 g.
                let p = [-2.0 * mode.damping_ratio * s * w_1 / w, s * w_1 / w];
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

    fn output(&self, force_model: ForceModel) -> DVector<f64> {
        let mut c = DVector::zeros(2 * self.modes.len() + force_model.state_count());
        for (j, mode) in self.modes.iter().enumerate() {
            c[2 * j] = mode.tip_value;
        }
        c
    }

    fn velocity_output(&self, force_model: ForceModel) -> DVector<f64> {
        let mut c = DVector::zeros(2 * self.modes.len() + force_model.state_count());
        for (j, mode) in self.modes.iter().enumerate() {
            c[2 * j + 1] = mode.tip_value * mode.angular_frequency();
        }
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
    /// Index of the force state.
    pub force_index: usize,
    /// `z[force_index] = force_scale F`, in m/N.
    pub force_scale: f64,
    /// `z[force_index + 1] = slope_scale F'`, in m s/N.
    pub slope_scale: f64,
}

fn check_mode(number: usize, mode: &Mode) -> Result<(), ObserverError> {
    let bad = |what, value, unit, rule| {
        Err(ObserverError::BadModeValue {
            mode: number,
            what,
            value,
            unit,
            rule,
        })
    };
    if !(mode.frequency_hz > 0.0 && mode.frequency_hz.is_finite()) {
        return bad(
            "natural frequency",
            mode.frequency_hz,
            "Hz",
            "must be above 0",
        );
    }
    if !(0.0..1.0).contains(&mode.damping_ratio) {
        return bad(
            "damping ratio",
            mode.damping_ratio,
            "",
            "must be at least 0 and below 1",
        );
    }
    if !(mode.mass_kg > 0.0 && mode.mass_kg.is_finite()) {
        return bad("modal mass", mode.mass_kg, "kg", "must be above 0");
    }
    if !mode.tip_value.is_finite() {
        return bad("tip value", mode.tip_value, "", "must be finite");
    }
    if mode.tip_value == 0.0 {
        return Err(ObserverError::UnobservableMode {
            mode: number,
            frequency_hz: mode.frequency_hz,
        });
    }
    Ok(())
}
