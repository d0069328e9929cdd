//! Amplitude spectrum and harmonics.

use std::f64::consts::TAU;

use realfft::RealFftPlanner;

/// One-sided amplitude spectrum.
#[derive(Debug, Clone)]
pub struct Spectrum {
    /// Frequencies, Hz; even spacing from 0.
    pub frequency: Vec<f64>,
    /// Amplitude of the sine at each frequency, in the unit of the signal.
    pub amplitude: Vec<f64>,
}

fn hann(i: usize, n: usize) -> f64 {
    0.5 - 0.5 * (TAU * (i as f64 + 0.5) / n as f64).cos()
}

/// Amplitude spectrum of an evenly sampled signal, mean removed, Hann window.
///
/// ```text
/// A_k = 2 |sum_i w_i (y_i - mean y) exp(-2 pi j i k / n)| / sum_i w_i,   f_k = k / (n dt)
/// ```
///
/// A sine of amplitude a shows a peak of height a to 15 % (scalloping of the Hann window), its skirts fall fast.
/// Source: Harris, Proc. IEEE 66 (1978) 51.
pub fn spectrum(values: &[f64], interval: f64) -> Spectrum {
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n as f64;
    let mut input: Vec<f64> = values
        .iter()
        .enumerate()
        .map(|(i, v)| hann(i, n) * (v - mean))
        .collect();
    let plan = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut output = plan.make_output_vec();
    plan.process(&mut input, &mut output)
        .expect("buffers come from the plan itself");
    // The window's sum is n/2.
    let scale = 4.0 / n as f64;
    let step = 1.0 / (n as f64 * interval);
    Spectrum {
        frequency: (0..output.len()).map(|k| k as f64 * step).collect(),
        amplitude: output.iter().map(|c| c.norm() * scale).collect(),
    }
}

/// Amplitudes of the sines at 1, 2, ... `count` times `fundamental` (Hz), in the unit of the signal.
///
/// ```text
/// A_k = 2 |sum_i w_i (y_i - mean y) exp(-2 pi j k f t_i)| / sum_i w_i,   w Hann over the record
/// ```
///
/// Sample times may be uneven. The record should hold at least four periods, so that harmonics do not overlap.
pub fn harmonics(time: &[f64], values: &[f64], fundamental: f64, count: usize) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let (first, span) = (time[0], time[time.len() - 1] - time[0]);
    (1..=count)
        .map(|k| {
            let omega = TAU * fundamental * k as f64;
            let (mut re, mut im, mut weights) = (0.0, 0.0, 0.0);
            for (t, v) in time.iter().zip(values) {
                let w = 0.5 - 0.5 * (TAU * (t - first) / span).cos();
                let (sin, cos) = (omega * (t - first)).sin_cos();
                re += w * (v - mean) * cos;
                im += w * (v - mean) * sin;
                weights += w;
            }
            2.0 * re.hypot(im) / weights
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_sines() -> (Vec<f64>, Vec<f64>) {
        let value = |t: f64| 2.0 + 3.0 * (TAU * 33.0 * t).sin() + 0.5 * (TAU * 66.0 * t).cos();
        (0..6000)
            .map(|i| f64::from(i) * 1e-4)
            .map(|t| (t, value(t)))
            .unzip()
    }

    #[test]
    fn val_harmonics_of_two_sines_are_their_amplitudes() {
        let (time, values) = two_sines();
        let found = harmonics(&time, &values, 33.0, 3);
        for (found, expected) in found.iter().zip([3.0, 0.5, 0.0]) {
            assert!((found - expected).abs() < 2e-3, "{found} {expected}");
        }
    }

    #[test]
    fn val_the_spectrum_peaks_where_the_sine_is() {
        let (_, values) = two_sines();
        let spectrum = spectrum(&values, 1e-4);
        let peak = (0..spectrum.amplitude.len())
            .max_by(|a, b| spectrum.amplitude[*a].total_cmp(&spectrum.amplitude[*b]))
            .unwrap();
        assert!((spectrum.frequency[peak] - 33.0).abs() < 1.7);
        assert!((spectrum.amplitude[peak] / 3.0 - 1.0).abs() < 0.16);
    }
}
