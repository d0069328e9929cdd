//! The correlation sum of a series, for all embedding dimensions and radii in one pass over the pairs.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::error::DimensionError;
use super::euclidean::SquareCounter;
use super::lag::{Instructions, LagCounter};
use super::radii::Radii;

/// How the distance of two delay vectors is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Norm {
    /// The largest difference of a component.
    #[default]
    Maximum,
    /// The root of the sum of squares.
    Euclidean,
}

impl Norm {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Norm::Maximum => "maximum norm",
            Norm::Euclidean => "Euclidean norm",
        }
    }
}

/// What to count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SumSettings {
    /// Delay of the embedding, samples.
    pub delay: usize,
    /// Largest embedding dimension; all from 1 on are counted.
    pub dimensions: usize,
    /// Pairs at most this many samples apart in time are left out.
    pub theiler: usize,
    /// Only every `thin`-th vector is the first of a pair (with 1: all pairs). The second runs over all.
    pub thin: usize,
    /// The norm.
    pub norm: Norm,
    /// Number of radii.
    pub radii: usize,
    /// Range to cut the radii from, if not that of the series: for sums that are to be compared.
    pub range: Option<f64>,
    /// Threads; 0 takes one for each processor.
    pub threads: usize,
    /// Machine instructions.
    pub instructions: Instructions,
}

impl Default for SumSettings {
    fn default() -> Self {
        SumSettings {
            delay: 1,
            dimensions: 10,
            theiler: 0,
            thin: 1,
            norm: Norm::Maximum,
            radii: 40,
            range: None,
            threads: 0,
            instructions: Instructions::Widest,
        }
    }
}

/// Numbers of pairs of delay vectors within radii.
#[derive(Debug, Clone, PartialEq)]
pub struct CorrelationSum {
    /// The radii, rising, in the unit of the series. The last one holds all pairs.
    pub radii: Vec<f64>,
    /// Per embedding dimension from 1 on, the pairs within each radius.
    pub counts: Vec<Vec<u64>>,
    /// How it was counted.
    pub settings: SumSettings,
}

