//! Whether the slope has stopped to depend on the embedding dimension, and whether the motion came back often enough to say so.

/// Change of the slope over the embedding dimensions that a region is taken from.
///
/// The dimension is the limit of the slopes for ever larger embedding dimension (Stelter 1992, eq. 14). Slopes that differ
/// little from one dimension to the next may still climb without end, as those of a short noisy record do. So the change over
/// all dimensions of the region is held against its own standard error. That is much smaller than the error of the slopes
/// themselves, since neighbouring dimensions count the same pairs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Slope at the last embedding dimension of the region less slope at the first.
    pub change: f64,
    /// Standard error of that change, by the jackknife that gives the slope's own.
    pub std: f64,
    /// Standard deviation stated with the dimension.
    pub stated: f64,
}

/// Standard errors of the change above which it is no chance; as for surrogates.
const BEYOND: f64 = 3.0;

impl Convergence {
    /// Whether the slope stands still: its change is chance, or fits into the interval that is stated anyway, the slope give or take
    /// its standard deviation.
    pub fn is_plateau(&self) -> bool {
        let change = self.change.abs();
        change <= BEYOND * self.std || change <= 2.0 * self.stated
    }
}

/// Fewest returns of a motion from which a dimension is claimed.
///
/// Errors come from leaving out one of ten blocks of time. Blocks must be independent, so each must hold several
/// returns: five here. With less, all close pairs are of a few passes, and leaving out a block takes away a part of the
/// attractor.
pub const FEWEST_RETURNS: usize = 50;

/// Band around the mean, in standard deviations to either side, that a series must cross as a whole: noise crosses the mean often.
const BAND: f64 = 0.2;

/// How often a series comes back: its passages from below its mean to above it.
pub fn returns(series: &[f64]) -> usize {
    let there = || series.iter().copied().filter(|x| x.is_finite());
    let n = there().count().max(1) as f64;
    let mean = there().sum::<f64>() / n;
    let spread = (there().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
    let (mut is_below, mut count) = (false, 0);
    for x in there() {
        if x < mean - BAND * spread {
            is_below = true;
        } else if x > mean + BAND * spread {
            count += usize::from(is_below);
            is_below = false;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_returns_are_the_periods_of_a_sine_also_under_noise() {
        // Source: construction: 15 periods, the first of which starts at the mean.
        let mut random = fastrand::Rng::with_seed(1);
        for noise in [0.0, 0.1] {
            let x: Vec<f64> = (0..3000)
                .map(|i| {
                    let phase = f64::from(i) / 200.0 * std::f64::consts::TAU;
                    phase.sin() + noise * (random.f64() - 0.5)
                })
                .collect();
            assert_eq!(returns(&x), 14);
        }
        assert_eq!(returns(&[1.0, f64::NAN, -1.0, 1.0, -1.0, f64::NAN, 1.0]), 2);
    }

    #[test]
    fn a_change_counts_only_beyond_its_own_error_and_the_stated_one() {
        // Source: construction, with the changes of the demonstration's run 1, of the logistic map and of a laser.
        let of = |change, std, stated| {
            Convergence {
                change,
                std,
                stated,
            }
            .is_plateau()
        };
        assert!(!of(0.042, 0.003, 0.014));
        assert!(!of(-0.042, 0.003, 0.014));
        assert!(of(0.034, 0.014, 0.015));
        assert!(of(0.061, 0.009, 0.055));
        assert!(!of(0.061, 0.009, 0.03));
    }
}
