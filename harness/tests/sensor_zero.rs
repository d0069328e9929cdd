//! Displacements that do not count from the tip's rest, through the commands: the demonstration with the mean of each run taken off.

mod rig;

use rig::campaign::stickslip;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use stickslip::check::{Severity, check};
use stickslip::measurement::Campaign;

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo")
}

/// Writes the demonstration to `folder`, less what `zero` makes of the mean reading of each run, in m.
fn write_less(folder: &Path, zero: fn(f64) -> f64) {
    for entry in std::fs::read_dir(demo()).unwrap() {
        let file = entry.unwrap().path();
        let to = folder.join(file.file_name().unwrap());
        match file.extension().and_then(|e| e.to_str()) {
            Some("csv") => std::fs::write(to, less(&std::fs::read_to_string(file).unwrap(), zero)),
            _ if file.ends_with("campaign.toml") => std::fs::copy(file, to).map(drop),
            _ => Ok(()),
        }
        .unwrap();
    }
}

fn less(csv: &str, zero: fn(f64) -> f64) -> String {
    let (head, rows) = csv.split_once('\n').unwrap();
    let rows: Vec<(&str, f64)> = rows
        .lines()
        .filter_map(|row| {
            let (time, value) = row.split_once(',')?;
            Some((time, value.parse().ok()?))
        })
        .collect();
    let zero = zero(rows.iter().map(|(_, v)| v).sum::<f64>() / rows.len() as f64);
    let mut text = format!("{head}\n");
    for (time, value) in rows {
        let _ = writeln!(text, "{time},{:.10}", value - zero);
    }
    text
}

#[test]
fn readings_without_their_mean_are_questioned() {
    let folder = tempfile::tempdir().unwrap();
    write_less(folder.path(), |mean| mean);
    let found = |folder: &Path| check(&Campaign::load(folder).unwrap()).findings;
    let findings = found(folder.path());
    let [zero] = &findings[..] else {
        panic!("{findings:?}");
    };
    assert_eq!((zero.id, zero.severity), ("zero", Severity::Warning));
    assert_eq!(zero.runs.len(), 4);
    assert!(found(&demo()).is_empty());
}

// Source: the constants with which the independent generator made the demonstration (reference-data/demo/truth.json).
#[test]
fn val_an_effect_is_found_in_readings_without_their_mean() {
    let folder = tempfile::tempdir().unwrap();
    write_less(folder.path(), |mean| mean);
    let found = the_hidden_effect(folder.path());
    let remarks = found["remarks"].as_array().unwrap();
    let of_zero = |r: &&serde_json::Value| r.as_str().unwrap().contains("sensor's zero");
    assert_eq!(remarks.iter().filter(of_zero).count(), 1, "{remarks:#?}");
}

// Source: as above.
#[test]
fn val_an_effect_is_found_from_a_zero_that_is_stated_to_be_uncertain() {
    let folder = tempfile::tempdir().unwrap();
    write_less(folder.path(), |_| 2e-4);
    let file = folder.path().join("campaign.toml");
    let stated = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, stated + "\n[sensor]\noffset_std = 3e-4\n").unwrap();
    the_hidden_effect(folder.path());
}

/// What `try` gives with the effect that is hidden in the demonstration; it has to explain the data with the constants hidden.
fn the_hidden_effect(folder: &Path) -> serde_json::Value {
    let words = ["try", ".", "--add", "belt_periodic_friction", "-o", "out"];
    let output = stickslip(&words, folder);
    assert!(output.status.success(), "{output:?}");
    let file = std::fs::read(folder.join("out/diagnosis.json")).unwrap();
    let found: serde_json::Value = serde_json::from_slice(&file).unwrap();
    let ladder = found["error_ladder"].as_array().unwrap();
    let left = ladder.last().unwrap()["holdout_over_noise"].as_f64();
    assert!(left.unwrap() < 1.1, "{ladder:#?}");
    let effect = &found["effects"][0]["parameters"];
    for (name, hidden) in [("amplitude", 0.08), ("wavelength", 0.022)] {
        let value = effect[name]["value"].as_f64().unwrap();
        assert!((value / hidden - 1.0).abs() < 5e-3, "{name} = {value}");
    }
    found
}
