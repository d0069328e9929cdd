//! Displacements that do not count from the tip's rest, through the commands: the demonstration with the mean of each run taken off, or
//! with an AC-coupled sensor.

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
    write_changed(folder, &|readings| {
        let zero = zero(readings.iter().sum::<f64>() / readings.len() as f64);
        readings.iter_mut().for_each(|reading| *reading -= zero);
    });
}

/// Writes it as a sensor reads it that passes a high-pass filter with this corner frequency in Hz, 10 000 samples a second.
fn write_ac_coupled(folder: &Path, corner: f64) {
    let (rate, h) = (std::f64::consts::TAU * corner, 1e-4);
    let kept = (-rate * h).exp();
    write_changed(folder, &|readings| {
        let mut before = readings[0];
        let mut passed = 0.0;
        for reading in readings {
            // Exact where the tip moves evenly between two samples.
            passed = kept * passed + (*reading - before) * (1.0 - kept) / (rate * h);
            before = std::mem::replace(reading, passed);
        }
    });
}

/// Writes the demonstration to `folder` with the readings of each run changed.
fn write_changed(folder: &Path, change: &dyn Fn(&mut [f64])) {
    for entry in std::fs::read_dir(demo()).unwrap() {
        let file = entry.unwrap().path();
        let to = folder.join(file.file_name().unwrap());
        match file.extension().and_then(|e| e.to_str()) {
            Some("csv") => {
                std::fs::write(to, changed(&std::fs::read_to_string(file).unwrap(), change))
            }
            _ if file.ends_with("campaign.toml") => std::fs::copy(file, to).map(drop),
            _ => Ok(()),
        }
        .unwrap();
    }
}

fn changed(csv: &str, change: &dyn Fn(&mut [f64])) -> String {
    let (head, rows) = csv.split_once('\n').unwrap();
    let (times, mut readings): (Vec<&str>, Vec<f64>) = rows
        .lines()
        .filter_map(|row| {
            let (time, value) = row.split_once(',')?;
            Some((time, value.parse::<f64>().ok()?))
        })
        .unzip();
    change(&mut readings);
    let mut text = format!("{head}\n");
    for (time, reading) in times.iter().zip(&readings) {
        let _ = writeln!(text, "{time},{reading:.10}");
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

#[test]
fn an_ac_coupled_sensor_is_recognised_by_its_readings_in_stick() {
    for corner in [0.5, 2.0, 8.0] {
        let folder = tempfile::tempdir().unwrap();
        write_ac_coupled(folder.path(), corner);
        let findings = check(&Campaign::load(folder.path()).unwrap()).findings;
        let of_filter = findings.iter().find(|f| f.id == "high_pass");
        let found = of_filter.unwrap_or_else(|| panic!("{corner} Hz: {findings:?}"));
        assert_eq!(found.severity, Severity::Warning);
        let stated = found.remedy.split("high_pass_hz = ").nth(1).unwrap();
        let stated: f64 = stated.split(' ').next().unwrap().parse().unwrap();
        assert!(
            (stated / corner - 1.0).abs() < 0.05,
            "{corner} Hz: {stated}"
        );
    }
}

// Source: as above.
#[test]
fn val_an_effect_is_found_through_an_ac_coupled_sensor_that_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    write_ac_coupled(folder.path(), 2.0);
    let file = folder.path().join("campaign.toml");
    let stated = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, stated + "\n[sensor]\nhigh_pass_hz = 2.0\n").unwrap();
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
