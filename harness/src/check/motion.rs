//! What one run says of itself, without a look at what is stated of it.

use std::borrow::Cow;

use super::plateau::{Plateau, plateau};
use super::thresholds::{LEAST_SPEED, WIDEST_BAND};
use crate::measurement::{BeamKnowledge, Measurand, Run};
use crate::metric::{
    LEAST_REST, StickDetection, amplitude, integral, measured_stick_velocity, quantile,
    resting_stick, standard_deviation, stick_velocity, velocity,
};

/// What is measured in a run.
#[derive(Debug, Clone)]
pub struct Motion {
    /// Speed of the tip in its stick phases, m/s; `None` where no stick is seen. Of an acceleration, the one with which the
    /// mean velocity of the tip is zero.
    pub stick_speed: Option<f64>,
    /// Share of the samples in stick, 1.
    pub stick_share: f64,
    /// Range of the displacement, or of the integral of the velocity, measured or that of [`resting_stick`], without its outermost
    /// percent, m.
    pub range: f64,
    /// Mean displacement, m; `None` where something else was measured.
    pub mean: Option<f64>,
    /// Standard deviation of what was measured, m, m/s or m/s2.
    pub std: f64,
    /// Fastest speed but for the outermost percent, m/s.
    pub fastest: f64,
    /// Frequency of the free motion in slip, Hz.
    pub slip_frequency: Option<f64>,
    /// Where what was measured itself rests, m, m/s or m/s2, with the share of samples there.
    pub rest: Option<(f64, f64)>,
    /// Where the integral of what was measured rests, m s or m: the stick speed, had an acceleration
    /// been measured.
    pub integral_rest: Option<f64>,
    /// Where the derivative of what was measured rests: the stick speed, had a displacement been
    /// measured in place of a velocity or an acceleration.
    pub derivative_rest: Option<f64>,
    /// Change of what was measured over the run by a straight line through it, m, m/s or m/s2; 0 where
    /// the run is too short to tell.
    pub trend: f64,
}

/// Longest smoothing, s, and half widths in samples: see [`crate::metric::detect_stick`].
const LONGEST_SMOOTHING: f64 = 5e-4;
const HALF_WIDTHS: (usize, usize) = (2, 50);
/// A speed counts as slip for the frequency if it differs by this share of the stick speed: nearer,
/// friction depends on it.
const WELL_IN_SLIP: f64 = 0.5;
/// Fewest samples for a frequency.
const FEWEST: usize = 50;

/// Half width in samples of the window in which the slope of what a run measures is taken, and the slope's noise per s.
pub(super) fn slope_window(run: &Run) -> (usize, f64) {
    let interval = run.sample_interval();
    let half = ((LONGEST_SMOOTHING / interval) as usize).clamp(HALF_WIDTHS.0, HALF_WIDTHS.1);
    let h = half as f64;
    let per_noise = (3.0 / (h * (h + 1.0) * (2.0 * h + 1.0))).sqrt() / interval;
    (half, run.noise.std * per_noise)
}

