//! Campaigns of tip velocities, as a laser vibrometer gives them, through the commands.
//!
//! Motions in which nothing is missing come from rig/, an independent simulation; those with an effect from the FMU.

mod rig;

use rig::campaign::{POINTS, RATE, disturbed, json, motions, stickslip, with_noise};
use std::path::Path;
use stickslip::check::{Severity, check};
use stickslip::measurement::Campaign;

/// Standard deviation of the sensor's noise in m/s.
const NOISE: f64 = 1e-4;

fn write(folder: &Path, runs: &[Vec<f64>]) {
    rig::campaign::write(folder, "velocity_column", "v", runs);
}

fn noisy(values: &[f64], seed: u64) -> Vec<f64> {
    with_noise(values, 0.0, NOISE, seed)
}

fn velocities(duration: f64) -> Vec<Vec<f64>> {
    disturbed(&motions(duration), |r| &r.velocity, 0.0, NOISE)
}

// Source: independent simulation (rig/).
#[test]
fn val_velocities_are_checked_as_what_they_are() {
    type Spoil<'a> = &'a dyn Fn(&rig::Record) -> Vec<f64>;
    let runs = motions(0.6);
    let of = |values: Spoil| {
        let folder = tempfile::tempdir().unwrap();
        let values: Vec<Vec<f64>> = runs.iter().map(values).collect();
        write(folder.path(), &values);
        check(&Campaign::load(folder.path()).unwrap())
    };
    let good = of(&|r| noisy(&r.velocity, 1));
    assert!(good.findings.is_empty(), "{:?}", good.findings);
    for (run, (belt, _)) in good.runs.iter().zip(POINTS) {
        let speed = run.stick_speed_m_per_s.unwrap();
        assert!((speed / belt - 1.0).abs() < 5e-3, "{speed} for {belt}");
        assert!(run.mean_friction.is_none());
    }
    for (run, record) in good.runs.iter().zip(&runs) {
        let w = &record.displacement;
        let range =
            w.iter().fold(f64::MIN, |a, v| a.max(*v)) - w.iter().fold(f64::MAX, |a, v| a.min(*v));
        // The integral about the mean velocity leaves out the line from the first to the last
        // displacement; the outermost percent is left out too.
        let line = (w[w.len() - 1] - w[0]).abs();
        let off = (run.range_m - range).abs();
        assert!(off < line + 0.05 * range, "{} for {range}", run.range_m);
    }
    let spoilt: [(&str, Spoil, &str); 4] = [
        (
            "velocity_in_mm_per_s",
            &|r| noisy(&r.velocity, 1).iter().map(|v| 1e3 * v).collect(),
            "velocity_scale",
        ),
        (
            "displacement",
            &|r| with_noise(&r.displacement, 0.0, 5e-7, 1),
            "displacement_column",
        ),
        (
            "acceleration",
            &|r| {
                let steps = r.velocity.windows(2);
                noisy(
                    &steps.map(|v| (v[1] - v[0]) * RATE).collect::<Vec<f64>>(),
                    1,
                )
            },
            "velocity_column",
        ),
        (
            "sign",
            &|r| noisy(&r.velocity, 1).iter().map(|v| -v).collect(),
            "velocity_scale",
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
fn val_the_model_of_a_rig_meets_its_velocities() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &velocities(0.6));
    let found = json(&stickslip(&["compare", ".", "--json"], folder.path()));
    let runs = found["runs"].as_array().unwrap();
    assert_eq!(runs.len(), POINTS.len());
    for run in runs {
        assert!(run["nrmse"].as_f64().unwrap() < 0.05, "{run:#}");
        let noise = run["noise_std_m_per_s"].as_f64().unwrap();
        assert!((noise / NOISE - 1.0).abs() < 0.2, "{noise}");
        assert!(run.get("noise_std_m").is_none());
        let of = |who: &str| run[who]["stick_fraction"].as_f64().unwrap();
        assert!((of("model") - of("measured")).abs() < 0.05, "{run:#}");
    }
    let page = std::fs::read_to_string(folder.path().join("comparison/report.html")).unwrap();
    assert!(page.contains("tip velocity") && page.contains("mm/s"));
    assert!(page.contains("Nothing measured contradicts"));
}

// Source: independent simulation (rig/), in which nothing is missing.
#[test]
fn val_nothing_is_claimed_of_velocities_in_which_nothing_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("001")).unwrap();
    write(&folder.path().join("001"), &velocities(0.4));
    let truth = r#"[{"campaign": "001", "effects": []}]"#;
    std::fs::write(folder.path().join("truth.json"), truth).unwrap();
    let counted = json(&stickslip(&["blind-test", ".", "--json"], folder.path()));
    assert_eq!(counted["campaigns"][0]["right"], true, "{counted:#}");
    let diagnosis = folder.path().join("blind-test/001/diagnosis.json");
    let found = std::fs::read_to_string(diagnosis).unwrap();
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    assert_eq!(found["verdict"], "no_missing_effect", "{found:#}");
    assert_eq!(found["measured_quantity"], "velocity");
    assert!(found["noise_std_m_per_s"].as_f64().unwrap() < 2.0 * NOISE);
    let said = found["remarks"].to_string();
    assert!(
        said.contains("sensor of displacements alone") && said.contains("sensor_lag"),
        "{said}"
    );
    assert!(
        found["forecast"][0]["amplitude_m_per_s"]["measured"].is_number(),
        "{found:#}"
    );
}

