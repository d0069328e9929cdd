//! The linear part of the rig: vibration modes driven at the tip, and measured there or at another point `s`.
//!
//! `q_j'' + (2 D_j w_j + d_j) q_j' + w_j^2 q_j = phi_j F / m_j`, `w_tip = sum_j phi_j q_j`, `w_s = sum_j phi_j(s) q_j`
//! (Stelter 1992, eqs. 2, 3, with `d_j = 0`; `phi_j = phi_j(1)`), with the contact force as additional state:
//! `F' = 0` (his eq. 10), or driven by white noise for the Kalman filter.

mod discrete;

use super::error::ObserverError;
pub use discrete::{DiscreteModel, ForceModel};
use std::f64::consts::PI;

/// Largest number of modes.
pub const MODE_LIMIT: usize = 16;

/// Least number of samples per period of the highest mode.
const SAMPLES_PER_PERIOD: f64 = 2.5;

/// Rate in 1/s by which the motion of a mode without a spring is scaled: 16 Hz, among the modes of rigs that rub.
const FREE_RATE: f64 = 100.0;

/// One vibration mode as seen at the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mode {
    /// Natural frequency `f_j` in Hz; 0 for a mass that slides freely.
    pub frequency_hz: f64,
    /// Damping ratio `D_j` (1), at least 0 and below 1.
    pub damping_ratio: f64,
    /// Damping rate `d_j` in 1/s beside it, a viscous damper over the modal mass: the damping of a mass that slides freely.
    pub damping_rate: f64,
    /// Modal mass `m_j` in kg.
    pub mass_kg: f64,
    /// Value of the mode shape at the tip, `phi_j(1)` (1).
    pub tip_value: f64,
    /// Value of the mode shape where the sensor looks over that at the tip, `phi_j(s) / phi_j(1)` (1).
    pub sensor_ratio: f64,
    /// Share of the mode in what the tip does where the clamp moves (1): its modal acceleration is `-share/phi_j(1)` times that of the
    /// clamp.
    pub clamp_share: f64,
}

impl Mode {
    /// Value of the mode shape where the sensor looks, `phi_j(s)` (1).
    pub fn sensor_value(&self) -> f64 {
        self.tip_value * self.sensor_ratio
    }

    /// Natural angular frequency `w_j = 2 pi f_j` in rad/s.
    pub fn angular_frequency(&self) -> f64 {
        2.0 * PI * self.frequency_hz
    }

    /// Rate in 1/s by which velocities of the mode are scaled: its angular frequency, or a fixed one where it has no spring.
    pub fn rate(&self) -> f64 {
        if self.is_free() {
            FREE_RATE
        } else {
            self.angular_frequency()
        }
    }

    /// All its damping, `2 D_j w_j + d_j` in 1/s.
    pub fn damping(&self) -> f64 {
        2.0 * self.damping_ratio * self.angular_frequency() + self.damping_rate
    }

    /// All damping of a mode with a spring as a damping ratio, `D_j + d_j / (2 w_j)`.
    pub fn whole_damping_ratio(&self) -> f64 {
        self.damping_ratio + 0.5 * self.damping_rate / self.rate()
    }

    /// Whether it has no spring.
    pub fn is_free(&self) -> bool {
        self.frequency_hz == 0.0
    }

    /// Static modal deflection per force at the tip, `phi_j / (m_j w_j^2)` in m/N; with [`Self::rate`] for `w_j` a scale
    /// where the mode has no spring.
    pub fn modal_compliance(&self) -> f64 {
        self.tip_value / (self.mass_kg * self.rate().powi(2))
    }
}

