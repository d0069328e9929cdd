//! Campaigns of the rig's motions in one measured quantity, and the command run on them.
#![allow(dead_code)]

use super::{Noise, Record, Rig};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

/// Belt velocities in m/s and normal forces in N.
pub const POINTS: [(f64, f64); 4] = [(0.06, 60.0), (0.1, 100.0), (0.12, 120.0), (0.08, 120.0)];
/// Samples in a second.
pub const RATE: f64 = 1e4;

/// Two columns of one run, time in s and another.
fn csv(column: &str, values: &[f64]) -> String {
    let mut text = format!("t,{column}\n");
    for (k, v) in values.iter().enumerate() {
        let _ = writeln!(text, "{:.4},{v:.9e}", k as f64 / RATE);
    }
    text
}

/// Writes a campaign of each operating point's values, in the column that a key of `[channels]` (as `velocity_column`) names.
pub fn write(folder: &Path, key: &str, column: &str, runs: &[Vec<f64>]) {
    let mut toml = format!(
        "[beam]\nnatural_frequencies_hz = [80.0, 510.0]\ndamping_ratios = [0.00015, 0.00085]\nmass_kg = 0.427\n\
         [channels]\n{key} = \"{column}\"\n",
    );
    for (i, (values, (belt, force))) in runs.iter().zip(POINTS).enumerate() {
        std::fs::write(folder.join(format!("run{i}.csv")), csv(column, values)).unwrap();
        let _ = write!(
            toml,
            "[[run]]\nfile = \"run{i}.csv\"\nbelt_velocity_m_per_s = {belt:?}\nnormal_force_n = {force:?}\n"
        );
    }
    std::fs::write(folder.join("campaign.toml"), toml).unwrap();
}

/// What the rig does at each operating point, without noise.
pub fn motions(duration: f64) -> Vec<Record> {
    let at = |(belt_velocity, normal_force)| {
        let rig = Rig {
            belt_velocity,
            normal_force,
            ..Rig::default_case()
        };
        rig.run(0.5, duration, RATE)
    };
    POINTS.map(at).into()
}

/// Values with an offset and normal noise of a standard deviation, all in their unit.
pub fn with_noise(values: &[f64], offset: f64, std: f64, seed: u64) -> Vec<f64> {
    let mut random = Noise::new(seed);
    let disturbed = |v: &f64| v + offset + std * random.normal();
    values.iter().map(disturbed).collect()
}

/// A signal of each run, disturbed likewise, each by noise of its own.
pub fn disturbed(
    runs: &[Record],
    signal: fn(&Record) -> &Vec<f64>,
    offset: f64,
    std: f64,
) -> Vec<Vec<f64>> {
    let numbered = runs.iter().zip(1..);
    numbered
        .map(|(run, seed)| with_noise(signal(run), offset, std, seed))
        .collect()
}

/// The command run in a folder.
pub fn stickslip(words: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap()
}

/// What a command that succeeded printed as JSON.
pub fn json(output: &Output) -> Value {
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).unwrap()
}
