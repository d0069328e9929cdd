//! `stickslip sweep` through the command line, and its table of names against the FMU's.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::OnceLock;

use beam_physics::sweep::Values;

const RANGE: [&str; 8] = [
    "--parameter",
    "belt_velocity",
    "--from",
    "0.096",
    "--to",
    "0.108",
    "--points",
    "7",
];
/// Enough to tell motions, and quick.
const SHORT: [&str; 4] = ["--settle", "30", "--cycles", "30"];

fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_stickslip"));
    command.arg("sweep").arg("--fmu").arg(fmu()).args(arguments);
    command
}

fn sweep(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Folder(tempfile::tempdir().unwrap())
    }
    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
    fn text(&self, name: &str) -> String {
        self.path(name).to_str().unwrap().to_owned()
    }
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

// Source: the FMU's own table of variables (crate beam-model-description): every start value that can be set must mean
// the same here.
#[test]
fn val_the_names_and_start_values_are_those_of_the_fmu() {
    let mut checked = 0;
    let values = Values::default();
    for variable in beam_model_description::variables() {
        if let Some(start) = variable.start.filter(|_| variable.is_settable()) {
            assert_eq!(values.get(&variable.name), Some(start), "{}", variable.name);
            checked += 1;
        }
    }
    assert!(checked > 150, "{checked}");
}

// Source: physics.md's independent study, cited in the README: at 100 N period one up to 0.099 m/s, main frequency about
// 33 Hz; direct simulation finds irregular motions beyond.
#[test]
fn val_sweep_writes_the_table_the_section_and_the_pictures() {
    let folder = Folder::new();
    let done = sweep(&[&RANGE[..], &["--json", "-o", &folder.text("out")]].concat());
    assert!(done.status.success(), "{}", said(&done));
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(json["rows"][0]["period"], 1);
    let table = read(&folder.path("out/sweep.csv"));
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!(
        lines[0],
        "belt_velocity,start,period,main_frequency_hz,amplitude_m,stick_fraction,lyapunov_per_s,status"
    );
    assert_eq!(lines.len(), 8);
    let first: Vec<&str> = lines[1].split(',').collect();
    assert_eq!(first[..3], ["0.096", "fixed", "1"]);
    let frequency: f64 = first[3].parse().unwrap();
    assert!((frequency - 33.3).abs() < 0.1, "{frequency}");
    let irregular = |line: &&&str| line.split(',').nth(2) == Some("0");
    assert!(lines[1..].iter().filter(irregular).count() >= 2, "{table}");
    let section = read(&folder.path("out/section.csv"));
    assert_eq!(section.lines().count(), 1 + 7 * 200);
    assert!(read(&folder.path("out/sweep.html")).contains("static amplitude"));
    assert!(read(&folder.path("out/sweep.svg")).contains("belt velocity [m/s]"));
}

