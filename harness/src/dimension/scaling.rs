//! The scaling region: where the local slopes agree over radii and over embedding dimensions.

use super::correlation_sum::CorrelationSum;
use super::slopes::fitted_slope;

/// What a scaling region must be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RegionSettings {
    /// Smallest number of pairs within a radius.
    pub fewest_pairs: u64,
    /// Largest C(m, r): above it the size of the attractor is felt.
    pub largest_sum: f64,
    /// Largest radius, as share of the range of the series: for the same reason.
    pub largest_radius: f64,
    /// Shortest region, octaves.
    pub octaves: f64,
    /// Largest difference of slopes between embedding dimensions, as share of the slope.
    pub spread: f64,
    /// Largest difference of slopes between the parts of the region, as share of the slope.
    pub curvature: f64,
    /// Embedding dimensions in a row that have to agree.
    pub agreeing: usize,
    /// Radii between which to look, if they are not to be found; unit of the series.
    pub between: Option<(f64, f64)>,
}

impl RegionSettings {
    /// Usual values for a sum.
    pub fn of(sum: &CorrelationSum) -> RegionSettings {
        let along = (sum.settings.delay / sum.settings.thin).max(1) as u64;
        RegionSettings {
            // Pairs come in runs about one delay long along the trajectory, and at as many neighbouring lags.
            fewest_pairs: (150 * along * sum.settings.delay as u64).clamp(500, 20_000),
            largest_sum: 0.02,
            largest_radius: 1.0 / 16.0,
            octaves: 2.0,
            spread: 0.05,
            curvature: 0.1,
            agreeing: 4,
            between: None,
        }
    }
}

/// A scaling region and the slope there.
#[derive(Debug, Clone, PartialEq)]
pub struct Region {
    /// Numbers of the first and last radius.
    pub radii: (usize, usize),
    /// Their values, unit of the series.
    pub from: f64,
    /// Largest radius.
    pub to: f64,
    /// First and last embedding dimension that agree.
    pub dimensions: (usize, usize),
    /// Slope: the mean over those dimensions, weighted by the pairs within the smallest radius.
    pub slope: f64,
    /// Slope of each of them.
    pub slopes: Vec<f64>,
    /// Root mean square over windows that would also do, weighted by their quality, of slope less this slope.
    pub window_std: f64,
}

impl Region {
    /// Length in octaves.
    pub fn octaves(&self) -> f64 {
        (self.to / self.from).log2()
    }

    /// The slope of another sum of the same form (a part of the data, say) in the same region.
    pub fn slope_of(&self, sum: &CorrelationSum) -> f64 {
        let (first, last) = self.dimensions;
        let each = (first..=last).map(|m| {
            let slope = fitted_slope(sum, m, self.radii.0, self.radii.1).0;
            (sum.counts[m - 1][self.radii.0] as f64, slope)
        });
        weighted_mean(each)
    }

    /// Slope at the last agreeing embedding dimension less that at the first, of another sum of the same form.
    pub fn change_of(&self, sum: &CorrelationSum) -> f64 {
        let (first, last) = self.dimensions;
        let slope = |m| fitted_slope(sum, m, self.radii.0, self.radii.1).0;
        slope(last) - slope(first)
    }
}

/// Misfit in ln C below which straighter is chance: a short window is easily straight.
const STRAIGHT_ENOUGH: f64 = 0.02;

/// How far an embedding dimension must be above the slope: just above it, slopes are still low.
const ABOVE: f64 = 1.5;

struct Candidate {
    radii: (usize, usize),
    dimensions: (usize, usize),
    slope: f64,
    slopes: Vec<f64>,
    weight: f64,
}

