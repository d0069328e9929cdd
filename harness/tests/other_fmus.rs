//! An FMU of another make, a block on a belt written in C (tests/foreign), diagnosed by means of its side file.
//! val: the motions come from this project's FMU, which shares nothing with it but the physics: another law of the same shape, events
//! located by another method, values that the FMU is not told.

mod foreign;

use foreign::Foreign;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Belt velocities in m/s and normal forces in N.
const POINTS: [(f64, f64); 4] = [(0.06, 8.0), (0.1, 10.0), (0.12, 14.0), (0.08, 12.0)];
/// Seconds left out, so that the motion has settled, and seconds recorded.
const SKIPPED: f64 = 2.0;
const RECORDED: f64 = 2.0;
/// Noise of the sensor in m.
const NOISE: f64 = 5e-6;
/// Cubic stiffness that is hidden, N/m3: a twentieth of the spring's force.
const HIDDEN: f64 = 1e7;

const SIDE_FILE: &str = include_str!("foreign/mass_on_belt.effects.toml");

fn stickslip(words: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A record of displacements in m.
fn record(folder: &Path, point: (f64, f64), cubic: f64, seed: u64) -> String {
    let of = ("tip_displacement", "tip_displacement_m", NOISE);
    simulated(folder, point, cubic, of, seed)
}

/// A record of velocities in m/s.
fn velocities(folder: &Path, point: (f64, f64), seed: u64) -> String {
    let of = ("tip_velocity", "tip_velocity_m_per_s", 1e-4);
    simulated(folder, point, 0.0, of, seed)
}

/// A record of an output of a block whose constants are some percent off what campaign and FMU state, under this name and with noise
/// of this standard deviation.
fn simulated(
    folder: &Path,
    (belt, force): (f64, f64),
    cubic: f64,
    (output, column, noise): (&str, &str, f64),
    seed: u64,
) -> String {
    let duration = (SKIPPED + RECORDED).to_string();
    let sets = [
        ("mode_count", 1.0),
        ("mode[1].frequency", 6.03),
        ("mode[1].damping_ratio", 0.0055),
        ("mode[1].mass", 1.01),
        ("mode[1].tip_value", 1.0),
        ("friction.mu_0", 0.42),
        ("friction.a1", 0.4),
        ("friction.v1", 0.055),
        ("friction.a2", 0.0),
        ("belt_velocity", belt),
        ("normal_force", force),
        ("cubic_stiffness.coefficient", cubic),
    ];
    let sets = sets.map(|(name, value)| format!("--set={name}={value}"));
    let mut words = vec!["simulate", "--duration", &duration, "--step", "0.002"];
    words.extend(["--variables", output]);
    words.extend(sets.iter().map(String::as_str));
    let output = stickslip(&words, folder);
    assert!(output.status.success(), "{}", said(&output));
    let mut random = fastrand::Rng::with_seed(seed);
    let mut csv = format!("time_s,{column}\n");
    let text = String::from_utf8(output.stdout).unwrap();
    let rows = text.lines().filter(|l| !l.starts_with('#')).skip(1);
    for row in rows {
        let mut cells = row.split(',').map(|cell| cell.parse::<f64>().unwrap());
        let (t, w) = (cells.next().unwrap(), cells.next().unwrap());
        if t >= SKIPPED {
            let radius = (-2.0 * (1.0 - random.f64()).ln()).sqrt();
            let noise = noise * radius * (std::f64::consts::TAU * random.f64()).cos();
            let _ = writeln!(csv, "{:.4},{:.9e}", t - SKIPPED, w + noise);
        }
    }
    csv
}

/// A folder with a campaign of the block.
fn campaign(folder: &Path, cubic: f64) -> PathBuf {
    let campaign = folder.join("campaign");
    std::fs::create_dir(&campaign).unwrap();
    let mut toml = String::from(
        "[beam]\nnatural_frequencies_hz = [6.0]\ndamping_ratios = [0.005]\nmasses_kg = [1.0]\ntip_values = [1.0]\n\
         [channels]\ndisplacement_column = \"tip_displacement_m\"\n",
    );
    for (i, point) in POINTS.into_iter().enumerate() {
        let csv = record(folder, point, cubic, i as u64);
        std::fs::write(campaign.join(format!("run{i}.csv")), csv).unwrap();
        let _ = write!(
            toml,
            "[[run]]\nfile = \"run{i}.csv\"\nbelt_velocity_m_per_s = {:?}\nnormal_force_n = {:?}\n",
            point.0, point.1
        );
    }
    std::fs::write(campaign.join("campaign.toml"), toml).unwrap();
    campaign
}

/// The FMU with this side file beside it.
fn fmu_with(foreign: &Foreign, side_file: &str) -> PathBuf {
    let fmu = foreign.fmu();
    std::fs::write(fmu.with_extension("effects.toml"), side_file).unwrap();
    fmu
}

/// What is diagnosed from a campaign with this hidden cubic stiffness, and the folder with the results.
fn diagnosed(cubic: f64) -> (Value, tempfile::TempDir) {
    let foreign = Foreign::new("mass_on_belt");
    let fmu = fmu_with(&foreign, SIDE_FILE);
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path(), cubic);
    let words = ["diagnose", "campaign", "--json", "-o", "out", "--fmu"];
    let output = stickslip(
        &[&words[..], &[fmu.to_str().unwrap()]].concat(),
        folder.path(),
    );
    assert!(output.status.success(), "{}", said(&output));
    (serde_json::from_slice(&output.stdout).unwrap(), folder)
}

