//! Where a measured acceleration rests, as it does in stick, and the velocity that follows from there.

/// Stretches of a record in which the acceleration is constant.
#[derive(Debug, Clone, PartialEq)]
pub struct Rest {
    /// Mean of the acceleration there, m/s^2: the sensor's offset, where the tip sticks to a belt of constant speed.
    pub offset: f64,
    /// Standard error of it, m/s^2.
    pub offset_std: f64,
    /// For each sample, whether it lies in such a stretch.
    pub on: Vec<bool>,
}

/// A sum of squares this many standard deviations above its mean is no longer that of noise.
const BEYOND_NOISE: f64 = 4.0;
/// Fewest samples of a stretch.
const FEWEST_SAMPLES: usize = 6;
/// Samples of slip beside the noise that end a stretch: beyond this many standard deviations of it.
const EDGE: f64 = 4.0;

/// Least share of the samples at rest from which an acceleration tells velocities and displacements throughout: with less, most
/// slips are followed through transitions that are too short to be seen.
pub const LEAST_REST: f64 = 0.25;

/// Finds where the tip rests on the belt: stretches of at least `shortest` samples in which an `acceleration` (m/s^2, NaN where
/// missing) is that of noise of the standard deviation `noise` (m/s^2) about an offset common to all.
///
/// ```text
/// sum over n samples of (a_i - o)^2 / s^2 <= n + 4 sqrt(2 n),   n = shortest,   o = median of the stretches' means
/// ```
///
/// In rigid stick on a belt of constant speed the tip is not accelerated; slipping, its acceleration is hundreds of times the
/// noise and passes zero within a sample or two. Holds for white noise of known size and contacts that stick rigidly; `None`
/// where nothing rests. Source: the mean n and variance 2 n of chi-square with n degrees of freedom.
pub fn rest(acceleration: &[f64], noise: f64, shortest: usize) -> Option<Rest> {
    let n = shortest.max(FEWEST_SAMPLES);
    if acceleration.len() < n || !(noise > 0.0) {
        return None;
    }
    let most = n as f64 + BEYOND_NOISE * (2.0 * n as f64).sqrt();
    let window = |first: usize, about: Option<f64>| -> Option<f64> {
        let values = acceleration[first..first + n].iter();
        let found = values.clone().filter(|a| a.is_finite()).count();
        // Half of them missing, a stretch says nothing.
        if 2 * found < n {
            return None;
        }
        let finite = || values.clone().filter(|a| a.is_finite());
        let mean = finite().sum::<f64>() / found as f64;
        let about = about.unwrap_or(mean);
        let square = finite().map(|a| ((a - about) / noise).powi(2)).sum::<f64>();
        (square <= most).then_some(mean)
    };
    let count = acceleration.len() - n + 1;
    // Whatever offset a stretch has by itself, it rests; the sensor's is what most of them agree on.
    let mut means: Vec<f64> = (0..count).filter_map(|k| window(k, None)).collect();
    if means.is_empty() {
        return None;
    }
    let offset = super::median(&mut means);
    let mut on = vec![false; acceleration.len()];
    let mut known = 0;
    for first in 0..count {
        if window(first, Some(offset)).is_some() {
            on[first.max(known)..first + n].fill(true);
            known = first + n;
        }
    }
    trim(&mut on, |k| (acceleration[k] - offset).abs() > EDGE * noise);
    let rested: Vec<f64> = (0..on.len())
        .filter(|k| on[*k] && acceleration[*k].is_finite())
        .map(|k| acceleration[k])
        .collect();
    if rested.is_empty() {
        return None;
    }
    let samples = rested.len() as f64;
    Some(Rest {
        offset: rested.iter().sum::<f64>() / samples,
        offset_std: noise / samples.sqrt(),
        on,
    })
}

/// Takes samples off the ends of the stretches while `moves` says that they belong to slip.
fn trim(on: &mut [bool], moves: impl Fn(usize) -> bool) {
    let mut before = false;
    for k in 0..on.len() {
        on[k] &= before || !moves(k);
        before = on[k];
    }
    let mut after = false;
    for k in (0..on.len()).rev() {
        on[k] &= after || !moves(k);
        after = on[k];
    }
}

