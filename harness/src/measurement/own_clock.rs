//! Readings of a sensor with a clock of its own, at the times of another one.

use super::Sampling;
use super::band_limited::kernel;
use super::inputs::is_even;
use super::noise::Noise;

/// Share of an interval within which a sample is taken as it is: of the fastest motion that a record may hold, at a twentieth of its
/// rate, it shifts the phase by 0.6 thousandths.
const AS_IT_IS: f64 = 1e-4;

/// What a further sensor read.
pub(super) struct Readings {
    /// Values at the times of the first sensor; NaN where there are none.
    pub values: Vec<f64>,
    /// Time in s to either side of a jump over which interpolation draws it.
    pub drawn_over: f64,
    /// Standard deviation of its noise, where its own samples told it.
    pub noise: Option<f64>,
}

impl Readings {
    /// Readings in the samples of the first sensor.
    pub fn in_rows(values: Vec<f64>) -> Self {
        Self {
            values,
            drawn_over: 0.0,
            noise: None,
        }
    }
}

/// What a sensor read at `wanted` times in s, of its `values` at its own strictly increasing `times`, which are later by `delay` in s than
/// those of the other clock. NaN where it read nothing.
///
/// Between samples the signal is the one of least bandwidth ([`kernel`]); one that `jumps` is the cubic through four samples (Lagrange),
/// which keeps a jump to two samples on either side and is good to `3/128 (w h)^4` of its size at angular frequency w (rad/s) and interval
/// h (s). Of a sensor that is slower than the other one, each sample counts once, at the time nearest to it. Holds for even samples
/// without gaps.
///
/// # Errors
/// The sampling, where it is uneven.
pub(super) fn at(
    wanted: &[f64],
    (times, values): (&[f64], &[f64]),
    delay: f64,
    jumps: bool,
) -> Result<Readings, Sampling> {
    let own = Sampling::of(times);
    if !is_even(&own) {
        return Err(own);
    }
    let last = times.len() - 1;
    // The whole record tells the interval better than one step of rounded times.
    let interval = (times[last] - times[0]) / last as f64;
    let of_other = Sampling::of(wanted).interval;
    let nearest = 0.5 * (of_other / interval).min(1.0);
    let place = |t: &f64| -> Option<f64> {
        let place = (t + delay - times[0]) / interval;
        let is_inside = place > -AS_IT_IS && place < last as f64 + AS_IT_IS;
        let is_nearest = (place - place.round()).abs() <= nearest + AS_IT_IS;
        (is_inside && is_nearest).then_some(place)
    };
    let reading = |t: &f64| place(t).map_or(f64::NAN, |place| between(values, place, jumps));
    let noise = Noise::estimate(values, &own.unbroken()).of_sensor();
    let values: Vec<f64> = wanted.iter().map(reading).collect();
    Ok(Readings {
        values,
        drawn_over: match wanted
            .iter()
            .filter_map(place)
            .any(|place| !is_sample(place))
        {
            true => 2.0 * interval,
            false => 0.0,
        },
        noise: Some(noise),
    })
}

/// Whether a place, in intervals, is that of a sample.
fn is_sample(place: f64) -> bool {
    (place - place.round()).abs() < AS_IT_IS
}

/// The signal at a place between samples; NaN too near to an end.
fn between(values: &[f64], place: f64, jumps: bool) -> f64 {
    if is_sample(place) {
        return values[place.round() as usize];
    }
    let (before, share) = (place.floor() as usize, place.fract());
    let weights = match jumps {
        true => cubic(share).to_vec(),
        false => kernel(share),
    };
    let half = weights.len() / 2;
    let first = (before + 1).checked_sub(half);
    let Some(around) = first.and_then(|first| values.get(first..first + weights.len())) else {
        return f64::NAN;
    };
    around.iter().zip(&weights).map(|(y, w)| y * w).sum()
}

/// Weights of the four samples around a place that lies by `s` of the interval behind the second.
fn cubic(s: f64) -> [f64; 4] {
    [
        -s * (s - 1.0) * (s - 2.0) / 6.0,
        (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0,
        -(s + 1.0) * s * (s - 2.0) / 2.0,
        (s + 1.0) * s * (s - 1.0) / 6.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(rate: f64, from: f64, count: usize) -> Vec<f64> {
        (0..count).map(|k| from + k as f64 / rate).collect()
    }

    /// Two modes of the nominal beam.
    fn motion(t: f64) -> f64 {
        (std::f64::consts::TAU * 80.0 * t).sin() + 0.1 * (std::f64::consts::TAU * 510.0 * t).cos()
    }

    #[test]
    fn val_a_clock_that_is_off_and_faster_is_read_between_its_samples() {
        // Source: the signal itself.
        let wanted = grid(1e4, 0.0, 2000);
        let delay = 0.012_34;
        let times = grid(51_200.0, 0.005, 11_000);
        let values: Vec<f64> = times.iter().map(|t| motion(t - delay)).collect();
        for (jumps, tolerance) in [(false, 1e-5), (true, 1e-5)] {
            let read = at(&wanted, (&times, &values), delay, jumps).unwrap().values;
            let off = |k: usize| (read[k] - motion(wanted[k])).abs();
            assert!((0..1900).all(|k| off(k) < tolerance), "{jumps}");
        }
    }

    #[test]
    fn val_the_same_rate_half_a_sample_off_is_good_to_the_bound_stated() {
        // Source: 3/128 (w h)^4 of the mode at 510 Hz, amplitude 0.1, at 10 kHz: 2.5e-5.
        let wanted = grid(1e4, 0.0, 1000);
        let times = grid(1e4, -0.01, 1200);
        let delay = 0.5e-4;
        let values: Vec<f64> = times.iter().map(|t| motion(t - delay)).collect();
        let worst = |jumps: bool| {
            let read = at(&wanted, (&times, &values), delay, jumps).unwrap();
            assert_eq!(read.drawn_over, 2e-4);
            let off = |k: usize| (read.values[k] - motion(wanted[k])).abs();
            (0..1000).map(off).fold(0.0, f64::max)
        };
        assert!(worst(false) < 1e-4, "{}", worst(false));
        assert!((1e-5..4e-5).contains(&worst(true)), "{}", worst(true));
    }

    #[test]
    fn a_slower_sensor_reads_each_sample_once_and_nothing_outside() {
        let wanted = grid(1e4, 0.0, 1000);
        let times = grid(2500.0, 0.02, 200);
        let values: Vec<f64> = (0..200).map(f64::from).collect();
        let readings = at(&wanted, (&times, &values), 0.0, true).unwrap();
        assert_eq!(readings.drawn_over, 0.0);
        let read = readings.values;
        let found: Vec<f64> = read.iter().copied().filter(|y| y.is_finite()).collect();
        assert_eq!(found, values);
        assert!(read[..200].iter().all(|y| y.is_nan()) && read[200] == 0.0);
        assert!(read[997..].iter().all(|y| y.is_nan()));
    }

    #[test]
    fn an_uneven_clock_is_refused() {
        let mut times = grid(1e4, 0.0, 100);
        times.remove(50);
        let values = vec![1.0; 99];
        let refused = at(&grid(1e4, 0.0, 90), (&times, &values), 0.0, false)
            .err()
            .unwrap();
        assert_eq!(refused.gaps.len(), 1);
    }
}
