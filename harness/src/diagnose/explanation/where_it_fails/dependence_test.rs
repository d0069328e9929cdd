//! When an error is said to depend on a quantity.
//!
//! Two conditions, because each alone misleads. The levels must differ by more than [`FACTOR`]: a difference that is certain but
//! smaller is no clue to what is missing; a level below the noise counts as the noise, which fitted start states take a part of. And they must differ by more than chance makes: the logarithms of the groups' medians
//! are dealt out anew among the intervals, [`SHUFFLES`] times, and the sum of squares between the intervals may be reached
//! in no more than [`CHANCE`] of them. Six pictures then name a dependence by chance in about 3 reports of 100. Where a segment has
//! samples in several intervals, what it has in common with itself makes the test more cautious, not less.

use super::level::Level;

/// Largest over smallest level below which no dependence is named.
pub const FACTOR: f64 = 1.5;
/// Times that the groups are dealt out anew.
pub const SHUFFLES: usize = 999;
/// Share of them that may come as far apart by chance.
pub const CHANCE: f64 = 0.005;

/// What the levels say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Finding {
    /// The error depends on the quantity.
    Depends,
    /// The levels are the same but for a factor that is no clue.
    Same,
    /// The levels are apart, but no further than chance makes them.
    Chance,
    /// Fewer than two intervals with a level.
    TooFew,
}

/// The largest and the smallest level that are compared: of the stratum in which they are furthest apart.
pub fn extremes(levels: &[Level]) -> Option<(&Level, &Level)> {
    let strata: std::collections::BTreeSet<usize> = levels.iter().map(|l| l.stratum).collect();
    let of = |stratum: usize| {
        let known = || {
            levels
                .iter()
                .filter(move |l| l.stratum == stratum && l.is_known())
        };
        let by = |a: &&Level, b: &&Level| a.over_noise.total_cmp(&b.over_noise);
        let (largest, smallest) = (known().max_by(by)?, known().min_by(by)?);
        (known().count() > 1).then_some((largest, smallest))
    };
    let ratio = |pair: &(&Level, &Level)| pair.0.over_noise / pair.1.over_noise;
    strata
        .into_iter()
        .filter_map(of)
        .max_by(|a, b| ratio(a).total_cmp(&ratio(b)))
}

/// Whether the error depends on the quantity.
pub fn judge(levels: &[Level]) -> Finding {
    let Some((largest, smallest)) = extremes(levels) else {
        return Finding::TooFew;
    };
    if largest.over_noise < FACTOR * smallest.over_noise.max(1.0) {
        return Finding::Same;
    }
    match probability_of_chance(levels) <= CHANCE {
        true => Finding::Depends,
        false => Finding::Chance,
    }
}

/// Share of random exchanges of groups between intervals, within their strata, that spread the intervals as far.
fn probability_of_chance(levels: &[Level]) -> f64 {
    let known: Vec<&Level> = levels.iter().filter(|l| l.is_known()).collect();
    let mut strata: std::collections::BTreeMap<usize, (Vec<usize>, Vec<f64>)> = Default::default();
    for level in known {
        let (counts, values) = strata.entry(level.stratum).or_default();
        counts.push(level.groups.len());
        values.extend(&level.groups);
    }
    let spread = |strata: &std::collections::BTreeMap<usize, (Vec<usize>, Vec<f64>)>| -> f64 {
        let of = |(counts, values): &(Vec<usize>, Vec<f64>)| -> f64 {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let mut first = 0;
            let squares = counts.iter().map(|&n| {
                let here = values[first..first + n].iter().sum::<f64>() / n as f64;
                first += n;
                n as f64 * (here - mean).powi(2)
            });
            squares.sum()
        };
        strata.values().map(of).sum()
    };
    // Rounding must not make an exchange that changes nothing look smaller.
    let found = spread(&strata) * (1.0 - 1e-9);
    let mut random = fastrand::Rng::with_seed(1);
    let mut as_far = 1;
    for _ in 0..SHUFFLES {
        for (_, values) in strata.values_mut() {
            random.shuffle(values);
        }
        as_far += usize::from(spread(&strata) >= found);
    }
    as_far as f64 / (SHUFFLES + 1) as f64
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::level::BySegment;
    use super::*;

    /// A level of `segments` segments of ten samples each, around `level` times a scatter from segment to segment.
    pub fn level(place: &str, level: f64, scatter: f64, segments: usize, seed: u64) -> Level {
        let mut random = fastrand::Rng::with_seed(seed);
        let by_segment: BySegment = (0..segments)
            .map(|s| {
                let own = level * (scatter * (random.f64() + random.f64() - 1.0)).exp();
                let samples = (0..10).map(|_| own * (0.9 + 0.2 * random.f64())).collect();
                (s, samples)
            })
            .collect();
        Level::new(place.to_owned(), 0.0, 0, &by_segment)
    }

    #[test]
    fn a_dependence_is_named_where_levels_are_further_apart_than_segments_scatter() {
        let of = |a: f64, b: f64, scatter: f64, segments: usize| {
            judge(&[
                level("a", a, scatter, segments, 1),
                level("b", b, scatter, segments, 2),
                level("c", a, scatter, segments, 3),
            ])
        };
        assert_eq!(of(1.0, 14.0, 0.3, 20), Finding::Depends);
        assert_eq!(of(1.0, 1.1, 0.0, 20), Finding::Same);
        // Fitted start states take away the noise's low frequencies: nothing fails there.
        assert_eq!(of(1.0, 0.6, 0.01, 40), Finding::Same);
        // Certain, but too small to be a clue.
        assert_eq!(of(1.0, 1.4, 0.01, 40), Finding::Same);
        // Segments of which each errs by a factor of its own, up to 20.
        assert_eq!(of(10.0, 20.0, 3.0, 6), Finding::Chance);
        assert_eq!(of(1.0, 14.0, 0.3, 3), Finding::TooFew);
    }

    #[test]
    fn chance_alone_names_no_more_than_it_may() {
        let named = (0..400).filter(|trial| {
            let levels: Vec<Level> = (0..6)
                .map(|i| level("", 10.0, 3.0, 7, 1000 + 10 * trial + i))
                .collect();
            judge(&levels) == Finding::Depends
        });
        let named = named.count();
        assert!(named <= 6, "{named} of 400 where 2 are expected");
    }

    #[test]
    fn intervals_are_compared_within_their_strata_only() {
        let mut levels = [level("a", 1.0, 0.1, 20, 1), level("b", 100.0, 0.1, 20, 2)];
        assert_eq!(judge(&levels), Finding::Depends);
        levels[1].stratum = 1;
        assert_eq!(judge(&levels), Finding::TooFew);
    }
}
