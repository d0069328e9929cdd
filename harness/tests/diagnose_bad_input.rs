//! Campaigns that a diagnosis can learn little or nothing from: each ends with a verdict that claims no more
//! than the data tell, or with one sentence that says what is wrong, where, and what to do.
//!
//! Source of the motions: rig/, an independent simulation of the reference model, in which nothing is missing.

mod rig;

use rig::campaign::with_noise;
use rig::{Record, Rig};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// Belt velocities in m/s and normal forces in N.
const POINTS: [(f64, f64); 4] = [(0.04, 36.0), (0.06, 60.0), (0.1, 80.0), (0.12, 120.0)];
/// Standard deviation of the sensor's noise in m.
const NOISE: f64 = 3e-7;
/// Samples in a second.
const RATE: f64 = 1e4;
/// Length of a run in s where the length is not what a test is about: five cycles.
const SHORT: f64 = 0.16;

/// The displacement of the rig at an operating point, after half a second of its own.
fn motion((belt_velocity, normal_force): (f64, f64), duration: f64) -> Vec<f64> {
    let rig = Rig {
        belt_velocity,
        normal_force,
        ..Rig::default_case()
    };
    let Record { displacement, .. } = rig.run(0.5, duration, RATE);
    displacement
}

fn noisy(signal: &[f64], seed: u64) -> Vec<f64> {
    with_noise(signal, 0.0, NOISE, seed)
}

fn write(folder: &Path, runs: &[((f64, f64), Vec<f64>)]) {
    let mut toml = String::from(
        "[beam]\nnatural_frequencies_hz = [80.0, 510.0]\ndamping_ratios = [0.00015, 0.00085]\nmass_kg = 0.427\n",
    );
    for (i, ((velocity, force), signal)) in runs.iter().enumerate() {
        let mut csv = String::from("time_s,tip_displacement_m\n");
        for (k, y) in signal.iter().enumerate() {
            writeln!(csv, "{:.7},{y:e}", k as f64 / RATE).unwrap();
        }
        std::fs::write(folder.join(format!("run{i}.csv")), csv).unwrap();
        write!(
            toml,
            "[[run]]\nfile = \"run{i}.csv\"\nbelt_velocity_m_per_s = {velocity}\nnormal_force_n = {force}\n"
        )
        .unwrap();
    }
    std::fs::write(folder.join("campaign.toml"), toml).unwrap();
}

