//! Bad input gives a clear message, gaps and clipping are bridged, offset and drift are reported.

mod rig;

use rig::Rig;
use stickslip::observer::{
    BeltVelocity, BinSettings, Contact, NormalForce, ObserverError, Settings, Structure,
    UniformRecord, drift, friction_characteristic, offset_from_symmetry, smooth, smooth_stick_slip,
};

fn beam() -> Structure {
    Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap()
}

fn wave(count: usize) -> Vec<f64> {
    (0..count).map(|k| 1e-3 * (0.05 * k as f64).sin()).collect()
}

fn refused(displacement: &[f64], interval: f64) -> ObserverError {
    smooth(&beam(), interval, displacement, &Settings::default()).unwrap_err()
}

// Source: issue text, "bad input: ... a clear message".
#[test]
fn val_bad_records_are_refused_with_value_unit_and_action() {
    let slow = refused(&wave(1000), 1e-3);
    assert!(matches!(
        slow,
        ObserverError::SamplingTooSlow { mode: 2, .. }
    ));
    let text = slow.to_string();
    assert!(
        text.contains("1000.0 Hz") && text.contains("510 Hz") && text.contains("1275.0 Hz"),
        "{text}"
    );
    assert!(matches!(
        refused(&wave(10), 5e-5),
        ObserverError::TooFewSamples { found: 10, .. }
    ));
    assert!(matches!(
        refused(&[0.5; 100], 5e-5),
        ObserverError::ConstantSignal { .. }
    ));
    assert!(matches!(
        refused(&wave(100), 0.0),
        ObserverError::BadSampleInterval { .. }
    ));
    let mut infinite = wave(100);
    infinite[7] = f64::INFINITY;
    assert!(matches!(
        refused(&infinite, 5e-5),
        ObserverError::InfiniteSample { index: 7, .. }
    ));
    let hidden = Structure::from_lists(&[80.0, 510.0], &[0.01, 0.01], &[0.4, 0.4], &[2.0, 0.0]);
    let text = hidden.unwrap_err().to_string();
    assert!(
        text.contains("mode 2") && text.contains("unobservable"),
        "{text}"
    );
    let belt = [0.1; 3];
    let short = smooth_stick_slip(
        &beam(),
        5e-5,
        &wave(1000),
        BeltVelocity::Sampled(&belt),
        &Default::default(),
    );
    assert!(matches!(
        short.unwrap_err(),
        ObserverError::LengthMismatch { found: 3, .. }
    ));
}

// Source: independent simulation (rig/); 4 % of the samples missing, in gaps and one by one.
#[test]
fn val_gaps_and_untrusted_samples_are_bridged() {
    let record = Rig::default_case().run(0.5, 0.5, 20e3);
    let y = rig::noisy(&record.displacement, 80.0, 1);
    let trusted: Vec<bool> = (0..y.len()).map(|k| k % 50 != 7).collect();
    let gap = |k: usize| k % 2000 >= 1960;
    let kept: Vec<usize> = (0..y.len()).filter(|k| !gap(*k)).collect();
    let time: Vec<f64> = kept.iter().map(|k| 3.0 + *k as f64 * 5e-5).collect();
    let values: Vec<f64> = kept.iter().map(|k| y[*k]).collect();
    let flags: Vec<bool> = kept.iter().map(|k| trusted[*k]).collect();
    let grid = UniformRecord::of(&time, &values, Some(&flags)).unwrap();
    assert!((grid.interval / 5e-5 - 1.0).abs() < 1e-9 && (grid.start - 3.0).abs() < 1e-9);
    assert!(grid.missing > 300);
    let belt = BeltVelocity::Constant(0.1);
    let found =
        smooth_stick_slip(&beam(), 5e-5, &grid.measured, belt, &Default::default()).unwrap();
    let n = grid.measured.len();
    let error = rig::error(&found.smoothed.force, &record.force[..n]);
    println!("force error with gaps {error:.4}");
    assert!(error < 0.1);
}

// Source: definition of a uniform grid.
#[test]
fn val_uneven_and_falling_time_is_refused() {
    let y = wave(100);
    let mut time: Vec<f64> = (0..100).map(|k| k as f64 * 1e-3).collect();
    time[40] += 4e-4;
    let uneven = UniformRecord::of(&time, &y, None).unwrap_err();
    assert!(matches!(
        uneven,
        ObserverError::UnevenSampling { index: 40, .. }
    ));
    time[40] = 0.0;
    let falling = UniformRecord::of(&time, &y, None).unwrap_err();
    assert!(matches!(
        falling,
        ObserverError::TimeNotRising { index: 40, .. }
    ));
}

// Source: independent simulation (rig/) with a drift of 2 mm/s and an offset of 0.2 mm put on.
#[test]
fn val_drift_and_offset_are_found() {
    let record = Rig::default_case().run(0.5, 1.0, 20e3);
    let y = rig::noisy(&record.displacement, 80.0, 1);
    let slow = drift(&y, 5e-5).unwrap();
    assert!(!slow.is_significant(), "{slow:?}");
    let drifting: Vec<f64> = (0..y.len())
        .map(|k| y[k] + 2e-3 * 5e-5 * k as f64)
        .collect();
    let found = drift(&drifting, 5e-5).unwrap();
    assert!(
        found.is_significant() && (found.value - 2e-3).abs() < 3.0 * found.std + 1e-4,
        "{found:?}"
    );

    // A plucked beam slips in both directions until friction has stopped it.
    let plucked = Rig {
        belt_velocity: 0.01,
        ..Rig::default_case()
    };
    let record = plucked.run_from(vec![0.02, 0.0, 0.0, 0.0], 0.0, 0.2, 20e3);
    let y = rig::noisy(&record.displacement, 80.0, 1);
    let shifted: Vec<f64> = y.iter().map(|y| y + 2e-4).collect();
    let belt = BeltVelocity::Constant(0.01);
    let smoothed = smooth_stick_slip(&beam(), 5e-5, &shifted, belt, &Default::default()).unwrap();
    let normal_force = NormalForce::Constant(100.0);
    let contact = Contact {
        relative_velocity: &smoothed.relative_velocity,
        force: &smoothed.smoothed.force,
        normal_force,
        phases: &smoothed.phases,
    };
    let bins = friction_characteristic(&contact, &BinSettings::default()).unwrap();
    let offset = offset_from_symmetry(&beam(), &bins, normal_force).unwrap();
    println!("{offset:?}");
    assert!((offset.value - 2e-4).abs() < 3.0 * offset.std + 2e-5);
}

// Source: independent simulation (rig/) with a third mode at 1428 Hz that the structure lacks.
#[test]
fn val_missing_mode_shows_in_the_innovation() {
    let mut rig = Rig::default_case();
    let plain = rig.run(0.5, 0.8, 20e3);
    rig.frequencies_hz.push(1428.0);
    rig.damping_ratios.push(0.001);
    rig.tip_values.push(2.0);
    let three = rig.run(0.5, 0.8, 20e3);
    let white = |record: &rig::Record| {
        let y = rig::noisy(&record.displacement, 60.0, 1);
        smooth(&beam(), 5e-5, &y, &Settings::default())
            .unwrap()
            .whiteness
    };
    assert!(white(&plain).acceptable());
    let found = white(&three);
    println!(
        "{} at {} Hz",
        found.largest_autocorrelation(),
        found.peak_frequency_hz
    );
    assert!(!found.acceptable());
    assert!((found.peak_frequency_hz / 1428.0 - 1.0).abs() < 0.05);
}