/// The velocity (m/s) less that of the belt, from an acceleration (m/s^2): zero where it rests, and from there on the integral
/// by trapezoids.
///
/// ```text
/// v_r(t) = integral from t_0 to t of (a - o) dt,   t_0 the end of the rest before
/// ```
///
/// Each slip begins anew from rest, so that what noise and offset add up to stays that of one slip; integrated through the whole
/// record it would drift by as much as the belt runs. Before the first rest it is integrated backwards. Where a slip ends, the
/// acceleration jumps within one sample, so that the last sample of slip may be off by the jump times the interval. A slip that
/// closes worse than that has transitions within that were too short to be seen, or a drift: what is left over is taken off
/// evenly. `time` in s. Without rest the velocity is the integral about its mean.
pub fn velocity_from_rest(time: &[f64], acceleration: &[f64], rest: Option<&Rest>) -> Vec<f64> {
    let Some(rest) = rest else {
        return super::integral(time, acceleration);
    };
    let value = |k: usize| {
        let a = acceleration[k] - rest.offset;
        if a.is_finite() { a } else { 0.0 }
    };
    let rise = |k: usize| (time[k + 1] - time[k]) * 0.5 * (value(k) + value(k + 1));
    let mut out = vec![0.0; time.len()];
    for k in 1..time.len() {
        out[k] = if rest.on[k] {
            0.0
        } else {
            out[k - 1] + rise(k - 1)
        };
    }
    let first = rest.on.iter().position(|on| *on).unwrap_or(0);
    for k in (0..first).rev() {
        out[k] = out[k + 1] - rise(k);
    }
    let mut begin = first;
    for end in first + 1..time.len() {
        if !rest.on[end] {
            continue;
        }
        // From the last sample of one rest to the first of the next.
        let left_over = out[end - 1] + rise(end - 1);
        let by_jump = (value(end - 1) * (time[end] - time[end - 1])).abs();
        if end > begin + 1 && left_over.abs() > by_jump {
            let rate = left_over / (time[end] - time[begin]);
            let slip = begin + 1..end;
            slip.for_each(|k| out[k] -= rate * (time[k] - time[begin]));
        }
        begin = end;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    const STEP: f64 = 1e-4;

    /// Standard normal numbers.
    fn normal(seed: u64) -> impl FnMut() -> f64 {
        let mut random = fastrand::Rng::with_seed(seed);
        move || (-2.0 * (1.0 - random.f64()).ln()).sqrt() * (TAU * random.f64()).cos()
    }

    /// Cycles of 30 ms: 20 ms of rest, then one swing v_r = -0.1 (1 - cos) of 10 ms; acceleration, and v_r.
    fn record(noise: f64, offset: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
        let mut random = normal(5);
        let time: Vec<f64> = (0..6000).map(|i| f64::from(i) * STEP).collect();
        let swing = |t: f64| (t.rem_euclid(0.03) - 0.02).max(0.0) * TAU / 0.01;
        let velocity: Vec<f64> = time
            .iter()
            .map(|t| -0.1 * (1.0 - swing(*t).cos()))
            .collect();
        let acceleration = time
            .iter()
            .map(|t| -0.1 * TAU / 0.01 * swing(*t).sin() + offset + noise * random())
            .collect();
        (time, acceleration, velocity)
    }

    #[test]
    fn val_rest_is_found_with_its_offset_and_gives_the_velocity_of_the_swing() {
        // Source: closed form of the swing that the record was made of.
        let (noise, offset) = (0.3, -0.05);
        let (time, acceleration, velocity) = record(noise, offset);
        let found = rest(&acceleration, noise, 30).unwrap();
        assert!(
            (found.offset - offset).abs() < 4.0 * found.offset_std,
            "{found:?}"
        );
        let wrong = (0..time.len())
            .filter(|&k| found.on[k] != (velocity[k] == 0.0))
            .count();
        assert!(wrong < time.len() / 50, "{wrong}");
        let by_integral = velocity_from_rest(&time, &acceleration, Some(&found));
        for (found, v) in by_integral.iter().zip(&velocity) {
            assert!((found - v).abs() < 2e-3, "{found} {v}");
        }
    }

    #[test]
    fn nothing_rests_in_a_swing_and_in_no_record() {
        let swing: Vec<f64> = (0..3000)
            .map(|i| 50.0 * (PI * f64::from(i) / 60.0).sin())
            .collect();
        assert_eq!(rest(&swing, 0.3, 30), None);
        assert_eq!(rest(&[], 0.3, 30), None);
        assert_eq!(rest(&[0.0; 40], 0.0, 30), None);
    }
}
