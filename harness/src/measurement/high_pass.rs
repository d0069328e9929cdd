//! A reading that has passed a first-order high-pass filter, undone.
//!
//! An AC-coupled sensor or recorder reads y of a quantity u,
//!
//! ```text
//! y' = u' - 2 pi f y,   hence   u = y + 2 pi f (integral of y dt) + constant
//! ```
//!
//! with the corner frequency f (Hz, -3 dB) that data sheets state. The constant is lost: the mean of the record is taken off, as for a
//! sensor whose zero is not known. Holds for an even record without gaps; a zero of the recorder that is off by b makes the result drift
//! by `2 pi f b t`, and white noise of standard deviation s adds `2 pi f s sqrt(h t)` with the sample interval h. Source: Oppenheim and
//! Willsky 1997, Signals and Systems, sect. 6.5 (first-order systems).

/// Replaces readings at these times (s) by what the filter was given, about its mean.
pub(super) fn undo(readings: &mut [f64], time: &[f64], corner_hz: f64) {
    let rate = std::f64::consts::TAU * corner_hz;
    let mut integral = 0.0;
    let mut before = readings.first().copied().unwrap_or(0.0);
    for k in 0..readings.len() {
        let reading = readings[k];
        if k > 0 {
            integral += 0.5 * (before + reading) * (time[k] - time[k - 1]);
        }
        before = reading;
        readings[k] = reading + rate * integral;
    }
    let mean = readings.iter().sum::<f64>() / readings.len().max(1) as f64;
    readings.iter_mut().for_each(|u| *u -= mean);
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn val_a_cosine_comes_back_from_its_filtered_reading() {
        // Source: closed form; of cos(w t) the filter leaves a^2 cos(w t) - a sqrt(1 - a^2) sin(w t), a^2 = w^2 / (w^2 + r^2), once settled.
        let (w, corner) = (TAU * 30.0, 8.0);
        let rate = TAU * corner;
        let a = w / w.hypot(rate);
        let time: Vec<f64> = (0..20_001).map(|k| 1e-5 * f64::from(k)).collect();
        let reading = |t: &f64| a * a * (w * t).cos() - a * (1.0 - a * a).sqrt() * (w * t).sin();
        let mut undone: Vec<f64> = time.iter().map(reading).collect();
        undo(&mut undone, &time, corner);
        // Six whole cycles: the mean of the cosine is that of its first sample, one in 20 001.
        for (t, u) in time.iter().zip(&undone) {
            assert!((u - (w * t).cos()).abs() < 1e-4, "{t}: {u}");
        }
    }

    #[test]
    fn no_readings_and_one_are_left_alone() {
        undo(&mut [], &[], 1.0);
        let mut one = [3.0];
        undo(&mut one, &[0.5], 1.0);
        assert_eq!(one, [0.0]);
    }
}
