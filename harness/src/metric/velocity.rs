//! Velocity from a noisy displacement.

/// The slope of the signal at each sample, by a least-squares parabola through the sample and `half_width` neighbours on
/// either side (fewer at the ends).
///
/// `time` in s, `values` in m, result in m/s. Noise of standard deviation s (m) at even spacing dt (s) gives a velocity
/// noise of about (s/dt) sqrt(3 / (h (h + 1) (2h + 1))), h the half width. Uneven spacing is taken into account.
/// Source: Savitzky and Golay, Anal. Chem. 36 (1964) 1627.
pub fn velocity(time: &[f64], values: &[f64], half_width: usize) -> Vec<f64> {
    let n = time.len();
    (0..n)
        .map(|i| {
            let window = i.saturating_sub(half_width)..(i + half_width + 1).min(n);
            slope(&time[window.clone()], &values[window], time[i])
        })
        .collect()
}

/// Derivative at `at` of the parabola that fits best.
fn slope(time: &[f64], values: &[f64], at: f64) -> f64 {
    let scale = (time[time.len() - 1] - time[0]).max(f64::MIN_POSITIVE);
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    // Moments about `at`, in units of the window, keep the normal equations well conditioned.
    let (mut s, mut b) = ([0.0; 5], [0.0; 3]);
    for (t, v) in time.iter().zip(values) {
        let x = (t - at) / scale;
        let mut power = 1.0;
        for k in 0..5 {
            s[k] += power;
            if k < 3 {
                b[k] += power * (v - mean);
            }
            power *= x;
        }
    }
    let det = |m: [[f64; 3]; 3]| {
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
            - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    };
    let all = det([[s[0], s[1], s[2]], [s[1], s[2], s[3]], [s[2], s[3], s[4]]]);
    let linear = det([[s[0], b[0], s[2]], [s[1], b[1], s[3]], [s[2], b[2], s[4]]]);
    linear / all / scale
}

#[cfg(test)]
mod tests {
    use super::velocity;

    #[test]
    fn val_a_parabola_is_differentiated_exactly_on_uneven_times() {
        let time: Vec<f64> = (0..50)
            .map(|i| f64::from(i) * 0.1 + 0.02 * f64::from(i % 3))
            .collect();
        let values: Vec<f64> = time.iter().map(|t| 3.0 - 2.0 * t + 0.5 * t * t).collect();
        for (t, v) in time.iter().zip(velocity(&time, &values, 4)) {
            assert!((v - (t - 2.0)).abs() < 1e-9, "{v} at {t}");
        }
    }
}
