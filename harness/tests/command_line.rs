//! What the command line takes and refuses: operating points given twice, negative numbers, wrong kinds of path, a
//! reader that goes.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use stickslip::cli::{command, takes_numbers};

fn stickslip(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(arguments)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Runs what must be refused as bad input, and returns the message.
fn refused(arguments: &[&str]) -> String {
    let done = stickslip(arguments);
    let message = text(&done.stderr);
    assert_eq!(done.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(message.lines().count(), 1, "{arguments:?}: {message}");
    message
}

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo")
}

/// Belt velocity and normal force at the start of a simulation with these options.
fn load_of(options: &[&str]) -> (f64, f64) {
    let run = [
        "simulate",
        "--duration=1e-3",
        "--step=1e-3",
        "--variables=belt_velocity,normal_force",
    ];
    let done = stickslip(&[&run[..], options].concat());
    assert!(done.status.success(), "{options:?}: {}", text(&done.stderr));
    let csv = text(&done.stdout);
    let row: Vec<f64> = csv
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .map(|v| v.parse().unwrap())
        .collect();
    (row[1], row[2])
}

#[test]
fn simulate_takes_its_operating_point_from_set_too() {
    let both = ["--set", "belt_velocity=0.05", "--set", "normal_force=60"];
    assert_eq!(load_of(&both), (0.05, 60.0));
    assert_eq!(load_of(&both[..2]), (0.05, 100.0));
    let same = [&both[..], &["--belt-velocity=0.05", "--normal-force=60"]].concat();
    assert_eq!(load_of(&same), (0.05, 60.0));
    assert_eq!(load_of(&["--normal-force=60"]), (0.1, 60.0));
}

#[test]
fn two_operating_points_are_refused_with_both_values() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let dimension = ["dimension", "--fmu", "own", "-o", out];
    for command in [&["simulate"][..], &dimension[..]] {
        let twice = ["--belt-velocity=0.1", "--set", "belt_velocity=0.05"];
        let message = refused(&[command, &twice[..]].concat());
        assert!(
            message.contains("0.1 m/s") && message.contains("0.05 m/s"),
            "{message}"
        );
        let twice = ["--normal-force=100", "--set", "normal_force=60"];
        let message = refused(&[command, &twice[..]].concat());
        assert!(
            message.contains("100 N") && message.contains("60 N"),
            "{message}"
        );
    }
    let run = demo().join("run01.csv");
    let observe = ["observe", run.to_str().unwrap(), "-o", out];
    let campaign = ["--campaign", demo().to_str().unwrap()].map(str::to_owned);
    let campaign: Vec<&str> = campaign.iter().map(String::as_str).collect();
    // The campaign has 0.04 m/s and 36 N for this run.
    for point in [
        &["--belt-velocity=0.05"][..],
        &["--set", "belt_velocity=0.05"][..],
    ] {
        let message = refused(&[&observe[..], &campaign, point].concat());
        assert!(
            message.contains("0.05 m/s") && message.contains("0.04 m/s"),
            "{message}"
        );
    }
}

#[test]
fn dimension_and_observe_take_their_operating_point_from_set_too() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let out = out.to_str().unwrap();
    let done = stickslip(&[
        "dimension",
        "--fmu=own",
        "--settle=0.1",
        "--samples=600",
        "--surrogates=19",
        "--set=belt_velocity=0.06",
        "--set=normal_force=60",
        "-o",
        out,
    ]);
    assert!(done.status.success(), "{}", text(&done.stderr));
    assert!(
        text(&done.stdout).contains("at 60 N, 0.06 m/s"),
        "{}",
        text(&done.stdout)
    );
    let beam = folder.path().join("beam.toml");
    std::fs::write(
        &beam,
        "[beam]\nnatural_frequencies_hz = [80.0, 510.0]\nmass_kg = 0.427\n",
    )
    .unwrap();
    let run = demo().join("run01.csv");
    let mut observe = vec![
        "observe",
        run.to_str().unwrap(),
        "--beam",
        beam.to_str().unwrap(),
        "--json",
        "-o",
        out,
        "--set=belt_velocity=0.04",
    ];
    let message = refused(&observe);
    assert!(message.contains("--normal-force is missing"), "{message}");
    observe.push("--set=normal_force=36");
    let done = stickslip(&observe);
    assert!(done.status.success(), "{}", text(&done.stderr));
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(json["belt_velocity_m_per_s"], 0.04);
    assert_eq!(json["normal_force_n"], 36.0);
    observe.push("--set=mode_count=3");
    assert!(refused(&observe).contains("mode_count=3"));
}

#[test]
fn options_that_take_numbers_take_negative_ones() {
    let mut checked = 0;
    for sub in command().get_subcommands() {
        for arg in sub.get_arguments().filter(|arg| takes_numbers(arg)) {
            let option = format!("--{}", arg.get_long().unwrap());
            let values = match arg.get_value_delimiter() {
                Some(_) => vec!["-1e-5", "-1e-5,-2"],
                None => vec!["-1e-5", "-3", "-inf"],
            };
            for value in values {
                let line = ["stickslip", sub.get_name(), &option, value];
                let error = command().try_get_matches_from(line).err();
                // That it is no whole number, or that others are missing, may be said; not that there is no such option.
                let unknown = error
                    .as_ref()
                    .is_some_and(|e| e.kind() == clap::error::ErrorKind::UnknownArgument);
                assert!(!unknown, "{line:?}: {}", error.unwrap());
                checked += 1;
            }
        }
    }
    assert!(checked > 60, "{checked}");
}

