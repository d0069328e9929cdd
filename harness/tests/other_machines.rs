//! Diagnoses of machines that are no beam on a belt and of another size by decades.

mod rig;

use rig::runge_kutta;
use serde_json::Value;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// An oscillator of milligrams and millinewtons, as the Silverbox is one: kg, N s/m, N/m.
const MASS: f64 = 5.4e-6;
const DAMPER: f64 = 2.3e-4;
const SPRING: f64 = 1.0;
/// Rate of its records in Hz and their length.
const RATE: f64 = 600.0;
const SAMPLES: usize = 3000;
/// Noise of its sensor in m, where it moves by 0.05 m.
const NOISE: f64 = 2e-4;

/// Displacements and forces of the oscillator with a quadratic and a cubic stiffness in N/m2 and N/m3 under a random multisine of 5 to
/// 140 Hz that is linear between samples, by Runge and Kutta's method at a fortieth of the interval.
fn record(quadratic: f64, cubic: f64, random: &mut fastrand::Rng) -> Vec<(f64, f64)> {
    let lines: Vec<(f64, f64)> = (0..200)
        .map(|_| (5.0 + 135.0 * random.f64(), TAU * random.f64()))
        .collect();
    let force = |sample: usize| {
        let t = sample as f64 / RATE;
        let of_line = |(f, phase): &(f64, f64)| (TAU * f * t + phase).sin();
        2.2e-3 * lines.iter().map(of_line).sum::<f64>()
    };
    let mut state = [0.0, 0.0];
    let mut rows = Vec::new();
    for k in 0..SAMPLES {
        let (from, to) = (force(k), force(k + 1));
        let radius = (-2.0 * (1.0 - random.f64()).ln()).sqrt();
        rows.push((state[0] + NOISE * radius * (TAU * random.f64()).cos(), from));
        let steps = 40;
        let h = 1.0 / (RATE * f64::from(steps));
        let rates = |t: f64, [x, v]: [f64; 2]| {
            let force = from + (to - from) * RATE * t;
            let restoring = SPRING * x + quadratic * x * x + cubic * x.powi(3);
            [v, (force - DAMPER * v - restoring) / MASS]
        };
        for step in 0..steps {
            state = runge_kutta::step(rates, h * f64::from(step), state, h);
        }
    }
    rows
}

/// Displacements in m and forces in N of an oscillator of 1.2 kg and 9 Hz, with 1.5 % of damping, that a force of this amplitude in N sweeps
/// from 5 to 12.2 Hz, at 1 kHz; a spring three times as stiff as its own stands 4 mm away on one side. By Runge and Kutta's method at a
/// tenth of the interval; 4 um of noise.
fn swept_against_a_stop(amplitude: f64, random: &mut fastrand::Rng) -> Vec<(f64, f64)> {
    let (mass, rate) = (1.2, TAU * 9.0);
    let force = |t: f64| amplitude * (TAU * (5.0 + 0.9 * t) * t).sin();
    let rates = |t: f64, [x, v]: [f64; 2]| {
        let stop = 3.0 * rate * rate * (x - 4e-3).max(0.0);
        [
            v,
            force(t) / mass - 0.03 * rate * v - rate * rate * x - stop,
        ]
    };
    let (mut state, h) = ([0.0, 0.0], 1e-4);
    let mut rows = Vec::new();
    for k in 0..4000 {
        let radius = (-2.0 * (1.0 - random.f64()).ln()).sqrt();
        let noise = 4e-6 * radius * (TAU * random.f64()).cos();
        rows.push((state[0] + noise, force(1e-3 * f64::from(k))));
        for step in 0..10 {
            let t = 1e-3 * f64::from(k) + h * f64::from(step);
            state = runge_kutta::step(rates, t, state, h);
        }
    }
    rows
}

/// What is diagnosed from two records of the oscillator of which the linear model is stated.
fn diagnosed(quadratic: f64, cubic: f64) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let mut random = fastrand::Rng::with_seed(5);
    let mut toml = format!(
        "[beam]\nnatural_frequencies_hz = [{}]\ndamping_ratios = [{}]\nmasses_kg = [{MASS:e}]\ntip_values = [1.0]\n\
         [channels]\nexternal_force_column = \"force_n\"\ninput_interpolation = \"linear\"\n",
        (SPRING / MASS).sqrt() / TAU,
        DAMPER / (2.0 * (SPRING * MASS).sqrt())
    );
    for name in ["a", "b"] {
        let mut csv = String::from("time_s,tip_displacement_m,force_n\n");
        for (k, (x, f)) in record(quadratic, cubic, &mut random).iter().enumerate() {
            let _ = writeln!(csv, "{:.7},{x:.7},{f:.7}", k as f64 / RATE);
        }
        std::fs::write(folder.path().join(format!("{name}.csv")), csv).unwrap();
        let _ = write!(
            toml,
            "[[run]]\nfile = \"{name}.csv\"\nbelt_velocity_m_per_s = 0\nnormal_force_n = 0\n"
        );
    }
    std::fs::write(folder.path().join("campaign.toml"), toml).unwrap();
    said(folder.path(), &["diagnose", "."])
}

