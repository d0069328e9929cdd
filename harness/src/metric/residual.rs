//! Residual of a self-excited motion, phase drift taken out cycle by cycle.

use super::nrmse::nrmse;

/// Model and measurement, aligned.
#[derive(Debug, Clone)]
pub struct AlignedResidual {
    /// The model at the measurement's sample times, after alignment.
    pub model: Vec<f64>,
    /// Measured minus model.
    pub residual: Vec<f64>,
    /// Shift of the model in each cycle, s; its slope is the relative error of the period.
    pub shifts: Vec<f64>,
    /// [`nrmse`] of the aligned signals, 1.
    pub nrmse: f64,
}

/// Aligns a long model motion to a measurement.
///
/// A self-excited motion has no clock: model and measurement drift apart in phase however good the model is, and a plain
/// difference would mostly show the drift. So the measurement is cut into stretches of one `period` (s). For the first,
/// the shift of the model is searched over two periods; for each further one within a quarter period of the shift
/// before. What remains is the difference in shape and size. `model_time` must reach two periods beyond both ends of
/// `time` for every shift to be possible; shifts that leave the model are not tried.
///
/// The drift itself is not lost: it is the difference of the periods, a metric of its own.
pub fn aligned_residual(
    time: &[f64],
    measured: &[f64],
    model: &ModelMotion,
    period: f64,
) -> AlignedResidual {
    let mut aligned = Vec::with_capacity(time.len());
    let mut shifts = Vec::new();
    let mut first = 0;
    while first < time.len() {
        let mut end = time.partition_point(|t| *t < time[first] + period);
        // A short rest at the end would be fitted to anything; it goes with the last full stretch.
        if time[time.len() - 1] - time[end.min(time.len() - 1)] < 0.5 * period {
            end = time.len();
        }
        let stretch = first..end;
        let misfit =
            |shift: f64| model.misfit(&time[stretch.clone()], &measured[stretch.clone()], shift);
        let shift = match shifts.last() {
            None => search(misfit, 0.0, period, 120),
            Some(&before) => search(misfit, before, period / 4.0, 40),
        };
        aligned.extend(time[stretch].iter().map(|t| model.at(t + shift)));
        shifts.push(shift);
        first = end;
    }
    let residual = measured.iter().zip(&aligned).map(|(m, y)| m - y).collect();
    AlignedResidual {
        nrmse: nrmse(measured, &aligned),
        model: aligned,
        residual,
        shifts,
    }
}

/// Smallest `misfit` within `reach` of `centre`: the best of a grid, then golden section about it.
fn search(misfit: impl Fn(f64) -> f64, centre: f64, reach: f64, points: usize) -> f64 {
    let step = 2.0 * reach / points as f64;
    let grid = (0..=points).map(|i| centre - reach + i as f64 * step);
    let best = grid
        .min_by(|a, b| misfit(*a).total_cmp(&misfit(*b)))
        .unwrap_or(centre);
    let (mut low, mut high) = (best - step, best + step);
    let golden = 0.618_033_988_75;
    for _ in 0..24 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if misfit(a) <= misfit(b) {
            high = b;
        } else {
            low = a;
        }
    }
    let fine = 0.5 * (low + high);
    if misfit(fine) <= misfit(best) {
        fine
    } else {
        best
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

    fn misfit(&self, time: &[f64], measured: &[f64], shift: f64) -> f64 {
        let sum: f64 = time
            .iter()
            .zip(measured)
            .map(|(t, m)| (self.at(t + shift) - m).powi(2))
            .sum();
        if sum.is_nan() { f64::INFINITY } else { sum }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn val_a_motion_one_percent_slow_and_shifted_aligns_to_a_small_residual() {
        let time: Vec<f64> = (0..6000).map(|i| f64::from(i) * 1e-4).collect();
        let wave = |t: f64| (TAU * t).sin() + 0.3 * (2.0 * TAU * t).cos();
        let measured: Vec<f64> = time.iter().map(|t| wave(t / 0.0303 + 0.4)).collect();
        let values: Vec<f64> = (0..8000)
            .map(|i| wave((f64::from(i) * 1e-4 - 0.1) / 0.03))
            .collect();
        let model = ModelMotion {
            start: -0.1,
            interval: 1e-4,
            values: &values,
        };
        let found = aligned_residual(&time, &measured, &model, 0.0303);
        assert!(found.nrmse < 0.05, "{}", found.nrmse);
        // 1 % of the period is lost each cycle.
        let slope = (found.shifts[15] - found.shifts[0]) / 15.0;
        assert!((slope / -0.0003 - 1.0).abs() < 0.1, "{slope}");
    }
}
