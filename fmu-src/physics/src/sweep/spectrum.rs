//! Amplitude spectrum of an even series, and its strongest line.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;
use std::cell::RefCell;
use std::f64::consts::TAU;

/// Samples for which the window is worked out from one angle.
const BLOCK: usize = 16;

thread_local! {
    /// Remembers the factors of each length: to work them out costs more than the transform.
    static PLANNER: RefCell<RealFftPlanner<f64>> = RefCell::new(RealFftPlanner::new());
    /// Fresh memory costs as much as half the transform.
    static ROOM: RefCell<Room> = RefCell::default();
}

/// Room for a transform.
#[derive(Default)]
struct Room {
    padded: Vec<f64>,
    lines: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
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
    transformed(samples, |lines, weight, length| Spectrum {
        resolution: 1.0 / (length as f64 * interval),
        amplitudes: lines.iter().map(|c| 2.0 * c.norm() / weight).collect(),
    })
    .unwrap_or(Spectrum {
        resolution: 1.0,
        amplitudes: Vec::new(),
    })
}

/// Hands over the lines of the windowed and padded series, the sum of the window, and the padded length; `None` where there
/// are fewer than 8 samples.
fn transformed<T>(
    samples: &[f64],
    look: impl FnOnce(&[Complex<f64>], f64, usize) -> T,
) -> Option<T> {
    let n = samples.len();
    if n < 8 {
        return None;
    }
    let length = quick_length(2 * n);
    let mean = samples.iter().sum::<f64>() / n as f64;
    let transform = PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(length));
    ROOM.with_borrow_mut(|room| {
        room.padded.clear();
        let weight = window(samples, mean, &mut room.padded);
        room.padded.resize(length, 0.0);
        room.lines.resize(length / 2 + 1, Complex::default());
        let scratch = transform.get_scratch_len().max(room.scratch.len());
        room.scratch.resize(scratch, Complex::default());
        transform
            .process_with_scratch(&mut room.padded, &mut room.lines, &mut room.scratch)
            .expect("the planner's own lengths");
        Some(look(&room.lines, weight, length))
    })
}

/// The least length from `least` on that is 1, 3 or 9 times a power of two: nearly as quick as those, and up to a third shorter.
fn quick_length(least: usize) -> usize {
    let of = |odd: usize| odd * least.div_ceil(odd).next_power_of_two();
    of(1).min(of(3)).min(of(9))
}

/// Appends the samples less their mean, times the Hann window `h_i = 1/2 - cos(2 pi (i + 1/2)/n)/2`; the sum of the window.
fn window(samples: &[f64], mean: f64, out: &mut Vec<f64>) -> f64 {
    let step = TAU / samples.len() as f64;
    let turns: [(f64, f64); BLOCK] = std::array::from_fn(|j| (step * (j as f64 + 0.5)).sin_cos());
    let mut weight = 0.0;
    for (block, samples) in samples.chunks(BLOCK).enumerate() {
        // cos(a + b) = cos a cos b - sin a sin b.
        let (sin, cos) = (step * (block * BLOCK) as f64).sin_cos();
        let h = turns.map(|(s, c)| 0.5 - 0.5 * (cos * c - sin * s));
        out.extend(samples.iter().zip(h).map(|(x, h)| h * (x - mean)));
        weight += h[..samples.len()].iter().sum::<f64>();
    }
    weight
}

/// Lines within the width of the window around zero, in which none is looked for.
const WIDTH: usize = 4;

/// Frequency in Hz of the strongest line of an even series, as [`main_frequency`] of its [`spectrum`] to rounding, without
/// working all amplitudes out.
pub fn strongest_line(samples: &[f64], interval: f64) -> Option<f64> {
    transformed(samples, |lines, _, length| {
        let peak = strongest(lines.len(), |i| lines[i].norm_sqr())?;
        let l = |i: usize| 0.5 * lines[i].norm_sqr().max(f64::MIN_POSITIVE).ln();
        let place = between(peak, [peak - 1, peak, peak + 1].map(l));
        Some(place / (length as f64 * interval))
    })?
}

/// Frequency in Hz of the strongest line, between the lines by a parabola through the logarithms.
///
/// Lines within the width of the window around zero are left out. `None` for a series that rests.
pub fn main_frequency(spectrum: &Spectrum) -> Option<f64> {
    let a = &spectrum.amplitudes;
    let peak = strongest(a.len(), |i| a[i])?;
    let l = |i: usize| a[i].max(f64::MIN_POSITIVE).ln();
    let place = between(peak, [peak - 1, peak, peak + 1].map(l));
    Some(place * spectrum.resolution)
}

/// The last of the strongest lines that have neighbours; `None` where all are nothing.
fn strongest(count: usize, size: impl Fn(usize) -> f64) -> Option<usize> {
    let mut best = (0, 0.0);
    for i in WIDTH..count.saturating_sub(1) {
        let size = size(i);
        if size >= best.1 {
            best = (i, size);
        }
    }
    (best.1 > 0.0).then_some(best.0)
}

/// Place of the top of the parabola through the logarithms of a line and its neighbours.
fn between(peak: usize, [left, middle, right]: [f64; 3]) -> f64 {
    let bend = left - 2.0 * middle + right;
    let shift = if bend < 0.0 {
        (0.5 * (left - right) / bend).clamp(-0.5, 0.5)
    } else {
        0.0
    };
    peak as f64 + shift
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
        let quick = strongest_line(&x, dt).unwrap();
        assert_relative_eq!(quick, main_frequency(&s).unwrap(), max_relative = 1e-12);
        let largest = s.amplitudes.iter().fold(0.0, |a: f64, b| a.max(*b));
        assert_relative_eq!(largest, 0.7, max_relative = 0.04);
    }

    #[test]
    fn rest_has_no_frequency() {
        assert_eq!(main_frequency(&spectrum(&[3.0; 64], 1.0)), None);
        assert_eq!(main_frequency(&spectrum(&[3.0; 4], 1.0)), None);
    }
}