impl CorrelationSum {
    /// Counts the pairs of a series.
    ///
    /// ```text
    /// C(m, r) = 2 / [(M - W)(M - W - 1)] sum_(i < j, j - i > W) H(r - |z_i - z_j|),   M = N - (m-1) d
    /// z_i = (x_i, x_(i+d), ..., x_(i+(m-1)d))
    /// ```
    ///
    /// x: samples, N of them; m: embedding dimension, 1; d: delay, samples; W: Theiler window, samples; r: radius, unit of x;
    /// H(0) = 1. [`CorrelationSum::counts`] holds the sums as integers, every pair counted, and compared as `f64` are:
    /// the distance of two components is the rounded `|x_i - x_j|`.
    ///
    /// A missing sample is NaN; the vectors it is part of are in no pair. Memory is linear in N, time is quadratic (in N over
    /// `thin`). With `thin` above 1 the sums are a sample of all pairs: neighbouring pairs along a trajectory say the same,
    /// neighbouring lags do not, so a `thin` up to the delay leaves the scatter of the slopes as it is.
    ///
    /// `progress` hears of shares done (0 to 1), and stops the count by returning false.
    ///
    /// # Errors
    /// [`DimensionError`] where a setting does not fit the series, or the count was stopped.
    ///
    /// Source: Grassberger and Procaccia, Physica D 9 (1983) 189; Stelter 1992, eq. (13); time window: Theiler,
    /// Phys. Rev. A 34 (1986) 2427.
    pub fn count(
        series: &[f64],
        settings: &SumSettings,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<CorrelationSum, DimensionError> {
        check(series, settings)?;
        let range = settings.range.unwrap_or(range(series)?);
        let squared = settings.norm == Norm::Euclidean;
        let largest = match settings.norm {
            Norm::Maximum => range,
            // A little more, so that rounding in the sum of squares leaves no pair outside.
            Norm::Euclidean => range * (settings.dimensions as f64).sqrt() * (1.0 + 1e-12),
        };
        let radii = Radii::up_to(largest, settings.radii, squared);
        let lags = settings.theiler + 1..series.len();
        let work = Work::new(series, settings, &radii);
        let flat = work.count(lags, progress)?;
        let counts = (0..settings.dimensions)
            .map(|m| {
                (0..radii.count())
                    .map(|r| flat[r * settings.dimensions + m])
                    .collect()
            })
            .collect();
        Ok(CorrelationSum {
            radii: radii.values(),
            counts,
            settings: *settings,
        })
    }

    /// Pairs at embedding dimension `m` (from 1).
    pub fn pairs(&self, m: usize) -> u64 {
        *self.counts[m - 1].last().expect("there are radii")
    }

    /// C(m, r) at embedding dimension `m` (from 1), for every radius.
    pub fn sums(&self, m: usize) -> Vec<f64> {
        let pairs = self.pairs(m).max(1) as f64;
        self.counts[m - 1]
            .iter()
            .map(|c| *c as f64 / pairs)
            .collect()
    }
}

/// Per lag 1 to `lags`, the pairs within each radius at one embedding dimension, and the radii.
///
/// Source: Provenzale, Smith, Vio and Murante, Physica D 58 (1992) 31 (space-time separation).
pub(super) fn counts_per_lag(
    series: &[f64],
    delay: usize,
    dimension: usize,
    lags: usize,
) -> Result<(Vec<f64>, Vec<Vec<u64>>), DimensionError> {
    let settings = SumSettings {
        delay,
        dimensions: dimension,
        ..SumSettings::default()
    };
    check(series, &settings)?;
    let radii = Radii::up_to(range(series)?, settings.radii, false);
    let work = Work::new(series, &settings, &radii);
    let mut counter = LagCounter::new(&radii, delay, dimension);
    let counts = (1..=lags.min(series.len() - 1))
        .map(|lag| {
            counter.clear();
            let (a, b, anchors) = work.pairs_at(lag);
            counter.add(a, b, anchors, Instructions::Widest);
            counter
                .counts()
                .skip(dimension - 1)
                .step_by(dimension)
                .collect()
        })
        .collect();
    Ok((radii.values(), counts))
}

/// Largest less smallest sample.
pub(super) fn range(series: &[f64]) -> Result<f64, DimensionError> {
    let finite = series.iter().filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| {
        (l.min(*x), h.max(*x))
    });
    if high > low {
        return Ok(high - low);
    }
    Err(DimensionError::Constant {
        samples: series.len(),
        value: low,
    })
}

fn check(series: &[f64], s: &SumSettings) -> Result<(), DimensionError> {
    let refuse = |name, value: usize, rule: &str| {
        Err(DimensionError::Setting {
            name,
            value: value.to_string(),
            rule: rule.into(),
        })
    };
    if s.delay == 0 {
        return refuse(
            "delay",
            0,
            "all components of a delay vector would be the same sample; give 1 or more samples",
        );
    }
    if s.dimensions == 0 || s.dimensions > 64 {
        return refuse(
            "largest embedding dimension",
            s.dimensions,
            "1 to 64 are possible",
        );
    }
    if s.thin == 0 {
        return refuse("thinning", 0, "give 1 for all pairs");
    }
    if s.radii < 2 || s.radii > Radii::MOST {
        return refuse("number of radii", s.radii, "2 to 200 are possible");
    }
    if s.theiler >= series.len() {
        return Err(DimensionError::Setting {
            name: "Theiler window",
            value: format!("{} samples", s.theiler),
            rule: format!(
                "the series has {} samples, so that no pair would be left; make it shorter",
                series.len()
            ),
        });
    }
    if let Some(index) = series.iter().position(|x| x.is_infinite()) {
        return Err(DimensionError::Infinite { index });
    }
    let needed = (s.dimensions - 1) * s.delay + s.theiler + 2;
    if series.len() < needed {
        return Err(DimensionError::TooFewSamples {
            samples: series.len(),
            dimension: s.dimensions,
            delay: s.delay,
            theiler: s.theiler,
            needed,
        });
    }
    Ok(())
}

/// The series as the counters want it: cut into `thin` series that are `thin` samples apart, with NaN behind their ends.
struct Work<'a> {
    settings: &'a SumSettings,
    radii: &'a Radii,
    phases: Vec<Vec<f64>>,
    /// The step between phases: at most `thin`, and a divisor of the delay.
    step: usize,
    samples: usize,
}

