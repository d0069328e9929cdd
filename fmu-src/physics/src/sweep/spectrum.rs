//! Amplitude spectrum of an even series, and its strongest line.

use realfft::RealFftPlanner;
use std::cell::RefCell;
use std::f64::consts::TAU;

thread_local! {
    /// Remembers the factors of each length: to work them out costs more than the transform.
    static PLANNER: RefCell<RealFftPlanner<f64>> = RefCell::new(RealFftPlanner::new());
}

/// Amplitudes over even frequencies.
#[derive(Debug, Clone)]
pub struct Spectrum {
    /// Distance of the lines in Hz.
    pub resolution: f64,
    /// Amplitude of a sine at each line, in the unit of the series; the mean is left out.
    pub amplitudes: Vec<f64>,
}

/// Amplitude spectrum with a Hann window, padded to twice its length.
///
/// `A_k = 2 |sum h_i (x_i - mean) exp(-2 pi i k / N)| / sum h_i`; a sine between two lines shows at least 0.96 of its
/// amplitude. `interval` is the sampling interval in s. Needs at least 8 samples; fewer give no lines.
pub fn spectrum(samples: &[f64], interval: f64) -> Spectrum {
    let n = samples.len();
    if n < 8 {
        return Spectrum {
            resolution: 1.0,
            amplitudes: Vec::new(),
        };
    }
    let length = (2 * n).next_power_of_two();
    let mean = samples.iter().sum::<f64>() / n as f64;
    let window = |i: usize| 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / n as f64).cos();
    let mut padded = vec![0.0; length];
    let mut weight = 0.0;
    for (i, (p, x)) in padded.iter_mut().zip(samples).enumerate() {
        let h = window(i);
        weight += h;
        *p = h * (x - mean);
    }
    let transform = PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(length));
    let mut lines = transform.make_output_vec();
    transform
        .process(&mut padded, &mut lines)
        .expect("the planner's own lengths");
    Spectrum {
        resolution: 1.0 / (length as f64 * interval),
        amplitudes: lines.iter().map(|c| 2.0 * c.norm() / weight).collect(),
    }
}

/// Frequency in Hz of the strongest line, between the lines by a parabola through the logarithms.
///
/// Lines within the width of the window around zero are left out. `None` for a series that rests.
pub fn main_frequency(spectrum: &Spectrum) -> Option<f64> {
    const WIDTH: usize = 4;
    let a = &spectrum.amplitudes;
    let inner = WIDTH..a.len().saturating_sub(1);
    let peak = inner.max_by(|i, j| a[*i].total_cmp(&a[*j]))?;
    if !(a[peak] > 0.0) {
        return None;
    }
    let l = |i: usize| a[i].max(f64::MIN_POSITIVE).ln();
    let (left, middle, right) = (l(peak - 1), l(peak), l(peak + 1));
    let bend = left - 2.0 * middle + right;
    let shift = if bend < 0.0 {
        (0.5 * (left - right) / bend).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    Some((peak as f64 + shift) * spectrum.resolution)
}

#[cfg(all(test, not(feature = "tangent")))]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn val_two_sines_give_amplitude_and_frequency_of_the_stronger() {
        // Source: the series itself, 0.7 sin(2 pi 33.4 t) + 0.2 sin(2 pi 170 t) + 5.
        let dt = 5e-4;
        let x: Vec<f64> = (0..3000)
            .map(|i| {
                let t = i as f64 * dt;
                0.7 * (TAU * 33.4 * t).sin() + 0.2 * (TAU * 170.0 * t).sin() + 5.0
            })
            .collect();
        let s = spectrum(&x, dt);
        assert_relative_eq!(main_frequency(&s).unwrap(), 33.4, max_relative = 2e-4);
        let largest = s.amplitudes.iter().fold(0.0, |a: f64, b| a.max(*b));
        assert_relative_eq!(largest, 0.7, max_relative = 0.04);
    }

    #[test]
    fn rest_has_no_frequency() {
        assert_eq!(main_frequency(&spectrum(&[3.0; 64], 1.0)), None);
        assert_eq!(main_frequency(&spectrum(&[3.0; 4], 1.0)), None);
    }
}
