//! The value at which a signal rests: in stick the tip's velocity is the belt's.

/// A plateau of a signal.
#[derive(Debug, Clone)]
pub struct Plateau {
    /// Where it is, in the signal's unit.
    pub value: f64,
    /// Half the width of the band that counts as this value, in the signal's unit.
    pub half: f64,
    /// For each sample, whether it lies on it.
    pub on: Vec<bool>,
    /// Share of the samples that lie on it.
    pub share: f64,
}

/// Half width of the band that counts as one value: in standard deviations of the noise, and at
/// least this share of the signal's root mean square.
const BAND_STDS: f64 = 3.0;
const BAND_SHARE: f64 = 5e-3;
/// Samples beside the band, within three half widths, over those in it. A turning point leaves 0.73
/// times as many there, a phase of rest next to none.
const BESIDE: f64 = 0.4;
/// A band that holds fewer samples is no plateau.
const LEAST_SHARE: f64 = 0.03;

/// The most frequent value of `signal`, whose noise has the standard deviation `std`, if the signal
/// rests there and does not merely turn. Nothing is known beforehand of where it is.
pub fn plateau(signal: &[f64], std: f64) -> Option<Plateau> {
    let half = half_band(signal, std);
    if !(half > 0.0 && half.is_finite()) {
        return None;
    }
    let mut sorted = signal.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (mut most, mut value, mut past) = (0, f64::NAN, 0);
    for first in 0..sorted.len() {
        while past < sorted.len() && sorted[past] <= sorted[first] + 2.0 * half {
            past += 1;
        }
        if past - first > most {
            // The median of the band, since transitions hang on one side of it.
            (most, value) = (past - first, sorted[(first + past) / 2]);
        }
    }
    let count = |reach: f64| {
        sorted.partition_point(|v| *v <= value + reach)
            - sorted.partition_point(|v| *v < value - reach)
    };
    let inside = count(half);
    let beside = count(3.0 * half) - inside;
    let share = inside as f64 / signal.len() as f64;
    let rests = share >= LEAST_SHARE && (beside as f64) < BESIDE * inside as f64;
    rests.then(|| Plateau {
        value,
        half,
        on: signal.iter().map(|v| (v - value).abs() <= half).collect(),
        share,
    })
}

/// Half the width of the band that counts as one value.
pub(super) fn half_band(signal: &[f64], std: f64) -> f64 {
    let rms = (signal.iter().map(|v| v * v).sum::<f64>() / signal.len() as f64).sqrt();
    (BAND_STDS * std).max(BAND_SHARE * rms)
}

#[cfg(test)]
mod tests {
    use super::plateau;

    /// Rests at `value` for two thirds of each cycle, then swings through zero.
    fn signal(value: f64) -> Vec<f64> {
        let at = |i: i32| match i % 300 {
            0..200 => value,
            rest => -2.0 * value * f64::from(rest - 250) / 50.0,
        };
        let mut random = fastrand::Rng::with_seed(3);
        (0..9000)
            .map(|i| at(i) + 1e-3 * value * (random.f64() - 0.5))
            .collect()
    }

    #[test]
    fn val_a_plateau_is_found_wherever_it_is_and_a_turning_point_is_none() {
        // The value is the one that the signal was made with.
        for value in [0.06, -60.0, 1e-5] {
            let found = plateau(&signal(value), 3e-4 * value.abs()).unwrap();
            assert!((found.value / value - 1.0).abs() < 2e-3, "{}", found.value);
            assert!((found.share - 0.667).abs() < 0.02, "{}", found.share);
        }
        let sine: Vec<f64> = (0..9000).map(|i| (0.021 * f64::from(i)).sin()).collect();
        assert!(plateau(&sine, 1e-3).is_none());
        assert!(plateau(&[0.0; 100], 0.0).is_none());
        assert!(plateau(&[f64::MAX; 100], 0.0).is_none());
    }
}
