//! What an effect is expected to gain in evidence, from the score of its constants and the information on them.
//!
//! With g and H the score of a strength at zero and the information on it, all nuisances and start states projected out (Schur
//! complement), and s the standard deviation of the belief in the strength, the evidence gained is to first order
//!
//! ```text
//! 1/2 g^2 / (H + 1/s^2) - 1/2 ln(1 + s^2 H)
//! ```
//!
//! and for many values, each believed alike, the sum of that over the eigenvectors of H. The second part is the price of what is
//! free, that of Laplace's approximation. Source: MacKay, Neural Computation 4 (1992) 415, sect. 4.

use nalgebra::{DMatrix, DVector};

/// Expected gain of a strength or of values, their standard deviation on their own scale and the price of leaving them free.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gain {
    /// Gain in evidence, nats.
    pub gain: f64,
    /// Of a strength, what the data leave; of values, how far they spread where they gain most.
    pub std: f64,
    /// Price, nats.
    pub occam: f64,
}

/// That of parameter `c` with the belief `std`, all others projected out; one that can't be negative gains nothing where the
/// data pull it there, nor does one that leaves no trace in the data. `None` where the others are not determined.
pub(crate) fn gain(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    c: usize,
    std: f64,
    is_positive: bool,
) -> Option<Gain> {
    let (information, score) = projected(matrix, gradient, &[c])?;
    let (information, score) = (information[(0, 0)], score[0]);
    if !(information > 0.0) {
        let none = Gain {
            gain: 0.0,
            std: f64::INFINITY,
            occam: 0.0,
        };
        // Less than nothing is rounding of what is determined by the others.
        return (matrix[(c, c)] <= 0.0).then_some(none);
    }
    let score = if is_positive { score.max(0.0) } else { score };
    let occam = 0.5 * (std * std * information).ln_1p();
    Some(Gain {
        gain: 0.5 * score * score / (information + std.powi(-2)) - occam,
        std: information.sqrt().recip(),
        occam,
    })
}

/// Expected gain in evidence and fall of the objective by constants `curve` with standard normal beliefs, which `matrix` and
/// `gradient` hold already: `1/2 g' (H + 1)^-1 g - 1/2 ln det(H + 1)`, all others projected out.
pub(crate) fn gain_of_curve(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    curve: &[usize],
) -> Option<(f64, f64)> {
    let (information, score) = projected(matrix, gradient, curve)?;
    let factor = information.cholesky()?;
    let fall = 0.5 * score.dot(&factor.solve(&score));
    let occam: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
    Some((fall - occam, fall))
}

/// That of the constants `values`, of which `matrix` and `gradient` hold no belief yet, each believed to be normal about zero
/// with the standard deviation that gains most: `most`, halved as long as the data would tell any such value. `None` where the others
/// are not determined.
pub(crate) fn gain_of_profile(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    values: &[usize],
    most: f64,
) -> Option<Gain> {
    let (information, score) = projected(matrix, gradient, values)?;
    if information.iter().chain(&score).any(|v| !v.is_finite()) {
        return None;
    }
    let eigen = information.symmetric_eigen();
    let along = eigen.eigenvectors.tr_mul(&score);
    let modes = || {
        let modes = eigen.eigenvalues.iter().zip(&along);
        modes.filter(|(information, _)| **information > 0.0)
    };
    let at = |std: f64| {
        let occam = |information: &f64| 0.5 * (std * std * information).ln_1p();
        let fall = |(h, g): (&f64, &f64)| 0.5 * g * g / (h + std.powi(-2));
        let occam: f64 = modes().map(|(h, _)| occam(h)).sum();
        let gain = modes().map(fall).sum::<f64>() - occam;
        Gain { gain, std, occam }
    };
    let is_told = |std: f64| modes().any(|(h, _)| std * std * h > 1.0);
    let halved = |std: &f64| Some(0.5 * std).filter(|&std| is_told(std));
    let stds = std::iter::successors(Some(most), halved);
    stds.map(at).max_by(|a, b| a.gain.total_cmp(&b.gain))
}

