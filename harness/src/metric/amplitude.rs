//! Amplitude that a few outliers do not move.

/// The value below which a share `q` (0..=1) of `values` lies, by linear interpolation. Not a number for no values.
pub fn quantile(values: &[f64], q: f64) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let at = q.clamp(0.0, 1.0) * (values.len() - 1) as f64;
    let below = at.floor() as usize;
    let mut parted = values.to_vec();
    let (_, low, above) = parted.select_nth_unstable_by(below, f64::total_cmp);
    let next = above.iter().copied().min_by(f64::total_cmp);
    match next.filter(|_| at > below as f64) {
        Some(high) => *low + (at - below as f64) * (high - *low),
        None => *low,
    }
}

/// The middle of `values`, the upper one of two, which it reorders. Not a number for no values.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Standard deviation of `values` about their mean, in their unit (divided by their number).
pub fn standard_deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Half the distance between the 0.5 % and the 99.5 % quantile, in the unit of `values`.
///
/// For a smooth motion that is the peak amplitude to a few parts in 10^4: near its turning points it spends much time.
pub fn amplitude(values: &[f64]) -> f64 {
    (quantile(values, 0.995) - quantile(values, 0.005)) / 2.0
}

#[cfg(test)]
mod tests {
    use super::amplitude;

    #[test]
    fn val_a_sine_with_spikes_has_the_sines_amplitude() {
        let mut values: Vec<f64> = (0..5000)
            .map(|i| 3.0 * (0.01 * f64::from(i)).sin())
            .collect();
        values[77] = 1e3;
        assert!((amplitude(&values) - 3.0).abs() < 3e-3);
    }
}
