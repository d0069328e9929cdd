//! The belt's speed from the stick phases of a record.

use std::ops::Range;

/// A speed with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StickVelocity {
    /// Velocity of the tip in stick, which is the belt's, m/s.
    pub velocity: f64,
    /// Its standard error, m/s.
    pub std: f64,
    /// Stick phases that it rests on.
    pub phases: usize,
    /// Samples in these.
    pub samples: usize,
}

/// What the sampling of transitions leaves uncertain in any record, as a share of the speed: one part in two thousand.
const RESOLVED: f64 = 5e-4;
/// A stated speed this many standard errors away is contradicted.
const CONTRADICTED: f64 = 3.0;

impl StickVelocity {
    /// By how much a `stated` speed (m/s) is off, as a share of the speed found.
    pub fn stated_is_off_by(&self, stated: f64) -> f64 {
        stated / self.velocity - 1.0
    }

    /// Whether the record contradicts a `stated` speed, m/s: it is off by more than three standard errors, and by more than
    /// the transitions between samples could explain.
    pub fn contradicts(&self, stated: f64) -> bool {
        let off = (stated - self.velocity).abs();
        off > CONTRADICTED * self.std.hypot(RESOLVED * self.velocity)
    }
}

/// Samples left out at either end of a stick phase, and the same as a share of the phase: there the tip may still slip, and
/// a velocity smoothed over neighbours is not yet the belt's.
const EDGE_SAMPLES: usize = 3;
const EDGE_SHARE: f64 = 0.1;
/// Fewest samples of a phase, edges left out.
const FEWEST_SAMPLES: usize = 6;
/// Fewest phases; the scatter between them is part of the uncertainty.
const FEWEST_PHASES: usize = 3;
/// A phase whose slope lies this many robust standard deviations from the others is none of stick.
const OUTLIER: f64 = 4.0;
/// Standard deviation of a Gaussian over its median absolute deviation.
pub const MAD: f64 = 1.4826;

/// Estimates the belt's speed: in stick the tip moves with it, so each phase is a straight line of the same slope.
///
/// ```text
/// w_i = c_k + v t_i + noise   in phase k,      v = sum_k S_k v_k / sum_k S_k,
/// v_k = sum_i (t_i - mean t) (w_i - mean w) / S_k,   S_k = sum_i (t_i - mean t)^2
/// ```
///
/// `time` in s, `displacement` in m (NaN where missing), one flag per sample. The standard error is the larger of the one
/// from the scatter within the phases and the one from the scatter between them, since noise need not be white. Holds for
/// a contact that sticks rigidly on a belt of constant speed; `None` with fewer than three phases. Source: analysis of
/// covariance, one slope in several groups (Fisher 1932).
pub fn stick_velocity(
    time: &[f64],
    displacement: &[f64],
    sticks: &[bool],
) -> Option<StickVelocity> {
    let through = |range| Line::through(time, displacement, range);
    of_phases(sticks, through, 2)
}

/// The same from a measured `velocity` (m/s, NaN where missing): in stick it is the belt's, so each phase is a constant.
///
/// ```text
/// v_i = v + noise   in phase k,      v = sum_k n_k mean_k / sum_k n_k
/// ```
///
/// Holds and is judged as [`stick_velocity`]; an offset of the sensor counts as speed of the belt.
pub fn measured_stick_velocity(velocity: &[f64], sticks: &[bool]) -> Option<StickVelocity> {
    of_phases(sticks, |range| Line::level(velocity, range), 1)
}

/// The common slope of the lines that `through` lays through the stick phases, each with so many constants of its own.
fn of_phases(
    sticks: &[bool],
    through: impl Fn(Range<usize>) -> Option<Line>,
    constants: usize,
) -> Option<StickVelocity> {
    let mut lines: Vec<Line> = stretches(sticks)
        .into_iter()
        .filter_map(|range| through(inner(range)))
        .collect();
    let mut velocity = common(&lines);
    let middle = |mut values: Vec<f64>| {
        let at = values.len() / 2;
        *values.select_nth_unstable_by(at, f64::total_cmp).1
    };
    if lines.len() >= FEWEST_PHASES {
        velocity = middle(lines.iter().map(|l| l.slope).collect());
        let away = |line: &Line| ((line.slope - velocity) * line.weight.sqrt()).abs();
        let limit = OUTLIER * MAD * middle(lines.iter().map(away).collect());
        lines.retain(|line| away(line) <= limit.max(f64::MIN_POSITIVE));
        velocity = common(&lines);
    }
    if lines.len() < FEWEST_PHASES {
        return None;
    }
    let weight: f64 = lines.iter().map(|l| l.weight).sum();
    let samples: usize = lines.iter().map(|l| l.samples).sum();
    let between: f64 = lines
        .iter()
        .map(|l| l.weight * (l.slope - velocity).powi(2))
        .sum();
    let within: f64 = lines.iter().map(|l| l.misfit).sum();
    let count = lines.len();
    let variance =
        (between / (count - 1) as f64).max(within / (samples - constants * count) as f64);
    Some(StickVelocity {
        velocity,
        std: (variance / weight).sqrt(),
        phases: count,
        samples,
    })
}