/// Expected gain in evidence of a line that lowers the objective by `fall`, found among so many independent ones, with a phase
/// in each of so many runs: amplitude and phases are each known to `1/sqrt(2 fall)` of themselves.
pub(crate) fn gain_of_line(fall: f64, lines: f64, runs: usize) -> f64 {
    let constants = 1.0 + runs as f64;
    fall - 0.5 * constants * (2.0 * fall / constants).ln_1p() - lines.max(1.0).ln()
}

/// Information on the constants `own` and the score of each, all others projected out; `None` where those are not determined.
fn projected(
    matrix: &DMatrix<f64>,
    gradient: &DVector<f64>,
    own: &[usize],
) -> Option<(DMatrix<f64>, DVector<f64>)> {
    let mut is_own = vec![false; matrix.nrows()];
    own.iter().for_each(|&i| is_own[i] = true);
    let others: Vec<usize> = (0..matrix.nrows()).filter(|&i| !is_own[i]).collect();
    let scale = DVector::from_iterator(
        others.len(),
        others.iter().map(|&i| matrix[(i, i)].sqrt().recip()),
    );
    let scaled = DMatrix::from_fn(others.len(), others.len(), |i, j| {
        matrix[(others[i], others[j])] * scale[i] * scale[j]
    });
    let across = DMatrix::from_fn(others.len(), own.len(), |i, j| {
        matrix[(others[i], own[j])] * scale[i]
    });
    let factor = scaled.cholesky()?;
    let solved = factor.solve(&across);
    let information = matrix.select_rows(own).select_columns(own) - across.tr_mul(&solved);
    let score = gradient.select_rows(own)
        - solved.tr_mul(&gradient.select_rows(&others).component_mul(&scale));
    Some((information, score))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Source: Bayes' theorem for a straight line with known noise, evidence of slope and level against level alone.
    #[test]
    fn val_the_gain_is_the_evidence_of_a_linear_model() {
        let n = 40;
        let x: Vec<f64> = (0..n).map(|i| f64::from(i) / 10.0).collect();
        let y: Vec<f64> = x.iter().map(|x| 1.0 + 0.3 * x + (7.0 * x).sin()).collect();
        let design = DMatrix::from_fn(n as usize, 2, |i, j| if j == 0 { 1.0 } else { x[i] });
        let std = [2.0, 0.7];
        let believed =
            DMatrix::from_diagonal(&DVector::from_vec(vec![std[0] * std[0], std[1] * std[1]]));
        let data = DVector::from_vec(y);
        let evidence = |columns: usize| {
            let part = design.columns(0, columns).into_owned();
            let prior = believed.view((0, 0), (columns, columns)).into_owned();
            let covariance =
                DMatrix::identity(n as usize, n as usize) + &part * prior * part.transpose();
            let factor = covariance.cholesky().unwrap();
            let half_log: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
            -0.5 * data.dot(&factor.solve(&data)) - half_log
        };
        // At the optimum of the level alone.
        let level = design.column(0).dot(&data) / (f64::from(n) + std[0].powi(-2));
        let rest = &data - design.column(0) * level;
        let prior = DMatrix::from_diagonal(&DVector::from_vec(vec![std[0].powi(-2), 1e-12]));
        let matrix = design.tr_mul(&design) + prior;
        let mut gradient = design.tr_mul(&rest);
        gradient[0] -= level * std[0].powi(-2);
        let expected = evidence(2) - evidence(1);
        let found = gain(&matrix, &gradient, 1, std[1], false).unwrap().gain;
        assert!(
            (found - expected).abs() < 1e-9 * expected.abs(),
            "{found} {expected}"
        );
    }

    /// Source: Bayes' theorem for a straight line with known noise, evidence of two waves with standard normal weights beside a
    /// level against the level alone.
    #[test]
    fn val_the_gain_of_a_curve_is_the_evidence_of_a_linear_model() {
        let n = 40;
        let x: Vec<f64> = (0..n).map(|i| f64::from(i) / 10.0).collect();
        let data = DVector::from_fn(n as usize, |i, _| 1.0 + 0.8 * x[i].sin() - 0.3 * x[i].cos());
        let design = DMatrix::from_fn(n as usize, 3, |i, j| match j {
            0 => 1.0,
            1 => x[i].sin(),
            _ => x[i].cos(),
        });
        let level_std = 2.0_f64;
        let evidence = |columns: usize| {
            let part = design.columns(0, columns).into_owned();
            let mut prior = DMatrix::identity(columns, columns);
            prior[(0, 0)] = level_std.powi(2);
            let covariance =
                DMatrix::identity(n as usize, n as usize) + &part * prior * part.transpose();
            let factor = covariance.cholesky().unwrap();
            let half_log: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
            -0.5 * data.dot(&factor.solve(&data)) - half_log
        };
        // At the optimum of the level alone.
        let level = design.column(0).dot(&data) / (f64::from(n) + level_std.powi(-2));
        let rest = &data - design.column(0) * level;
        let beliefs = DVector::from_vec(vec![level_std.powi(-2), 1.0, 1.0]);
        let matrix = design.tr_mul(&design) + DMatrix::from_diagonal(&beliefs);
        let mut gradient = design.tr_mul(&rest);
        gradient[0] -= level * level_std.powi(-2);
        let (found, fall) = gain_of_curve(&matrix, &gradient, &[1, 2]).unwrap();
        let expected = evidence(3) - evidence(1);
        assert!(
            (found - expected).abs() < 1e-9 * expected.abs(),
            "{found} {expected}"
        );
        assert!(fall > found);
    }

    /// Source: Bayes' theorem for a straight line with known noise, evidence of three waves beside a level against the level alone, at
    /// each spread of their weights.
    #[test]
    fn val_the_gain_of_a_profile_is_the_evidence_at_the_spread_that_has_most() {
        let n = 60;
        let x: Vec<f64> = (0..n).map(|i| f64::from(i) / 10.0).collect();
        let wave = |j: usize, x: f64| (1.7 * j as f64 * x + 0.4).sin();
        let data = DVector::from_fn(n as usize, |i, _| {
            1.0 + 0.05 * wave(1, x[i]) - 0.06 * wave(3, x[i])
        }) * 20.0;
        let design = DMatrix::from_fn(n as usize, 4, |i, j| match j {
            0 => 20.0,
            _ => 20.0 * wave(j, x[i]),
        });
        let level_std = 2.0_f64;
        let evidence = |std: f64| {
            let mut prior = DMatrix::zeros(4, 4);
            prior[(0, 0)] = level_std.powi(2);
            (1..4).for_each(|i| prior[(i, i)] = std * std);
            let covariance =
                DMatrix::identity(n as usize, n as usize) + &design * prior * design.transpose();
            let factor = covariance.cholesky().unwrap();
            let half_log: f64 = factor.l().diagonal().iter().map(|d| d.ln()).sum();
            -0.5 * data.dot(&factor.solve(&data)) - half_log
        };
        let level =
            design.column(0).dot(&data) / (design.column(0).norm_squared() + level_std.powi(-2));
        let rest = &data - design.column(0) * level;
        let mut matrix = design.tr_mul(&design);
        matrix[(0, 0)] += level_std.powi(-2);
        let mut gradient = design.tr_mul(&rest);
        gradient[0] -= level * level_std.powi(-2);
        let found = gain_of_profile(&matrix, &gradient, &[1, 2, 3], 0.8).unwrap();
        let spreads: Vec<f64> = (0..8).map(|k| 0.8 * 0.5_f64.powi(k)).collect();
        let best = spreads
            .iter()
            .copied()
            .max_by(|a, b| evidence(*a).total_cmp(&evidence(*b)))
            .unwrap();
        assert_eq!(found.std, best);
        let expected = evidence(best) - evidence(0.0);
        assert!(
            (found.gain - expected).abs() < 1e-9 * expected.abs(),
            "{found:?} {expected}"
        );
    }

    #[test]
    fn what_leaves_no_trace_gains_nothing_and_is_not_told() {
        let matrix = DMatrix::from_diagonal(&DVector::from_vec(vec![4.0, 0.0]));
        let gradient = DVector::from_vec(vec![1.0, 0.0]);
        let found = gain(&matrix, &gradient, 1, 0.3, false).unwrap();
        assert_eq!((found.gain, found.occam), (0.0, 0.0));
        assert!(found.std.is_infinite());
        // Nothing determines the other.
        assert!(gain(&matrix, &gradient, 0, 0.3, false).is_none());
    }
}