#[test]
fn val_friction_that_each_run_has_by_itself_is_followed_in_velocities() {
    let foreign = Foreign::new("mass_on_belt");
    let dynamic = "variable = \"friction.mu_d\"\nstd = 0.1\n";
    assert!(SIDE_FILE.contains(dynamic));
    let per_run = SIDE_FILE.replace(dynamic, &format!("{dynamic}per_run = true\n"));
    // A velocity does not tell the level of the force.
    let side_file = format!("friction_coefficient = 0.3\n{per_run}");
    let fmu = fmu_with(&foreign, &side_file);
    let folder = tempfile::tempdir().unwrap();
    let campaign = campaign(folder.path(), 0.0);
    for (run, point) in POINTS.into_iter().enumerate() {
        let csv = velocities(folder.path(), point, run as u64);
        std::fs::write(campaign.join(format!("run{run}.csv")), csv).unwrap();
    }
    let toml = campaign.join("campaign.toml");
    let text = std::fs::read_to_string(&toml).unwrap();
    let columns = [
        "displacement_column = \"tip_displacement_m\"",
        "velocity_column = \"tip_velocity_m_per_s\"",
    ];
    std::fs::write(&toml, text.replace(columns[0], columns[1])).unwrap();
    let words = [
        "diagnose",
        "campaign",
        "--json",
        "-o",
        "out",
        "--fmu",
        fmu.to_str().unwrap(),
    ];
    let output = stickslip(&words, folder.path());
    assert!(output.status.success(), "{}", said(&output));
    let diagnosis: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        diagnosis["verdict"], "no_missing_effect",
        "{}",
        diagnosis["summary"]
    );
    let starts = std::fs::read_to_string(folder.path().join("out/runs/run2.ssv")).unwrap();
    assert!(starts.contains("name=\"friction.mu_d\""), "{starts}");
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn val_a_spring_that_hardens_is_missing_in_an_fmu_of_another_make() {
    let (diagnosis, folder) = diagnosed(HIDDEN);
    let effects = diagnosis["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{}", diagnosis["summary"]);
    assert_eq!(effects[0]["id"], "hardening_spring");
    let found = &effects[0]["parameters"]["spring.c3"];
    let off = number(&found["value"]) - HIDDEN;
    assert!(off.abs() < 3.0 * number(&found["std"]), "{found}");
    assert!(number(&found["std"]) < 0.05 * HIDDEN, "{found}");
    assert_eq!(found["unit"], "N/m3");
    let ladder = diagnosis["error_ladder"].as_array().unwrap();
    assert!(number(&ladder.last().unwrap()["holdout_over_noise"]) < 1.3);
    // Constants under the FMU's own names, which a master gives it.
    let spring = &diagnosis["calibrated"]["spring.c"];
    let stiffness = 1.01 * (std::f64::consts::TAU * 6.03).powi(2);
    let off = number(&spring["value"]) - stiffness;
    assert!(off.abs() < 3.0 * number(&spring["std"]), "{spring}");
    let out = folder.path().join("out");
    let parameters = std::fs::read_to_string(out.join("mass_on_belt.ssv")).unwrap();
    assert!(parameters.contains("name=\"spring.c3\""), "{parameters}");
    assert!(parameters.contains("name=\"friction.v_s\""), "{parameters}");
    let calibrated = stickslip::fmu::Fmu::load(&out.join("mass_on_belt.fmu")).unwrap();
    let start = calibrated.variable("spring.c3").unwrap().start_number();
    assert_eq!(start, Some(number(&found["value"])));
    // It carries its side file along, so that a comparison starts where the record does.
    let words = [
        "compare",
        "campaign",
        "--json",
        "-o",
        "compared",
        "--fmu",
        "out/mass_on_belt.fmu",
    ];
    let compared = stickslip(&words, folder.path());
    assert!(compared.status.success(), "{}", said(&compared));
    let compared: Value = serde_json::from_slice(&compared.stdout).unwrap();
    for run in compared["runs"].as_array().unwrap() {
        assert!(number(&run["nrmse"]) < 0.01, "{run:#}");
        let over_noise = number(&run["nrmse_from_start_states"]) / number(&run["noise_floor"]);
        assert!(over_noise < 1.5, "{run:#}");
    }
    let again = stickslip(
        &[
            "diagnose",
            "campaign",
            "-o",
            "again",
            "--fmu",
            "out/mass_on_belt.fmu",
        ],
        folder.path(),
    );
    let refused = said(&again);
    assert!(
        refused.contains("an amplitude must be 0 there"),
        "{refused}"
    );
    let starts = std::fs::read_to_string(out.join("runs/run0.csv")).unwrap();
    let header = starts.lines().next().unwrap();
    assert_eq!(
        header,
        "start_s,end_s,measured_m,s_start,v_start,sensor_offset"
    );
    // The side file is among what the result rests on.
    let inputs = diagnosis["provenance"]["inputs"].to_string();
    assert!(inputs.contains("mass_on_belt.effects.toml"), "{inputs}");
}

