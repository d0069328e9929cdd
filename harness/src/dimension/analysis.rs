//! From a series to a verdict.

use super::convergence::{Convergence, FEWEST_RETURNS, returns};
use super::correlation_sum::{CorrelationSum, Norm, SumSettings, range};
use super::delay::{DelayChoice, choose_delay};
use super::error::DimensionError;
use super::lyapunov::{Divergence, largest_exponent};
use super::periodicity::{Periodicity, find_period};
use super::quantisation::{Quantisation, dither, find_steps};
use super::resampling::{SurrogateTest, jackknife, surrogate_test};
use super::scaling::{Region, RegionSettings, find_region};
use super::slopes::{fitted_slope, local_slopes, takens};
use super::surrogate::longest_unbroken;
use super::theiler::{Separation, choose_theiler};
use super::verdict::Verdict;
use crate::watch::Watch;

/// What is asked for; `None` is chosen from the series.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Delay, samples.
    pub delay: Option<usize>,
    /// Theiler window, samples.
    pub theiler: Option<usize>,
    /// Largest embedding dimension.
    pub max_dimension: usize,
    /// Norm.
    pub norm: Norm,
    /// Thinning of the first points of pairs: 1 counts all pairs.
    pub thin: Option<usize>,
    /// Smallest and largest radius of the scaling region, unit of the series.
    pub region: Option<(f64, f64)>,
    /// Number of surrogates.
    pub surrogates: usize,
    /// Seed of surrogates and dither.
    pub seed: u64,
    /// Add half a step of noise to a rounded series.
    pub dither: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            delay: None,
            theiler: None,
            max_dimension: 10,
            norm: Norm::Maximum,
            thin: None,
            region: None,
            surrogates: 39,
            seed: 1,
            dither: false,
        }
    }
}

/// Everything said of a series.
#[derive(Debug, Clone, PartialEq)]
pub struct Analysis {
    /// Samples, missing ones included.
    pub samples: usize,
    /// Missing samples.
    pub missing: usize,
    /// The verdict.
    pub verdict: Verdict,
    /// The delay's grounds.
    pub delay_choice: DelayChoice,
    /// Delay used, samples.
    pub delay: usize,
    /// The Theiler window's grounds.
    pub separation: Separation,
    /// Theiler window used, samples.
    pub theiler: usize,
    /// The correlation sums.
    pub sum: CorrelationSum,
    /// Local slopes, per embedding dimension from 1 on; NaN where too few pairs.
    pub slopes: Vec<Vec<f64>>,
    /// The scaling region, if there is one.
    pub region: Option<Region>,
    /// Standard deviation of the dimension: jackknife, and choice of the window.
    pub std: Option<f64>,
    /// Change of the slope over the embedding dimensions of the region.
    pub convergence: Option<Convergence>,
    /// How often the series comes back.
    pub returns: usize,
    /// Slope in the region for each embedding dimension.
    pub over_dimensions: Vec<f64>,
    /// Takens' estimate up to the largest radius of the region, at the last agreeing dimension.
    pub takens: Option<f64>,
    /// Slopes in the region of the first and second half of the record.
    pub halves: Option<(f64, f64)>,
    /// The period that the series keeps best.
    pub period: Option<Periodicity>,
    /// Comparison with surrogates.
    pub surrogates: SurrogateTest,
    /// How neighbours part.
    pub divergence: Option<Divergence>,
    /// Rounding of the series.
    pub quantisation: Option<Quantisation>,
    /// Radius below which noise fills all dimensions, if it is seen.
    pub noise_radius: Option<f64>,
    /// What the reader must know.
    pub remarks: Vec<String>,
}

/// Series up to this length are counted exactly if not asked otherwise.
const EXACT: usize = 60_000;
/// Fewest samples in a row.
const FEWEST: usize = 500;
/// Embedding dimension of space-time separation, exponent and surrogates.
const USUAL_DIMENSION: usize = 6;
/// Slope up to which a repeating series is a closed curve.
const CLOSED_CURVE: f64 = 1.3;

impl Analysis {
    /// Correlation dimension, where the verdict claims one.
    pub fn dimension(&self) -> Option<f64> {
        let claimed = self.verdict == Verdict::Dimension;
        self.region.as_ref().filter(|_| claimed).map(|r| r.slope)
    }

