//! Straight-line interpolation: to even spacing, or to another signal's times.

/// The signal's value at `at`; beyond its ends the end values. `time` strictly increasing.
pub fn interpolate(time: &[f64], values: &[f64], at: f64) -> f64 {
    match time.partition_point(|t| *t <= at) {
        0 => values[0],
        n if n == time.len() => values[n - 1],
        i => {
            let share = (at - time[i - 1]) / (time[i] - time[i - 1]);
            values[i - 1] + share * (values[i] - values[i - 1])
        }
    }
}

/// The signal at even spacing `interval` (s) from its first time to its last; gaps are bridged by straight lines.
pub fn resample(time: &[f64], values: &[f64], interval: f64) -> Vec<f64> {
    let first = time[0];
    let samples = ((time[time.len() - 1] - first) / interval + 1e-6).floor() as usize + 1;
    let mut i = 1;
    (0..samples)
        .map(|k| {
            let at = first + k as f64 * interval;
            while i + 1 < time.len() && time[i] < at {
                i += 1;
            }
            let share = ((at - time[i - 1]) / (time[i] - time[i - 1])).clamp(0.0, 1.0);
            values[i - 1] + share * (values[i] - values[i - 1])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn val_a_straight_line_stays_one_across_a_gap() {
        let time = [0.0, 0.9, 2.1, 5.0];
        let values = time.map(|t| 2.0 * t + 1.0);
        for (k, v) in resample(&time, &values, 1.0).iter().enumerate() {
            assert!((v - (2.0 * k as f64 + 1.0)).abs() < 1e-12);
        }
        assert!((interpolate(&time, &values, 3.3) - 7.6).abs() < 1e-12);
        assert_eq!(interpolate(&time, &values, 9.0), 11.0);
    }
}
