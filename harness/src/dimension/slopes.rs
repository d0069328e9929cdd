//! Local slopes of the correlation sum, and Takens' estimate, both from the counts alone.

use super::correlation_sum::CorrelationSum;

/// Slope of ln C over ln r around each radius, embedding dimension `m` (from 1).
///
/// ```text
/// D(m, r_k) = [ln C(m, r_(k+2)) - ln C(m, r_(k-2))] / [ln r_(k+2) - ln r_(k-2)]
/// ```
///
/// over one octave; NaN where a count is below `least`. Source: Stelter 1992, eq. (14), as a difference.
pub fn local_slopes(sum: &CorrelationSum, m: usize, least: u64) -> Vec<f64> {
    let counts = &sum.counts[m - 1];
    let last = counts.len() - 1;
    (0..counts.len())
        .map(|k| {
            if k < 2 || k + 2 > last || counts[k - 2] < least.max(1) {
                return f64::NAN;
            }
            (counts[k + 2] as f64 / counts[k - 2] as f64).ln()
                / (sum.radii[k + 2] / sum.radii[k - 2]).ln()
        })
        .collect()
}

/// Least-squares slope of ln C over ln r for radii `from..=to`, and its root mean square misfit.
pub(super) fn fitted_slope(sum: &CorrelationSum, m: usize, from: usize, to: usize) -> (f64, f64) {
    let counts = &sum.counts[m - 1][from..=to];
    let x: Vec<f64> = sum.radii[from..=to].iter().map(|r| r.ln()).collect();
    let y: Vec<f64> = counts.iter().map(|c| (*c as f64).ln()).collect();
    let n = x.len() as f64;
    let (x0, y0) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let xx: f64 = x.iter().map(|x| (x - x0).powi(2)).sum();
    let xy: f64 = x.iter().zip(&y).map(|(x, y)| (x - x0) * (y - y0)).sum();
    let slope = xy / xx;
    let misfit: f64 = x
        .iter()
        .zip(&y)
        .map(|(x, y)| (y - y0 - slope * (x - x0)).powi(2))
        .sum();
    (slope, (misfit / n).sqrt())
}

/// Takens' maximum-likelihood estimate at each radius as the upper limit, embedding dimension `m` (from 1).
///
/// ```text
/// D_T(r0) = -1 / <ln(d / r0)>_(d < r0) = C(r0) / integral_0^r0 C(r)/r dr
/// ```
///
/// d: distances below r0, unit of the series. Between radii C is taken as a power law, below the smallest one as the power law of the
/// first step. NaN where a count is below `least`. Holds if C is a power law up to r0; where it is not, the value is a
/// weighted mean of the slopes below r0. Source: Takens, Lecture Notes in Mathematics 1125 (1985) 99; the integral form:
/// Theiler, Phys. Lett. A 133 (1988) 195.
pub fn takens(sum: &CorrelationSum, m: usize, least: u64) -> Vec<f64> {
    let counts = &sum.counts[m - 1];
    let mut integral = f64::NAN;
    let mut out = vec![f64::NAN; counts.len()];
    for k in 1..counts.len() {
        let (low, high) = (counts[k - 1], counts[k]);
        if low < least.max(1) {
            continue;
        }
        let octaves = (sum.radii[k] / sum.radii[k - 1]).ln();
        let growth = (high as f64 / low as f64).ln();
        // The integral of a power law between two radii, and its limit for a flat part.
        let step = if growth > 1e-12 {
            (high - low) as f64 * octaves / growth
        } else {
            low as f64 * octaves
        };
        if integral.is_nan() {
            let slope = (growth / octaves).max(0.1);
            integral = low as f64 / slope;
        }
        integral += step;
        out[k] = high as f64 / integral;
    }
    out
}