#[test]
fn val_nothing_is_missing_in_an_fmu_of_another_make_that_has_all() {
    let (diagnosis, _folder) = diagnosed(0.0);
    assert_eq!(
        diagnosis["verdict"], "no_missing_effect",
        "{}",
        diagnosis["summary"]
    );
    let ladder = diagnosis["error_ladder"].as_array().unwrap();
    assert!(number(&ladder.last().unwrap()["holdout_over_noise"]) < 1.3);
}

/// The message with which `diagnose` refuses a side file.
fn refused(foreign: &Foreign, folder: &Path, side_file: Option<&str>) -> String {
    let fmu = match side_file {
        Some(text) => fmu_with(foreign, text),
        None => foreign.fmu(),
    };
    let words = ["diagnose", "campaign", "-o", "out", "--fmu"];
    let output = stickslip(&[&words[..], &[fmu.to_str().unwrap()]].concat(), folder);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    let place = fmu.parent().unwrap().display().to_string();
    said(&output).replace(&format!("{place}/"), "")
}

#[test]
fn side_files_that_do_not_fit_are_refused_with_line_and_remedy() {
    let folder = tempfile::tempdir().unwrap();
    campaign(folder.path(), 0.0);
    let foreign = Foreign::new("mass_on_belt");
    let message = refused(&foreign, folder.path(), None);
    assert!(
        message.contains("no variable 'q[1]', and no mass_on_belt.effects.toml beside it"),
        "{message}"
    );
    let line_of = |text: &str| 1 + SIDE_FILE.lines().position(|l| l == text).unwrap();
    for (what, instead, expected) in [
        (
            "belt_velocity = \"vBelt\"",
            "belt_velocity = \"v_belt\"",
            "variable 'v_belt' of the FMU does not exist; like it: vBelt",
        ),
        (
            "normal_force = \"load\"",
            "normal_load = \"load\"",
            "'normal_load' is no name that [variables] knows",
        ),
        (
            "friction_force = \"friction.f\"",
            "friction_force = \"friction.mode\"",
            "variable 'friction.mode' of the FMU is no Real",
        ),
        (
            "start = \"s_start\"",
            "start = \"block.s\"",
            "has no start value that could be set",
        ),
        ("std = 0.3", "std = -0.3", "standard deviation of -0.3"),
        ("std = 0.3", "", "needs either std, as a share"),
        (
            "role = \"amplitude\"",
            "role = \"strength\"",
            "has the role 'strength'",
        ),
        (
            "typical = 1.0",
            "typical = 50.0",
            "min = 0, typical = 50, max = 20",
        ),
        (
            "id = \"viscous_contact\"",
            "id = \"hardening_spring\"",
            "is there twice",
        ),
        ("min = 0.0", "least = 0.0", "unknown field `least`"),
        ("typical = 1.0", "typical = 0.0", "has typical = 0"),
        (
            "min = 0.0",
            "min = 0.5",
            "0, which switches the effect off, must be allowed",
        ),
        (
            "variable = \"friction.d\"",
            "variable = \"damper.d\"",
            "'damper.d' of the FMU is set twice",
        ),
        (
            "id = \"viscous_contact\"",
            "id = \"friction\"",
            "is called as constant 'friction.mu_s' begins",
        ),
        (
            "id = \"viscous_contact\"",
            "id = \"term_viscous\"",
            "are those of the library",
        ),
        (
            "belt_velocity = \"vBelt\"",
            "belt_velocity = \"block.v\"",
            "has no start value that could be set",
        ),
    ] {
        assert!(SIDE_FILE.contains(what), "{what}");
        let text = SIDE_FILE.replacen(what, instead, 1);
        let message = refused(&foreign, folder.path(), Some(&text));
        assert!(message.contains(expected), "{what}: {message}");
        let near = |line: usize| message.contains(&format!("mass_on_belt.effects.toml:{line}: "));
        // The line of the key, or that of the table's variable above it.
        let line = line_of(what);
        assert!(
            (line.saturating_sub(3)..=line).any(near),
            "{what}: {message}"
        );
    }
    let one_state = SIDE_FILE.replacen(
        "[[state]]\nstart = \"v_start\"\nvalue = \"block.v\"\n",
        "",
        1,
    );
    let message = refused(&foreign, folder.path(), Some(&one_state));
    assert!(
        message.contains("1 tables [[state]], but the 1 modes"),
        "{message}"
    );
    let unnamed = SIDE_FILE.replacen("belt_velocity = \"vBelt\"", "", 1);
    let message = refused(&foreign, folder.path(), Some(&unnamed));
    assert!(
        message.contains("belt_velocity differs between the runs"),
        "{message}"
    );
    let unseen = SIDE_FILE.replacen("tip_displacement = \"block.s\"", "", 1);
    let message = refused(&foreign, folder.path(), Some(&unseen));
    assert!(
        message.contains("tip_displacement is asked for"),
        "{message}"
    );
    let in_mm = foreign.with_xml(|xml| {
        let of = |unit: &str| {
            format!("description=\"displacement of the block\"><Real unit=\"{unit}\"/>")
        };
        assert!(xml.contains(&of("m")));
        xml.replacen(&of("m"), &of("mm"), 1)
    });
    std::fs::write(in_mm.with_extension("effects.toml"), SIDE_FILE).unwrap();
    let words = [
        "diagnose",
        "campaign",
        "-o",
        "out",
        "--fmu",
        in_mm.to_str().unwrap(),
    ];
    let message = said(&stickslip(&words, folder.path()));
    assert!(
        message.contains("'block.s' of the FMU is in mm"),
        "{message}"
    );
    let toml = folder.path().join("campaign/campaign.toml");
    let text = std::fs::read_to_string(&toml).unwrap();
    std::fs::write(&toml, text.replace("masses_kg = [1.0]\n", "")).unwrap();
    let message = refused(&foreign, folder.path(), Some(SIDE_FILE));
    assert!(
        message.contains("does not state the structure"),
        "{message}"
    );
}
