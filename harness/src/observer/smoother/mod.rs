//! Force and motion from a measured displacement, velocity or acceleration: Kalman filter and fixed-interval smoother.
//!
//! State `[q_1, q_1', ..., q_n, q_n', F]` with `F' = white noise` (random walk; with
//! `F'' = white noise` as a choice), output `w = sum phi_j q_j + offset + sensor noise`, or
//! `w' = sum phi_j q_j' + offset + sensor noise`, or
//! `w'' = sum phi_j (phi_j F / m_j - 2 D_j w_j q_j' - w_j^2 q_j) + offset + sensor noise`. The
//! observer of Stelter 1992 (sect. 5, after Mueller 1990) is the same with `F' = 0` and a gain
//! chosen by poles; here the gain follows from the noise levels, which the data give
//! (maximum likelihood of the innovations, Schweppe 1965), and the later samples are used too
//! (Rauch, Tung, Striebel 1965).
//!
//! A velocity says nothing of a constant force and of the deflection that balances it: with
//! springs, force and displacement are then found up to such a level, near zero at the start. Of an
//! acceleration that holds too, and a slow change of velocity shows in it hardly at all: only where
//! the velocity is known besides, as in stick, it is found.
//!
//! Holds for a linear structure whose modes are all given. A natural frequency wrong by 0.1 %
//! adds a third to the error of the force, by 1 % it multiplies it by eight; a mode left out
//! spoils it: look at [`Smoothed::whiteness`] and estimate the frequencies together with the force.

mod levels;
mod record;

use super::error::ObserverError;
use super::kernel;
use super::structure::{ForceModel, Structure};
use super::whiteness::Whiteness;
use crate::measurement::Measurand;
pub(super) use levels::{Levels, minimise};
pub(super) use record::Record;

/// Choices for [`smooth`].
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// What is measured.
    pub measurand: Measurand,
    /// How the force is thought to move.
    pub force_model: ForceModel,
    /// Standard deviation of the sensor noise in m (m/s, m/s^2); estimated from the data if `None`.
    pub noise_std: Option<f64>,
    /// Intensity of the white noise that drives the force, in N^2/s (random walk) or N^2/s^3
    /// (integrated random walk); estimated from the data if `None`.
    pub force_intensity: Option<f64>,
    /// Sensor offset in m (m/s, m/s^2), subtracted from what is measured.
    ///
    /// A constant offset and a constant force look the same in the displacement of a linear
    /// structure, so it cannot be estimated here.
    pub offset: f64,
    /// Use the converged gain wherever samples are complete (same numbers, much faster).
    pub converged_gain: bool,
    /// Longest part of the record used to estimate the noise levels, in samples.
    pub search_samples: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            measurand: Measurand::Displacement,
            force_model: ForceModel::RandomWalk,
            noise_std: None,
            force_intensity: None,
            offset: 0.0,
            converged_gain: true,
            search_samples: 60_000,
        }
    }
}

/// What the smoother finds; one value per sample in every column.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// Sample interval in s.
    pub sample_interval: f64,
    /// Modal coordinates `q[j][k]` in m.
    pub q: Vec<Vec<f64>>,
    /// Modal velocities `q_dot[j][k]` in m/s.
    pub q_dot: Vec<Vec<f64>>,
    /// Contact force on the tip in N, positive along the belt's motion.
    pub force: Vec<f64>,
    /// Standard deviation of the force in N (for right structure and noise model).
    pub force_std: Vec<f64>,
    /// Tip displacement without noise and offset in m.
    pub displacement: Vec<f64>,
    /// Its standard deviation in m.
    pub displacement_std: Vec<f64>,
    /// Tip velocity in m/s.
    pub velocity: Vec<f64>,
    /// Its standard deviation in m/s.
    pub velocity_std: Vec<f64>,
    /// Tip acceleration in m/s^2, `sum phi_j (phi_j F / m_j - 2 D_j w_j q_j' - w_j^2 q_j)`.
    pub acceleration: Vec<f64>,
    /// Standard deviation of the sensor noise, given or estimated, in m (m/s, m/s^2).
    pub noise_std: f64,
    /// Intensity of the noise that drives the force, given or estimated; unit as in
    /// [`Settings::force_intensity`].
    pub force_intensity: f64,
    /// Sensor offset that was subtracted, in m (m/s, m/s^2).
    pub offset: f64,
    /// Innovations of the filter over their standard deviation (NaN where no sample).
    pub innovation: Vec<f64>,
    /// Whiteness of the innovations.
    pub whiteness: Whiteness,
    /// Natural logarithm of the likelihood of the record.
    pub log_likelihood: f64,
}

/// Smooths a uniformly sampled displacement, velocity or acceleration ([`Settings::measurand`]).
///
/// `sample_interval` in s; `measured` in m (m/s, m/s^2) at the tip, NaN where a sample is missing.
/// Two million state updates per second and more where samples are complete.
pub fn smooth(
    structure: &Structure,
    sample_interval: f64,
    measured: &[f64],
    settings: &Settings,
) -> Result<Smoothed, ObserverError> {
    let record = Record::new(structure, sample_interval, measured, settings)?;
    let levels = record.levels(settings)?;
    let solution = kernel::smooth(&record.problem(levels, settings.converged_gain), false);
    Ok(record.unscale(&solution, levels))
}
