//! By how much a further sensor's clock is late, by the correlation of what it read with what the motion asks for.
//!
//! At the right offset both correlate most. A motion that repeats looks alike after each of its periods: of offsets that explain the
//! readings alike the least counts.

/// The longest offset looked for, as a share of a record, ...
const LONGEST_SHARE: usize = 4;
/// ... and in samples: beyond, records have no beginning in common.
const MOST_SAMPLES: isize = 10_000;
/// Samples that a correlation is worked out from at most: it is then good to a few percent of what is left.
const MOST_PAIRS: usize = 4000;
/// Pairs of samples that it needs at least.
const FEWEST_PAIRS: usize = 100;
/// What is left of the readings at an offset, over what is left at another one, from which on the two explain them differently.
const ALIKE: f64 = 2.0;
/// What is left of readings that follow as well as any do.
const LEAST_LEFT: f64 = 1e-6;

/// An offset between two clocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ClockOffset {
    /// Samples by which the readings are late; between samples by a parabola.
    pub samples: f64,
    /// Correlation at that offset.
    pub correlation: f64,
    /// Share of the readings' variance that is left there, ...
    left: f64,
    /// ... and without an offset.
    left_without: f64,
}

impl ClockOffset {
    /// The offset of what was `read` at the samples of what is `expected`; not finite is what is not known. `None` where nothing varies.
    pub fn between(read: &[f64], expected: &[f64]) -> Option<Self> {
        let count = read.len().min(expected.len());
        let most = MOST_SAMPLES.min((count / LONGEST_SHARE) as isize);
        let places = places(read);
        let at = |lag: isize| correlation(read, expected, &places, lag).unwrap_or(0.0);
        let all: Vec<f64> = (-most - 1..=most + 1).map(at).collect();
        let left = |i: usize| (1.0 - all[i].max(0.0).powi(2)).max(LEAST_LEFT);
        let inner = 1..all.len() - 1;
        let least = inner.clone().map(left).reduce(f64::min);
        let least = least.filter(|least| *least < 1.0)?;
        let is_top = |&i: &usize| all[i] >= all[i - 1] && all[i] >= all[i + 1];
        let tops = inner.filter(|i| is_top(i) && left(*i) <= ALIKE * least);
        let lag = |i: usize| i as isize - most - 1;
        let best = tops.min_by_key(|&i| lag(i).abs())?;
        let (before, top, after) = (all[best - 1], all[best], all[best + 1]);
        let bend = before - 2.0 * top + after;
        let between = match bend < 0.0 {
            true => 0.5 * (before - after) / bend,
            false => 0.0,
        };
        Some(Self {
            samples: lag(best) as f64 + between,
            correlation: top,
            left: left(best),
            left_without: left((most + 1) as usize),
        })
    }

    /// Whether the clocks differ by a sample at least, and the readings follow clearly better with that.
    pub fn is_clear(&self) -> bool {
        self.samples.abs() >= 1.0 && self.left * ALIKE < self.left_without
    }
}

/// Correlation of readings at these places with what is expected `lag` samples before; `None` where nothing varies.
fn correlation(read: &[f64], expected: &[f64], places: &[usize], lag: isize) -> Option<f64> {
    let pairs = places.iter().filter_map(|&i| {
        let before = usize::try_from(i as isize - lag).ok()?;
        let pair = (*expected.get(before)?, read[i]);
        pair.0.is_finite().then_some(pair)
    });
    let (mut n, mut x, mut y, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    let mut origin = None;
    for (a, b) in pairs {
        // About the first pair: a mean far from zero would cost digits.
        let (a0, b0) = *origin.get_or_insert((a, b));
        let (a, b) = (a - a0, b - b0);
        n += 1.0;
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
        yy += b * b;
    }
    let (xx, xy, yy) = (xx - x * x / n, xy - x * y / n, yy - y * y / n);
    (n >= FEWEST_PAIRS as f64 && xx > 0.0 && yy > 0.0).then(|| xy / (xx * yy).sqrt())
}

/// Places of at most [`MOST_PAIRS`] readings, at irregular distances: at regular ones a motion that repeats may look like none.
fn places(read: &[f64]) -> Vec<usize> {
    let known: Vec<usize> = (0..read.len()).filter(|&i| read[i].is_finite()).collect();
    if known.len() <= MOST_PAIRS {
        return known;
    }
    // Multiples of the golden section modulo 1 fill an interval evenly and without a period (Weyl).
    let share = |n: usize| (n as f64 * (5.0_f64.sqrt() - 1.0) / 2.0).fract();
    let drawn = (0..MOST_PAIRS).map(|n| known[(share(n) * known.len() as f64) as usize]);
    drawn.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(t: f64) -> f64 {
        (0.11 * t).sin() + 0.4 * (0.53 * t + 0.2).sin() + 2e-4 * t
    }

    fn readings(late_by: f64, noise: f64) -> Vec<f64> {
        let at = |i: u32| {
            let t = f64::from(i);
            5.0 + 3.0 * motion(t - late_by) + noise * (1.7 * t * t).sin()
        };
        (0..2000).map(at).collect()
    }

    #[test]
    fn readings_that_are_late_are_found_to_be_so_by_a_part_of_a_sample() {
        let expected: Vec<f64> = (0..2000).map(|i| motion(f64::from(i))).collect();
        for late_by in [-31.3, 4.4, 12.0] {
            let found = ClockOffset::between(&readings(late_by, 0.02), &expected).unwrap();
            assert!((found.samples - late_by).abs() < 0.05, "{found:?}");
            assert!(found.is_clear() && found.correlation > 0.995, "{found:?}");
        }
    }

    #[test]
    fn of_a_motion_that_repeats_the_least_offset_counts_and_none_is_claimed_of_clocks_that_agree() {
        let period = 40.0;
        let wave = |t: f64| (std::f64::consts::TAU * t / period).sin();
        let expected: Vec<f64> = (0..2000).map(|i| wave(f64::from(i))).collect();
        let read: Vec<f64> = (0..2000).map(|i| wave(f64::from(i) - 7.0)).collect();
        let found = ClockOffset::between(&read, &expected).unwrap();
        assert!((found.samples - 7.0).abs() < 0.05, "{found:?}");
        assert!(
            !ClockOffset::between(&expected, &expected)
                .unwrap()
                .is_clear()
        );
        let expected: Vec<f64> = (0..2000).map(|i| motion(f64::from(i))).collect();
        let agreeing = ClockOffset::between(&readings(0.0, 0.5), &expected).unwrap();
        assert!(!agreeing.is_clear(), "{agreeing:?}");
        assert_eq!(ClockOffset::between(&[1.0; 500], &expected), None);
    }
}
