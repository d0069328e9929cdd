//! How sure a slope is: parts of the record left out, surrogates put in.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::correlation_sum::{CorrelationSum, SumSettings};
use super::error::DimensionError;
use super::scaling::Region;
use super::slopes::fitted_slope;
use super::surrogate::{ends_that_fit, iaaft, longest_unbroken};
use crate::watch::Watch;

/// Blocks of the jackknife.
const BLOCKS: usize = 10;

/// Standard deviations by delete-block jackknife.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Errors {
    /// Of the slope in a region.
    pub slope: f64,
    /// Of its change from the first embedding dimension of the region to the last.
    pub change: f64,
}

/// Standard deviations of the slope in a region, and of its change over embedding dimensions, by delete-block jackknife.
///
/// ```text
/// s^2 = (g - 1)/g sum_b (D_b - <D>)^2
/// ```
///
/// D_b: slope without the samples of block b of g = 10 in time. A block is longer than the correlation of the series, so that blocks
/// are independent; the least-squares error of the straight line is several times too small, as pairs share points.
/// Source: Kuensch, Annals of Statistics 17 (1989) 1217.
///
/// # Errors
/// [`DimensionError::Stopped`].
pub(super) fn jackknife(
    series: &[f64],
    settings: &SumSettings,
    region: &Region,
    watch: &dyn Watch,
) -> Result<Errors, DimensionError> {
    let n = series.len();
    let mut slopes = Vec::with_capacity(BLOCKS);
    let mut changes = Vec::with_capacity(BLOCKS);
    for block in 0..BLOCKS {
        watch.step("blocks left out", block, BLOCKS);
        let mut left = series.to_vec();
        left[block * n / BLOCKS..(block + 1) * n / BLOCKS].fill(f64::NAN);
        let sum = CorrelationSum::count(&left, settings, &|_| !watch.stop())?;
        slopes.push(region.slope_of(&sum));
        changes.push(region.change_of(&sum));
    }
    Ok(Errors {
        slope: deviation(&slopes),
        change: deviation(&changes),
    })
}

/// The jackknife's standard deviation from the values without each block.
fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / BLOCKS as f64;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (squares * (BLOCKS as f64 - 1.0) / BLOCKS as f64).sqrt()
}

/// Slopes of the series and of its surrogates, at one embedding dimension.
#[derive(Debug, Clone, PartialEq)]
pub struct SurrogateTest {
    /// Embedding dimension.
    pub dimension: usize,
    /// Slope of the series where C is near 0.001.
    pub slope: f64,
    /// The same of each surrogate.
    pub surrogates: Vec<f64>,
    /// (slope - mean of the surrogates) / their standard deviation.
    pub z: f64,
    /// Share of series and surrogates with a slope as low as that of the series.
    pub p_value: f64,
    /// Lowest and highest C(r) of the surrogates over the radii, for the picture.
    pub band: Vec<(f64, f64)>,
    /// Samples used: the longest part without gaps, shortened where the series is long.
    pub samples: usize,
}

/// |z| up to which a series is not told from its surrogates.
const DISTINCT: f64 = 3.0;
/// p value above which it is not, either.
const CHANCE: f64 = 0.05;

impl SurrogateTest {
    /// Lower-dimensional than its surrogates, beyond chance.
    pub fn is_distinct(&self) -> bool {
        self.z < -DISTINCT && self.p_value <= CHANCE
    }
}

/// Longest series that is tested; a longer one is told apart by a part of it.
const LONGEST: usize = 30_000;
/// C(r) between which the slope is fitted.
const SUMS: (f64, f64) = (2e-4, 5e-3);

/// Compares a series with surrogates that have its values and its spectrum.
///
/// The slope of ln C where C is near 0.001 is compared at one embedding dimension. A series of low dimension has a lower one than its
/// surrogates. One-sided; with 39 surrogates the smallest possible p value is 0.025. Source: Theiler and others, Physica D 58 (1992) 77.
///
/// # Errors
/// [`DimensionError`] as in [`CorrelationSum::count`]. A stop leaves the surrogates done by then; with less than 19, it is an error.
pub(super) fn surrogate_test(
    series: &[f64],
    settings: &SumSettings,
    dimension: usize,
    count: usize,
    seed: u64,
    watch: &dyn Watch,
) -> Result<SurrogateTest, DimensionError> {
    let unbroken = &series[longest_unbroken(series)];
    let excess = unbroken.len().saturating_sub(LONGEST) / 2;
    let part = ends_that_fit(&unbroken[excess..unbroken.len() - excess]);
    let settings = SumSettings {
        dimensions: dimension,
        threads: 1,
        ..*settings
    };
    let own = CorrelationSum::count(part, &settings, &|_| !watch.stop())?;
    let slope = slope_near(&own, dimension);
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let worker = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count || watch.stop() {
                break;
            }
            let surrogate = iaaft(part, seed.wrapping_add(number as u64));
            if let Ok(sum) = CorrelationSum::count(&surrogate, &settings, &|_| !watch.stop()) {
                let mut done = done.lock().unwrap_or_else(|e| e.into_inner());
                done.push((number, slope_near(&sum, dimension), sum.sums(dimension)));
                watch.step("surrogates", done.len(), count);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(worker);
        }
    });
    let mut done = done.into_inner().unwrap_or_else(|e| e.into_inner());
    // Whichever thread was faster: the result is the same.
    done.sort_by_key(|d| d.0);
    if done.len() < 19 {
        return Err(DimensionError::Stopped {
            what: "comparing with surrogates",
        });
    }
    let band = (0..own.radii.len()).map(|k| {
        let at = done.iter().map(|d| d.2[k]);
        at.fold((f64::INFINITY, 0.0_f64), |(l, h), c| (l.min(c), h.max(c)))
    });
    let band = band.collect();
    let surrogates: Vec<f64> = done.iter().map(|d| d.1).filter(|s| s.is_finite()).collect();
    let n = surrogates.len().max(1) as f64;
    let mean = surrogates.iter().sum::<f64>() / n;
    let variance = surrogates.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
    let as_low = surrogates.iter().filter(|s| **s <= slope).count();
    Ok(SurrogateTest {
        dimension,
        slope,
        z: (slope - mean) / variance.sqrt().max(1e-6),
        p_value: (1 + as_low) as f64 / (n + 1.0),
        surrogates,
        band,
        samples: part.len(),
    })
}

/// Slope of ln C where C is near 0.001; NaN where that is not resolved.
fn slope_near(sum: &CorrelationSum, m: usize) -> f64 {
    let shares = sum.sums(m);
    let inside = |k: &usize| shares[*k] >= SUMS.0 && sum.counts[m - 1][*k] >= 20;
    let from = (0..shares.len()).find(inside);
    let to = (0..shares.len()).rev().find(|k| shares[*k] <= SUMS.1);
    match (from, to) {
        (Some(from), Some(to)) if to >= from + 2 => fitted_slope(sum, m, from, to).0,
        // So steep that a step of the radius passes over the whole range of C: the slope around it.
        (Some(from), _) if from > 0 && from + 1 < shares.len() => {
            fitted_slope(sum, m, from - 1, from + 1).0
        }
        _ => f64::NAN,
    }
}