/// A straight line through the displacements of one phase, or a level through its velocities.
struct Line {
    /// m/s.
    slope: f64,
    /// Sum of the squared distances in time from the middle, s^2; of a level the number of samples.
    weight: f64,
    /// Sum of squares of what the line leaves, m^2, or m^2/s^2 of a level.
    misfit: f64,
    samples: usize,
}

impl Line {
    fn through(time: &[f64], displacement: &[f64], range: Range<usize>) -> Option<Line> {
        let points: Vec<(f64, f64)> = range
            .map(|i| (time[i], displacement[i]))
            .filter(|p| p.1.is_finite())
            .collect();
        if points.len() < FEWEST_SAMPLES {
            return None;
        }
        let n = points.len() as f64;
        let (t, w) = points
            .iter()
            .fold((0.0, 0.0), |s, p| (s.0 + p.0, s.1 + p.1));
        let (t, w) = (t / n, w / n);
        let (mut tt, mut tw, mut ww) = (0.0, 0.0, 0.0);
        for (time, value) in &points {
            let (dt, dw) = (time - t, value - w);
            tt += dt * dt;
            tw += dt * dw;
            ww += dw * dw;
        }
        (tt > 0.0).then(|| Line {
            slope: tw / tt,
            weight: tt,
            misfit: (ww - tw * tw / tt).max(0.0),
            samples: points.len(),
        })
    }

    fn level(velocity: &[f64], range: Range<usize>) -> Option<Line> {
        // A short phase at the end leaves a range that is empty and begins beyond the record.
        let values = || {
            let of_range = range.clone().map(|i| velocity[i]);
            of_range.filter(|v| v.is_finite())
        };
        let samples = values().count();
        if samples < FEWEST_SAMPLES {
            return None;
        }
        let mean = values().sum::<f64>() / samples as f64;
        Some(Line {
            slope: mean,
            weight: samples as f64,
            misfit: values().map(|v| (v - mean).powi(2)).sum(),
            samples,
        })
    }
}

/// The slope that all lines have in common.
fn common(lines: &[Line]) -> f64 {
    let weight: f64 = lines.iter().map(|l| l.weight).sum();
    lines.iter().map(|l| l.weight * l.slope).sum::<f64>() / weight
}

/// Index ranges in which `flags` is true.
fn stretches(flags: &[bool]) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut first = 0;
    for stretch in flags.chunk_by(|a, b| a == b) {
        if stretch[0] {
            found.push(first..first + stretch.len());
        }
        first += stretch.len();
    }
    found
}

/// A phase without its edges.
fn inner(range: Range<usize>) -> Range<usize> {
    let edge = EDGE_SAMPLES.max((EDGE_SHARE * range.len() as f64) as usize);
    range.start + edge..range.end.saturating_sub(edge).max(range.start + edge)
}

/// How far from the stated speed the belt's is looked for, as a share of it.
const SEARCHED: f64 = 0.2;
/// Half width of the band of velocities that counts as one speed: in standard deviations of the velocity, and at least this
/// share of the speed.
const BAND_STDS: f64 = 3.0;
const BAND_SHARE: f64 = 2e-3;
/// A turning point of the velocity leaves 0.7 times as many samples beside the band as in it, a phase of stick next to none.
const BESIDE: f64 = 0.35;