/// Velocities of the FMU with a hardening spring at its tip.
const HARDENING: f64 = 4e8;

// Source: the coefficient that the motions were made with.
#[test]
fn val_a_hidden_spring_is_found_in_velocities_tried_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let runs: Vec<Vec<f64>> = POINTS
        .iter()
        .zip(1..)
        .map(|((belt, force), seed)| {
            let (belt, force) = (belt.to_string(), force.to_string());
            let spring = format!("cubic_stiffness.coefficient={HARDENING}");
            let output = stickslip(
                &[
                    "simulate",
                    "--belt-velocity",
                    &belt,
                    "--normal-force",
                    &force,
                    "--set",
                    &spring,
                    "--duration",
                    "0.7",
                    "--variables",
                    "tip_velocity",
                ],
                folder.path(),
            );
            assert!(output.status.success());
            let text = String::from_utf8(output.stdout).unwrap();
            let speed = |line: &str| line.split(',').nth(1).unwrap().parse::<f64>().unwrap();
            let all: Vec<f64> = text.lines().skip(1).map(speed).collect();
            noisy(&all[3000..], seed)
        })
        .collect();
    write(folder.path(), &runs);
    let found = json(&stickslip(
        &["try", ".", "--add", "cubic_stiffness", "--json"],
        folder.path(),
    ));
    assert_eq!(found["verdict"], "effect_found", "{found:#}");
    let value = found["effects"][0]["parameters"]["coefficient"]["value"]
        .as_f64()
        .unwrap();
    assert!((value / HARDENING - 1.0).abs() < 0.1, "{value:e}");
    let page = std::fs::read_to_string(folder.path().join("try/report.html")).unwrap();
    assert!(page.contains("tip velocity"));
    let calibrated = json(&stickslip(
        &["compare", ".", "--json", "--fmu", "try/StickSlipBeam.fmu"],
        folder.path(),
    ));
    for run in calibrated["runs"].as_array().unwrap() {
        let floor = run["noise_floor"].as_f64().unwrap();
        let error = run["nrmse_from_start_states"].as_f64().unwrap();
        assert!(error < 1.5 * floor, "{run:#}");
    }
}

#[test]
fn an_effect_of_another_sensor_says_so() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &velocities(0.3));
    let words = ["try", ".", "--add", "sensor_lag"];
    let output = stickslip(&words, folder.path());
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("does not move the tip"), "{text}");
}
