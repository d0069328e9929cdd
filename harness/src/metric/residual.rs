//! Residual of a self-excited motion: each measured cycle against the most similar cycle of the model.

use std::ops::Range;

use super::cycle::cycle_starts;
use super::nrmse::nrmse;

/// Model and measurement, aligned.
#[derive(Debug, Clone)]
pub struct AlignedResidual {
    /// The model at the measurement's sample times, after alignment.
    pub model: Vec<f64>,
    /// Measured minus model.
    pub residual: Vec<f64>,
    /// What was fitted to each stretch, in the order of time.
    pub fits: Vec<Fit>,
    /// [`nrmse`] of the aligned signals, 1.
    pub nrmse: f64,
}

/// The motion that fits a stretch of the measurement best.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Samples of the stretch.
    pub samples: Range<usize>,
    /// Which motion.
    pub motion: usize,
    /// By how much it is shifted: the motion at t + shift belongs to the measurement at t, s.
    pub shift: f64,
}

/// Grid points per period in the search for a shift: finer than the rise of a stick-slip cycle.
const POINTS_PER_PERIOD: f64 = 60.0;
/// Samples per stretch that the grid search looks at.
const GRID_SAMPLES: usize = 60;
/// Of so many motions that fit best on the grid, the shift is refined.
const REFINED: usize = 4;

/// Aligns motions of a model to a measurement, stretch by stretch.
///
/// A self-excited motion has no clock: model and measurement drift apart in phase however good the model is, an irregular
/// one never repeats, and a small push moves it from one of several coexisting motions to another. A plain difference
/// would show little else. So the measurement is cut at its cycle starts (or, where it has none, into pieces of one
/// `period`, s), and each stretch is compared with the motion and the shift that fit it best:
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
    for range in stretches(time, &cycle_starts(time, measured, period), period) {
        let (first, end) = (range.start, range.end);
        let stretch = Stretch {
            time: &time[first..end],
            measured: &measured[first..end],
        };
        let mut coarse: Vec<(usize, f64, f64)> = motions
            .iter()
            .enumerate()
            .map(|(k, motion)| stretch.coarse(k, motion, motion.shifts_covering(time), period))
            .collect();
        coarse.sort_by(|a, b| a.2.total_cmp(&b.2));
        let refined = coarse.iter().take(REFINED).map(|(k, shift, _)| {
            let (shift, misfit) = stretch.refine(
                &motions[*k],
                *shift,
                motions[*k].shifts_covering(time),
                period,
            );
            (*k, shift, misfit)
        });
        let best = refined.min_by(|a, b| a.2.total_cmp(&b.2));
        let (which, shift, _) = best.expect("there is at least one motion");
        model.extend(stretch.time.iter().map(|t| motions[which].at(t + shift)));
        fits.push(Fit {
            samples: range,
            motion: which,
            shift,
        });
    }
    let residual = measured.iter().zip(&model).map(|(m, y)| m - y).collect();
    AlignedResidual {
        nrmse: nrmse(measured, &model),
        model,
        residual,
        fits,
    }
}

/// Index ranges from cycle start to cycle start. What is longer than one and a half periods is cut evenly; the pieces
/// before the first start and after the last go with their neighbours if they are shorter than half a period, since
/// anything fits a short piece.
fn stretches(time: &[f64], starts: &[f64], period: f64) -> Vec<Range<usize>> {
    let (begin, end) = (time[0], time[time.len() - 1]);
    let inner = starts
        .iter()
        .copied()
        .filter(|s| *s > begin + 0.5 * period && *s < end - 0.5 * period);
    let ends: Vec<f64> = std::iter::once(begin)
        .chain(inner)
        .chain(std::iter::once(end))
        .collect();
    let mut cuts = vec![0];
    for pair in ends.windows(2) {
        let pieces = ((pair[1] - pair[0]) / period).round().max(1.0);
        let evenly =
            (1..=pieces as usize).map(|k| pair[0] + (pair[1] - pair[0]) * k as f64 / pieces);
        cuts.extend(evenly.map(|cut| time.partition_point(|t| *t < cut)));
    }
    // The last sample belongs to the last stretch.
    if let Some(last) = cuts.last_mut() {
        *last = time.len();
    }
    cuts.windows(2)
        .map(|w| w[0]..w[1])
        .filter(|r| !r.is_empty())
        .collect()
}

/// A piece of the measurement.
struct Stretch<'a> {
    time: &'a [f64],
    measured: &'a [f64],
}

impl Stretch<'_> {
    /// The shift within `bounds` that fits best on a grid: motion, shift, misfit.
    fn coarse(
        &self,
        k: usize,
        motion: &ModelMotion,
        (lowest, highest): (f64, f64),
        period: f64,
    ) -> (usize, f64, f64) {
        let step = period / POINTS_PER_PERIOD;
        let skip = (self.time.len() / GRID_SAMPLES).max(1);
        let points = ((highest - lowest) / step).floor().max(0.0) as usize;
        let mut best = (k, lowest, f64::INFINITY);
        for shift in (0..=points).map(|i| lowest + i as f64 * step) {
            let misfit = self.misfit(motion, shift, skip, best.2);
            if misfit < best.2 {
                best = (k, shift, misfit);
            }
        }
        best
    }

    /// Golden section about a shift of the grid: shift, misfit.
    fn refine(
        &self,
        motion: &ModelMotion,
        start: f64,
        (lowest, highest): (f64, f64),
        period: f64,
    ) -> (f64, f64) {
        let step = period / POINTS_PER_PERIOD;
        let misfit = |shift| self.misfit(motion, shift, 1, f64::INFINITY);
        let (mut low, mut high) = ((start - step).max(lowest), (start + step).min(highest));
        let golden = 0.618_033_988_75;
        for _ in 0..18 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if misfit(a) <= misfit(b) {
                high = b;
            } else {
                low = a;
            }
        }
        let shift = 0.5 * (low + high);
        (shift, misfit(shift))
    }

    /// Sum of squares over every `skip`th sample; infinite where the model does not reach, and as soon as it passes `give_up`.
    fn misfit(&self, motion: &ModelMotion, shift: f64, skip: usize, give_up: f64) -> f64 {
        let mut sum = 0.0;
        for (t, m) in self.time.iter().zip(self.measured).step_by(skip) {
            sum += (motion.at(t + shift) - m).powi(2);
            if sum.is_nan() || sum > give_up {
                return f64::INFINITY;
            }
        }
        sum
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

    /// The values at these times, as [`ModelMotion::at`].
    pub fn at_all(&self, time: &[f64]) -> Vec<f64> {
        time.iter().map(|t| self.at(*t)).collect()
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
        // Within a cycle the phase runs off by up to half a percent of the period either way, 0.29 % rms; times the
        // relative slope of the wave, 2 pi sqrt((1 + 4 * 0.09) / 1.09), that is 2.0 %.
        assert!((found.nrmse - 0.0204).abs() < 2e-3, "{}", found.nrmse);
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
        assert_eq!(
            (
                found.fits[0].motion,
                found.fits[found.fits.len() - 1].motion
            ),
            (0, 1)
        );
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