    /// `2 log10 N`: no dimension above it can be measured with N points.
    ///
    /// Within a decade of radii a set of dimension D needs `N^2/2` pairs times `10^-D` to be at least of order one. Necessary,
    /// by far not sufficient. Source: Eckmann and Ruelle, Physica D 56 (1992) 185.
    pub fn eckmann_ruelle_bound(&self) -> f64 {
        2.0 * ((self.samples - self.missing) as f64).log10()
    }
}

/// Analyses a series sampled at even times; a missing sample is NaN.
///
/// Delay, Theiler window, correlation sums, scaling region, error, surrogates, exponent, verdict: each step says in its own
/// docstring what it does and where it comes from.
///
/// # Errors
/// [`DimensionError`] where series or settings cannot be used, or `watch` stopped the work.
pub fn analyse(
    series: &[f64],
    settings: &Settings,
    watch: &dyn Watch,
) -> Result<Analysis, DimensionError> {
    let spread = usable(series, settings)?;
    let mut remarks = Vec::new();
    let quantisation = find_steps(series);
    let dithered = quantisation
        .filter(|_| settings.dither)
        .map(|q| dither(series, q.step, settings.seed));
    let series = dithered.as_deref().unwrap_or(series);
    let n = series.len();

    let delay_choice = choose_delay(series, 1000.min(n / 10));
    let delay = settings.delay.unwrap_or(delay_choice.delay);
    // Where the series crosses its mean for the first time; a slow drift must not make the window a tenth of the record.
    let decorrelated = delay_choice.falls_to(0.0).unwrap_or(0).min(n / 50);
    let usual = USUAL_DIMENSION.min(settings.max_dimension);
    let lags = (40 * delay).clamp(100, 2000).min(n / 4);
    let separation = choose_theiler(series, delay.max(1), usual.min(4), decorrelated, lags)?;
    let theiler = settings.theiler.unwrap_or(separation.window);

    let thin = settings.thin.unwrap_or(if n > EXACT { delay } else { 1 });
    let base = SumSettings {
        delay,
        dimensions: settings.max_dimension,
        theiler,
        thin,
        norm: settings.norm,
        radii: 48,
        range: Some(spread),
        ..SumSettings::default()
    };
    let sum = CorrelationSum::count(series, &base, &|share| {
        watch.step("pairs", (1000.0 * share) as usize, 1000);
        !watch.stop()
    })?;
    let rule = RegionSettings {
        between: settings.region,
        ..RegionSettings::of(&sum)
    };
    let slopes: Vec<Vec<f64>> = (1..=settings.max_dimension)
        .map(|m| local_slopes(&sum, m, rule.fewest_pairs))
        .collect();
    let region = find_region(&sum, &rule);
    let thinned = SumSettings {
        thin: thin.max(delay),
        ..base
    };
    let mut std = None;
    let mut convergence = None;
    let mut halves = None;
    let mut over_dimensions = Vec::new();
    if let Some(region) = &region {
        let error = jackknife(series, &thinned, region, watch)?;
        let stated = error.slope.hypot(region.window_std);
        std = Some(stated);
        convergence = Some(Convergence {
            change: region.change_of(&sum),
            std: error.change,
            stated,
        });
        let half = |part: std::ops::Range<usize>| {
            CorrelationSum::count(&series[part], &thinned, &|_| !watch.stop())
                .map(|sum| region.slope_of(&sum))
        };
        halves = half(0..n / 2).ok().zip(half(n / 2..n).ok());
        over_dimensions = (1..=settings.max_dimension)
            .map(|m| fitted_slope(&sum, m, region.radii.0, region.radii.1).0)
            .collect();
    }
    let surrogates = surrogate_test(
        series,
        &thinned,
        usual,
        settings.surrogates,
        settings.seed,
        watch,
    )?;
    let period = find_period(series);
    let dimension = region.as_ref().map_or(usual, |r| r.dimensions.0);
    let ahead = (10 * delay).clamp(30, 1000).min(n / 10);
    let divergence = largest_exponent(series, delay, dimension, theiler, ahead);
    let takens_limit = region
        .as_ref()
        .map(|r| takens(&sum, r.dimensions.1, rule.fewest_pairs.min(100))[r.radii.1]);
    let noise_radius = region
        .as_ref()
        .and_then(|r| noise_radius(&sum.radii, &slopes, r));
    let returns = returns(series);
    let converged = convergence.is_none_or(|c| c.is_plateau()) && returns >= FEWEST_RETURNS;
    let verdict = judge(region.as_ref(), period.as_ref(), &surrogates, converged);
    if surrogates.surrogates.len() < settings.surrogates {
        remarks.push(format!(
            "{} of {} surrogates were compared.",
            surrogates.surrogates.len(),
            settings.surrogates
        ));
    }
    let mut analysis = Analysis {
        samples: n,
        missing: series.iter().filter(|x| x.is_nan()).count(),
        verdict,
        delay_choice,
        delay,
        separation,
        theiler,
        sum,
        slopes,
        region,
        std,
        convergence,
        returns,
        over_dimensions,
        takens: takens_limit,
        halves,
        period,
        surrogates,
        divergence,
        quantisation,
        noise_radius,
        remarks,
    };
    let more = super::verdict::remarks(&analysis, settings);
    analysis.remarks.extend(more);
    Ok(analysis)
}

