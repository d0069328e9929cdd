//! Poles and gain of the extended state observer of Stelter 1992, eqs. (10), (11).
//!
//! With one output the gain that gives `A_e - v c'` the poles `p_k` is unique. In the eigenvectors
//! of the scaled `A_e` it has a closed form, without characteristic polynomial or inverse:
//!
//! `l_i = prod_k (lambda_i - p_k) / [c_i prod_(j != i) (lambda_i - lambda_j)]`, `L = V l`
//!
//! (partial fractions of Ackermann's formula, 1972), also for repeated poles. In raw SI units the
//! observability matrix has condition 1e19 and library routines refuse or misplace poles.

use super::error::ObserverError;
use super::smoother::{Record, Settings};
use super::structure::{ForceModel, Structure};
use crate::measurement::Measurand;
use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::PI;

/// A rule for the `2 n + 1` observer poles.
#[derive(Debug, Clone, PartialEq)]
pub enum PoleRule {
    /// These poles, in 1/s; complex ones with their conjugates.
    Given(Vec<Complex<f64>>),
    /// All poles on a half circle of this radius (Hz), as of a Butterworth filter.
    Butterworth {
        /// Radius over 2 pi, in Hz.
        frequency_hz: f64,
    },
    /// All poles equal and real, at minus this frequency (Hz).
    EqualReal {
        /// Distance from the origin over 2 pi, in Hz.
        frequency_hz: f64,
    },
    /// Two poles at each transmission zero, where the optimal observer of a beam measured where it
    /// is driven has them, the remaining three as of a Butterworth filter of this radius (Hz).
    AtZeros {
        /// Radius over 2 pi, in Hz.
        frequency_hz: f64,
    },
    /// [`PoleRule::AtZeros`] with the radius at which force and sensor noise balance,
    /// `w_c^6 = (sum phi_j^2/m_j)^2 q / (r T)`: `q` (N^2/s) and `r` (m^2) the noise levels of
    /// greatest likelihood of a random-walk force, `T` the sample interval. Above `w_c` the
    /// displacement holds more noise than force.
    FromData,
}

/// Damping ratio of the poles placed at undamped transmission zeros.
const ZERO_DAMPING: f64 = 0.1;

impl PoleRule {
    /// The poles in 1/s for a structure and, with [`PoleRule::FromData`], a record.
    pub fn poles(
        &self,
        structure: &Structure,
        sample_interval: f64,
        displacement: &[f64],
    ) -> Result<Vec<Complex<f64>>, ObserverError> {
        let count = 2 * structure.modes().len() + 1;
        let poles = match self {
            PoleRule::Given(poles) => poles.clone(),
            PoleRule::Butterworth { frequency_hz } => butterworth(count, radius(*frequency_hz)?),
            PoleRule::EqualReal { frequency_hz } => {
                vec![Complex::new(-radius(*frequency_hz)?, 0.0); count]
            }
            PoleRule::AtZeros { frequency_hz } => at_zeros(structure, radius(*frequency_hz)?),
            PoleRule::FromData => {
                let w = balance(structure, sample_interval, displacement)?;
                at_zeros(structure, w)
            }
        };
        check_poles(&poles, count)?;
        Ok(poles)
    }
}

/// Angular frequency (rad/s) at which force and sensor noise balance; see [`PoleRule::FromData`].
fn balance(
    structure: &Structure,
    sample_interval: f64,
    displacement: &[f64],
) -> Result<f64, ObserverError> {
    let settings = Settings::default();
    let record = Record::new(structure, sample_interval, displacement, &settings)?;
    let levels = record.levels(&settings)?;
    let intensity = levels.intensity / record.model.force_scale.powi(2);
    let ratio = intensity / (levels.noise_variance * sample_interval);
    Ok((structure.inverse_tip_mass().powi(2) * ratio).powf(1.0 / 6.0))
}

fn radius(frequency_hz: f64) -> Result<f64, ObserverError> {
    if frequency_hz > 0.0 && frequency_hz.is_finite() {
        return Ok(2.0 * PI * frequency_hz);
    }
    Err(ObserverError::BadSetting {
        name: "pole frequency",
        value: frequency_hz,
        unit: "Hz",
        rule: "must be above 0",
    })
}

