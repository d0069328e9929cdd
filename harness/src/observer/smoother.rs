//! Force and motion from a measured displacement: Kalman filter and fixed-interval smoother.
//!
//! State `[q_1, q_1', ..., q_n, q_n', F]` with `F' = white noise` (random walk; with
//! `F'' = white noise` as a choice), output `w = sum phi_j q_j + offset + sensor noise`. The
//! observer of Stelter 1992 (sect. 5, after Mueller 1990) is the same with `F' = 0` and a gain
//! chosen by poles; here the gain follows from the noise levels, which the data give
//! (maximum likelihood of the innovations, Schweppe 1965), and the later samples are used too
//! (Rauch, Tung, Striebel 1965).
//!
//! Holds for a linear structure whose modes are all given. A natural frequency wrong by 0.1 %
//! adds a third to the error of the force, by 1 % it multiplies it by eight; a mode left out
//! spoils it: look at [`Smoothed::whiteness`] and estimate the frequencies together with the force.

use super::error::ObserverError;
use super::kernel::{self, Likelihood, Problem, Solution};
use super::structure::{DiscreteModel, ForceModel, Structure};
use super::whiteness::Whiteness;
use nalgebra::{DMatrix, DVector};

/// Choices for [`smooth`].
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// How the force is thought to move.
    pub force_model: ForceModel,
    /// Standard deviation of the sensor noise in m; estimated from the data if `None`.
    pub noise_std: Option<f64>,
    /// Intensity of the white noise that drives the force, in N^2/s (random walk) or N^2/s^3
    /// (integrated random walk); estimated from the data if `None`.
    pub force_intensity: Option<f64>,
    /// Sensor offset in m, subtracted from the displacement.
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
    /// Standard deviation of the sensor noise, given or estimated, in m.
    pub noise_std: f64,
    /// Intensity of the noise that drives the force, given or estimated; unit as in
    /// [`Settings::force_intensity`].
    pub force_intensity: f64,
    /// Sensor offset that was subtracted, in m.
    pub offset: f64,
    /// Innovations of the filter over their standard deviation (NaN where no sample).
    pub innovation: Vec<f64>,
    /// Whiteness of the innovations.
    pub whiteness: Whiteness,
    /// Natural logarithm of the likelihood of the record.
    pub log_likelihood: f64,
}

/// Smooths a uniformly sampled displacement.
///
/// `sample_interval` in s; `displacement` in m at the tip, NaN where a sample is missing.
/// Two million state updates per second and more where samples are complete.
pub fn smooth(
    structure: &Structure,
    sample_interval: f64,
    displacement: &[f64],
    settings: &Settings,
) -> Result<Smoothed, ObserverError> {
    let record = Record::new(structure, sample_interval, displacement, settings)?;
    let levels = record.levels(settings)?;
    let solution = kernel::smooth(&record.problem(levels, settings.converged_gain), false);
    Ok(record.unscale(&solution, levels))
}

/// Noise levels in scaled units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Levels {
    /// Variance of the sensor noise in m^2.
    pub noise_variance: f64,
    /// Intensity of the scaled force state in m^2/s.
    pub intensity: f64,
}

/// A checked record with its discretised structure.
pub(super) struct Record<'a> {
    pub structure: &'a Structure,
    pub model: DiscreteModel,
    pub sample_interval: f64,
    pub displacement: Vec<f64>,
    pub offset: f64,
    mean: f64,
    variance: f64,
}

impl<'a> Record<'a> {
    pub fn new(
        structure: &'a Structure,
        sample_interval: f64,
        displacement: &[f64],
        settings: &Settings,
    ) -> Result<Self, ObserverError> {
        let model = structure.discretise(settings.force_model, sample_interval)?;
        check_settings(settings)?;
        let displacement: Vec<f64> = displacement.iter().map(|y| y - settings.offset).collect();
        let (mean, variance) = check_displacement(&displacement, sample_interval, &model)?;
        Ok(Self {
            structure,
            model,
            sample_interval,
            displacement,
            offset: settings.offset,
            mean,
            variance,
        })
    }