/// Finds the samples in stick without trusting the stated speed: the most frequent `velocity` (m/s, one per sample, of
/// standard deviation `velocity_std`) within a fifth of the speed `stated`, if it is a plateau and no mere turning point.
///
/// A plateau has few samples beside its band, of half width h = max(3 std, 0.002 |stated|): a turning point, where time
/// near the largest velocity grows as the root of the distance from it, leaves sqrt(3) - 1 times as many there as within.
pub fn plateau(velocity: &[f64], velocity_std: f64, stated: f64) -> Option<Vec<bool>> {
    let half = (BAND_STDS * velocity_std).max(BAND_SHARE * stated.abs());
    let mut near: Vec<f64> = velocity
        .iter()
        .copied()
        .filter(|v| (v - stated).abs() <= SEARCHED * stated.abs())
        .collect();
    near.sort_by(f64::total_cmp);
    let count = |low: f64, high: f64| {
        near.partition_point(|v| *v <= high) - near.partition_point(|v| *v < low)
    };
    let (mut most, mut middle, mut past) = (0, f64::NAN, 0);
    for first in 0..near.len() {
        while past < near.len() && near[past] <= near[first] + 2.0 * half {
            past += 1;
        }
        if past - first > most {
            // The median of the band, since transitions hang on one side of it.
            (most, middle) = (past - first, near[(first + past) / 2]);
        }
    }
    let inside = count(middle - half, middle + half);
    let beside = count(middle - 3.0 * half, middle + 3.0 * half) - inside;
    let is_plateau = inside > 0 && (beside as f64) < BESIDE * inside as f64;
    is_plateau.then(|| {
        velocity
            .iter()
            .map(|v| (v - middle).abs() <= half)
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    const STEP: f64 = 1e-4;

    #[test]
    fn val_measured_velocities_give_the_belt_s_speed_whatever_the_phases_are_cut_to() {
        // Source: the speed that the phases were made with; the last one ends with the record and is too short to count.
        let mut noise = normal(4);
        let sticks: Vec<bool> = (0..3001).map(|i| i % 300 < 200).collect();
        let velocity: Vec<f64> = sticks
            .iter()
            .map(|s| if *s { 0.06 } else { -0.2 } + 1e-4 * noise())
            .collect();
        let found = measured_stick_velocity(&velocity, &sticks).unwrap();
        assert_eq!(found.phases, 10);
        assert!((found.velocity - 0.06).abs() < 4.0 * found.std, "{found:?}");
        assert!((1e-6..1e-5).contains(&found.std), "{found:?}");
        assert!(measured_stick_velocity(&velocity[..500], &sticks[..500]).is_none());
    }

    /// Standard normal numbers.
    fn normal(seed: u64) -> impl FnMut() -> f64 {
        let mut random = fastrand::Rng::with_seed(seed);
        move || (-2.0 * (1.0 - random.f64()).ln()).sqrt() * (TAU * random.f64()).cos()
    }

    /// 0.8 s of cycles of 30 ms: stick at `speed` for 20 ms, then back along half a cosine, with noise of `std`.
    fn record(speed: f64, std: f64) -> (Vec<f64>, Vec<f64>, Vec<bool>) {
        let mut noise = normal(7);
        let time: Vec<f64> = (0..8000).map(|i| f64::from(i) * STEP).collect();
        let phase = |t: &f64| t.rem_euclid(0.03);
        let value = |t: f64| {
            if t < 0.02 {
                speed * t
            } else {
                0.5 * speed * 0.02 * (1.0 + (PI * (t - 0.02) / 0.01).cos())
            }
        };
        let values = time.iter().map(|t| value(phase(t)) + std * noise());
        let values = values.collect();
        let sticks = time.iter().map(|t| phase(t) < 0.02).collect();
        (time, values, sticks)
    }

    #[test]
    fn val_straight_lines_give_their_slope_and_its_standard_error() {
        let (time, values, sticks) = record(0.1, 1e-6);
        let found = stick_velocity(&time, &values, &sticks).unwrap();
        // 27 phases (the last is cut short) of 160 samples: S = n (n^2 - 1) dt^2 / 12 each.
        let expected = 1e-6 / (26.5 * 160.0 * (160.0 * 160.0 - 1.0) / 12.0 * STEP * STEP).sqrt();
        assert!(
            (found.std / expected - 1.0).abs() < 0.25,
            "{found:?} {expected:e}"
        );
        assert!((found.velocity - 0.1).abs() < 3.5 * found.std, "{found:?}");
    }

    #[test]
    fn a_speed_stated_one_percent_off_is_contradicted_and_the_right_one_is_not() {
        let (time, values, sticks) = record(-0.1, 1e-6);
        let found = stick_velocity(&time, &values, &sticks).unwrap();
        assert!(
            found.contradicts(-0.101) && found.contradicts(-0.099),
            "{found:?}"
        );
        assert!(
            !found.contradicts(-0.1) && !found.contradicts(-0.1001),
            "{found:?}"
        );
        assert!((found.stated_is_off_by(-0.101) - 0.01).abs() < 1e-3);
    }

    #[test]
    fn a_plateau_is_found_where_the_stated_speed_is_wrong_and_a_turning_point_is_none() {
        let mut noise = normal(3);
        let stick = |i: i32| i % 300 < 200;
        let speed = |i: i32| {
            if stick(i) {
                0.1
            } else {
                -0.2 * f64::from(i % 300 - 250) / 50.0
            }
        };
        let velocity: Vec<f64> = (0..9000).map(|i| speed(i) + 1e-4 * noise()).collect();
        let flags = plateau(&velocity, 1e-4, 0.115).unwrap();
        let wrong = flags
            .iter()
            .zip(0..)
            .filter(|(f, i)| **f != stick(*i))
            .count();
        assert!(wrong < 9000 / 50, "{wrong}");
        let sine: Vec<f64> = (0..9000)
            .map(|i| 0.1 * (TAU * f64::from(i) / 300.0).sin())
            .collect();
        assert_eq!(plateau(&sine, 1e-4, 0.1), None);
    }

    #[test]
    fn too_few_phases_give_nothing() {
        let (time, values, sticks) = record(0.1, 1e-6);
        assert_eq!(
            stick_velocity(&time[..500], &values[..500], &sticks[..500]),
            None
        );
        assert_eq!(stick_velocity(&time, &values, &vec![false; 8000]), None);
        assert_eq!(plateau(&[], 0.0, 0.1), None);
        assert_eq!(plateau(&[0.0; 100], 0.0, 0.1), None);
    }
}