/// Poles of a Butterworth filter of order `count` (Butterworth 1930).
fn butterworth(count: usize, radius: f64) -> Vec<Complex<f64>> {
    (0..count)
        .map(|k| {
            let angle = PI * (0.5 + (2 * k + 1) as f64 / (2 * count) as f64);
            let imaginary = if 2 * k + 1 == count {
                0.0
            } else {
                radius * angle.sin()
            };
            // Conjugate pairs exactly.
            Complex::new(radius * angle.cos(), imaginary)
        })
        .collect()
}

fn at_zeros(structure: &Structure, radius: f64) -> Vec<Complex<f64>> {
    let mut poles = butterworth(3, radius);
    for w in transmission_zeros(structure) {
        let real = -ZERO_DAMPING * w;
        let imaginary = w * (1.0 - ZERO_DAMPING * ZERO_DAMPING).sqrt();
        poles.push(Complex::new(real, imaginary));
        poles.push(Complex::new(real, -imaginary));
    }
    poles
}

/// Angular frequencies (rad/s) at which a force at the tip does not move the tip, undamped:
/// roots of `sum_j (phi_j^2/m_j) / (w_j^2 - w^2)`, one between any two natural frequencies.
///
/// For two modes with equal `phi^2/m`: `sqrt((w_1^2 + w_2^2) / 2)`.
pub fn transmission_zeros(structure: &Structure) -> Vec<f64> {
    let mut modes: Vec<(f64, f64)> = structure
        .modes()
        .iter()
        .map(|m| {
            (
                m.angular_frequency().powi(2),
                m.tip_value.powi(2) / m.mass_kg,
            )
        })
        .collect();
    modes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let response = |square: f64| -> f64 { modes.iter().map(|(w2, b)| b / (w2 - square)).sum() };
    modes
        .windows(2)
        .map(|pair| {
            // Rises from minus to plus infinity between two poles.
            let (mut low, mut high) = (pair[0].0, pair[1].0);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if response(middle) < 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            (0.5 * (low + high)).sqrt()
        })
        .collect()
}

fn check_poles(poles: &[Complex<f64>], needed: usize) -> Result<(), ObserverError> {
    if poles.len() != needed {
        return Err(ObserverError::PoleCount {
            needed,
            found: poles.len(),
        });
    }
    if let Some(index) = poles
        .iter()
        .position(|p| !(p.re < 0.0 && p.re.is_finite() && p.im.is_finite()))
    {
        return Err(ObserverError::UnstablePole {
            index: index + 1,
            real_per_s: poles[index].re,
            imaginary_per_s: poles[index].im,
        });
    }
    let mut open: Vec<Complex<f64>> = poles.iter().filter(|p| p.im != 0.0).copied().collect();
    while let Some(pole) = open.pop() {
        let partner = open
            .iter()
            .position(|p| (p.conj() - pole).norm() <= 1e-9 * pole.norm());
        match partner {
            Some(index) => open.swap_remove(index),
            None => {
                return Err(ObserverError::UnpairedPole {
                    real_per_s: pole.re,
                    imaginary_per_s: pole.im,
                });
            }
        };
    }
    Ok(())
}

/// Eigenvalues of the extended system (1/s), mode by mode, the force's 0 last, and the scaled
/// eigenvectors `(1, lambda/w)` of each mode and `(compliances, 0, ..., 1)` of the force.
fn eigen(structure: &Structure) -> (Vec<Complex<f64>>, DMatrix<Complex<f64>>) {
    let n = structure.modes().len();
    let size = 2 * n + 1;
    let mut values = Vec::with_capacity(size);
    let mut vectors = DMatrix::zeros(size, size);
    for (j, mode) in structure.modes().iter().enumerate() {
        let w = mode.angular_frequency();
        let damping = mode.whole_damping_ratio();
        for (i, sign) in [1.0, -1.0].into_iter().enumerate() {
            let value = Complex::new(-damping * w, sign * w * (1.0 - damping * damping).sqrt());
            vectors[(2 * j, 2 * j + i)] = Complex::new(1.0, 0.0);
            vectors[(2 * j + 1, 2 * j + i)] = value / w;
            values.push(value);
        }
        let compliance = mode.modal_compliance() / structure.force_scale();
        vectors[(2 * j, 2 * n)] = Complex::new(compliance, 0.0);
    }
    vectors[(2 * n, 2 * n)] = Complex::new(1.0, 0.0);
    values.push(Complex::new(0.0, 0.0));
    (values, vectors)
}

