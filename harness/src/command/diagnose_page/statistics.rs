//! Small statistics for pictures.

/// Median of the finite values; NaN without any.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, 0.5)
}

fn quantile_of_sorted(sorted: &[f64], share: f64) -> f64 {
    match sorted.len() {
        0 => f64::NAN,
        n => sorted[((n - 1) as f64 * share).round() as usize],
    }
}

/// Scatter of y over intervals of x.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Bins {
    /// Middle of each interval.
    pub x: Vec<f64>,
    /// Lower quartile in it; NaN where there are too few values, here and below.
    pub low: Vec<f64>,
    /// Median.
    pub middle: Vec<f64>,
    /// Upper quartile.
    pub high: Vec<f64>,
}

/// Fewest values from which an interval shows quartiles.
const FEWEST: usize = 6;

/// Quartiles of y in `count` equal intervals of x.
pub fn bins(points: &[(f64, f64)], count: usize) -> Bins {
    let finite = || points.iter().filter(|p| p.0.is_finite() && p.1.is_finite());
    let low = finite().map(|p| p.0).fold(f64::INFINITY, f64::min);
    let high = finite().map(|p| p.0).fold(f64::NEG_INFINITY, f64::max);
    if !(high > low) {
        return Bins::default();
    }
    let width = (high - low) / count as f64;
    let mut values = vec![Vec::new(); count];
    for p in finite() {
        values[(((p.0 - low) / width) as usize).min(count - 1)].push(p.1);
    }
    let mut out = Bins::default();
    for (i, list) in values.iter_mut().enumerate() {
        list.sort_by(f64::total_cmp);
        let kept: &[f64] = if list.len() < FEWEST { &[] } else { list };
        out.x.push(low + width * (i as f64 + 0.5));
        out.low.push(quantile_of_sorted(kept, 0.25));
        out.middle.push(quantile_of_sorted(kept, 0.5));
        out.high.push(quantile_of_sorted(kept, 0.75));
    }
    out
}

/// Stretches of bins that hold values, for bands, which can't be interrupted.
pub fn stretches(bins: &Bins) -> Vec<std::ops::Range<usize>> {
    let mut out = Vec::new();
    let mut first = 0;
    for part in bins.middle.chunk_by(|a, b| a.is_finite() == b.is_finite()) {
        if part[0].is_finite() {
            out.push(first..first + part.len());
        }
        first += part.len();
    }
    out
}

/// At most `most` of the items, evenly spread.
pub fn thinned<T: Clone>(items: &[T], most: usize) -> Vec<T> {
    let every = items.len().div_ceil(most.max(1)).max(1);
    items.iter().step_by(every).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_show_quartiles_and_leave_gaps() {
        let mut points: Vec<(f64, f64)> = (0..100).map(|i| (0.1, f64::from(i))).collect();
        points.push((1.0, 5.0));
        points.push((f64::NAN, 5.0));
        let found = bins(&points, 3);
        assert_eq!(
            (found.low[0], found.middle[0], found.high[0]),
            (25.0, 50.0, 74.0)
        );
        assert!(found.middle[1].is_nan() && found.middle[2].is_nan());
        assert_eq!(stretches(&found), vec![0..1]);
        assert!(bins(&[], 3).x.is_empty());
    }

    #[test]
    fn the_median_ignores_what_is_missing() {
        assert_eq!(median([3.0, f64::NAN, 1.0, 2.0].into_iter()), 2.0);
        assert!(median(std::iter::empty()).is_nan());
    }
}
