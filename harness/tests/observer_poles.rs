//! The paper's observer: matrix, gain, poles, and what it is worth on known forces.

mod rig;

use nalgebra::{Complex, DMatrix};
use rig::Rig;
use stickslip::observer::poles::{self, PoleRule, continuous_gain, discrete_gain, observer_matrix};
use stickslip::observer::{
    ForceModel, ObserverError, Settings, Structure, TimeForm, observe, smooth,
};

fn beam() -> Structure {
    Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap()
}

// Source: Stelter 1992, eq. (11), typed from the paper entry by entry.
#[test]
fn val_observer_matrix_is_equation_11() {
    let structure =
        Structure::from_lists(&[80.0, 510.0], &[0.02, 0.03], &[0.4, 0.5], &[2.0, -1.9]).unwrap();
    let (w1, w2) = (
        2.0 * std::f64::consts::PI * 80.0,
        2.0 * std::f64::consts::PI * 510.0,
    );
    let (d1, d2, phi1, phi2) = (0.02, 0.03, 2.0, -1.9);
    let (b2, b4) = (phi1 / 0.4, phi2 / 0.5);
    let v = nalgebra::DVector::from_vec(vec![3.0, -5.0, 7.0, 11.0, -13.0]);
    #[rustfmt::skip]
    let printed = DMatrix::from_row_slice(5, 5, &[
        -phi1 * v[0],           1.0,            -phi2 * v[0],           0.0,            0.0,
        -w1 * w1 - phi1 * v[1], -2.0 * d1 * w1, -phi2 * v[1],           0.0,            b2,
        -phi1 * v[2],           0.0,            -phi2 * v[2],           1.0,            0.0,
        -phi1 * v[3],           0.0,            -w2 * w2 - phi2 * v[3], -2.0 * d2 * w2, b4,
        -phi1 * v[4],           0.0,            -phi2 * v[4],           0.0,            0.0,
    ]);
    let found = observer_matrix(&structure, &v);
    for row in 0..5 {
        for column in 0..5 {
            let (a, b) = (found[(row, column)], printed[(row, column)]);
            assert!(
                (a - b).abs() <= 1e-14 * b.abs(),
                "entry {row}, {column}: {a} not {b}"
            );
        }
    }
}

// Source: trials with other software: condition of the observability matrix 1e19 in SI units, 2.7e2
// with scaled states and time in 1/sqrt(w_1 w_2).
#[test]
fn val_scaled_states_make_the_observability_matrix_well_conditioned() {
    let beam = beam();
    let a = poles::extended_matrix(&beam);
    let condition = |scale: [f64; 5], rate: f64| {
        let scaled = DMatrix::from_fn(5, 5, |i, j| a[(i, j)] * scale[j] / scale[i] / rate);
        let mut row =
            DMatrix::from_row_slice(1, 5, &[2.0 * scale[0], 0.0, -2.0 * scale[2], 0.0, 0.0]);
        let mut observability = DMatrix::zeros(5, 5);
        for k in 0..5 {
            observability.set_row(k, &row.row(0));
            row = &row * &scaled;
        }
        let values = observability.singular_values();
        values.max() / values.min()
    };
    let w: Vec<f64> = beam.modes().iter().map(|m| m.angular_frequency()).collect();
    let states = [1.0, w[0], 1.0, w[1], 1.0 / beam.force_scale()];
    let (raw, scaled) = (
        condition([1.0; 5], 1.0),
        condition(states, (w[0] * w[1]).sqrt()),
    );
    println!("condition {raw:.1e} in SI units, {scaled:.1e} scaled");
    assert!(raw > 1e16);
    assert!((scaled / 270.0 - 1.0).abs() < 0.05);
}

/// Largest coefficient error of the characteristic polynomial, scaled by the pole radius.
fn polynomial_error(matrix: &DMatrix<f64>, poles: &[Complex<f64>]) -> f64 {
    let radius = poles.iter().map(|p| p.norm()).fold(0.0, f64::max);
    let a = matrix / radius;
    let n = a.nrows();
    // Faddeev and LeVerrier.
    let mut found = vec![1.0];
    let mut m = DMatrix::<f64>::identity(n, n);
    for k in 1..=n {
        let am = &a * &m;
        let c = -am.trace() / k as f64;
        found.push(c);
        m = am + DMatrix::identity(n, n) * c;
    }
    let mut wanted = vec![Complex::new(1.0, 0.0)];
    for p in poles {
        wanted.push(Complex::new(0.0, 0.0));
        for i in (1..wanted.len()).rev() {
            let before = wanted[i - 1];
            wanted[i] -= before * p / radius;
        }
    }
    let size = wanted.iter().map(|c| c.norm()).fold(0.0, f64::max);
    found
        .iter()
        .zip(&wanted)
        .map(|(f, w)| (Complex::new(*f, 0.0) - w).norm() / size)
        .fold(0.0, f64::max)
}