/// Finds the scaling region, or none.
///
/// Every window of radii of at least the shortest length is tried. In it the slope of ln C over ln r is fitted for each embedding
/// dimension. A window counts if (1) it holds enough pairs and C is small enough; (2) the slopes of its halves differ by less than
/// `curvature`; (3) for some dimensions in a row, from the first one that is above the slope by 1.5 or more, the slopes differ by less than
/// `spread`. Its weight is
///
/// ```text
/// octaves^2 / [m0 (misfit^2 + spread^2 + 0.02^2)]
/// ```
///
/// misfit: of the straight line, in ln C; m0: first of the dimensions (the larger they are, the fewer pairs are left); spread: standard deviation of the slopes over dimensions as share of the slope. The
/// region is the window whose slope is the weighted median of all and whose weight is largest among those near it.
///
/// Sources: Deshmukh, Bradley, Garland and Meiss, Chaos 31 (2021) 123102 (all windows, weighted); Albano and others, Phys. Rev. A 38
/// (1988) 3017 (slopes within 10 %, several dimensions); Ding and others, Phys. Rev. Lett. 70 (1993) 3872 (saturation from the
/// first dimension above D on).
pub fn find_region(sum: &CorrelationSum, s: &RegionSettings) -> Option<Region> {
    let mut found = Vec::new();
    let count = sum.radii.len();
    let (lowest, highest) = s
        .between
        .unwrap_or((0.0, s.largest_radius * sum.radii[count - 1]));
    // The largest radius may be up to a step above the range.
    let inside = |k: usize| (lowest..=highest * 1.0001).contains(&sum.radii[k]);
    let shares: Vec<Vec<f64>> = (1..=sum.settings.dimensions).map(|m| sum.sums(m)).collect();
    for from in 0..count {
        for to in from + 1..count {
            let octaves = (sum.radii[to] / sum.radii[from]).log2();
            if octaves < s.octaves - 1e-9 || !inside(from) || !inside(to) {
                continue;
            }
            let given = s.between.is_some();
            let usable = |m: usize| {
                sum.counts[m - 1][from] >= s.fewest_pairs
                    && (given || shares[m - 1][to] <= s.largest_sum)
            };
            found.extend(candidate(sum, s, (from, to), octaves, &usable));
        }
    }
    let total: f64 = found.iter().map(|c| c.weight).sum();
    found.sort_by(|a, b| a.slope.total_cmp(&b.slope));
    let mut passed = 0.0;
    let median = found.iter().find(|c| {
        passed += c.weight;
        passed >= 0.5 * total
    })?;
    let slope = median.slope;
    let variance = found
        .iter()
        .map(|c| c.weight * (c.slope - slope).powi(2))
        .sum::<f64>()
        / total;
    let near = |c: &&Candidate| (c.slope - slope).abs() <= 0.01 * slope;
    let best = found
        .iter()
        .filter(near)
        .max_by(|a, b| a.weight.total_cmp(&b.weight))?;
    Some(Region {
        radii: best.radii,
        from: sum.radii[best.radii.0],
        to: sum.radii[best.radii.1],
        dimensions: best.dimensions,
        slope: best.slope,
        slopes: best.slopes.clone(),
        window_std: variance.sqrt(),
    })
}

/// The dimensions that agree in one window, if there are enough.
fn candidate(
    sum: &CorrelationSum,
    s: &RegionSettings,
    radii: (usize, usize),
    octaves: f64,
    usable: &dyn Fn(usize) -> bool,
) -> Option<Candidate> {
    let middle = (radii.0 + radii.1) / 2;
    let mut run: Vec<(usize, f64, f64)> = Vec::new();
    for m in 1..=sum.settings.dimensions {
        let straight = usable(m).then(|| {
            let (slope, misfit) = fitted_slope(sum, m, radii.0, radii.1);
            let halves = [(radii.0, middle), (middle, radii.1)]
                .map(|(from, to)| fitted_slope(sum, m, from, to).0);
            let bent = (halves[1] - halves[0]).abs() > s.curvature * slope;
            (!bent && slope > 0.05 && m as f64 >= slope + ABOVE).then_some((m, slope, misfit))
        });
        let Some(one) = straight.flatten() else {
            run.clear();
            continue;
        };
        run.push(one);
        // The last dimensions that agree with one another.
        while spread(&run) > s.spread {
            run.remove(0);
        }
        if run.len() < s.agreeing {
            continue;
        }
        let n = run.len() as f64;
        let pairs = |m: usize| sum.counts[m - 1][radii.0] as f64;
        let slope = weighted_mean(run.iter().map(|r| (pairs(r.0), r.1)));
        let variance = run.iter().map(|r| (r.1 / slope - 1.0).powi(2)).sum::<f64>() / n;
        let misfit = run.iter().map(|r| r.2 * r.2).sum::<f64>() / n;
        let weight = octaves.powi(2)
            / run[0].0 as f64
            / (misfit + variance + STRAIGHT_ENOUGH * STRAIGHT_ENOUGH);
        // The first run of dimensions is taken: the larger they are, the fewer pairs are left at the same radius.
        return Some(Candidate {
            radii,
            dimensions: (run[0].0, m),
            slope,
            slopes: run.iter().map(|r| r.1).collect(),
            weight,
        });
    }
    None
}

/// Mean of values with weights in front. Slopes are weighted by the pairs they rest on.
fn weighted_mean(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (sum, weight) = values.fold((0.0, 0.0), |(s, w), (weight, value)| {
        (s + weight * value, w + weight)
    });
    sum / weight
}

/// Largest less smallest slope, as share of their mean.
fn spread(run: &[(usize, f64, f64)]) -> f64 {
    let slopes = run.iter().map(|r| r.1);
    let (low, high) = slopes
        .clone()
        .fold((f64::INFINITY, 0.0_f64), |(l, h), s| (l.min(s), h.max(s)));
    let mean = slopes.sum::<f64>() / run.len() as f64;
    (high - low) / mean
}
