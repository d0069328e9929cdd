//! Noise levels: given, or those of greatest likelihood.

use super::record::Record;
use super::{Settings, Smoothed};
use crate::measurement::Measurand;
use crate::observer::error::ObserverError;
use crate::observer::kernel::{self, Likelihood};

/// Noise levels in scaled units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::observer) struct Levels {
    /// Variance of the sensor noise in the square of the unit of what is measured.
    pub noise_variance: f64,
    /// Intensity of the scaled force state in m^2/s.
    pub intensity: f64,
}

impl Record<'_> {
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
    pub(super) fn intensity_scale(&self) -> f64 {
        match self.model.noise.len() {
            1 => self.model.force_scale.powi(2),
            _ => self.model.slope_scale.powi(2),
        }
    }

    fn search_part(&self, longest: usize) -> &[f64] {
        let n = self.measured.len();
        let start = n.saturating_sub(longest) / 2;
        &self.measured[start..(start + longest).min(n)]
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
        let rate = self.structure.modes()[0].rate() / std::f64::consts::TAU;
        let centre = match self.model.measures {
            Measurand::Displacement => (1e6 * rate).ln(),
            Measurand::Velocity | Measurand::Acceleration => {
                (1e6 * rate / self.per_displacement().powi(2)).ln()
            }
        };
        let best = minimise(cost, centre, 5.0_f64.ln(), 12, 0.02);
        let (mut levels, terms) = levels_at(best);
        if free {
            let factor = terms.sum_square / terms.count;
            levels.noise_variance *= factor;
            levels.intensity *= factor;
        }
        levels
    }
}

/// Minimum of `cost`: coarse scan of `2 count + 1` points `step` apart about `centre`, then golden
/// section down to `tolerance`.
pub(in crate::observer) fn minimise(
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