    /// A filtering task with constant noise levels.
    pub fn problem(&self, levels: Levels, converge: bool) -> Problem<'_> {
        self.problem_on(&self.displacement, levels, converge)
    }

    /// The same on other displacements (a part of the record).
    pub fn problem_on<'b>(
        &'b self,
        displacement: &'b [f64],
        levels: Levels,
        converge: bool,
    ) -> Problem<'b> {
        let last = self.model.noise.len() - 1;
        let (start, start_covariance) = self.start();
        Problem {
            model: &self.model,
            noise: &self.model.noise[last] * levels.intensity,
            varying: Vec::new(),
            measurement_variance: levels.noise_variance,
            displacement,
            known: None,
            start,
            start_covariance,
            converge,
        }
    }

    /// Start at the static deflection of the mean, with a wide covariance.
    fn start(&self) -> (DVector<f64>, DMatrix<f64>) {
        let size = self.model.output.len();
        let force = self.mean / self.structure.static_compliance();
        let mut start = DVector::zeros(size);
        let mut covariance = DMatrix::zeros(size, size);
        let wide = 100.0 * (self.variance + 1e-4 * self.mean.powi(2));
        for (j, mode) in self.structure.modes().iter().enumerate() {
            start[2 * j] = mode.modal_compliance() * force;
            let q = wide / mode.tip_value.powi(2);
            covariance[(2 * j, 2 * j)] = q;
            covariance[(2 * j + 1, 2 * j + 1)] = q;
        }
        let first = self.structure.modes()[0].tip_value.powi(2);
        for state in self.model.force_index..size {
            covariance[(state, state)] = 10.0 * wide / first;
        }
        start[self.model.force_index] = force * self.model.force_scale;
        (start, covariance)
    }

    /// Noise levels given, or of greatest likelihood.
    pub fn levels(&self, settings: &Settings) -> Result<Levels, ObserverError> {
        let scale = self.intensity_scale();
        let given = settings.force_intensity.map(|q| q * scale);
        if let (Some(std), Some(intensity)) = (settings.noise_std, given) {
            return Ok(Levels {
                noise_variance: std * std,
                intensity,
            });
        }
        let part = self.search_part(settings.search_samples);
        Ok(self.most_likely(part, settings.noise_std.map(|s| s * s), given))
    }

    /// The noise levels of an earlier result in scaled units.
    pub fn scaled_levels(&self, smoothed: &Smoothed) -> Levels {
        Levels {
            noise_variance: smoothed.noise_std.powi(2),
            intensity: smoothed.force_intensity * self.intensity_scale(),
        }
    }

    /// Scaled intensity per intensity in SI units.
    fn intensity_scale(&self) -> f64 {
        match self.model.noise.len() {
            1 => self.model.force_scale.powi(2),
            _ => self.model.slope_scale.powi(2),
        }
    }

    fn search_part(&self, longest: usize) -> &[f64] {
        let n = self.displacement.len();
        let start = n.saturating_sub(longest) / 2;
        &self.displacement[start..(start + longest).min(n)]
    }

    /// Searches the ratio of intensity to noise variance (1-D, golden section after a coarse scan).
    ///
    /// With the noise level unknown, the ratio alone is searched and the level follows in closed
    /// form (concentrated likelihood, Harvey 1989, sect. 3.4.4).
    fn most_likely(&self, part: &[f64], noise: Option<f64>, intensity: Option<f64>) -> Levels {
        let reference = 1e-8 * self.variance;
        let levels_at = |log_ratio: f64| -> (Levels, Likelihood) {
            let ratio = log_ratio.exp();
            let levels = match (noise, intensity) {
                (Some(r), _) => Levels {
                    noise_variance: r,
                    intensity: ratio * r,
                },
                (None, Some(q)) => Levels {
                    noise_variance: q / ratio,
                    intensity: q,
                },
                (None, None) => Levels {
                    noise_variance: reference,
                    intensity: ratio * reference,
                },
            };
            (
                levels,
                kernel::likelihood(&self.problem_on(part, levels, true)),
            )
        };
        let free = noise.is_none() && intensity.is_none();
        let cost = |log_ratio: f64| {
            let terms = levels_at(log_ratio).1;
            if free {
                terms.count * (terms.sum_square / terms.count).ln() + terms.sum_log
            } else {
                terms.sum_square + terms.sum_log
            }
        };
        // A force of the size of the signal in one period of mode 1, against noise 1e-2 to 1e-6.
        let rate = self.structure.modes()[0].frequency_hz;
        let centre = (1e6 * rate).ln();
        let best = minimise(cost, centre, 5.0_f64.ln(), 12, 0.02);
        let (mut levels, terms) = levels_at(best);
        if free {
            let factor = terms.sum_square / terms.count;
            levels.noise_variance *= factor;
            levels.intensity *= factor;
        }
        levels
    }

    /// Physical columns from scaled states.
    pub fn unscale(&self, solution: &Solution, levels: Levels) -> Smoothed {
        let modes = self.structure.modes();
        let size = solution.size;
        let column = |index: usize, factor: f64| -> Vec<f64> {
            let states = solution.states.chunks_exact(size);
            states.map(|z| z[index] * factor).collect()
        };
        let q: Vec<Vec<f64>> = (0..modes.len()).map(|j| column(2 * j, 1.0)).collect();
        let q_dot: Vec<Vec<f64>> = (0..modes.len())
            .map(|j| column(2 * j + 1, modes[j].angular_frequency()))
            .collect();
        let force = column(self.model.force_index, 1.0 / self.model.force_scale);
        let tip = |columns: &[Vec<f64>]| -> Vec<f64> {
            (0..force.len())
                .map(|k| {
                    modes
                        .iter()
                        .zip(columns)
                        .map(|(m, c)| m.tip_value * c[k])
                        .sum()
                })
                .collect()
        };
        let (displacement, velocity) = (tip(&q), tip(&q_dot));
        let acceleration = acceleration(self.structure, &q, &q_dot, &force);
        let std = |variance: &[f64], factor: f64| -> Vec<f64> {
            variance.iter().map(|v| v.sqrt() * factor).collect()
        };
        let terms = solution.likelihood;
        Smoothed {
            sample_interval: self.sample_interval,
            q,
            q_dot,
            force_std: std(&solution.variance[0], 1.0 / self.model.force_scale.abs()),
            force,
            displacement,
            displacement_std: std(&solution.variance[1], 1.0),
            velocity,
            velocity_std: std(&solution.variance[2], 1.0),
            acceleration,
            noise_std: levels.noise_variance.sqrt(),
            force_intensity: levels.intensity / self.intensity_scale(),
            offset: self.offset,
            whiteness: Whiteness::of(&solution.innovation, self.sample_interval),
            innovation: solution.innovation.clone(),
            log_likelihood: -0.5
                * (terms.count * (2.0 * std::f64::consts::PI).ln()
                    + terms.sum_log
                    + terms.sum_square),
        }
    }
}