impl<'a> Work<'a> {
    fn new(series: &[f64], settings: &'a SumSettings, radii: &'a Radii) -> Work<'a> {
        let step = divisor(settings.delay, settings.thin);
        let padding = LagCounter::padding(settings.delay / step, settings.dimensions);
        let phase = |p: usize| -> Vec<f64> {
            let samples = series[p..].iter().copied().step_by(step);
            samples
                .chain(std::iter::repeat_n(f64::NAN, padding))
                .collect()
        };
        Work {
            settings,
            radii,
            phases: (0..step.min(series.len())).map(phase).collect(),
            step,
            samples: series.len(),
        }
    }

    /// First and second samples of the pairs at a lag, and how many there are.
    fn pairs_at(&self, lag: usize) -> (&[f64], &[f64], usize) {
        let second = &self.phases[lag % self.step][lag / self.step..];
        (
            &self.phases[0],
            second,
            (self.samples - lag).div_ceil(self.step),
        )
    }

    fn count(
        &self,
        lags: std::ops::Range<usize>,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Vec<u64>, DimensionError> {
        const AT_ONCE: usize = 32;
        let s = self.settings;
        let threads = match s.threads {
            0 => std::thread::available_parallelism().map_or(1, |n| n.get()),
            n => n,
        };
        let next = AtomicUsize::new(lags.start);
        let stopped = std::sync::atomic::AtomicBool::new(false);
        let total = Mutex::new(vec![0_u64; self.radii.count() * s.dimensions]);
        let every = s.thin.div_ceil(self.step).max(1);
        let worker = || {
            let mut counter = Counter::new(self.radii, s, self.step);
            loop {
                let from = next.fetch_add(AT_ONCE, Ordering::Relaxed);
                if from >= lags.end || stopped.load(Ordering::Relaxed) {
                    break;
                }
                for lag in from..lags.end.min(from + AT_ONCE) {
                    // A delay without a divisor near the thinning asked for: lags are left out instead.
                    if lag % every == 0 {
                        let (a, b, anchors) = self.pairs_at(lag);
                        counter.add(a, b, anchors, s.instructions);
                    }
                }
                let left = (lags.end - from) as f64 / lags.len().max(1) as f64;
                if !progress((1.0 - left * left).clamp(0.0, 1.0)) {
                    stopped.store(true, Ordering::Relaxed);
                }
            }
            let mut total = total.lock().unwrap_or_else(|e| e.into_inner());
            for (sum, count) in total.iter_mut().zip(counter.counts()) {
                *sum += count;
            }
        };
        if threads == 1 {
            worker();
        } else {
            std::thread::scope(|scope| {
                for _ in 0..threads {
                    scope.spawn(worker);
                }
            });
        }
        if stopped.into_inner() {
            return Err(DimensionError::Stopped {
                what: "counting pairs",
            });
        }
        Ok(total.into_inner().unwrap_or_else(|e| e.into_inner()))
    }
}

/// The largest divisor of `delay` that is at most `most`.
fn divisor(delay: usize, most: usize) -> usize {
    (1..=delay.min(most))
        .rev()
        .find(|d| delay.is_multiple_of(*d))
        .unwrap_or(1)
}

enum Counter {
    Maximum(LagCounter),
    Euclidean(Box<SquareCounter>),
}

impl Counter {
    fn new(radii: &Radii, s: &SumSettings, step: usize) -> Counter {
        let delay = s.delay / step;
        match s.norm {
            Norm::Maximum => Counter::Maximum(LagCounter::new(radii, delay, s.dimensions)),
            Norm::Euclidean => {
                Counter::Euclidean(Box::new(SquareCounter::new(radii, delay, s.dimensions)))
            }
        }
    }

    fn add(&mut self, a: &[f64], b: &[f64], anchors: usize, with: Instructions) {
        match self {
            Counter::Maximum(counter) => counter.add(a, b, anchors, with),
            Counter::Euclidean(counter) => counter.add(a, b, anchors),
        }
    }

    fn counts(&self) -> Vec<u64> {
        match self {
            Counter::Maximum(counter) => counter.counts().collect(),
            Counter::Euclidean(counter) => counter.counts(),
        }
    }
}