impl Motion {
    /// Of a run; `beam` says only over how many samples the motion is smoothed.
    pub fn of(run: &Run, beam: &BeamKnowledge) -> Motion {
        let (time, values) = (&run.time, &run.measured);
        let noise = run.noise.std;
        let interval = run.sample_interval();
        let (half, slope_noise) = slope_window(run);
        let mut resting = None;
        let (displacement, speed, speed_noise) = match run.measurand {
            Measurand::Displacement => {
                let speed = velocity(time, values, half);
                (Cow::Borrowed(values.as_slice()), speed, slope_noise)
            }
            Measurand::Velocity => {
                let displacement = integral(time, values);
                (Cow::Owned(displacement), values.clone(), noise)
            }
            Measurand::Acceleration => {
                resting = Some(resting_stick(time, values, 0.0, noise));
                let relative = resting.iter().flat_map(|found| &found.velocity);
                let mean = relative.clone().sum::<f64>() / values.len() as f64;
                let mut speed: Vec<f64> = relative.map(|v| v - mean).collect();
                let rested = resting.iter().flat_map(|found| &found.sticks);
                let rested = rested.filter(|on| **on).count();
                let mut displacement = integral(time, &speed);
                if (rested as f64) < LEAST_REST * values.len() as f64 {
                    // What drifts is not known: what is left is the motion about its mean over a period.
                    let half = half_period(beam, interval);
                    speed = about(&speed, half);
                    displacement = about(&integral(time, &speed), half);
                }
                (Cow::Owned(displacement), speed, 0.0)
            }
        };
        let stick = match &resting {
            Some(found) => at_rest(found, &speed),
            None => plateau(&speed, speed_noise),
        };
        let absolute: Vec<f64> = speed.iter().map(|v| v.abs()).collect();
        let fastest = quantile(&absolute, 0.99);
        let clear = |p: &Plateau| p.value.abs() > (p.half / WIDEST_BAND).max(LEAST_SPEED * fastest);
        let stick = stick.filter(clear);
        let found = stick.as_ref().and_then(|p| match run.measurand {
            Measurand::Displacement => stick_velocity(time, values, &p.on),
            Measurand::Velocity => measured_stick_velocity(values, &p.on),
            Measurand::Acceleration => measured_stick_velocity(&speed, &p.on),
        });
        let stick = stick.filter(|_| found.is_some());
        Motion {
            stick_speed: found.map(|f| f.velocity),
            stick_share: stick.as_ref().map_or(0.0, |p| p.share),
            range: 2.0 * amplitude(&displacement),
            mean: match run.measurand {
                Measurand::Displacement => Some(values.iter().sum::<f64>() / values.len() as f64),
                Measurand::Velocity | Measurand::Acceleration => None,
            },
            std: standard_deviation(values),
            fastest,
            slip_frequency: slip_frequency(run, beam, (&displacement, &speed), stick.as_ref()),
            rest: plateau(values, noise).map(|p| (p.value, p.share)),
            integral_rest: plateau(&integral(time, values), 0.0).map(|p| p.value),
            derivative_rest: match run.measurand {
                Measurand::Displacement => None,
                Measurand::Velocity | Measurand::Acceleration => {
                    // Within a band as wide as the value, noise rests anywhere.
                    plateau(&velocity(time, values, half), slope_noise)
                        .filter(|p| p.value.abs() > p.half / WIDEST_BAND)
                        .map(|p| p.value)
                }
            },
            trend: trend(time, values),
        }
    }
}

/// The stick of a measured acceleration as a plateau of the `speed` (m/s) that follows from it.
fn at_rest(found: &StickDetection, speed: &[f64]) -> Option<Plateau> {
    let first = found.sticks.iter().position(|on| *on)?;
    let count = found.sticks.iter().filter(|on| **on).count();
    let share = count as f64 / speed.len() as f64;
    (share >= LEAST_REST).then(|| Plateau {
        value: speed[first],
        half: found.tolerance,
        on: found.sticks.clone(),
        share,
    })
}

/// Fewest times that a motion passes the straight line through it: five cycles. A piece of one
/// cycle rises by itself.
const FEWEST_PASSES: usize = 10;
/// Distance from the line, in standard deviations, that counts as beyond it.
const BEYOND: f64 = 0.25;

/// Rise over the record of the straight line that fits best; 0 for fewer than five cycles.
fn trend(time: &[f64], values: &[f64]) -> f64 {
    let points = || time.iter().copied().zip(values.iter().copied());
    let Some(slope) = slope(points()) else {
        return 0.0;
    };
    let left: Vec<f64> = points().map(|(t, v)| v - slope * t).collect();
    let mean = left.iter().sum::<f64>() / left.len() as f64;
    let beyond = BEYOND * standard_deviation(&left);
    let (mut passes, mut side) = (0, 0.0);
    for distance in left.iter().map(|v| v - mean) {
        if distance.abs() > beyond && distance.signum() != side {
            (passes, side) = (passes + 1, distance.signum());
        }
    }
    if passes < FEWEST_PASSES {
        return 0.0;
    }
    slope * (time[time.len() - 1] - time[0])
}

