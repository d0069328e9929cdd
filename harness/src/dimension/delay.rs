//! The delay of an embedding, from the series itself.

use realfft::RealFftPlanner;

/// What speaks for a delay.
#[derive(Debug, Clone, PartialEq)]
pub struct DelayChoice {
    /// Delay taken, samples.
    pub delay: usize,
    /// Whether it is the first minimum of the mutual information; else it is where the autocorrelation has fallen to 1/e.
    pub from_information: bool,
    /// Mutual information of `x_i` and `x_(i+k)`, bit, for k = 0, 1, ...
    pub mutual_information: Vec<f64>,
    /// Autocorrelation for k = 0, 1, ...
    pub autocorrelation: Vec<f64>,
}

impl DelayChoice {
    /// First lag at which the autocorrelation is not above `level`; `None` where it stays above.
    pub fn falls_to(&self, level: f64) -> Option<usize> {
        self.autocorrelation.iter().position(|r| *r <= level)
    }
}

/// The first minimum of the mutual information.
///
/// ```text
/// I(k) = sum_ab p_ab(k) log2 [p_ab(k) / (p_a p_b)]
/// ```
///
/// p_a: share of samples in bin a (bins of equal occupation, so 1/bins); p_ab: share of pairs with `x_i` in a and `x_(i+k)` in b;
/// k: lag, samples. A minimum counts if it is the lowest within a few lags on either side and the information has come down from
/// its start. Where the autocorrelation is below 1/e after one sample, the series is one of a map and the delay 1.
///
/// Holds for series of some hundred samples and more. Missing samples are NaN and are passed over.
///
/// Source: Fraser and Swinney, Phys. Rev. A 33 (1986) 1134.
pub fn choose_delay(series: &[f64], most: usize) -> DelayChoice {
    let most = most.min(series.len() / 4).max(2);
    let autocorrelation = autocorrelation(series, most);
    let mutual_information = mutual_information(series, most);
    let by_correlation = autocorrelation
        .iter()
        .position(|r| *r <= std::f64::consts::E.recip())
        .unwrap_or(most)
        .max(1);
    let minimum = (by_correlation > 1)
        .then(|| first_minimum(&mutual_information))
        .flatten();
    DelayChoice {
        delay: minimum.unwrap_or(by_correlation),
        from_information: minimum.is_some(),
        mutual_information,
        autocorrelation,
    }
}

/// The first lag that is lowest among its neighbours, wider ones at longer lags.
fn first_minimum(information: &[f64]) -> Option<usize> {
    (1..information.len()).find(|k| {
        let reach = 1 + k / 4;
        let (from, to) = (k.saturating_sub(reach), k + reach);
        to < information.len()
            && information[from..=to].iter().all(|i| *i >= information[*k])
            && information[*k] < 0.9 * information[1]
    })
}

/// Autocorrelation for lags 0 to `most`, each over the pairs there are.
///
/// ```text
/// R(k) = sum_i (x_i - x0)(x_(i+k) - x0) / sum_i (x_i - x0)^2, with sums as means over existing pairs
/// ```
///
/// x0: mean. By fast Fourier transform of the zero-padded series. Source: Box and Jenkins, Time Series Analysis, chapter 2, without
/// the weight (1 - k/N) there.
pub fn autocorrelation(series: &[f64], most: usize) -> Vec<f64> {
    let here: Vec<f64> = series
        .iter()
        .map(|x| f64::from(u8::from(x.is_finite())))
        .collect();
    let count = here.iter().sum::<f64>().max(1.0);
    let mean = series.iter().filter(|x| x.is_finite()).sum::<f64>() / count;
    let centred: Vec<f64> = series
        .iter()
        .map(|x| if x.is_finite() { x - mean } else { 0.0 })
        .collect();
    let sums = lagged_products(&centred, most);
    let pairs = lagged_products(&here, most);
    let means: Vec<f64> = sums
        .iter()
        .zip(&pairs)
        .map(|(s, p)| if *p > 0.5 { s / p } else { 0.0 })
        .collect();
    means.iter().map(|m| m / means[0]).collect()
}

/// Sums of `x_i x_(i+k)` for k = 0 to `most`.
fn lagged_products(x: &[f64], most: usize) -> Vec<f64> {
    let size = (x.len() + most + 1).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, back) = (
        planner.plan_fft_forward(size),
        planner.plan_fft_inverse(size),
    );
    let mut padded = x.to_vec();
    padded.resize(size, 0.0);
    let mut spectrum = forward.make_output_vec();
    let done = "the buffers have the planned sizes";
    forward.process(&mut padded, &mut spectrum).expect(done);
    for s in &mut spectrum {
        *s = (s.norm_sqr() / size as f64).into();
    }
    back.process(&mut spectrum, &mut padded).expect(done);
    padded.truncate(most + 1);
    padded
}

/// Mutual information for lags 0 to `most`, bit.
fn mutual_information(series: &[f64], most: usize) -> Vec<f64> {
    // Enough pairs per cell, and fine enough to see the structure.
    let bins = ((series.len() as f64 / 20.0).sqrt() as usize).clamp(4, 32);
    let binned = equal_bins(series, bins);
    (0..=most)
        .map(|lag| {
            let mut joint = vec![0_u32; bins * bins];
            let pairs = binned.iter().zip(&binned[lag..]);
            for (a, b) in pairs {
                if let (Some(a), Some(b)) = (a, b) {
                    joint[a * bins + b] += 1;
                }
            }
            information(&joint, bins)
        })
        .collect()
}

fn information(joint: &[u32], bins: usize) -> f64 {
    let total = joint.iter().sum::<u32>().max(1) as f64;
    let (mut rows, mut columns) = (vec![0.0; bins], vec![0.0; bins]);
    for (cell, n) in joint.iter().enumerate() {
        rows[cell / bins] += f64::from(*n) / total;
        columns[cell % bins] += f64::from(*n) / total;
    }
    let part = |(cell, n): (usize, &u32)| {
        let p = f64::from(*n) / total;
        let independent = rows[cell / bins] * columns[cell % bins];
        if p > 0.0 {
            p * (p / independent).log2()
        } else {
            0.0
        }
    };
    joint.iter().enumerate().map(part).sum()
}

/// Bins of equal occupation, by rank; equal samples share one.
fn equal_bins(series: &[f64], bins: usize) -> Vec<Option<usize>> {
    let mut order: Vec<usize> = (0..series.len())
        .filter(|i| series[*i].is_finite())
        .collect();
    order.sort_by(|a, b| series[*a].total_cmp(&series[*b]));
    let mut out = vec![None; series.len()];
    let mut before: Option<(f64, usize)> = None;
    for (rank, i) in order.iter().enumerate() {
        let bin = match before {
            Some((value, bin)) if value == series[*i] => bin,
            _ => rank * bins / order.len(),
        };
        out[*i] = Some(bin);
        before = Some((series[*i], bin));
    }
    out
}