// Source: the definition of pole assignment: det(s - A_B) = prod (s - p_k).
#[test]
fn val_poles_lie_where_asked_repeated_ones_too() {
    let beam = beam();
    for frequency_hz in [100.0, 500.0, 1500.0] {
        for rule in [
            PoleRule::Butterworth { frequency_hz },
            PoleRule::EqualReal { frequency_hz },
            PoleRule::AtZeros { frequency_hz },
        ] {
            let wanted = rule.poles(&beam, 5e-5, &[]).unwrap();
            // SI units scaled so that the polynomial can be formed at all.
            let gain = continuous_gain(&beam, &wanted).unwrap();
            let mut matrix = observer_matrix(&beam, &gain);
            let scale = [1.0, 503.0, 1.0, 3204.0, 1.0 / beam.force_scale()];
            for r in 0..5 {
                for c in 0..5 {
                    matrix[(r, c)] *= scale[c] / scale[r];
                }
            }
            let error = polynomial_error(&matrix, &wanted);
            println!("{rule:?}: {error:.1e}");
            assert!(error < 1e-10, "{rule:?}: {error:e}");
            // Discrete: A (I - K c) has the poles exp(p T).
            let k = discrete_gain(&beam, &wanted, 5e-5).unwrap();
            let model = beam
                .discretise(
                    ForceModel::RandomWalk,
                    5e-5,
                    stickslip::measurement::Measurand::Displacement,
                )
                .unwrap();
            let closed =
                &model.transition * (DMatrix::identity(5, 5) - &k * model.output.transpose());
            let z: Vec<_> = wanted.iter().map(|p| (p * 5e-5).exp()).collect();
            let error = polynomial_error(&closed, &z);
            assert!(error < 1e-10, "discrete {rule:?}: {error:e}");
        }
    }
}

// Source: closed form for equal participation, sqrt((f1^2 + f2^2)/2) = 365.04 Hz.
#[test]
fn val_transmission_zero_of_two_equal_modes() {
    let zeros = poles::transmission_zeros(&beam());
    let expected =
        2.0 * std::f64::consts::PI * ((80.0_f64.powi(2) + 510.0_f64.powi(2)) / 2.0).sqrt();
    assert_eq!(zeros.len(), 1);
    assert!((zeros[0] / expected - 1.0).abs() < 1e-12);
}

// Source: independent simulation (rig/); both forms of the observer are the same to first order,
// and the smoother beats the best of them.
#[test]
fn val_pole_placed_observer_on_the_default_case() {
    let record = Rig::default_case().run(0.5, 0.6, 20e3);
    let y = rig::noisy(&record.displacement, 60.0, 1);
    let mut best = f64::INFINITY;
    let mut report = |rule: &PoleRule| {
        let discrete = observe(&beam(), 5e-5, &y, rule, TimeForm::Discrete).unwrap();
        let continuous = observe(&beam(), 5e-5, &y, rule, TimeForm::Continuous).unwrap();
        let causal = rig::error(&discrete.force, &record.force);
        let shifted = rig::error(&discrete.force_without_delay(5e-5), &record.force);
        let other = rig::error(&continuous.force, &record.force);
        println!(
            "{rule:?}: causal {causal:.3} (continuous {other:.3}), delay taken out {shifted:.3}, delay {:.2e} s, radius {:.0} Hz",
            discrete.delay,
            discrete.poles[0].norm() / std::f64::consts::TAU
        );
        assert!((causal / other - 1.0).abs() < 0.1);
        best = best.min(causal).min(shifted);
        shifted
    };
    for frequency_hz in [150.0, 250.0, 350.0, 500.0, 700.0, 1000.0] {
        report(&PoleRule::Butterworth { frequency_hz });
        report(&PoleRule::EqualReal { frequency_hz });
        report(&PoleRule::AtZeros { frequency_hz });
    }
    let from_data = report(&PoleRule::FromData);
    assert!(from_data < 0.5);
    let smoothed = smooth(&beam(), 5e-5, &y, &Settings::default()).unwrap();
    assert!(rig::error(&smoothed.force, &record.force) < best);
}

// Source: the messages promised for bad input.
#[test]
fn val_bad_poles_are_refused() {
    let beam = beam();
    let left = Complex::new(-100.0, 0.0);
    let with = |p: Complex<f64>| PoleRule::Given(vec![left, left, left, left, p]);
    let fail = |rule: PoleRule| rule.poles(&beam, 5e-5, &[]).unwrap_err();
    assert!(matches!(
        fail(with(Complex::new(3.0, 0.0))),
        ObserverError::UnstablePole { index: 5, .. }
    ));
    assert!(matches!(
        fail(with(Complex::new(-3.0, 2.0))),
        ObserverError::UnpairedPole { .. }
    ));
    assert!(matches!(
        fail(PoleRule::Given(vec![left])),
        ObserverError::PoleCount {
            needed: 5,
            found: 1
        }
    ));
}