/// The diagnosis of these runs, or what it was refused with.
fn diagnosed(runs: &[((f64, f64), Vec<f64>)]) -> Result<Value, String> {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), runs);
    let output = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(["diagnose", ".", "--json", "-o", "diagnosis"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(!said.contains("panicked"), "{said}");
    match output.status.code() {
        Some(0) => Ok(serde_json::from_slice(&output.stdout).unwrap()),
        Some(2) => {
            // What the look at the data found may stand before the one error.
            let errors = said.lines().filter(|line| line.starts_with("error:"));
            assert_eq!(errors.count(), 1, "{said}");
            Err(said)
        }
        _ => panic!("{}: {said}", output.status),
    }
}

fn at_all_points(signal: impl Fn((f64, f64), u64) -> Vec<f64>) -> Vec<((f64, f64), Vec<f64>)> {
    let points = POINTS.iter().zip(1..);
    points.map(|(&at, seed)| (at, signal(at, seed))).collect()
}

fn remarks(diagnosis: &Value) -> String {
    diagnosis["remarks"].to_string()
}

fn claims_nothing(diagnosis: &Value) {
    assert_eq!(diagnosis["verdict"], "no_missing_effect", "{diagnosis:#}");
}

#[test]
fn val_one_run_is_enough_for_a_verdict_and_what_it_cannot_tell_is_said() {
    let at = POINTS[1];
    let diagnosis = diagnosed(&[(at, noisy(&motion(at, 0.6), 1))]).unwrap();
    claims_nothing(&diagnosis);
    let said = remarks(&diagnosis);
    assert!(said.contains("at least 3 operating points"), "{said}");
    assert!(said.contains("second load"), "{said}");
}

#[test]
fn val_three_cycles_claim_nothing() {
    let short = |at, seed| noisy(&motion(at, 0.09), seed);
    claims_nothing(&diagnosed(&at_all_points(short)).unwrap());
}

#[test]
fn val_motion_without_stick_claims_nothing() {
    // The tip rings at 1 m/s, so that the belt stays faster; light loads hardly excite it.
    let fast = |(_, force): (f64, f64)| (1.5, force / 30.0);
    let ringing = |at: (f64, f64), seed| {
        let (belt_velocity, normal_force) = fast(at);
        let rig = Rig {
            belt_velocity,
            normal_force,
            ..Rig::default_case()
        };
        let record = rig.run_slipping(vec![1e-3, 0.0, 1e-5, 0.0], 0.2, RATE);
        assert!(record.mode.iter().all(|mode| *mode != 0));
        noisy(&record.displacement, seed)
    };
    let runs = at_all_points(ringing).into_iter();
    let runs: Vec<_> = runs.map(|(at, signal)| (fast(at), signal)).collect();
    claims_nothing(&diagnosed(&runs).unwrap());
}

#[test]
fn val_a_simulation_without_noise_claims_nothing_and_is_called_one() {
    let diagnosis = diagnosed(&at_all_points(|at, _| motion(at, SHORT))).unwrap();
    claims_nothing(&diagnosis);
    let said = remarks(&diagnosis);
    assert!(said.contains("as in a simulation"), "{said}");
    // Of one sensor for all runs, though the motions are 3 to 1 in size.
    let noise = diagnosis["noise_std_m"].as_f64().unwrap();
    assert!((3e-9..3e-8).contains(&noise), "{noise}");
}

#[test]
fn runs_in_which_nothing_moves_are_refused() {
    let still = |(_, force): (f64, f64), seed| noisy(&vec![1.5e-5 * force; 3000], seed);
    let said = diagnosed(&at_all_points(still)).unwrap_err();
    assert!(
        said.contains("nothing moves") && said.contains("3.0e-7 m"),
        "{said}"
    );
}

#[test]
fn a_dead_channel_is_named_with_its_value_and_place() {
    let mut runs = at_all_points(|at, seed| noisy(&motion(at, 0.1), seed));
    runs[2].1.fill(0.0);
    let said = diagnosed(&runs).unwrap_err();
    for part in [
        "run2.csv",
        "0 of 1000 samples",
        "held",
        "0 m",
        "leave this run out",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    // Dead from its middle on, the rest of it is used.
    let mut runs = at_all_points(|at, seed| noisy(&motion(at, 0.3), seed));
    runs[2].1[1500..].fill(0.0);
    let diagnosis = diagnosed(&runs).unwrap();
    claims_nothing(&diagnosis);
    let said = remarks(&diagnosis);
    assert!(said.contains("1500 samples are clipped or held"), "{said}");
    // The noise is that of the other half: nothing is put on.
    assert!(!said.contains("white noise of"), "{said}");
}

#[test]
fn of_a_long_run_the_beginning_is_used_and_that_is_said() {
    let (at, duration) = (POINTS[2], 25.0);
    let mut runs = at_all_points(|at, seed| noisy(&motion(at, SHORT), seed));
    let cycle = motion(at, 0.5);
    // What lies beyond is a motion that no model makes.
    let count = (duration * RATE) as usize;
    let mut long = noisy(&motion(at, 20.0), 9);
    long.extend((long.len()..count).map(|k| cycle[k % 100]));
    runs.push((at, long));
    let diagnosis = diagnosed(&runs).unwrap();
    claims_nothing(&diagnosis);
    let said = remarks(&diagnosis);
    assert!(said.contains("run4: 250000 samples over 25.0 s"), "{said}");
    assert!(said.contains("the first 200000 of them, 20.0 s"), "{said}");
}
