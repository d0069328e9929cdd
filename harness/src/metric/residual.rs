//! Residual of a self-excited motion: each measured cycle against the most similar cycle of the model.

use super::nrmse::nrmse;

/// Model and measurement, aligned.
#[derive(Debug, Clone)]
pub struct AlignedResidual {
    /// The model at the measurement's sample times, after alignment.
    pub model: Vec<f64>,
    /// Measured minus model.
    pub residual: Vec<f64>,
    /// For each stretch, which motion fits it and by how much it is shifted, s.
    pub fits: Vec<(usize, f64)>,
    /// [`nrmse`] of the aligned signals, 1.
    pub nrmse: f64,
}

/// Grid points per period in the search for a shift: finer than the rise of a stick-slip cycle.
const POINTS_PER_PERIOD: f64 = 60.0;
/// Samples per stretch that the grid search looks at.
const GRID_SAMPLES: usize = 60;

/// Aligns motions of a model to a measurement, stretch by stretch.
///
/// A self-excited motion has no clock: model and measurement drift apart in phase however good the model is, an irregular
/// one never repeats, and a small push moves it from one of several coexisting motions to another. A plain difference
/// would show little else. So the measurement is cut into stretches of one `period` (s), and each is compared with the
/// motion and the shift that fit it best:
///
/// ```text
/// y_i = motion_k(t_i + s),   (k, s) minimise sum_(i in stretch) (m_i - y_i)^2
/// ```
///
/// What remains is the difference in shape and size between cycles that are measured and cycles that the model makes.
/// `motions` are motions of the model, settled or on their way; s runs over every shift with which they cover
/// the record, so they should reach two periods beyond both of its ends. Errors of the period as such do not show here;
/// they are a metric of their own.
pub fn aligned_residual(
    time: &[f64],
    measured: &[f64],
    motions: &[ModelMotion],
    period: f64,
) -> AlignedResidual {
    let mut model = Vec::with_capacity(time.len());
    let mut fits = Vec::new();
    let mut first = 0;
    while first < time.len() {
        let mut end = time.partition_point(|t| *t < time[first] + period);
        // A short rest at the end would be fitted to anything; it goes with the last full stretch.
        if time[time.len() - 1] - time[end.min(time.len() - 1)] < 0.5 * period {
            end = time.len();
        }
        let stretch = Stretch {
            time: &time[first..end],
            measured: &measured[first..end],
        };
        let candidates = motions
            .iter()
            .map(|motion| stretch.best_shift(motion, motion.shifts_covering(time), period));
        let best = candidates
            .enumerate()
            .min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let (which, (shift, _)) = best.expect("there is at least one motion");
        model.extend(stretch.time.iter().map(|t| motions[which].at(t + shift)));
        fits.push((which, shift));
        first = end;
    }
    let residual = measured.iter().zip(&model).map(|(m, y)| m - y).collect();
    AlignedResidual {
        nrmse: nrmse(measured, &model),
        model,
        residual,
        fits,
    }
}

/// A piece of the measurement.
struct Stretch<'a> {
    time: &'a [f64],
    measured: &'a [f64],
}

impl Stretch<'_> {
    /// The shift within `bounds` that fits best, with its misfit: the best of a coarse grid, then golden section about it.
    fn best_shift(
        &self,
        motion: &ModelMotion,
        (lowest, highest): (f64, f64),
        period: f64,
    ) -> (f64, f64) {
        let step = period / POINTS_PER_PERIOD;
        let skip = (self.time.len() / GRID_SAMPLES).max(1);
        let points = ((highest - lowest) / step).floor().max(0.0) as usize;
        let grid = (0..=points).map(|i| lowest + i as f64 * step);
        let coarse = grid
            .map(|shift| (shift, self.misfit(motion, shift, skip)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        let start = coarse.map_or(lowest, |(shift, _)| shift);
        let (mut low, mut high) = ((start - step).max(lowest), (start + step).min(highest));
        let golden = 0.618_033_988_75;
        for _ in 0..20 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if self.misfit(motion, a, 1) <= self.misfit(motion, b, 1) {
                high = b;
            } else {
                low = a;
            }
        }
        let shift = 0.5 * (low + high);
        (shift, self.misfit(motion, shift, 1))
    }

    /// Sum of squares over every `skip`th sample; infinite where the model does not reach.
    fn misfit(&self, motion: &ModelMotion, shift: f64, skip: usize) -> f64 {
        let pairs = self.time.iter().zip(self.measured).step_by(skip);
        let sum: f64 = pairs.map(|(t, m)| (motion.at(t + shift) - m).powi(2)).sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }
}