/// The range of a series that can be used.
fn usable(series: &[f64], settings: &Settings) -> Result<f64, DimensionError> {
    if let Some(index) = series.iter().position(|x| x.is_infinite()) {
        return Err(DimensionError::Infinite { index });
    }
    let spread = range(series)?;
    let needed =
        FEWEST.max(2 * (settings.max_dimension.saturating_sub(1)) * settings.delay.unwrap_or(1));
    let longest = longest_unbroken(series).len();
    let missing = series.iter().filter(|x| x.is_nan()).count();
    if series.len() < needed {
        return Err(DimensionError::TooFewSamples {
            samples: series.len(),
            dimension: settings.max_dimension,
            delay: settings.delay.unwrap_or(1),
            theiler: settings.theiler.unwrap_or(1),
            needed,
        });
    }
    if longest < needed {
        return Err(DimensionError::TooManyGaps {
            samples: series.len(),
            missing,
            longest,
            needed,
        });
    }
    let refuse = |name, value: String, rule: &str| {
        Err(DimensionError::Setting {
            name,
            value,
            rule: rule.into(),
        })
    };
    if settings.delay == Some(0) {
        return refuse(
            "delay",
            "0".into(),
            "all components of a delay vector would be the same sample; give 1 or more samples",
        );
    }
    if !(4..=30).contains(&settings.max_dimension) {
        return refuse(
            "largest embedding dimension",
            settings.max_dimension.to_string(),
            "4 to 30 are possible: below 4 nothing can be said of saturation",
        );
    }
    if !(19..=999).contains(&settings.surrogates) {
        return refuse(
            "number of surrogates",
            settings.surrogates.to_string(),
            "19 to 999 are possible: with less nothing can be said at 95 %",
        );
    }
    if let Some((low, high)) = settings.region
        && !(low > 0.0 && high >= 4.0 * low)
    {
        return refuse(
            "scaling region",
            format!("{low} to {high}"),
            "give two positive radii that are two octaves or more apart",
        );
    }
    Ok(spread)
}

/// Order matters: what repeats is periodic, whatever its slopes; what noise shows too is no dimension.
fn judge(
    region: Option<&Region>,
    period: Option<&Periodicity>,
    surrogates: &SurrogateTest,
    converged: bool,
) -> Verdict {
    let closed = region.is_none_or(|r| r.slope < CLOSED_CURVE);
    if period.is_some_and(|p| p.is_exact() || p.repeats() && closed) {
        return Verdict::Periodic;
    }
    match region {
        _ if !surrogates.is_distinct() => Verdict::NotDistinguishableFromNoise,
        Some(_) if !converged => Verdict::NotConverged,
        Some(_) => Verdict::Dimension,
        None => Verdict::NoScalingRegion,
    }
}

/// The largest radius below the region at which the slopes rise with the embedding dimension.
fn noise_radius(radii: &[f64], slopes: &[Vec<f64>], region: &Region) -> Option<f64> {
    let (low, high) = (
        &slopes[region.dimensions.0 - 1],
        &slopes[region.dimensions.1 - 1],
    );
    (0..region.radii.0)
        .rev()
        .find(|k| low[*k] > 1.15 * region.slope && high[*k] > 1.3 * region.slope)
        .map(|k| radii[k])
}