fn acceleration(
    structure: &Structure,
    q: &[Vec<f64>],
    q_dot: &[Vec<f64>],
    force: &[f64],
) -> Vec<f64> {
    let driven = structure.inverse_tip_mass();
    let mut out: Vec<f64> = force.iter().map(|f| driven * f).collect();
    for (mode, (q, v)) in structure.modes().iter().zip(q.iter().zip(q_dot)) {
        let w = mode.angular_frequency();
        for (a, (q, v)) in out.iter_mut().zip(q.iter().zip(v)) {
            *a -= mode.tip_value * (2.0 * mode.damping_ratio * w * v + w * w * q);
        }
    }
    out
}

/// Minimum of `cost`: coarse scan of `2 count + 1` points `step` apart about `centre`, then golden
/// section down to `tolerance`.
pub(super) fn minimise(
    cost: impl Fn(f64) -> f64,
    centre: f64,
    step: f64,
    count: i32,
    tolerance: f64,
) -> f64 {
    let best = (-count..=count)
        .map(|i| centre + f64::from(i) * step)
        .map(|x| (x, cost(x)))
        .filter(|(_, c)| !c.is_nan())
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(centre, |(x, _)| x);
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let (mut low, mut high) = (best - step, best + step);
    let mut left = high - golden * (high - low);
    let mut right = low + golden * (high - low);
    let (mut at_left, mut at_right) = (cost(left), cost(right));
    while high - low > tolerance {
        if at_left < at_right {
            (high, right, at_right) = (right, left, at_left);
            left = high - golden * (high - low);
            at_left = cost(left);
        } else {
            (low, left, at_left) = (left, right, at_right);
            right = low + golden * (high - low);
            at_right = cost(right);
        }
    }
    0.5 * (low + high)
}

fn check_settings(settings: &Settings) -> Result<(), ObserverError> {
    let bad = |name, value, unit, rule| {
        Err(ObserverError::BadSetting {
            name,
            value,
            unit,
            rule,
        })
    };
    let positive = |v: f64| v > 0.0 && v.is_finite();
    if let Some(value) = settings.noise_std.filter(|v| !positive(*v)) {
        return bad("noise_std", value, "m", "must be above 0");
    }
    if let Some(value) = settings.force_intensity.filter(|v| !positive(*v)) {
        return bad("force_intensity", value, "N^2/s", "must be above 0");
    }
    if !settings.offset.is_finite() {
        return bad("offset", settings.offset, "m", "must be finite");
    }
    if settings.search_samples < 100 {
        return bad(
            "search_samples",
            settings.search_samples as f64,
            "samples",
            "at least 100",
        );
    }
    Ok(())
}

/// Mean and variance of the finite samples.
fn check_displacement(
    displacement: &[f64],
    sample_interval: f64,
    model: &DiscreteModel,
) -> Result<(f64, f64), ObserverError> {
    if let Some(index) = displacement.iter().position(|y| y.is_infinite()) {
        return Err(ObserverError::InfiniteSample {
            index,
            time_s: index as f64 * sample_interval,
        });
    }
    let finite = || displacement.iter().filter(|y| !y.is_nan());
    let found = finite().count();
    let needed = 4 * model.output.len();
    if found < needed {
        return Err(ObserverError::TooFewSamples { found, needed });
    }
    let mean = finite().sum::<f64>() / found as f64;
    let variance = finite().map(|y| (y - mean).powi(2)).sum::<f64>() / found as f64;
    let value_m = finite().copied().next().unwrap_or(f64::NAN);
    if finite().all(|y| *y == value_m) {
        return Err(ObserverError::ConstantSignal {
            value_m,
            count: found,
        });
    }
    Ok((mean, variance))
}
