//! `stickslip observe` through the command line.

mod rig;

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use rig::Rig;

fn observe(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .arg("observe")
        .args(arguments)
        .output()
        .unwrap()
}

const BEAM: &str = "[beam]
natural_frequencies_hz = [80.0, 510.0]
damping_ratios = [0.00015, 0.00085]
mass_kg = 0.427
";

/// A short record of the default case at 60 dB.
fn write_run(folder: &Path) -> rig::Record {
    let record = Rig::default_case().run(0.5, 0.4, 20e3);
    let y = rig::noisy(&record.displacement, 60.0, 1);
    let mut csv = String::from("time_s,tip_displacement_m\n");
    for (k, y) in y.iter().enumerate() {
        writeln!(csv, "{:.5},{y:.9}", k as f64 * 5e-5).unwrap();
    }
    std::fs::write(folder.join("run.csv"), csv).unwrap();
    std::fs::write(folder.join("beam.toml"), BEAM).unwrap();
    record
}

// Source: independent simulation (rig/): the force in force.csv is the simulated one.
#[test]
fn val_observe_writes_force_friction_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let record = write_run(folder.path());
    let (run, beam, out) = (at("run.csv"), at("beam.toml"), at("out"));
    let (v, n) = ("--belt-velocity=0.1", "--normal-force=100");
    let common = [&run[..], "--beam", &beam, v, n, "-o", &out, "--json"];
    for (method, bound) in [("stick-slip", 0.1), ("kalman", 0.16), ("pole", 0.4)] {
        let done = observe(&[&common[..], &["--method", method]].concat());
        assert!(
            done.status.success(),
            "{}",
            String::from_utf8_lossy(&done.stderr)
        );
        let summary: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        assert_eq!(summary["innovation"]["acceptable"], true);
        let force = std::fs::read_to_string(folder.path().join("out/force.csv")).unwrap();
        let mut lines = force.lines();
        let header = "time_s,force_n,force_std_n,displacement_m,velocity_m_per_s,relative_velocity_m_per_s,mode";
        assert_eq!(lines.next(), Some(header));
        let found: Vec<f64> = lines
            .map(|l| l.split(',').nth(1).unwrap().parse().unwrap())
            .collect();
        let error = rig::error(&found, &record.force);
        println!("{method}: {error:.3}");
        assert!(error < bound, "{method}: {error}");
        let friction = std::fs::read_to_string(folder.path().join("out/friction.csv")).unwrap();
        assert!(friction.starts_with("relative_velocity_m_per_s,mu,mu_std,count\n"));
        let page = std::fs::read_to_string(folder.path().join("out/observer.html")).unwrap();
        assert!(page.contains("<svg") && page.contains("Friction characteristic"));
    }
}

// Source: issue text, "bad input: ... a clear message".
#[test]
fn val_observe_refuses_bad_input_clearly() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    write_run(folder.path());
    let (run, beam, out) = (at("run.csv"), at("beam.toml"), at("out"));
    let refused = |arguments: &[&str], words: &[&str]| {
        let done = observe(arguments);
        let text = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(2), "{text}");
        assert!(words.iter().all(|w| text.contains(w)), "{text}");
    };
    let (v, n) = ("--belt-velocity=0.1", "--normal-force=100");
    refused(&[&run, "-o", &out], &["--beam"]);
    std::fs::write(&beam, "[beam]\nnatural_frequencies_hz = [80.0]\n").unwrap();
    refused(
        &[&run, "--beam", &beam, v, n, "-o", &out],
        &["mass_kg", "force"],
    );
    std::fs::write(
        &beam,
        "[beam]\nnatural_frequencies_hz = [80.0, 9000.0]\nmass_kg = 0.4\n",
    )
    .unwrap();
    refused(
        &[&run, "--beam", &beam, v, n, "-o", &out],
        &["20000.0 Hz is too slow", "9000 Hz"],
    );
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/demo");
    refused(
        &[&run, "--campaign", demo, "-o", &out],
        &["no run of this campaign", "run01.csv"],
    );
}
