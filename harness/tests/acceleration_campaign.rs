//! Campaigns of tip accelerations, as an accelerometer gives them, through the commands.
//!
//! The motions come from rig/, an independent simulation in which nothing is missing.

mod rig;

use rig::campaign::{POINTS, disturbed, json, motions, stickslip, with_noise};
use std::path::Path;
use stickslip::check::{Severity, check};
use stickslip::measurement::Campaign;

/// Standard deviation of the sensor's noise in m/s^2, and its offset.
const NOISE: f64 = 0.2;
const OFFSET: f64 = 0.03;

fn write(folder: &Path, runs: &[Vec<f64>]) {
    rig::campaign::write(folder, "acceleration_column", "a", runs);
}

fn noisy(values: &[f64], seed: u64) -> Vec<f64> {
    with_noise(values, OFFSET, NOISE, seed)
}

fn accelerations(duration: f64) -> Vec<Vec<f64>> {
    disturbed(&motions(duration), |r| &r.acceleration, OFFSET, NOISE)
}

// Source: independent simulation (rig/).
#[test]
fn val_accelerations_are_checked_as_what_they_are() {
    type Spoil<'a> = &'a dyn Fn(&rig::Record) -> Vec<f64>;
    let runs = motions(0.6);
    let of = |values: Spoil| {
        let folder = tempfile::tempdir().unwrap();
        let values: Vec<Vec<f64>> = runs.iter().map(values).collect();
        write(folder.path(), &values);
        check(&Campaign::load(folder.path()).unwrap())
    };
    let good = of(&|r| noisy(&r.acceleration, 1));
    assert!(good.findings.is_empty(), "{:?}", good.findings);
    for (run, (belt, _)) in good.runs.iter().zip(POINTS) {
        // By a mean velocity of zero, over a record of some twenty cycles.
        let speed = run.stick_speed_m_per_s.unwrap();
        assert!((speed / belt - 1.0).abs() < 0.1, "{speed} for {belt}");
        assert!(run.mean_friction.is_none());
    }
    let spoilt: [(&str, Spoil, &str); 3] = [
        (
            "acceleration_in_g",
            &|r| {
                let a = noisy(&r.acceleration, 1);
                a.iter().map(|v| v / 9.806_65).collect()
            },
            "acceleration_scale",
        ),
        (
            "velocity",
            &|r| with_noise(&r.velocity, 0.0, 1e-4, 1),
            "velocity_column",
        ),
        (
            "sign",
            &|r| noisy(&r.acceleration, 1).iter().map(|v| -v).collect(),
            "acceleration_scale",
        ),
    ];
    for (id, values, remedy) in spoilt {
        let found = of(values).findings;
        let finding = found.iter().find(|f| f.id == id);
        let finding = finding.unwrap_or_else(|| panic!("{id}: {found:?}"));
        assert_eq!(finding.severity, Severity::Error);
        assert!(finding.remedy.contains(remedy), "{}", finding.remedy);
    }
}

// Source: independent simulation (rig/), in which nothing is missing.
#[test]
fn val_the_model_of_a_rig_meets_its_accelerations() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &accelerations(0.6));
    let found = json(&stickslip(&["compare", ".", "--json"], folder.path()));
    let runs = found["runs"].as_array().unwrap();
    assert_eq!(runs.len(), POINTS.len());
    for run in runs {
        let noise = run["noise_std_m_per_s2"].as_f64().unwrap();
        assert!((noise / NOISE - 1.0).abs() < 0.2, "{noise}");
        assert!(run.get("noise_std_m").is_none());
        let of = |who: &str| run[who]["stick_fraction"].as_f64().unwrap();
        assert!((of("model") - of("measured")).abs() < 0.05, "{run:#}");
    }
    let page = std::fs::read_to_string(folder.path().join("comparison/report.html")).unwrap();
    assert!(page.contains("tip acceleration") && page.contains("mm/s^2"));
}

// Source: independent simulation (rig/), in which nothing is missing.
#[test]
fn val_nothing_is_claimed_of_accelerations_in_which_nothing_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &accelerations(0.4));
    let found = json(&stickslip(&["diagnose", ".", "--json"], folder.path()));
    assert_eq!(found["verdict"], "no_missing_effect", "{found:#}");
    assert_eq!(found["measured_quantity"], "acceleration");
    assert!(found["noise_std_m_per_s2"].as_f64().unwrap() < 2.0 * NOISE);
}
