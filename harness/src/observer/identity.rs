//! Tests: the recursions against one dense Gaussian regression over the whole record.

use super::kernel::{self, Known, Problem, VaryingNoise};
use super::structure::{DiscreteModel, ForceModel, Structure};
use crate::measurement::Measurand;
use nalgebra::{DMatrix, DVector};

const N: usize = 120;

struct Case {
    model: DiscreteModel,
    noise: DMatrix<f64>,
    level: Vec<f64>,
    displacement: Vec<f64>,
    known: Vec<Known>,
    start: DVector<f64>,
    start_covariance: DMatrix<f64>,
}

fn case(force_model: ForceModel, gaps: bool, varying: bool, held: bool) -> Case {
    let structure = Structure::cantilever(&[80.0, 510.0], &[0.01, 0.02], 0.427).unwrap();
    let model = structure
        .discretise(force_model, 1e-4, Measurand::Displacement)
        .unwrap();
    let size = model.output.len();
    let last = model.noise.len() - 1;
    let intensity = if last == 1 { 1.0 } else { 100.0 };
    let displacement = (0..N)
        .map(|k| {
            if gaps && (k % 17 == 3 || (50..58).contains(&k)) {
                f64::NAN
            } else {
                (0.3 * k as f64).sin() + 0.5 * (1.7 * k as f64).cos() + 0.2
            }
        })
        .collect();
    let known = (0..N)
        .map(|k| match k {
            30..70 if held => Known::velocity(500.0, 1e3),
            80..90 if held => Known {
                velocity: 1.0,
                force: 200.0,
                value: 400.0,
                variance: 2e3,
            },
            _ => Known::NOTHING,
        })
        .collect();
    let level = (0..N)
        .map(|k| {
            if varying {
                intensity * (k % 7) as f64
            } else {
                0.0
            }
        })
        .collect();
    Case {
        noise: &model.noise[last] * intensity,
        level,
        displacement,
        known,
        start: DVector::from_element(size, 0.1),
        start_covariance: DMatrix::identity(size, size),
        model,
    }
}

/// Posterior mean (all states) and variances of force, displacement and velocity.
///
/// Cov(z_i, z_j) = A^(i-j) P_j for i >= j; measurements are rows of z plus noise, so the posterior
/// is one dense regression (Rasmussen and Williams 2006, eq. 2.19); its likelihood, eq. 2.30.
fn dense(case: &Case, r: f64) -> (DVector<f64>, Vec<[f64; 3]>, f64) {
    let a = &case.model.transition;
    let size = case.start.len();
    let mut cov = DMatrix::zeros(N * size, N * size);
    let mut mean = DVector::zeros(N * size);
    let (mut p, mut m) = (case.start_covariance.clone(), case.start.clone());
    for j in 0..N {
        mean.rows_mut(j * size, size).copy_from(&m);
        let mut block = p.clone();
        for i in j..N {
            cov.view_mut((i * size, j * size), (size, size))
                .copy_from(&block);
            cov.view_mut((j * size, i * size), (size, size))
                .copy_from(&block.transpose());
            block = a * block;
        }
        let extra = case.model.noise.last().unwrap() * case.level[j];
        p = a * p * a.transpose() + &case.noise + extra;
        m = a * m;
    }
    let row_of = |known: &Known| {
        let mut row = &case.model.velocity * known.velocity;
        row[case.model.force_index] += known.force;
        row
    };
    let mut rows = Vec::new();
    for k in 0..N {
        if !case.displacement[k].is_nan() {
            rows.push((k, case.model.output.clone(), case.displacement[k], r));
        }
        let known = &case.known[k];
        if known.is_something() {
            rows.push((k, row_of(known), known.value, known.variance));
        }
    }
    let mut h = DMatrix::zeros(rows.len(), N * size);
    let mut y = DVector::zeros(rows.len());
    let mut noise = DVector::zeros(rows.len());
    for (row, (k, c, value, variance)) in rows.iter().enumerate() {
        h.view_mut((row, k * size), (1, size))
            .copy_from(&c.transpose());
        y[row] = *value;
        noise[row] = *variance;
    }
    let ph = &cov * h.transpose();
    let s = &h * &ph + DMatrix::from_diagonal(&noise);
    let residual = y - &h * &mean;
    let cholesky = s.cholesky().unwrap();
    let post = &mean + &ph * cholesky.solve(&residual);
    let post_cov = &cov - &ph * cholesky.solve(&ph.transpose());
    let mut unit = DVector::zeros(size);
    unit[case.model.force_index] = 1.0;
    let variances = (0..N)
        .map(|k| {
            let block = post_cov.view((k * size, k * size), (size, size));
            [&unit, &case.model.output, &case.model.velocity]
                .map(|u| (u.transpose() * block * u)[(0, 0)])
        })
        .collect();
    let deviance = residual.dot(&cholesky.solve(&residual)) + cholesky.determinant().ln();
    (post, variances, deviance)
}

fn compare(force_model: ForceModel, gaps: bool, varying: bool, held: bool, converge: bool) {
    let case = case(force_model, gaps, varying, held);
    let r = 0.01;
    let (states, variances, deviance) = dense(&case, r);
    let problem = Problem {
        model: &case.model,
        noise: case.noise.clone(),
        varying: if varying {
            vec![VaryingNoise {
                unit: case.model.noise.last().unwrap(),
                level: &case.level,
            }]
        } else {
            Vec::new()
        },
        measurement_variance: r,
        measured: &case.displacement,
        known: held.then_some(&case.known[..]),
        start: case.start.clone(),
        start_covariance: case.start_covariance.clone(),
        converge,
    };
    let found = kernel::smooth(&problem, false);
    let scale = states.amax();
    let worst = (0..states.len())
        .map(|i| (found.states[i] - states[i]).abs() / scale)
        .fold(0.0, f64::max);
    // The dense matrix of the integrated walk is conditioned ten times worse.
    let bound = [5e-11, 5e-10][force_model.state_count() - 1];
    assert!(worst < bound, "states {worst:e}");
    for (output, column) in found.variance.iter().enumerate() {
        for k in 0..N {
            let truth = variances[k][output];
            assert!(
                (column[k] / truth - 1.0).abs() < 1e-6,
                "variance {output} at {k}"
            );
        }
    }
    if !held {
        let terms = kernel::likelihood(&problem);
        assert!(((terms.sum_log + terms.sum_square) / deviance - 1.0).abs() < 1e-9);
    }
}

// Source: Gaussian regression in one dense solve (Rasmussen and Williams 2006, eq. 2.19).
#[test]
fn val_smoother_equals_dense_regression() {
    for force_model in [ForceModel::RandomWalk, ForceModel::IntegratedRandomWalk] {
        for gaps in [false, true] {
            for varying in [false, true] {
                for held in [false, true] {
                    compare(force_model, gaps, varying, held, false);
                }
            }
        }
    }
}

// Source: the same; the converged gain may change nothing.
#[test]
fn val_converged_gain_equals_dense_regression() {
    compare(ForceModel::RandomWalk, false, false, false, true);
    compare(ForceModel::RandomWalk, true, false, true, true);
}
