//! Normalised root mean square error.

/// How far `model` is from `measured`, relative to how much `measured` moves.
///
/// ```text
/// NRMSE = sqrt( mean (y_i - m_i)^2 ) / sqrt( mean (m_i - mean m)^2 )
/// ```
///
/// `m` measured, `y` model, both in the same unit; the result has unit 1. 0 is a perfect match, 1 is as bad as a
/// constant, sqrt(2) is what two unrelated signals of equal size give. Not a number if `measured` does not move.
pub fn nrmse(measured: &[f64], model: &[f64]) -> f64 {
    assert_eq!(
        measured.len(),
        model.len(),
        "one model value per measured value"
    );
    let n = measured.len() as f64;
    let mean = measured.iter().sum::<f64>() / n;
    let spread: f64 = measured.iter().map(|m| (m - mean).powi(2)).sum();
    let error: f64 = measured
        .iter()
        .zip(model)
        .map(|(m, y)| (y - m).powi(2))
        .sum();
    (error / spread).sqrt()
}

#[cfg(test)]
mod tests {
    use super::nrmse;

    #[test]
    fn val_a_constant_at_the_mean_scores_one() {
        assert_eq!(nrmse(&[1.0, 2.0, 3.0], &[2.0, 2.0, 2.0]), 1.0);
    }

    #[test]
    fn val_a_perfect_match_scores_zero() {
        assert_eq!(nrmse(&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]), 0.0);
    }
}
