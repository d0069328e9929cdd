//! Is the series periodic?

use super::delay::autocorrelation;

/// A period and how well the series keeps it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Periodicity {
    /// Period, samples.
    pub period: f64,
    /// `<(x_(i+k) - x_i)^2> / (2 variance)` where k is one period (0: repeats exactly; 1: unrelated).
    pub after_one: f64,
    /// The same where k is as many periods as fit into half of the series.
    pub after_many: f64,
}

/// Misfit after many periods above which nothing repeats.
const REPEATS: f64 = 0.1;
/// Misfit below which the series is periodic whatever else it looks like.
const EXACT: f64 = 1e-4;
/// Growth of the misfit from one period to many that noise does not explain.
const GROWTH: f64 = 1.5;

impl Periodicity {
    /// Repeats, apart from noise: what is left after one period does not grow with the number of periods.
    pub fn repeats(&self) -> bool {
        // A parabola through three samples misses the bottom of a cosine by about this much.
        let between_samples = (std::f64::consts::PI / self.period).powi(4) / 12.0;
        self.after_many < REPEATS
            && self.after_many < GROWTH * self.after_one + EXACT + between_samples
    }

    /// Repeats so exactly that no chaos is left to find.
    pub fn is_exact(&self) -> bool {
        self.after_many < EXACT
    }
}

/// Looks for the period that the series keeps best.
///
/// ```text
/// d(k) = <(x_(i+k) - x_i)^2> / (2 s^2),   d(T) = d(2 T) = ... = (noise variance) / s^2 for period T
/// ```
///
/// s: standard deviation. The candidates are the minima of d between 2 samples and a quarter of the series; the shortest whose d is near the
/// lowest is followed to twice, four times, ... its length, which makes it sharper. Between samples d is a parabola. A
/// chaotic series comes back near its start too, but d then grows with the number of periods; on a torus as well. `None` without any
/// minimum.
pub fn find_period(series: &[f64]) -> Option<Periodicity> {
    let n = series.len();
    let most = n / 2;
    let d: Vec<f64> = autocorrelation(series, most)
        .iter()
        .map(|r| 1.0 - r)
        .collect();
    let minima: Vec<usize> = (2..n / 4)
        .filter(|k| d[*k] <= d[k - 1] && d[*k] < d[k + 1])
        .collect();
    let bottom = |k: usize| exact_bottom(series, k);
    let lowest = minima.iter().map(|k| d[*k]).fold(f64::INFINITY, f64::min);
    let first = *minima.iter().find(|k| d[**k] <= lowest + 0.02)?;
    let (mut period, after_one) = bottom(first);
    let (mut times, mut after_many) = (1.0, after_one);
    while 2.0 * times * period + 2.0 < most as f64 {
        times *= 2.0;
        let near = (times * period).round() as usize;
        // The true minimum may be a sample away while the period is still rough.
        let reach = (0.25 * period).min(2.0) as usize;
        let at =
            (near - reach..=(near + reach).min(most - 2)).min_by(|a, b| d[*a].total_cmp(&d[*b]))?;
        let (place, value) = bottom(at);
        if (place / times - period).abs() > 0.25 * period {
            break;
        }
        period = place / times;
        after_many = value;
    }
    Some(Periodicity {
        period,
        after_one,
        after_many,
    })
}

/// d at one lag, without the rounding of a Fourier transform.
fn difference(series: &[f64], lag: usize) -> f64 {
    let pairs = series.iter().zip(&series[lag..]);
    let (mut sum, mut count, mut mean, mut square) = (0.0, 0.0, 0.0, 0.0);
    for (a, b) in pairs.filter(|(a, b)| a.is_finite() && b.is_finite()) {
        sum += (b - a) * (b - a);
        mean += a + b;
        square += a * a + b * b;
        count += 1.0;
    }
    let mean = mean / (2.0 * count);
    let variance = square / (2.0 * count) - mean * mean;
    sum / count / (2.0 * variance)
}

/// Place and value of the bottom of the parabola through d at a minimum and its neighbours.
fn exact_bottom(series: &[f64], k: usize) -> (f64, f64) {
    let [a, b, c] = [k - 1, k, k + 1].map(|k| difference(series, k));
    let bend = a - 2.0 * b + c;
    if bend <= 0.0 || b > a || b > c {
        return (k as f64, b);
    }
    let shift = 0.5 * (a - c) / bend;
    (
        k as f64 + shift,
        (b - 0.125 * (a - c).powi(2) / bend).max(0.0),
    )
}
