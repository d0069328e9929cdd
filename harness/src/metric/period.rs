//! Period of a noisy, perhaps irregular oscillation.

use realfft::RealFftPlanner;

/// A period with its strength.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Period {
    /// Time from cycle to cycle, s.
    pub seconds: f64,
    /// Autocorrelation at that lag, 1: near 1 for a periodic motion, lower for an irregular or noisy one.
    pub regularity: f64,
}

/// A peak counts as the cycle if it is nearly as high as the highest. In a period-n motion the lags of single cycles are
/// lower than the lag of n; this share decides when they still count as the same cycle.
const SHARE_OF_HIGHEST: f64 = 0.75;
/// Below this autocorrelation there is no oscillation to speak of.
const WEAKEST: f64 = 0.2;
/// Lags up to this share of the record are used: longer ones compare too few cycles.
const LONGEST: f64 = 0.5;

/// The cycle period of an evenly sampled signal (`interval` in s), `None` if it does not oscillate.
///
/// The autocorrelation, corrected for the shrinking overlap,
///
/// ```text
/// r(l) = [sum_i y_i y_(i+l) / (n - l)] / [sum_i y_i^2 / n],   y with mean removed
/// ```
///
/// has peaks at the period and its multiples. The first peak as high as 0.75 times the highest is the period, refined
/// by a parabola and then by the last multiple in reach, which divides the error. Ripple of higher modes does not
/// disturb it as it would disturb zero crossings. Source: Rabiner, IEEE Trans. ASSP 25 (1977) 24.
pub fn period(values: &[f64], interval: f64) -> Option<Period> {
    let r = autocorrelation(values)?;
    let reach = (LONGEST * values.len() as f64) as usize;
    let past_zero = r.iter().position(|v| *v <= 0.0)?;
    let peaks: Vec<usize> = (past_zero.max(1)..reach.min(r.len() - 1))
        .filter(|&l| r[l] > r[l - 1] && r[l] >= r[l + 1])
        .collect();
    let highest = peaks
        .iter()
        .map(|&l| r[l])
        .fold(f64::NEG_INFINITY, f64::max);
    if highest < WEAKEST {
        return None;
    }
    let first = *peaks
        .iter()
        .find(|&&l| r[l] >= SHARE_OF_HIGHEST * highest)?;
    let mut lag = vertex(&r, first);
    let regularity = r[first].min(1.0);
    // Each multiple must be found near where the one before predicts it, else the motion is too irregular to follow.
    for multiple in 2.. {
        let expected = multiple as f64 * lag;
        if expected + 0.1 * lag >= reach as f64 {
            break;
        }
        // By bisection: a long record has many peaks and many multiples.
        let first = peaks.partition_point(|l| *l as f64 <= expected - 0.1 * lag);
        let past = peaks.partition_point(|l| (*l as f64) < expected + 0.1 * lag);
        let Some(&best) = peaks[first..past.max(first)]
            .iter()
            .max_by(|a, b| r[**a].total_cmp(&r[**b]))
        else {
            break;
        };
        if r[best] < SHARE_OF_HIGHEST * highest {
            break;
        }
        lag = vertex(&r, best) / multiple as f64;
    }
    Some(Period {
        seconds: lag * interval,
        regularity,
    })
}

/// Position of the top of the parabola through a peak and its neighbours.
fn vertex(r: &[f64], peak: usize) -> f64 {
    let (a, b, c) = (r[peak - 1], r[peak], r[peak + 1]);
    let curvature = a - 2.0 * b + c;
    let shift = if curvature < 0.0 {
        0.5 * (a - c) / curvature
    } else {
        0.0
    };
    peak as f64 + shift.clamp(-0.5, 0.5)
}

fn autocorrelation(values: &[f64]) -> Option<Vec<f64>> {
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n as f64;
    // Zeros behind the signal keep its end from wrapping onto its start.
    let padded = (2 * n).next_power_of_two();
    let mut input = vec![0.0; padded];
    input
        .iter_mut()
        .zip(values)
        .for_each(|(x, v)| *x = v - mean);
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (
        planner.plan_fft_forward(padded),
        planner.plan_fft_inverse(padded),
    );
    let mut bins = forward.make_output_vec();
    forward
        .process(&mut input, &mut bins)
        .expect("buffers come from the plan itself");
    bins.iter_mut()
        .for_each(|c| *c = realfft::num_complex::Complex::new(c.norm_sqr(), 0.0));
    inverse
        .process(&mut bins, &mut input)
        .expect("buffers come from the plan itself");
    let power = input[0] / n as f64;
    (power > 0.0).then(|| (0..n).map(|l| input[l] / (n - l) as f64 / power).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_the_period_of_a_rippled_sawtooth_is_exact() {
        let value = |t: f64| (t / 0.0301).fract() + 0.1 * (std::f64::consts::TAU * 510.0 * t).sin();
        let values: Vec<f64> = (0..6000).map(|i| value(f64::from(i) * 1e-4)).collect();
        let found = period(&values, 1e-4).unwrap();
        assert!((found.seconds / 0.0301 - 1.0).abs() < 1e-3, "{found:?}");
        assert!(found.regularity > 0.9);
    }

    #[test]
    fn val_noise_and_constants_have_no_period() {
        let mut seed = 1_u32;
        let noise: Vec<f64> = (0..4000)
            .map(|_| {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(seed) / f64::from(u32::MAX)
            })
            .collect();
        assert_eq!(period(&noise, 1e-4), None);
        assert_eq!(period(&[1.0; 100], 1e-4), None);
    }
}