/// A linear modal structure with a force at the tip and a sensor there or elsewhere ([`Mode::sensor_ratio`]).
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
        if modes.iter().all(|mode| mode.sensor_ratio == 0.0) {
            return Err(ObserverError::BlindSensor { count: modes.len() });
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
                    damping_rate: 0.0,
                    mass_kg: masses_kg[j],
                    tip_value: tip_values[j],
                    sensor_ratio: 1.0,
                    clamp_share: 1.0 / expected as f64,
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
            damping_rate: 0.0,
            mass_kg,
            tip_value: 1.0,
            sensor_ratio: 1.0,
            clamp_share: 1.0,
        }])
    }

    /// The modes.
    pub fn modes(&self) -> &[Mode] {
        &self.modes
    }

    /// The same structure with a sensor elsewhere: `ratios` of [`Mode::sensor_ratio`], one for each mode from the first on; 1 for those
    /// that are left out.
    ///
    /// # Errors
    /// A ratio that is no finite number; a sensor that sees no mode.
    pub fn with_sensor(&self, ratios: &[f64]) -> Result<Self, ObserverError> {
        let ratios = ratios.iter().copied().chain(std::iter::repeat(1.0));
        let modes = self.modes.iter().zip(ratios);
        let modes = modes.map(|(mode, sensor_ratio)| Mode {
            sensor_ratio,
            ..*mode
        });
        Self::new(modes.collect())
    }

    /// The same structure with dampers beside the damping ratios: `rates` of [`Mode::damping_rate`] in 1/s, one for each mode from the
    /// first on; 0 for those that are left out.
    ///
    /// # Errors
    /// A rate below 0 or no finite number, or one that leaves a mode with a spring overdamped.
    pub fn with_damping_rates(&self, rates: &[f64]) -> Result<Self, ObserverError> {
        let rates = rates.iter().copied().chain(std::iter::repeat(0.0));
        let modes = self.modes.iter().zip(rates);
        let modes = modes.map(|(mode, damping_rate)| Mode {
            damping_rate,
            ..*mode
        });
        Self::new(modes.collect())
    }

    /// Whether the sensor looks at the tip, where the force acts.
    pub fn is_collocated(&self) -> bool {
        self.modes.iter().all(|mode| mode.sensor_ratio == 1.0)
    }

    /// Static deflection where the sensor looks per force at the tip, in m/N.
    pub fn sensor_compliance(&self) -> f64 {
        let modes = self.modes.iter();
        modes.map(|m| m.sensor_value() * m.modal_compliance()).sum()
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
    /// `F_c = sum phi_j ((2 D_j w_j + d_j) q_j' + w_j^2 q_j) / sum(phi_j^2 / m_j)` (constant belt speed).
    ///
    /// `q` in m and `q_dot` in m/s, one value per mode.
    pub fn constraint_force(&self, q: &[f64], q_dot: &[f64]) -> f64 {
        self.elastic_acceleration(q, q_dot) / self.inverse_tip_mass()
    }

    /// `sum phi_j ((2 D_j w_j + d_j) q_j' + w_j^2 q_j)` in m/s^2; the tip acceleration is
    /// [`Self::inverse_tip_mass`] `* F` less this.
    pub fn elastic_acceleration(&self, q: &[f64], q_dot: &[f64]) -> f64 {
        self.modes
            .iter()
            .zip(q.iter().zip(q_dot))
            .map(|(m, (q, v))| {
                let w = m.angular_frequency();
                m.tip_value * (m.damping() * v + w * w * q)
            })
            .sum()
    }

    /// Displacement per unit of the scaled force state, `x_s = phi_1 / (m_1 w_1^2)` in m/N.
    pub fn force_scale(&self) -> f64 {
        self.modes[0].modal_compliance()
    }

    /// Whether a mode has no spring, so that a constant force leads to no deflection at rest.
    pub fn is_free(&self) -> bool {
        self.modes.iter().any(Mode::is_free)
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
    if !(mode.frequency_hz >= 0.0 && mode.frequency_hz.is_finite()) {
        return bad(
            "natural frequency",
            mode.frequency_hz,
            "Hz",
            "must be at least 0",
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
    let is_light = mode.is_free() || mode.whole_damping_ratio() < 1.0;
    if !(mode.damping_rate >= 0.0 && mode.damping_rate.is_finite() && is_light) {
        return bad(
            "damping rate",
            mode.damping_rate,
            "1/s",
            "must be at least 0 and leave the mode less than critically damped",
        );
    }
    if !(mode.mass_kg > 0.0 && mode.mass_kg.is_finite()) {
        return bad("modal mass", mode.mass_kg, "kg", "must be above 0");
    }
    if !mode.tip_value.is_finite() {
        return bad("tip value", mode.tip_value, "", "must be finite");
    }
    if !mode.sensor_ratio.is_finite() {
        return bad("sensor ratio", mode.sensor_ratio, "", "must be finite");
    }
    if mode.tip_value == 0.0 {
        return Err(ObserverError::UnobservableMode {
            mode: number,
            frequency_hz: mode.frequency_hz,
        });
    }
    Ok(())
}
