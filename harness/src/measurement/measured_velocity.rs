//! Campaigns that hold the tip's velocity: columns, units, and what a user can get wrong.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::{Campaign, Measurand};
use crate::error::Error;

const POINT: &str = "belt_velocity_m_per_s = 0.1\nnormal_force_n = 100\n";

fn speed(i: i32) -> f64 {
    f64::from((7 * i) % 11 - 5) * 1e-2
}

/// A table of times in s and velocities times `factor`.
fn table(header: &str, factor: f64) -> String {
    let mut text = format!("{header}\n");
    for i in 0..64 {
        let _ = writeln!(text, "{:.4},{}", f64::from(i) * 1e-4, speed(i) * factor);
    }
    text
}

fn write(folder: &Path, toml: &str, files: &[(&str, String)]) {
    fs::write(folder.join("campaign.toml"), toml).unwrap();
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
}

fn load(channels: &str, of_run: &str, csv: String) -> Result<Campaign, Error> {
    let folder = tempfile::tempdir().unwrap();
    let toml = format!("{channels}[[run]]\nfile = \"run.csv\"\n{of_run}{POINT}");
    write(folder.path(), &toml, &[("run.csv", csv)]);
    Campaign::load(folder.path())
}

#[test]
fn velocities_are_found_by_key_usual_name_and_unit() {
    let column = "[channels]\nvelocity_column = \"v\"\n";
    let scaled = "[channels]\nvelocity_column = \"v\"\nvelocity_scale = 1e-3\n";
    let cases = [
        ("", "", "time_s,tip_velocity_m_per_s", 1.0),
        ("", "", "time_s,tip_velocity", 1.0),
        ("", "", "t [s],v [mm/s]", 1e3),
        ("", "", "t [s],v (um/s)", 1e6),
        (column, "", "t,v", 1.0),
        (column, "", "t,v [mm/s]", 1e3),
        (scaled, "", "t,v [V]", 1e3),
        ("", "velocity_column = \"v\"\n", "t,v/(mm/s)", 1e3),
        ("", "velocity_scale = 1e-3\n", "t,tip_velocity_m_per_s", 1e3),
        // Keys of the run come before those of all runs.
        (
            "[channels]\ndisplacement_column = \"x\"\n",
            "velocity_column = \"v\"\n",
            "t,v",
            1.0,
        ),
    ];
    for (channels, of_run, header, factor) in cases {
        let campaign = load(channels, of_run, table(header, factor)).unwrap();
        assert_eq!(campaign.measurand(), Measurand::Velocity, "{header}");
        let run = &campaign.runs[0];
        for (i, v) in (0..).zip(&run.measured) {
            assert!((v - speed(i)).abs() < 1e-12, "{header}: {v}");
        }
    }
}

#[test]
fn a_displacement_is_taken_where_both_are_recorded_and_the_belt_is_not_the_tip() {
    let mut both = String::from("t [s],x [mm],v [mm/s]\n");
    for i in 0..64 {
        let _ = writeln!(both, "{:.4},{},{}", f64::from(i) * 1e-4, i % 5, i % 7);
    }
    let campaign = load("", "", both.clone()).unwrap();
    assert_eq!(campaign.measurand(), Measurand::Displacement);
    let named = load("", "velocity_column = \"v\"\n", both).unwrap();
    assert_eq!(named.measurand(), Measurand::Velocity);
    let belt = table("t [s],belt_velocity [m/s]", 1.0);
    let error = load("", "", belt).unwrap_err().to_string();
    assert!(error.contains("displacement_column"), "{error}");
}

#[test]
fn what_is_no_one_velocity_is_refused_with_what_to_do() {
    let good = || table("time_s,tip_velocity_m_per_s", 1.0);
    let two = "[channels]\ndisplacement_column = \"x\"\nvelocity_column = \"v\"\n";
    let scale = "[channels]\ndisplacement_column = \"x\"\nvelocity_scale = 1e-3\n";
    let column = "velocity_column = \"a\"\n";
    let cases: [(&str, &str, String, &[&str]); 6] = [
        (
            two,
            "",
            good(),
            &[
                "campaign.toml:3",
                "displacement_column = \"x\"",
                "velocity_column = \"v\"",
                "keep one",
            ],
        ),
        (scale, "", good(), &["velocity_scale = 0.001", "keep one"]),
        (
            "",
            column,
            table("t,a [g]", 1.0),
            &[
                "'a [g]'",
                "an acceleration",
                "a velocity",
                "velocity_column",
            ],
        ),
        (
            "",
            column,
            good(),
            &["no column 'a'", "tip_velocity_m_per_s", "velocity_column"],
        ),
        (
            "",
            "velocity_scale = 0\n",
            good(),
            &["velocity_scale", "must not be zero"],
        ),
        (
            "",
            "",
            table("time_s,tip_velocity_m_per_s", 0.0),
            &["run.csv", "0 m/s"],
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
fn runs_of_one_campaign_hold_one_quantity() {
    let folder = tempfile::tempdir().unwrap();
    let toml = format!(
        "[[run]]\nfile = \"a.csv\"\n{POINT}[[run]]\nfile = \"b.csv\"\nvelocity_column = \"v\"\n{POINT}"
    );
    let files = [
        ("a.csv", table("time_s,tip_displacement_m", 1e-3)),
        ("b.csv", table("t,v", 1.0)),
    ];
    write(folder.path(), &toml, &files);
    let error = Campaign::load(folder.path()).unwrap_err().to_string();
    for part in [
        "'a'",
        "displacement",
        "'b'",
        "velocity",
        "a campaign of each",
    ] {
        assert!(error.contains(part), "'{part}' is not in: {error}");
    }
}
