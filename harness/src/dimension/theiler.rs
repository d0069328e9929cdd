//! The Theiler window: how far apart in time two samples must be for their distance to say something of the shape.

use super::correlation_sum::counts_per_lag;
use super::error::DimensionError;

/// Space-time separation of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct Separation {
    /// The window taken, samples.
    pub window: usize,
    /// Shares of pairs that the contours enclose.
    pub shares: Vec<f64>,
    /// Per share, for lags 1, 2, ...: the radius within which that share of the pairs at this lag lies; unit of the series.
    pub contours: Vec<Vec<f64>>,
}

/// Contours shown.
const SHARES: [f64; 3] = [0.1, 0.5, 0.9];
/// The contour that decides.
const DECIDES: usize = 0;

/// Chooses the window from the space-time separation plot and the autocorrelation.
///
/// At each lag the radius is found within which 10 % of the pairs lie. It grows with the lag while pairs are close because they
/// are close in time. The window is twice the lag at which it first comes to its mean over the second half of the lags looked
/// at, and not less than `least` (where the autocorrelation passes zero). A long window costs little: a share of about 2 W/N of the pairs.
///
/// Source: Provenzale, Smith, Vio and Murante, Physica D 58 (1992) 31.
///
/// # Errors
/// [`DimensionError`] as in [`super::CorrelationSum::count`].
pub fn choose_theiler(
    series: &[f64],
    delay: usize,
    dimension: usize,
    least: usize,
    lags: usize,
) -> Result<Separation, DimensionError> {
    let (radii, counts) = counts_per_lag(series, delay, dimension, lags)?;
    let contours: Vec<Vec<f64>> = SHARES
        .iter()
        .map(|share| counts.iter().map(|c| contour(&radii, c, *share)).collect())
        .collect();
    let deciding = &contours[DECIDES];
    let late: Vec<f64> = deciding[deciding.len() / 2..]
        .iter()
        .filter(|r| **r > 0.0)
        .map(|r| r.ln())
        .collect();
    let level = (late.iter().sum::<f64>() / late.len().max(1) as f64).exp();
    let reached = deciding.iter().position(|r| *r >= level).unwrap_or(0) + 1;
    let most = series.len() / 10;
    Ok(Separation {
        window: (2 * reached).max(least).min(most).max(1),
        shares: SHARES.to_vec(),
        contours,
    })
}

/// Radius that encloses a share of the pairs, between two radii by a power law.
fn contour(radii: &[f64], counts: &[u64], share: f64) -> f64 {
    let all = *counts.last().unwrap_or(&0) as f64;
    let wanted = share * all;
    let Some(k) = counts.iter().position(|c| *c as f64 >= wanted) else {
        return f64::NAN;
    };
    if all == 0.0 {
        return f64::NAN;
    }
    if k == 0 || counts[k - 1] == 0 {
        return radii[k];
    }
    let (low, high) = ((counts[k - 1] as f64).ln(), (counts[k] as f64).ln());
    let part = (wanted.ln() - low) / (high - low);
    radii[k - 1] * (radii[k] / radii[k - 1]).powf(part)
}
