//! Least squares of what a characteristic leaves of one run's force on `m`, `m cos u` and `m sin u`, with m the expected force and
//! `u = 2 pi f t` or `2 pi s/L`, at one frequency or wave number after another. Angles are turned from one to the next, which costs a few
//! multiplications where a sine and a cosine would cost twenty times as much.

use crate::smoothing::SlipSample;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;

/// A fit at one wave.
pub(crate) struct AtWave {
    /// Fall of the logarithm of the likelihood.
    pub gain: f64,
    /// Amplitude relative to the expected force (1).
    pub amplitude: f64,
    /// Phase in rad.
    pub phase: f64,
}

/// Waves after which the turned angles are worked out anew, before rounding adds up.
const ANEW: usize = 64;

/// The least squares of one run at one wave after another.
pub(crate) struct WaveFits {
    /// 2 pi times the place of each sample.
    angle: Vec<f64>,
    /// Cosine and sine at the present wave, and of the turn from one wave to the next.
    now: Vec<[f64; 2]>,
    turn: Vec<[f64; 2]>,
    /// Expected force squared, and times the rest.
    weight: Vec<f64>,
    product: Vec<f64>,
    /// Sums of the weights, the products and the squares of the rest.
    sums: [f64; 3],
}

impl WaveFits {
    /// The fits of `rests` over places in units of the reciprocal wave, from one wave to the next `fine` further.
    pub fn new(
        samples: &[SlipSample],
        rests: &[f64],
        place: impl Fn(&SlipSample) -> f64,
        fine: f64,
    ) -> Self {
        let angle: Vec<f64> = samples.iter().map(|s| TAU * place(s)).collect();
        let weight: Vec<f64> = samples.iter().map(|s| s.expected * s.expected).collect();
        let with_rests = samples.iter().zip(rests);
        let product: Vec<f64> = with_rests.map(|(s, r)| s.expected * r).collect();
        Self {
            now: vec![[1.0, 0.0]; angle.len()],
            turn: angle.iter().map(|a| cosine_and_sine(a * fine)).collect(),
            sums: [
                weight.iter().sum(),
                product.iter().sum(),
                rests.iter().map(|r| r * r).sum(),
            ],
            angle,
            weight,
            product,
        }
    }

    /// The fit at `wave`, the `step`-th; to be asked for in turn.
    pub fn at(&mut self, wave: f64, step: usize) -> Option<AtWave> {
        if step.is_multiple_of(ANEW) {
            for (now, a) in self.now.iter_mut().zip(&self.angle) {
                *now = cosine_and_sine(a * wave);
            }
        } else {
            for ([cos, sin], [c, s]) in self.now.iter_mut().zip(&self.turn) {
                (*cos, *sin) = (*cos * c - *sin * s, *cos * s + *sin * c);
            }
        }
        let (mut first, mut second, mut right) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for (([cos, sin], w), p) in self.now.iter().zip(&self.weight).zip(&self.product) {
            let (wc, ws) = (w * cos, w * sin);
            first[0] += wc;
            first[1] += ws;
            second[0] += wc * cos;
            second[1] += wc * sin;
            right[0] += p * cos;
            right[1] += p * sin;
        }
        let [weight, product, total] = self.sums;
        let [cos, sin] = first;
        let [cos_cos, cos_sin] = second;
        let matrix = Matrix3::new(
            weight,
            cos,
            sin, //
            cos,
            cos_cos,
            cos_sin, //
            sin,
            cos_sin,
            weight - cos_cos,
        );
        let right = Vector3::new(product, right[0], right[1]);
        let solution = matrix.cholesky()?.solve(&right);
        let level = product * product / weight;
        let explained = right.dot(&solution);
        let (before, after) = (total - level, total - explained);
        (after > 0.0 && before > 0.0).then(|| AtWave {
            gain: 0.5 * self.angle.len() as f64 * (before / after).ln(),
            amplitude: solution[1].hypot(solution[2]),
            phase: (-solution[2]).atan2(solution[1]),
        })
    }
}

fn cosine_and_sine(angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos, sin]
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const WAVE: f64 = 13.0;

    /// Slip that comes and goes, with a rest of 7 % at one wave and a level off by 1 %.
    fn record() -> (Vec<SlipSample>, Vec<f64>) {
        let samples: Vec<SlipSample> = (0..400)
            .filter(|k| k % 50 < 30)
            .map(|k| SlipSample {
                time: 1e-3 * f64::from(k),
                travel: 0.0,
                relative_velocity: -0.1,
                force: 0.0,
                expected: -30.0 + 5.0 * (0.3 * f64::from(k)).sin(),
            })
            .collect();
        let jitter = |s: &SlipSample| 1e-4 * (1e6 * s.time * s.time).sin();
        let rest = |s: &SlipSample| {
            s.expected * (0.01 + 0.07 * (TAU * WAVE * s.time + 0.4).cos() + jitter(s))
        };
        let rests = samples.iter().map(rest).collect();
        (samples, rests)
    }

    #[test]
    fn val_a_line_has_its_amplitude_and_phase() {
        // Source: the record's own closed form.
        let (samples, rests) = record();
        let fit = WaveFits::new(&samples, &rests, |s| s.time, 0.5).at(WAVE, 0);
        let fit = fit.unwrap();
        assert_relative_eq!(fit.amplitude, 0.07, max_relative = 1e-3);
        assert_relative_eq!(fit.phase, 0.4, max_relative = 1e-3);
    }

    #[test]
    fn turned_angles_stay_what_they_are_anew() {
        let (samples, rests) = record();
        let fine = 0.11;
        let mut turned = WaveFits::new(&samples, &rests, |s| s.time, fine);
        for step in 0..ANEW {
            let wave = 9.0 + fine * step as f64;
            let now = turned.at(wave, step).unwrap();
            let anew = WaveFits::new(&samples, &rests, |s| s.time, fine).at(wave, 0);
            let anew = anew.unwrap();
            assert_relative_eq!(now.gain, anew.gain, max_relative = 1e-9, epsilon = 1e-9);
            assert_relative_eq!(now.amplitude, anew.amplitude, max_relative = 1e-9);
        }
    }
}
