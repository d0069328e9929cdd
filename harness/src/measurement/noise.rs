//! Noise level of a measured signal, from the signal alone.

use std::ops::Range;

/// Noise of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation of its white part, in the unit of what is measured.
    pub std: f64,
    /// Smallest usual step between successive samples, in the same unit: the recorder's, where that is coarse, else a small part of the
    /// noise or of the motion.
    pub resolution: f64,
    /// Whether all orders of difference show one standard deviation, as those of white noise do: else it is an upper bound.
    pub is_white: bool,
}

/// Orders of difference that are tried.
const ORDERS: std::ops::RangeInclusive<usize> = 3..=10;
/// By how much, times the root of the number of samples, the standard deviations that the orders show of white noise differ at most: of
/// 200 records of 3000 samples of Gaussian noise the worst had 1.9, the median 0.5.
const SCATTER_OF_ORDERS: f64 = 3.0;
/// Half width, in standard deviations, beyond which a difference is taken for motion and left out.
const CLIP: f64 = 3.0;
/// Standard deviation of a unit Gaussian cut off at [`CLIP`].
const CLIPPED_STD: f64 = 0.986_578;
/// Median of the absolute value of a unit Gaussian.
const MEDIAN_ABS: f64 = 0.674_490;

impl Noise {
    /// Estimates the noise of `signal` from `stretches` of it: samples side by side, of which none is missing or made by the recorder.
    ///
    /// The k-th difference of white noise of standard deviation s has standard deviation s sqrt(C(2k, k)), while that
    /// of a smooth motion of frequency f falls with (2 sin(pi f dt))^k. So the estimate
    ///
    /// ```text
    /// s_k = std(diff^k y) / sqrt(C(2k, k))
    /// ```
    ///
    /// falls with k until only noise is left, and the smallest is taken. Stick-slip transitions are kinks that no order
    /// removes: differences beyond 3 s are dropped, repeatedly. Differences do not reach across gaps. A value that the recorder repeats
    /// has none, whatever the sensor's noise: a run of which half is held would be estimated as free of noise.
    ///
    /// Holds for noise that is white up to half the sampling rate and a motion well below it; noise that is smoothed by
    /// the recorder is underestimated. Source: the difference-sequence estimators of variance (von Neumann 1941; Hall,
    /// Kay and Titterington, Biometrika 77 (1990) 521).
    pub(super) fn estimate(signal: &[f64], stretches: &[Range<usize>]) -> Noise {
        let of_stretches = stretches.iter().map(|r| signal[r.clone()].to_vec());
        let mut differences: Vec<Vec<f64>> = of_stretches.collect();
        let (mut best, mut worst, mut central_binomial) = (f64::INFINITY, 0.0_f64, 1.0);
        for order in 1..=*ORDERS.end() {
            for segment in &mut differences {
                *segment = segment.windows(2).map(|w| w[1] - w[0]).collect();
            }
            let k = order as f64;
            central_binomial *= 2.0 * (2.0 * k - 1.0) / k;
            if ORDERS.contains(&order)
                && let Some(std) = clipped_std(differences.concat())
            {
                let of_order = std / central_binomial.sqrt();
                (best, worst) = (best.min(of_order), worst.max(of_order));
            }
        }
        let samples: usize = stretches.iter().map(|stretch| stretch.len()).sum();
        let scatter = SCATTER_OF_ORDERS / (samples as f64).sqrt();
        Noise {
            std: if best.is_finite() { best } else { 0.0 },
            resolution: resolution(signal),
            is_white: worst <= (1.0 + scatter) * best,
        }
    }

    /// The standard deviation; that of rounding to the resolution, `resolution / sqrt(12)`, where it is more.
    pub(super) fn of_sensor(self) -> f64 {
        self.std.max(self.resolution / 12.0_f64.sqrt())
    }
}

/// Estimates of one sensor's noise within this factor of the smallest agree.
const AGREE: f64 = 1.06;
/// A run whose estimate is more than this many times the smallest was measured otherwise.
const OTHER_SENSOR: f64 = 2.0;

/// The sensor's noise in each of a campaign's runs, from the estimates of the runs.
///
/// A run at small, fast cycles has a transition every few samples, of which every order of difference keeps
/// something: its noise is overestimated, by up to three quarters. So runs are taken to be measured by one
/// sensor, whose noise is the root mean square of the estimates that agree with the smallest; only a run whose
/// estimate is more than twice that keeps its own. Does not hold for a sensor whose noise differs between runs by less
/// than that.
pub fn of_one_sensor(estimates: &[f64]) -> Vec<f64> {
    let least = estimates.iter().copied().fold(f64::INFINITY, f64::min);
    let agreeing: Vec<f64> = estimates
        .iter()
        .copied()
        .filter(|e| *e <= AGREE * least)
        .collect();
    let sensor = (agreeing.iter().map(|e| e * e).sum::<f64>() / agreeing.len() as f64).sqrt();
    estimates
        .iter()
        .map(|&e| if e > OTHER_SENSOR * least { e } else { sensor })
        .collect()
}