/// Slope of the straight line that fits best.
fn slope(points: impl Iterator<Item = (f64, f64)> + Clone) -> Option<f64> {
    let (mut n, mut x, mut y) = (0.0, 0.0, 0.0);
    for point in points.clone() {
        (n, x, y) = (n + 1.0, x + point.0, y + point.1);
    }
    let (x, y) = (x / n, y / n);
    let (mut xx, mut xy) = (0.0, 0.0);
    for point in points {
        xx += (point.0 - x).powi(2);
        xy += (point.0 - x) * (point.1 - y);
    }
    (xx > 0.0).then(|| xy / xx)
}

/// Mean over `half` samples to either side, as far as there are any.
fn moving_mean(values: &[f64], half: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    for value in values {
        sums.push(sums[sums.len() - 1] + value);
    }
    (0..values.len())
        .map(|i| {
            let (from, to) = (i.saturating_sub(half), (i + half + 1).min(values.len()));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// The values about their mean over `half` samples to either side.
fn about(values: &[f64], half: usize) -> Vec<f64> {
    let means = moving_mean(values, half);
    values.iter().zip(means).map(|(v, mean)| v - mean).collect()
}

/// Samples in half a period of the lowest natural frequency stated; as many as there may be where none is.
fn half_period(beam: &BeamKnowledge, interval: f64) -> usize {
    let stated = beam.natural_frequencies_hz.iter().copied();
    let lowest = stated.filter(|f| *f > 0.0).fold(f64::INFINITY, f64::min);
    match lowest.is_finite() {
        true => ((0.5 / lowest / interval).round() as usize).max(HALF_WIDTHS.0),
        false => usize::MAX / 2,
    }
}

/// Frequency of the free motion, Hz. In slip, with friction that hardly changes,
///
/// ```text
/// w'' = -(2 pi f)^2 (w - w_0)
/// ```
///
/// so that the slope of acceleration over displacement gives f. Higher modes are smoothed out over
/// a period of the second one stated.
fn slip_frequency(
    run: &Run,
    beam: &BeamKnowledge,
    (displacement, speed): (&[f64], &[f64]),
    stick: Option<&Plateau>,
) -> Option<f64> {
    let springs = beam.natural_frequencies_hz.iter().copied();
    let stated: Vec<f64> = springs.filter(|f| *f > 0.0).collect();
    let lowest = stated.iter().copied().fold(f64::INFINITY, f64::min);
    let above = stated.iter().copied().filter(|f| *f > 1.5 * lowest);
    let smoothed_over = above.fold(f64::INFINITY, f64::min).min(8.0 * lowest);
    let half = (0.5 / smoothed_over / run.sample_interval()) as usize;
    let half = half.clamp(HALF_WIDTHS.0, HALF_WIDTHS.1);
    let displacement = moving_mean(displacement, half);
    let acceleration = velocity(&run.time, &moving_mean(speed, half), half);
    let in_slip = |i: &usize| {
        stick.is_none_or(|p| (speed[*i] - p.value).abs() > WELL_IN_SLIP * p.value.abs())
    };
    let inner = 2 * half..run.time.len().saturating_sub(2 * half);
    let slip: Vec<usize> = inner.filter(in_slip).collect();
    if slip.len() < FEWEST {
        return None;
    }
    let slope = slope(slip.iter().map(|i| (displacement[*i], acceleration[*i])))?;
    (slope < 0.0).then(|| (-slope).sqrt() / std::f64::consts::TAU)
}
