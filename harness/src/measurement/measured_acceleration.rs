//! Campaigns that hold the tip's acceleration: columns, units, and what a user can get wrong.

use std::fmt::Write as _;
use std::fs;

use super::{Campaign, Measurand};
use crate::error::Error;

const POINT: &str = "belt_velocity_m_per_s = 0.1\nnormal_force_n = 100\n";

fn value(i: i32) -> f64 {
    f64::from((7 * i) % 11 - 5) * 10.0
}

/// A table of times in s and accelerations times `factor`.
fn table(header: &str, factor: f64) -> String {
    let mut text = format!("{header}\n");
    for i in 0..64 {
        let _ = writeln!(text, "{:.4},{}", f64::from(i) * 1e-4, value(i) * factor);
    }
    text
}

fn load(channels: &str, of_run: &str, csv: String) -> Result<Campaign, Error> {
    let folder = tempfile::tempdir().unwrap();
    let toml = format!("{channels}[[run]]\nfile = \"run.csv\"\n{of_run}{POINT}");
    fs::write(folder.path().join("campaign.toml"), toml).unwrap();
    fs::write(folder.path().join("run.csv"), csv).unwrap();
    Campaign::load(folder.path())
}

#[test]
fn accelerations_are_found_by_key_usual_name_and_unit() {
    let column = "[channels]\nacceleration_column = \"a\"\n";
    let scaled = "[channels]\nacceleration_column = \"a\"\nacceleration_scale = 10.0\n";
    let of_velocity = "[channels]\nvelocity_column = \"v\"\n";
    let cases = [
        ("", "", "time_s,tip_acceleration_m_per_s2", 1.0),
        ("", "", "time_s,tip_acceleration", 1.0),
        ("", "", "t [s],a [mm/s^2]", 1e3),
        ("", "", "t [s],a [g]", 1.0 / 9.806_65),
        (column, "", "t,a", 1.0),
        (column, "", "t,a [m/s2]", 1.0),
        (scaled, "", "t,a [V]", 0.1),
        // Keys of the run come before those of all runs.
        (of_velocity, "acceleration_column = \"a\"\n", "t,a", 1.0),
    ];
    for (channels, of_run, header, factor) in cases {
        let campaign = load(channels, of_run, table(header, factor)).unwrap();
        assert_eq!(campaign.measurand(), Measurand::Acceleration, "{header}");
        for (i, a) in (0..).zip(&campaign.runs[0].measured) {
            assert!((a - value(i)).abs() < 1e-9, "{header}: {a}");
        }
    }
}

#[test]
fn what_is_no_one_acceleration_is_refused_with_what_to_do() {
    let good = || table("time_s,tip_acceleration_m_per_s2", 1.0);
    let two = "[channels]\nvelocity_column = \"v\"\nacceleration_column = \"a\"\n";
    let column = "acceleration_column = \"v\"\n";
    let cases: [(&str, &str, String, &[&str]); 3] = [
        (
            two,
            "",
            good(),
            &[
                "campaign.toml:3",
                "velocity_column = \"v\"",
                "acceleration_column = \"a\"",
                "keep one",
            ],
        ),
        (
            "",
            column,
            table("t,v [m/s]", 1.0),
            &[
                "'v [m/s]'",
                "a velocity",
                "an acceleration",
                "acceleration_column",
            ],
        ),
        (
            "",
            column,
            good(),
            &[
                "no column 'v'",
                "tip_acceleration_m_per_s2",
                "acceleration_column",
            ],
        ),
    ];
    for (channels, of_run, csv, parts) in cases {
        let error = load(channels, of_run, csv).unwrap_err().to_string();
        for part in parts {
            assert!(error.contains(part), "'{part}' is not in: {error}");
        }
    }
}

#[test]
fn the_value_of_stick_is_no_fault() {
    // Rest at zero for 40 of 64 samples, as a simulation without noise records it.
    let mut text = String::from("time_s,tip_acceleration_m_per_s2\n");
    for i in 0..64 {
        let a = if i % 32 < 20 { 0.0 } else { value(i) };
        let _ = writeln!(text, "{:.4},{a}", f64::from(i) * 1e-4);
    }
    assert_eq!(load("", "", text).unwrap().runs[0].faults, []);
}

#[test]
fn the_clamps_acceleration_is_taken_off_what_an_accelerometer_reads() {
    let mut csv = String::from("time_s,tip_acceleration_m_per_s2,frame\n");
    for i in 0..64 {
        let clamp = f64::from(i) - 30.0;
        let _ = writeln!(csv, "{:.4},{},{clamp}", f64::from(i) * 1e-4, value(i));
    }
    let run = "clamp_acceleration_column = \"frame\"\nclamp_acceleration_m_per_s2 = 0.5\n";
    let campaign = load("", run, csv.clone()).unwrap();
    for (i, a) in (0..).zip(&campaign.runs[0].measured) {
        let clamp = f64::from(i) - 29.5;
        assert!((a - (value(i) - clamp)).abs() < 1e-9, "{i}: {a}");
    }
    let still = load("", "", csv).unwrap();
    assert!((still.runs[0].measured[7] - value(7)).abs() < 1e-9);
}
