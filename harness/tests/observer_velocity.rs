//! The smoother on a measured velocity or acceleration, against an independent truth.

mod rig;

use rig::Rig;
use stickslip::measurement::Measurand;
use stickslip::metric::rest;
use stickslip::observer::{
    BeltVelocity, Settings, StickSlipSettings, Structure, smooth_stick_slip,
};

fn beam() -> Structure {
    Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap()
}

/// The values less their mean: a velocity leaves a constant open.
fn about_the_mean(values: &[f64]) -> Vec<f64> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|v| v - mean).collect()
}

// Source: independent simulation (rig/); noise as a laser vibrometer has it at 0.1 m/s.
#[test]
fn val_force_displacement_and_phases_follow_from_a_velocity_but_for_their_level() {
    let record = Rig::default_case().run(0.5, 1.0, 20e3);
    for (noise, bound) in [(5e-5, 0.055), (5e-4, 0.055)] {
        let mut random = rig::Noise::new(3);
        let noisy = |v: &f64| v + noise * random.normal();
        let y: Vec<f64> = record.velocity.iter().map(noisy).collect();
        let belt = BeltVelocity::Constant(0.10);
        // Beside a force that jumps, so small a noise can't be told by the smoother itself.
        let settings = StickSlipSettings {
            smoother: Settings {
                measurand: Measurand::Velocity,
                noise_std: Some(noise),
                ..Settings::default()
            },
            ..StickSlipSettings::default()
        };
        let found = smooth_stick_slip(&beam(), 5e-5, &y, belt, &settings).unwrap();
        let smoothed = &found.smoothed;
        let error = |found: &[f64], truth: &[f64]| {
            rig::error(&about_the_mean(found), &about_the_mean(truth))
        };
        let force = error(&smoothed.force, &record.force);
        let displacement = error(&smoothed.displacement, &record.displacement);
        println!("{noise} m/s: force {force:.4}, displacement {displacement:.4}");
        assert!(force < bound, "{noise} m/s: {force}");
        assert!(displacement < 0.01, "{noise} m/s: {displacement}");
        assert_eq!(found.phases.len(), record.transitions.len() + 1);
        // The level stays near that of the start, zero: the filter does not run away.
        let size = record.force.iter().fold(0.0, |a: f64, f| a.max(f.abs()));
        let level = smoothed.force.iter().sum::<f64>() / smoothed.force.len() as f64;
        assert!(level.abs() < 3.0 * size, "{level} N");
    }
}

// Source: independent simulation (rig/); noise as a piezoelectric accelerometer has it.
#[test]
fn val_motion_and_phases_follow_from_an_acceleration_and_where_it_rests() {
    let record = Rig::default_case().run(0.5, 1.0, 1e4);
    for noise in [0.05, 0.4] {
        let mut random = rig::Noise::new(3);
        let noisy = |a: &f64| a + noise * random.normal();
        let y: Vec<f64> = record.acceleration.iter().map(noisy).collect();
        // A quarter of a period of 80 Hz.
        let resting = rest(&y, noise, 31).unwrap();
        let settings = StickSlipSettings {
            smoother: Settings {
                measurand: Measurand::Acceleration,
                noise_std: Some(noise),
                offset: resting.offset,
                ..Settings::default()
            },
            known_stick: Some(resting.on),
            // 0.4 times the load, as well known as that in a period of 125 samples.
            expected_force: Some((40.0, 40.0 * 125.0_f64.sqrt())),
            ..StickSlipSettings::default()
        };
        let belt = BeltVelocity::Constant(0.10);
        let found = smooth_stick_slip(&beam(), 1e-4, &y, belt, &settings).unwrap();
        let smoothed = &found.smoothed;
        let velocity = rig::error(&smoothed.velocity, &record.velocity);
        let displacement = rig::error(
            &about_the_mean(&smoothed.displacement),
            &about_the_mean(&record.displacement),
        );
        println!("{noise} m/s^2: velocity {velocity:.4}, displacement {displacement:.4}");
        assert!(velocity < 0.02, "{noise} m/s^2: {velocity}");
        // An acceleration leaves its slow part to what is expected of the force.
        assert!(displacement < 0.1, "{noise} m/s^2: {displacement}");
        assert_eq!(found.phases.len(), record.transitions.len() + 1);
    }
}