#[test]
fn a_wrong_kind_of_path_says_what_was_expected() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let out = at("out");
    let campaign = demo();
    let campaign = campaign.to_str().unwrap();
    let file = |name: &str| demo().join(name).to_str().unwrap().to_owned();
    let (run, toml) = (file("run01.csv"), file("campaign.toml"));
    let (fmu, text) = (at("x.fmu"), at("x.set"));
    std::fs::write(&fmu, b"PK\x03\x04\0\0").unwrap();
    std::fs::write(&text, "belt_velocity=0.1\n").unwrap();
    let empty = at("empty");
    std::fs::create_dir(&empty).unwrap();
    const CAMPAIGN: &str = "a campaign folder or its campaign.toml";
    let cases: Vec<(Vec<&str>, &str, &str)> = vec![
        (vec!["diagnose", &run], CAMPAIGN, "a CSV file"),
        (vec!["compare", &run], CAMPAIGN, "a CSV file"),
        (vec!["compare", &fmu], CAMPAIGN, "a zip archive"),
        (vec!["compare", &empty], CAMPAIGN, "without campaign.toml"),
        (vec!["try", &run, "--add", "x"], CAMPAIGN, "a CSV file"),
        (
            vec!["observe", campaign, "--campaign", &run],
            CAMPAIGN,
            "a CSV file",
        ),
        (
            vec![
                "observe",
                campaign,
                "--beam",
                &toml,
                "--belt-velocity=0.1",
                "--normal-force=100",
            ],
            "a CSV file",
            "a campaign folder",
        ),
        (
            vec![
                "observe",
                &run,
                "--beam",
                &run,
                "--belt-velocity=0.1",
                "--normal-force=100",
            ],
            "a TOML file with [beam]",
            "a CSV file",
        ),
        (vec!["dimension", &toml], "a CSV file", "a TOML file"),
        (
            vec!["dimension", campaign],
            "a CSV file",
            "a campaign folder",
        ),
        (vec!["dimension", &fmu], "a CSV file", "a zip archive"),
        (vec!["effects", "--fmu", &run], "a .fmu file", "a CSV file"),
        (
            vec!["effects", "--fmu", campaign],
            "a .fmu file",
            "a campaign folder",
        ),
        (
            vec!["pack", "--effect", &run],
            "a TOML file with an effect",
            "a CSV file",
        ),
        (
            vec!["pack", "--binaries", &run],
            "a folder of binaries",
            "a CSV file",
        ),
        (
            vec!["blind-test", &run],
            "a folder of campaigns",
            "a CSV file",
        ),
    ];
    for (arguments, expected, found) in cases {
        // `effects` writes nothing.
        let to: &[&str] = if arguments[0] == "effects" {
            &[]
        } else {
            &["-o", &out]
        };
        let message = refused(&[&arguments[..], to].concat());
        assert!(
            message.contains(expected) && message.contains(found),
            "{arguments:?}: {message}"
        );
    }
    let message = refused(&["simulate", "--set", &format!("@{run}")]);
    assert!(message.contains("NAME=VALUE lines"), "{message}");
    assert!(!Path::new(&out).exists(), "nothing was written");
}

#[test]
fn observe_says_both_ways_to_tell_it_of_the_beam() {
    let message = refused(&["observe", "run.csv"]);
    assert!(
        message.contains("--campaign <DIR>") && message.contains("--beam <FILE>"),
        "{message}"
    );
}

#[test]
fn help_lists_every_exit_code() {
    let help = text(&stickslip(&["--help"]).stdout);
    for exit in stickslip::exit::Exit::ALL {
        let line = help.lines().find(|line| {
            let mut words = line.split_whitespace();
            words.next() == Some(&exit.code().to_string())
                && words.collect::<Vec<_>>().join(" ") == exit.meaning()
        });
        assert!(line.is_some(), "{exit:?} in {help}");
    }
}

/// The commands that print something within a second or so.
fn printing() -> Vec<Vec<String>> {
    let folder = demo();
    let lines: [&[&str]; 6] = [
        &["effects"],
        &["effects", "--json"],
        &["simulate", "--list"],
        &["simulate", "--duration=0.1"],
        &["--help"],
        &["--version"],
    ];
    let mut all: Vec<Vec<String>> = lines
        .iter()
        .map(|line| line.iter().map(|a| (*a).to_owned()).collect())
        .collect();
    all.push(vec!["compare".into(), folder.display().to_string()]);
    all
}

#[test]
fn a_reader_that_has_gone_ends_a_command_quietly() {
    for mut line in printing() {
        let folder = tempfile::tempdir().unwrap();
        if line[0] == "compare" {
            line.extend(["-o".into(), folder.path().display().to_string()]);
        }
        // Gone before the command begins: else a short text may be written before.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let done = Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .args(&line)
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert_eq!(text(&done.stderr), "", "{line:?}");
        assert_eq!(done.status.code(), Some(141), "{line:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn standard_output_on_a_full_disk_is_an_error_that_is_said() {
    for mut line in printing() {
        let folder = tempfile::tempdir().unwrap();
        if line[0] == "compare" {
            line.extend(["-o".into(), folder.path().display().to_string()]);
        }
        let full = std::fs::File::options()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let done = Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .args(&line)
            .stdout(full)
            .output()
            .unwrap();
        let said = text(&done.stderr);
        assert_eq!(done.status.code(), Some(4), "{line:?}: {said}");
        assert!(
            said.contains("standard output") && said.lines().count() == 1,
            "{line:?}: {said}"
        );
    }
}
