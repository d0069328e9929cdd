//! A checked record with its structure: from what is measured to filtering task, and back to forces.

use super::levels::Levels;
use super::{Settings, Smoothed};
use crate::measurement::Measurand;
use crate::observer::error::ObserverError;
use crate::observer::kernel::{Problem, Solution};
use crate::observer::structure::{DiscreteModel, Structure};
use crate::observer::whiteness::Whiteness;
use nalgebra::{DMatrix, DVector};

/// A checked record with its discretised structure.
pub(in crate::observer) struct Record<'a> {
    pub structure: &'a Structure,
    pub model: DiscreteModel,
    pub sample_interval: f64,
    /// What was measured less the offset, in m, m/s or m/s^2.
    pub measured: Vec<f64>,
    pub offset: f64,
    pub(super) mean: f64,
    pub(super) variance: f64,
}

impl<'a> Record<'a> {
    pub fn new(
        structure: &'a Structure,
        sample_interval: f64,
        measured: &[f64],
        settings: &Settings,
    ) -> Result<Self, ObserverError> {
        let model =
            structure.discretise(settings.force_model, sample_interval, settings.measurand)?;
        check_settings(settings)?;
        let measured: Vec<f64> = measured.iter().map(|y| y - settings.offset).collect();
        let (mean, variance) = check_measured(&measured, sample_interval, &model)?;
        Ok(Self {
            structure,
            model,
            sample_interval,
            measured,
            offset: settings.offset,
            mean,
            variance,
        })
    }

    /// A filtering task with constant noise levels.
    pub fn problem(&self, levels: Levels, converge: bool) -> Problem<'_> {
        self.problem_on(&self.measured, levels, converge)
    }

    /// The same on other samples (a part of the record).
    pub fn problem_on<'b>(
        &'b self,
        measured: &'b [f64],
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
            measured,
            known: None,
            start,
            start_covariance,
            converge,
        }
    }

    /// Factor from a displacement in m to what is measured, by size: that of a motion at the rate of the first mode.
    pub(super) fn per_displacement(&self) -> f64 {
        match self.model.measures {
            Measurand::Displacement => 1.0,
            Measurand::Velocity => self.structure.modes()[0].rate(),
            Measurand::Acceleration => self.structure.modes()[0].rate().powi(2),
        }
    }

    /// Mean displacement of the tip in m and variance of it in m^2, from those where the sensor looks by the shape that a force at the
    /// tip bends. A velocity or an acceleration says nothing of where the tip rests: a
    /// constant force and the deflection that balances it are taken to be zero, and stay so.
    fn displacement_level(&self) -> (f64, f64) {
        let lever = self.structure.static_compliance() / self.structure.sensor_compliance();
        let (mean, variance) = (lever * self.mean, lever * lever * self.variance);
        match self.model.measures {
            Measurand::Displacement => (mean, variance),
            Measurand::Velocity | Measurand::Acceleration => {
                (0.0, variance / self.per_displacement().powi(2))
            }
        }
    }

    /// Start at the static deflection of the mean, with a wide covariance.
    fn start(&self) -> (DVector<f64>, DMatrix<f64>) {
        let size = self.model.output.len();
        let (mean, variance) = self.displacement_level();
        // Where no spring holds the mass, its place says nothing of the force.
        let force = if self.structure.is_free() {
            0.0
        } else {
            mean / self.structure.static_compliance()
        };
        let mut start = DVector::zeros(size);
        let mut covariance = DMatrix::zeros(size, size);
        let wide = 100.0 * (variance + 1e-4 * mean.powi(2));
        for (j, mode) in self.structure.modes().iter().enumerate() {
            start[2 * j] = mode.modal_compliance() * force;
            if mode.is_free() {
                start[2 * j] = mean / mode.tip_value;
            }
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
            .map(|j| column(2 * j + 1, modes[j].rate()))
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
            *a -= mode.tip_value * (mode.damping() * v + w * w * q);
        }
    }
    out
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
fn check_measured(
    measured: &[f64],
    sample_interval: f64,
    model: &DiscreteModel,
) -> Result<(f64, f64), ObserverError> {
    if let Some(index) = measured.iter().position(|y| y.is_infinite()) {
        return Err(ObserverError::InfiniteSample {
            index,
            time_s: index as f64 * sample_interval,
        });
    }
    let finite = || measured.iter().filter(|y| !y.is_nan());
    let found = finite().count();
    let needed = 4 * model.output.len();
    if found < needed {
        return Err(ObserverError::TooFewSamples { found, needed });
    }
    let mean = finite().sum::<f64>() / found as f64;
    let variance = finite().map(|y| (y - mean).powi(2)).sum::<f64>() / found as f64;
    let value = finite().copied().next().unwrap_or(f64::NAN);
    if finite().all(|y| *y == value) {
        return Err(ObserverError::ConstantSignal {
            value,
            count: found,
        });
    }
    Ok((mean, variance))
}
