//! Integral of a signal over time.

/// Integral from the first sample, by trapezoids, of `values` about their mean; about its own mean.
///
/// ```text
/// s_i = sum_(k<i) (t_(k+1) - t_k) ((v_k + v_(k+1))/2 - mean v),   s - mean s
/// ```
///
/// `time` in s; the result in the unit of the values times s. Holds for a signal whose integral does not drift: an offset of the
/// sensor falls out with the mean.
pub fn integral(time: &[f64], values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let mut sum = 0.0;
    let mut out = Vec::with_capacity(values.len());
    out.push(0.0);
    for (t, v) in time.windows(2).zip(values.windows(2)) {
        sum += (t[1] - t[0]) * ((v[0] + v[1]) / 2.0 - mean);
        out.push(sum);
    }
    let mean = out.iter().sum::<f64>() / out.len() as f64;
    out.iter_mut().for_each(|v| *v -= mean);
    out
}

#[cfg(test)]
mod tests {
    use super::integral;

    #[test]
    fn val_the_integral_of_a_cosine_is_a_sine_whatever_the_offset() {
        // Source: closed form, over 40 whole periods.
        let w = std::f64::consts::TAU * 20.0;
        let time: Vec<f64> = (0..20_000).map(|i| f64::from(i) * 1e-4).collect();
        let speed: Vec<f64> = time.iter().map(|t| 0.3 + (w * t).cos()).collect();
        for (t, s) in time.iter().zip(integral(&time, &speed)) {
            assert!((s - (w * t).sin() / w).abs() < 1e-5, "{s} at {t} s");
        }
    }
}