// Source: the uninterrupted run. A killed process leaves whole lines; the same command goes on and ends with the same
// bytes, continuations included.
#[test]
fn val_a_killed_sweep_goes_on_and_ends_with_the_same_bytes() {
    let folder = Folder::new();
    let options = [
        &RANGE[..],
        &SHORT,
        &["--start", "up,down,fixed", "--threads", "2"],
    ]
    .concat();
    let whole = sweep(&[&options[..], &["-o", &folder.text("whole")]].concat());
    assert!(whole.status.success(), "{}", said(&whole));
    let mut child = command(&[&options[..], &["-o", &folder.text("cut")]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let table = folder.path("cut/sweep.csv");
    let lines = || std::fs::read_to_string(&table).map_or(0, |t| t.lines().count());
    while lines() < 4 && child.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    let _ = child.kill();
    child.wait().unwrap();
    // A crash in the middle of a line.
    let mut text = read(&table);
    let kept = text.lines().count();
    text += "0.1,fixed,1,33.";
    std::fs::write(&table, text).unwrap();
    let again = sweep(&[&options[..], &["-o", &folder.text("cut")]].concat());
    assert!(again.status.success(), "{}", said(&again));
    assert!(kept >= 2);
    for name in ["sweep.csv", "section.csv"] {
        assert_eq!(
            read(&folder.path(&format!("cut/{name}"))),
            read(&folder.path(&format!("whole/{name}"))),
            "{name}"
        );
    }
}

#[test]
fn what_is_done_is_not_computed_again_and_other_sweeps_are_refused() {
    let folder = Folder::new();
    let out = folder.text("out");
    let options = [&RANGE[..], &SHORT, &["-o", &out]].concat();
    assert!(sweep(&options).status.success());
    // A result that no run gives shows that the row is taken as it is.
    let path = folder.path("out/sweep.csv");
    let marked = read(&path).replacen("0.096,fixed,1,", "0.096,fixed,7,", 1);
    std::fs::write(&path, &marked).unwrap();
    assert!(sweep(&options).status.success());
    assert_eq!(read(&path), marked);
    let other = sweep(&[&options[..], &["--set", "normal_force=90"]].concat());
    assert_eq!(other.status.code(), Some(2));
    assert!(said(&other).contains("another sweep"), "{}", said(&other));
    assert!(said(&other).contains("normal_force"), "{}", said(&other));
    assert_eq!(read(&path), marked);
}

#[test]
fn bad_input_is_refused_with_what_to_do() {
    let folder = Folder::new();
    let out = folder.text("out");
    let refused = |arguments: &[&str], words: &[&str]| {
        let done = sweep(&[arguments, &["-o", &out]].concat());
        let said = said(&done);
        assert_eq!(done.status.code(), Some(2), "{said}");
        for word in words {
            assert!(said.contains(word), "{said}");
        }
        assert!(!Path::new(&out).exists(), "{said}");
    };
    let range = |name, from, to, points| {
        [
            "--parameter",
            name,
            "--from",
            from,
            "--to",
            to,
            "--points",
            points,
        ]
    };
    refused(
        &range("belt_velocty", "0", "1", "3"),
        &["belt_velocty", "did you mean 'belt_velocity'"],
    );
    refused(
        &range("belt_velocity", "1", "0", "3"),
        &["--from 1", "swap"],
    );
    refused(&range("belt_velocity", "0", "1", "0"), &["--points 0"]);
    refused(&range("belt_velocity", "0", "0", "3"), &["equal ends"]);
    refused(
        &range("normal_force", "-1", "5", "3"),
        &["-1 N", "least value 0 N"],
    );
    refused(&range("tip_displacement", "0", "1", "3"), &["result"]);
    refused(&range("mode_count", "1", "2", "3"), &["whole numbers"]);
    let set = ["--set", "belt_velocity=0.1"];
    refused(
        &[&range("belt_velocity", "0", "1", "3")[..], &set].concat(),
        &["varied"],
    );
    let grid = ["--grid", "5"];
    refused(
        &[&range("belt_velocity", "0", "1", "3")[..], &grid].concat(),
        &["--grid 5", "5x3"],
    );
    refused(
        &["--parameter", "belt_velocity", "--values", "0.1,0.1"],
        &["twice"],
    );
}

// Source: the model: a natural frequency of zero is refused by the physics with its reason.
#[test]
fn val_a_point_that_fails_is_recorded_with_its_reason_and_the_others_are_kept() {
    let folder = Folder::new();
    let arguments = ["--parameter", "mode[1].frequency", "--values", "0,80", "-o"];
    let out = folder.text("out");
    let done = sweep(&[&arguments[..], &[&out], &SHORT].concat());
    assert!(done.status.success(), "{}", said(&done));
    let table = read(&folder.path("out/sweep.csv"));
    let line = table.lines().nth(1).unwrap();
    assert!(line.starts_with("0,fixed,,,,,,"), "{line}");
    assert!(line.contains("failed: mode[1].frequency = 0 Hz"), "{line}");
    let whole = table.lines().nth(2).unwrap();
    assert!(whole.starts_with("80,fixed,0,33."), "{table}");
    // Going on takes it as done.
    assert!(
        sweep(&[&arguments[..], &[&out], &SHORT].concat())
            .status
            .success()
    );
    assert_eq!(read(&folder.path("out/sweep.csv")), table);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said_and_finished_points_are_kept() {
    let folder = Folder::new();
    let long = ["--settle", "4000", "--cycles", "400", "--threads", "1"];
    let out = folder.text("out");
    let options = [&RANGE[..], &long, &["-o", &out]].concat();
    // A limit on the size of files stands for a full disk: 64 KiB hold the section points of two rows.
    let script = format!(
        "trap '' XFSZ; exec {} sweep --fmu {} {}",
        env!("CARGO_BIN_EXE_stickslip"),
        fmu().display(),
        options.join(" ")
    );
    let child = Command::new("bash")
        .args(["-c", &script])
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while !folder.path("out/sweep.csv").exists() {
        std::thread::yield_now();
    }
    let limited = Command::new("prlimit")
        .args(["--fsize=65536", "--pid", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(limited.success());
    let cut = child.wait_with_output().unwrap();
    assert_eq!(cut.status.code(), Some(4), "{}", said(&cut));
    assert!(said(&cut).contains("section.csv"), "{}", said(&cut));
    let kept = read(&folder.path("out/sweep.csv")).lines().count() - 1;
    assert!((1..7).contains(&kept), "{kept}");
    let again = sweep(&options);
    assert!(again.status.success(), "{}", said(&again));
    assert_eq!(
        read(&folder.path("out/section.csv")).lines().count(),
        1 + 7 * 400
    );
}

/// The FMU, packed once for all tests.
fn fmu() -> &'static Path {
    static FMU: OnceLock<(tempfile::TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = FMU.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("model.fmu");
        let done = Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .args(["pack", "-o", path.to_str().unwrap()])
            .output()
            .unwrap();
        assert!(done.status.success(), "{}", said(&done));
        (folder, path)
    });
    path
}

// Source: the branch found by Newton's method must pass the motion that direct simulation found.
#[test]
fn val_orbits_pass_the_motions_found_and_the_bifurcation_is_named() {
    let folder = Folder::new();
    let out = folder.text("out");
    let range = [
        "--parameter",
        "belt_velocity",
        "--values",
        "0.097,0.1,0.106",
    ];
    let done = sweep(&[&range[..], &["--orbits", "-o", &out]].concat());
    assert!(done.status.success(), "{}", said(&done));
    let bifurcations = read(&folder.path("out/bifurcations.csv"));
    assert!(bifurcations.contains("neimark_sacker"), "{bifurcations}");
    let amplitude: f64 = read(&folder.path("out/sweep.csv"))
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .nth(4)
        .unwrap()
        .parse()
        .unwrap();
    let orbits = read(&folder.path("out/orbits.csv"));
    let nearest = orbits
        .lines()
        .skip(1)
        .map(|line| line.split(',').collect::<Vec<_>>())
        .filter(|f| f[1] == "0.097")
        .map(|f| (f[5].parse::<f64>().unwrap() - amplitude).abs())
        .fold(f64::INFINITY, f64::min);
    assert!(nearest < 1e-8 * amplitude, "{nearest}");
    assert!(orbits.lines().any(|l| l.split(',').nth(2) == Some("0")));
    assert!(read(&folder.path("out/sweep.svg")).contains("orbit, unstable"));
}

#[test]
fn maps_and_grids_of_starts_have_a_row_for_each() {
    let folder = Folder::new();
    let arguments = [
        "--parameter",
        "belt_velocity",
        "--values",
        "0.1,0.2",
        "--second-parameter",
        "normal_force",
        "--second-values",
        "40,100",
        "--start",
        "grid",
        "--grid",
        "2x2",
        "--json",
        "-o",
    ];
    let done = sweep(&[&arguments[..], &[&folder.text("out")], &SHORT].concat());
    assert!(done.status.success(), "{}", said(&done));
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!(json["rows"].as_array().unwrap().len(), 2 * 2 * 4);
    let mut share = std::collections::HashMap::new();
    for group in json["coexisting"].as_array().unwrap() {
        *share.entry(group["at"].to_string()).or_insert(0.0) += group["share"].as_f64().unwrap();
    }
    assert_eq!(share.len(), 4);
    assert!(share.values().all(|s| (s - 1.0).abs() < 1e-12), "{share:?}");
}

// Source: the catalogue's effect of the same equation, F_N (1 + k w), integrated by other means (power series).
#[test]
fn val_a_users_formula_is_swept_as_the_catalogue_effect_that_says_the_same() {
    let folder = Folder::new();
    let formula = r#"
id = "spring_load"
title = "Deflection presses the beam on the belt"
target = "normal_force_factor"
expression = "1 + k*w"
[[parameter]]
name = "k"
unit = "1/m"
min = -200
max = 200
typical = 50
"#;
    std::fs::write(folder.path("spring_load.toml"), formula).unwrap();
    let own = folder.text("own.fmu");
    let packed = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args([
            "pack",
            "--effect",
            &folder.text("spring_load.toml"),
            "-o",
            &own,
        ])
        .output()
        .unwrap();
    assert!(packed.status.success(), "{}", said(&packed));
    let amplitudes = |fmu: &str, parameter: &str| -> Vec<f64> {
        let out = folder.text(parameter);
        let output = Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .args(["sweep", "--fmu", fmu, "--parameter", parameter, "-o", &out])
            .args(["--values", "0,20,60", "--set", "normal_force=80"])
            .args(SHORT)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", said(&output));
        let table = read(&Path::new(&out).join("sweep.csv"));
        let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
        let column = header.iter().position(|h| *h == "amplitude_m").unwrap();
        let field = |line: &str| line.split(',').nth(column).unwrap().parse().unwrap();
        table.lines().skip(1).map(field).collect()
    };
    let of_formula = amplitudes(&own, "spring_load.k");
    let of_catalogue = amplitudes(fmu().to_str().unwrap(), "normal_force_coupling.coefficient");
    assert_eq!(of_formula.len(), 3);
    assert!(
        (of_formula[2] / of_formula[0] - 1.0).abs() > 1e-3,
        "the effect does something"
    );
    for (a, b) in of_formula.iter().zip(&of_catalogue) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
}
