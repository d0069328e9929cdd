//! A sensor that looks at the beam elsewhere than where it rubs.
//!
//! Source of the motions: rig/, an independent simulation of the reference model, in which nothing is missing. Mode shapes there: values
//! of the clamped-free beam at 0.7 of its length over those at its end, evaluated from the formula of Blevins 1979, table 8-1.

mod rig;

use rig::Rig;
use rig::campaign::{json, motions, stickslip, with_noise};
use std::path::Path;
use stickslip::measurement::Campaign;
use stickslip::observer::{
    BeltVelocity, Settings, StickSlipSettings, Structure, smooth_stick_slip,
};

/// Ratios of the first two modes at 0.7 of the length.
const RATIOS: [f64; 2] = [0.590_876_298_1, -0.317_051_798_8];
/// Standard deviation of the sensor's noise in m.
const NOISE: f64 = 3e-7;

/// What the sensor reads of a record, without noise.
fn seen(record: &rig::Record) -> Vec<f64> {
    let tips = Rig::default_case().tip_values;
    let at = |k: usize| {
        let modes = RATIOS.iter().zip(&tips).zip(&record.q);
        modes.map(|((ratio, tip), q)| ratio * tip * q[k]).sum()
    };
    (0..record.displacement.len()).map(at).collect()
}

/// A campaign of such readings with these lines of campaign.toml.
fn write(folder: &Path, duration: f64, sensor: &str) {
    let runs: Vec<Vec<f64>> = motions(duration)
        .iter()
        .zip(1..)
        .map(|(record, seed)| with_noise(&seen(record), 0.0, NOISE, seed))
        .collect();
    rig::campaign::write(folder, "displacement_column", "w", &runs);
    let file = folder.join("campaign.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(file, format!("{sensor}\n{text}")).unwrap();
}

#[test]
fn val_force_motion_and_phases_at_the_tip_follow_from_a_sensor_elsewhere() {
    let record = Rig::default_case().run(0.5, 1.0, 20e3);
    let y = with_noise(&seen(&record), 0.0, NOISE, 5);
    let beam = Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap();
    let beam = beam.with_sensor(&RATIOS).unwrap();
    let settings = StickSlipSettings {
        smoother: Settings {
            noise_std: Some(NOISE),
            ..Settings::default()
        },
        ..StickSlipSettings::default()
    };
    let belt = BeltVelocity::Constant(0.10);
    let found = smooth_stick_slip(&beam, 5e-5, &y, belt, &settings).unwrap();
    let smoothed = &found.smoothed;
    let force = rig::error(&smoothed.force, &record.force);
    let displacement = rig::error(&smoothed.displacement, &record.displacement);
    println!("force {force:.4}, displacement {displacement:.5}");
    // At the tip itself, the same noise leaves 0.06 of the force.
    assert!(force < 0.1, "{force}");
    assert!(displacement < 2e-3, "{displacement}");
    assert_eq!(found.phases.len(), record.transitions.len() + 1);
}

#[test]
fn val_the_model_meets_a_sensor_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.6, "[sensor]\nposition = 0.7");
    let compared = json(&stickslip(&["compare", ".", "--json"], folder.path()));
    for run in compared["runs"].as_array().unwrap() {
        assert!(run["nrmse"].as_f64().unwrap() < 0.05, "{run:#}");
        // Stick does not show there.
        assert!(run["measured"]["stick_fraction"].is_null(), "{run:#}");
    }
}

#[test]
fn val_nothing_is_claimed_of_a_sensor_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.3, "[sensor]\nposition = 0.7");
    let found = json(&stickslip(&["diagnose", ".", "--json"], folder.path()));
    assert_eq!(found["verdict"], "no_missing_effect", "{found:#}");
    let ladder = found["error_ladder"].as_array().unwrap();
    let left = ladder[1]["holdout_over_noise"].as_f64().unwrap();
    assert!(left < 1.5, "{left} times the noise");
    let written = std::fs::read_to_string(folder.path().join("diagnosis/model.toml")).unwrap();
    assert!(written.contains("mode[2].sensor_ratio"), "{written}");
}

#[test]
fn val_observe_finds_the_belt_and_the_friction_from_a_sensor_elsewhere() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.6, "[sensor]\nposition = 0.7");
    let observe = |words: &[&str]| {
        let all = [&["observe", "run1.csv", "--campaign", "."][..], words].concat();
        stickslip(&all, folder.path())
    };
    let found = json(&observe(&["--json"]));
    let speed = found["belt_velocity_in_stick"]["value_m_per_s"]
        .as_f64()
        .unwrap();
    assert!((speed / 0.1 - 1.0).abs() < 5e-3, "{found:#}");
    let friction = found["break_away"]["mu_mean"].as_f64().unwrap();
    let truth = Rig::default_case().mu_0;
    assert!((friction / truth - 1.0).abs() < 0.05, "{friction}");
    let refused = observe(&["--method", "pole"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{said}");
    assert!(said.contains("use the smoother"), "{said}");
}

#[test]
fn a_place_gives_the_ratios_of_a_cantilever() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.1, "[sensor]\nposition = 0.7");
    let sensor = Campaign::load(folder.path()).unwrap().beam.sensor;
    for (found, expected) in sensor.ratios.iter().zip(RATIOS) {
        assert!((found - expected).abs() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn a_place_that_cannot_be_is_refused_with_its_line_and_what_to_do() {
    for (sensor, said) in [
        ("[sensor]\nposition = 70", "to 1"),
        ("[sensor]\nposition = 0", "nothing moves"),
        ("[sensor]\nmode_ratios = [0.0, 0.0]", "sees no mode"),
        ("[sensor]\nmode_ratios = [0.6]", "has 1"),
        (
            "[sensor]\nposition = 0.7\nmode_ratios = [0.6, -0.5]",
            "keep position for a uniform cantilever",
        ),
        (
            "[sensor]\nposition_std = 0.01",
            "give position or mode_ratios",
        ),
        ("[sensor]\nplace = 0.7", "unknown field `place`"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), 0.1, sensor);
        let error = Campaign::load(folder.path()).unwrap_err().to_string();
        assert!(error.contains(said), "{sensor}: {error}");
    }
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.1, "[sensor]\nposition = 0.7");
    let file = folder.path().join("campaign.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(
        &file,
        text.replace("displacement_column", "acceleration_column"),
    )
    .unwrap();
    let error = Campaign::load(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("put the accelerometer at the tip"),
        "{error}"
    );
}