/// What a command says of the campaign in a folder.
fn said(folder: &Path, arguments: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(arguments)
        .args(["-o", "out"])
        .current_dir(folder)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let text = std::fs::read_to_string(folder.join("out/diagnosis.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn check_value(parameter: &Value, hidden: f64) {
    let number = |key: &str| parameter[key].as_f64().unwrap();
    let off = number("value") - hidden;
    assert!(off.abs() < 3.0 * number("std"), "{parameter} for {hidden}");
    assert!(number("std") < 0.1 * hidden.abs(), "{parameter}");
}

// Source: the Runge-Kutta integration above, which knows nothing of the model.
#[test]
fn val_a_small_oscillator_lacks_a_cubic_spring() {
    let json = diagnosed(0.0, 4.0);
    let effects = json["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{}", json["summary"]);
    assert_eq!(effects[0]["id"], "cubic_stiffness");
    check_value(&effects[0]["parameters"]["coefficient"], 4.0);
    // Nothing rubs, so that nothing of friction, load or belt is calibrated, nor asked for.
    let calibrated = json["calibrated"].as_object().unwrap();
    assert!(calibrated.keys().all(|k| !k.starts_with("friction")));
    assert_eq!(json["inputs"], serde_json::json!({}));
    for remark in json["remarks"].as_array().unwrap() {
        let text = remark.as_str().unwrap();
        assert!(!text.contains("cycle") && !text.contains("load"), "{text}");
    }
}

// Source: likewise.
#[test]
fn val_a_small_oscillator_with_a_spring_that_differs_with_the_side_gets_a_term() {
    let json = diagnosed(0.5, 0.0);
    assert_eq!(json["verdict"], "unknown_effect", "{}", json["summary"]);
    let terms = json["residual"]["proposed_terms"].as_array().unwrap();
    assert_eq!(terms[0]["expression"], "-k*w^2");
    check_value(&terms[0]["parameters"]["k"], 0.5);
}

// Source: the Runge-Kutta integration above; 4 mm and 3 (2 pi 9 Hz)^2 1.2 kg.
#[test]
fn val_what_is_touched_at_resonance_alone_is_missing() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = fastrand::Rng::with_seed(5);
    let mut toml = String::from(
        "[beam]\nnatural_frequencies_hz = [9.02]\nnatural_frequencies_std_hz = 0.05\ndamping_ratios = [0.0155]\n\
         mass_kg = 1.19\nmass_std_kg = 0.03\ntip_values = [1.0]\n[channels]\nexternal_force_column = \"force_n\"\n",
    );
    for (name, amplitude) in [("a", 1.2), ("b", 2.5), ("c", 0.9), ("d", 2.0)] {
        let mut csv = String::from("time_s,tip_displacement_m,force_n\n");
        for (k, (x, f)) in swept_against_a_stop(amplitude, &mut random)
            .iter()
            .enumerate()
        {
            let _ = writeln!(csv, "{:.4},{x:.9},{f:.9}", 1e-3 * k as f64);
        }
        std::fs::write(folder.path().join(format!("{name}.csv")), csv).unwrap();
        let _ = write!(
            toml,
            "[[run]]\nfile = \"{name}.csv\"\nbelt_velocity_m_per_s = 0\nnormal_force_n = 0\n"
        );
    }
    std::fs::write(folder.path().join("campaign.toml"), toml).unwrap();
    let found = said(folder.path(), &["diagnose", "."]);
    assert_eq!(found["verdict"], "unknown_effect", "{}", found["summary"]);
    assert_eq!(found["unknown"]["library_effect"], "term_stop");
    let summary = found["summary"].as_str().unwrap();
    assert!(!summary.contains("to the noise level too"), "{summary}");
    let stop = &found["residual"]["proposed_terms"][0]["parameters"];
    check_value(&stop["g"], 4e-3);
    check_value(&stop["k"], 3.0 * (TAU * 9.0).powi(2) * 1.2);
    // The stop is touched in a quarter of the segments. Those that are met are no reason to name what does not touch it.
    let other = said(folder.path(), &["try", ".", "--add", "cubic_stiffness"]);
    assert_eq!(other["verdict"], "unknown_effect", "{}", other["summary"]);
    let summary = other["summary"].as_str().unwrap();
    assert!(summary.contains(" of 12 segments of "), "{summary}");
}