/// Gain in eigenvector coordinates for eigenvalues and poles of either kind of time.
fn modal_gain(
    structure: &Structure,
    values: &[Complex<f64>],
    vectors: &DMatrix<Complex<f64>>,
    poles: &[Complex<f64>],
) -> DVector<Complex<f64>> {
    let size = values.len();
    DVector::from_fn(size, |i, _| {
        let seen: Complex<f64> = structure
            .modes()
            .iter()
            .enumerate()
            .map(|(j, mode)| vectors[(2 * j, i)] * mode.tip_value)
            .sum();
        // Factor by factor, so that no product over- or underflows.
        let mut gain = (values[i] - poles[i]) / seen;
        for j in (0..size).filter(|j| *j != i) {
            gain *= (values[i] - poles[j]) / (values[i] - values[j]);
        }
        gain
    })
}

/// Gain `v` of the continuous observer (eq. 10) in SI units: `[q_1 (1/s), q_1' (1/s^2), ...,
/// F (N/(m s))]`, for `2 n + 1` poles in 1/s.
pub fn continuous_gain(
    structure: &Structure,
    poles: &[Complex<f64>],
) -> Result<DVector<f64>, ObserverError> {
    check_poles(poles, 2 * structure.modes().len() + 1)?;
    let (values, vectors) = eigen(structure);
    let gain = &vectors * modal_gain(structure, &values, &vectors, poles);
    let mut gain = gain.map(|g| g.re);
    for (j, mode) in structure.modes().iter().enumerate() {
        gain[2 * j + 1] *= mode.angular_frequency();
    }
    gain[2 * structure.modes().len()] /= structure.force_scale();
    Ok(gain)
}

/// Gain `K` of the exactly discretised observer, scaled states, as a filter:
/// `z_(k|k) = z_(k|k-1) + K (w_k - c z_(k|k-1))`; its poles are `exp(p_k T)`.
pub fn discrete_gain(
    structure: &Structure,
    poles: &[Complex<f64>],
    sample_interval: f64,
) -> Result<DVector<f64>, ObserverError> {
    structure.check_sampling(sample_interval)?;
    check_poles(poles, 2 * structure.modes().len() + 1)?;
    let (values, vectors) = eigen(structure);
    let step = |p: &Complex<f64>| (p * sample_interval).exp();
    let values: Vec<_> = values.iter().map(step).collect();
    let poles: Vec<_> = poles.iter().map(step).collect();
    // The predictor's gain is A K, and the eigenvectors of A are those of the continuous system.
    let mut gain = modal_gain(structure, &values, &vectors, &poles);
    for (gain, value) in gain.iter_mut().zip(&values) {
        *gain /= *value;
    }
    Ok((vectors * gain).map(|g| g.re))
}

/// The extended system matrix `A_e` in SI units, state `[q_1, q_1', ..., q_n, q_n', F]`.
pub fn extended_matrix(structure: &Structure) -> DMatrix<f64> {
    let n = structure.modes().len();
    let mut a = DMatrix::zeros(2 * n + 1, 2 * n + 1);
    for (j, mode) in structure.modes().iter().enumerate() {
        let w = mode.angular_frequency();
        a[(2 * j, 2 * j + 1)] = 1.0;
        a[(2 * j + 1, 2 * j)] = -w * w;
        a[(2 * j + 1, 2 * j + 1)] = -mode.damping();
        a[(2 * j + 1, 2 * n)] = mode.tip_value / mode.mass_kg;
    }
    a
}

/// The observer matrix `A_B = A_e - v c'` of eq. (11) in SI units for the gain `v`.
pub fn observer_matrix(structure: &Structure, gain: &DVector<f64>) -> DMatrix<f64> {
    let mut a = extended_matrix(structure);
    for (j, mode) in structure.modes().iter().enumerate() {
        for row in 0..a.nrows() {
            a[(row, 2 * j)] -= gain[row] * mode.tip_value;
        }
    }
    a
}

/// Delay of the estimated force at low frequency in s, `-sum 1/p_k` (the transfer function from
/// force to estimate is `prod(-p_k) / prod(s - p_k)` times the structure's undamped zeros).
pub fn delay(poles: &[Complex<f64>]) -> f64 {
    -poles.iter().map(|p| p.inv().re).sum::<f64>()
}

/// The discretised model used with [`discrete_gain`].
pub(super) fn model(
    structure: &Structure,
    sample_interval: f64,
) -> Result<super::structure::DiscreteModel, ObserverError> {
    structure.discretise(
        ForceModel::RandomWalk,
        sample_interval,
        Measurand::Displacement,
    )
}