/// Gives runs whose estimate is more than twice the smallest, and not that of white noise, the smallest.
///
/// Every order of difference keeps something of a mode that rings near the sampling rate and of transitions every few samples: of
/// velocities and accelerations with a mode at 1.4 kHz, sampled at 10 kHz, one run in two was estimated at 10 to 1800 times the noise, and
/// one run at least of every campaign within a factor of 1.6. Holds for runs of one sensor.
pub(super) fn of_quiet_runs(noises: &mut [&mut Noise]) {
    let all = noises.iter().map(|noise| noise.std);
    let least = all.filter(|std| *std > 0.0).fold(f64::INFINITY, f64::min);
    let bounds = noises.iter_mut().filter(|noise| !noise.is_white);
    for noise in bounds.filter(|noise| noise.std > OTHER_SENSOR * least) {
        noise.std = least;
    }
}

/// Standard deviation about zero, outliers left out; `None` with fewer than eight values.
fn clipped_std(mut values: Vec<f64>) -> Option<f64> {
    if values.len() < 8 {
        return None;
    }
    values.iter_mut().for_each(|v| *v = v.abs());
    let middle = values.len() / 2;
    let mut std = *values.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN_ABS;
    for _ in 0..20 {
        let kept = values.iter().filter(|v| **v <= CLIP * std);
        let (count, sum) = kept.fold((0, 0.0), |(n, s), v| (n + 1, s + v * v));
        let next = (sum / f64::from(count.max(1))).sqrt() / CLIPPED_STD;
        let settled = (next - std).abs() <= 1e-6 * std;
        std = next;
        if settled {
            break;
        }
    }
    Some(std)
}

/// Share of the steps between successive samples that lie below the resolution: rounding makes a few that are no steps.
const ROUNDED: f64 = 0.01;

/// Smallest usual step between successive samples; 0 where there is none.
pub(super) fn resolution(signal: &[f64]) -> f64 {
    let steps = signal
        .windows(2)
        .map(|w| (w[1] - w[0]).abs())
        .filter(|step| *step > 0.0);
    let mut steps: Vec<f64> = steps.collect();
    if steps.is_empty() {
        return 0.0;
    }
    let at = (ROUNDED * steps.len() as f64) as usize;
    *steps.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::super::faults;
    use super::super::measurand::Measurand;
    use super::super::sampling::Sampling;
    use super::*;

    /// A stick-slip-like motion (sawtooth with kinks and a 510 Hz ripple) plus seeded Gaussian noise.
    fn signal(samples: usize, std: f64) -> (Vec<f64>, Vec<f64>) {
        let mut seed = 1_u64;
        let mut uniform = || {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((seed >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
        };
        (0..samples)
            .map(|i| {
                let t = i as f64 * 1e-4;
                let phase = (t * 35.0).fract();
                let saw = if phase < 0.6 {
                    phase / 0.6
                } else {
                    (std::f64::consts::PI * (phase - 0.6) / 0.4).cos()
                };
                let ripple = 0.02 * (std::f64::consts::TAU * 510.0 * t).sin();
                let normal =
                    (-2.0 * uniform().ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
                (t, 1e-3 * (saw + ripple) + std * normal)
            })
            .unzip()
    }

    #[test]
    fn the_runs_of_one_sensor_share_its_noise() {
        let found = of_one_sensor(&[1.02, 1.6, 0.98, 1.0, 2.5]);
        for shared in &found[..4] {
            assert!((shared - 1.0).abs() < 1e-3, "{shared}");
        }
        assert_eq!(found[4], 2.5);
    }

    #[test]
    fn a_run_that_rings_has_the_noise_of_a_quiet_one_and_a_noisy_one_its_own() {
        let (time, quiet) = signal(6000, 1e-7);
        let (_, noisy) = signal(6000, 1e-6);
        let ringing = quiet.iter().zip(&time).map(|(y, t)| {
            let decay = (-(t * 400.0).fract() / 0.5).exp();
            y + 2e-4 * decay * (std::f64::consts::TAU * 2400.0 * t).sin()
        });
        let ringing: Vec<f64> = ringing.collect();
        let estimate = |signal: &[f64]| Noise::estimate(signal, &Sampling::of(&time).unbroken());
        let (mut quiet, mut noisy, mut ringing) =
            (estimate(&quiet), estimate(&noisy), estimate(&ringing));
        assert!(ringing.std > 1e-6 && !ringing.is_white, "{ringing:?}");
        of_quiet_runs(&mut [&mut quiet, &mut noisy, &mut ringing]);
        assert!((noisy.std / 1e-6 - 1.0).abs() < 0.1, "{noisy:?}");
        assert_eq!(ringing.std, quiet.std);
        assert!((quiet.std / 1e-7 - 1.0).abs() < 0.1, "{quiet:?}");
    }

    #[test]
    fn val_a_held_half_tells_nothing_of_the_noise() {
        let (time, mut signal) = signal(6000, 6e-7);
        let last = signal[2999];
        signal[3000..].fill(last);
        let faults = faults::of(Measurand::Displacement, &signal, resolution(&signal), 0.1);
        let left = faults::between(&faults, Sampling::of(&time).unbroken());
        let found = Noise::estimate(&signal, &left).std;
        assert!((found / 6e-7 - 1.0).abs() < 0.1, "{found:e}, {faults:?}");
    }

    #[test]
    fn val_known_noise_is_found_within_ten_percent() {
        for std in [1e-7, 6e-7, 1e-5] {
            let (time, signal) = signal(6000, std);
            let found = Noise::estimate(&signal, &Sampling::of(&time).unbroken()).std;
            assert!((found / std - 1.0).abs() < 0.1, "{found:e} for {std:e}");
        }
    }
}
