//! Band-limited interpolation: the signal of least bandwidth through even samples.

/// Samples to either side that take part.
pub(super) const HALF_WIDTH: usize = 24;
/// Shape of the Kaiser window: side lobes 90 dB down, and what lies below 0.92 of half the sample rate is passed.
const BETA: f64 = 9.0;

/// Even samples of the signal, `factor` times as many; those given are kept.
///
/// ```text
/// x(t) = sum_k x_k sinc(t/h - k) K((t/h - k)/24),   K Kaiser's window with beta = 9
/// ```
///
/// `x_k` samples at `k h`, h their interval in s. Holds for signals that were filtered below half the sample rate before
/// they were sampled, to 1e-3 of their size up to 0.9 of that frequency. Beyond both ends the record is continued by its
/// point reflection, so that within 24 samples of an end only what varies slowly is as good.
///
/// Source: Whittaker 1915 and Shannon 1949; window of Kaiser, in Oppenheim and Schafer, Discrete-Time Signal Processing,
/// section 7.6.
pub(super) fn refine(values: &[f64], factor: usize) -> Vec<f64> {
    let count = values.len();
    let last = count as isize - 1;
    let at = |i: isize| {
        // Past an end by more than the record is long, its end is all there is.
        let inside = |i: isize| values[i.clamp(0, last) as usize];
        if i < 0 {
            2.0 * values[0] - inside(-i)
        } else if i > last {
            2.0 * values[count - 1] - inside(2 * last - i)
        } else {
            values[i as usize]
        }
    };
    let kernels: Vec<Vec<f64>> = (1..factor)
        .map(|j| kernel(j as f64 / factor as f64))
        .collect();
    let mut fine = Vec::with_capacity((count - 1) * factor + 1);
    for i in 0..count {
        fine.push(values[i]);
        if i + 1 == count {
            break;
        }
        let first = i as isize - HALF_WIDTH as isize + 1;
        for kernel in &kernels {
            let terms = kernel.iter().enumerate();
            fine.push(
                terms
                    .map(|(k, weight)| weight * at(first + k as isize))
                    .sum(),
            );
        }
    }
    fine
}

/// Weights of the 48 samples around a place that lies by `share` of the interval behind the 24th; their sum is 1, so that a
/// constant stays one.
pub(super) fn kernel(share: f64) -> Vec<f64> {
    let weight = |k: usize| {
        let x = k as f64 + 1.0 - HALF_WIDTH as f64 - share;
        let angle = std::f64::consts::PI * x;
        let place = (x / HALF_WIDTH as f64).powi(2);
        angle.sin() / angle * bessel(BETA * (1.0 - place).max(0.0).sqrt()) / bessel(BETA)
    };
    let weights: Vec<f64> = (0..2 * HALF_WIDTH).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|w| w / sum).collect()
}

/// Modified Bessel function I_0 by its power series, `sum ((x/2)^k / k!)^2`; exact to rounding for the x used here.
fn bessel(x: f64) -> f64 {
    let (mut sum, mut term) = (1.0, 1.0);
    for k in 1..50 {
        term *= (0.5 * x / f64::from(k)).powi(2);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sum of sines, none of them a divisor of the sampling; t in samples.
    fn signal(t: f64) -> f64 {
        // Shares of half the sample rate.
        [(0.033, 0.4), (0.31, 1.0), (0.62, 0.7), (0.87, 0.5)]
            .iter()
            .enumerate()
            .map(|(i, (share, size))| {
                size * (std::f64::consts::PI * share * t + 1.3 * i as f64).sin()
            })
            .sum()
    }

    #[test]
    fn val_a_band_limited_signal_is_met_between_its_samples() {
        // Source: the signal itself at the places between.
        let samples: Vec<f64> = (0..400).map(|i| signal(f64::from(i))).collect();
        let fine = refine(&samples, 8);
        assert_eq!(fine.len(), 399 * 8 + 1);
        for (i, value) in fine.iter().enumerate().skip(8 * 30).take(8 * 340) {
            let truth = signal(i as f64 / 8.0);
            assert!((value - truth).abs() < 1e-3, "{i}: {value} {truth}");
        }
    }

    #[test]
    fn samples_are_kept_and_a_straight_line_stays_one_up_to_its_ends() {
        let samples: Vec<f64> = (0..40).map(|i| 3.0 - 0.5 * f64::from(i)).collect();
        let fine = refine(&samples, 4);
        for (i, value) in fine.iter().enumerate() {
            let truth = 3.0 - 0.125 * i as f64;
            // A window of finite width keeps constants, and slopes to 1e-4 of a step.
            assert!((value - truth).abs() < 1e-4, "{i}: {value} {truth}");
        }
        assert_eq!(fine[4 * 7], samples[7]);
        let constant = refine(&[2.0, 2.0], 8);
        assert!(constant.len() == 9 && constant.iter().all(|v| (v - 2.0).abs() < 1e-14));
    }
}