/// An evenly sampled model motion.
#[derive(Debug, Clone, Copy)]
pub struct ModelMotion<'a> {
    /// Time of the first value, s.
    pub start: f64,
    /// Sample interval, s.
    pub interval: f64,
    /// Values, in the unit of the measurement.
    pub values: &'a [f64],
}

impl ModelMotion<'_> {
    /// The value at `time` (s), straight lines between samples; NaN outside.
    pub fn at(&self, time: f64) -> f64 {
        let at = (time - self.start) / self.interval;
        if !(at >= 0.0 && at < (self.values.len() - 1) as f64) {
            return f64::NAN;
        }
        let i = at as usize;
        self.values[i] + (at - i as f64) * (self.values[i + 1] - self.values[i])
    }

    /// Smallest and largest shift that keep every time of the record inside the model.
    fn shifts_covering(&self, time: &[f64]) -> (f64, f64) {
        let end = self.start + (self.values.len() - 1) as f64 * self.interval;
        // A hundredth of a sample keeps rounding from leaving the model.
        let margin = 0.01 * self.interval;
        (
            self.start - time[0] + margin,
            end - time[time.len() - 1] - margin,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn wave(t: f64) -> f64 {
        (TAU * t).sin() + 0.3 * (2.0 * TAU * t).cos()
    }

    fn record() -> Vec<f64> {
        (0..6000).map(|i| f64::from(i) * 1e-4).collect()
    }

    fn motion(values: &[f64]) -> ModelMotion<'_> {
        ModelMotion {
            start: -0.1,
            interval: 1e-4,
            values,
        }
    }

    #[test]
    fn val_a_motion_one_percent_slow_and_shifted_aligns_to_a_small_residual() {
        let time = record();
        let measured: Vec<f64> = time.iter().map(|t| wave(t / 0.0303 + 0.4)).collect();
        let values: Vec<f64> = (0..8000)
            .map(|i| wave((f64::from(i) * 1e-4 - 0.1) / 0.03))
            .collect();
        let found = aligned_residual(&time, &measured, &[motion(&values)], 0.0303);
        assert!(found.nrmse < 0.02, "{}", found.nrmse);
    }

    #[test]
    fn val_a_measurement_that_jumps_between_two_motions_is_followed() {
        let time = record();
        let measured: Vec<f64> = time
            .iter()
            .map(|t| {
                if *t < 0.3 {
                    wave(t / 0.03)
                } else {
                    0.1 * wave(t / 0.03)
                }
            })
            .collect();
        let large: Vec<f64> = (0..8000)
            .map(|i| wave(f64::from(i) * 1e-4 / 0.03))
            .collect();
        let small: Vec<f64> = large.iter().map(|v| 0.1 * v).collect();
        let found = aligned_residual(&time, &measured, &[motion(&large), motion(&small)], 0.03);
        assert!(found.nrmse < 0.02, "{}", found.nrmse);
        assert_eq!((found.fits[0].0, found.fits[15].0), (0, 1));
    }

    #[test]
    fn val_a_wrong_amplitude_shows_in_full() {
        let time = record();
        let measured: Vec<f64> = time.iter().map(|t| wave(t / 0.03)).collect();
        let values: Vec<f64> = (0..8000)
            .map(|i| 0.8 * wave(f64::from(i) * 1e-4 / 0.03))
            .collect();
        let found = aligned_residual(&time, &measured, &[motion(&values)], 0.03);
        assert!((found.nrmse - 0.2).abs() < 1e-3, "{}", found.nrmse);
    }
}
