//! Runs driven by inputs that were measured along with the displacement, through the commands.

mod rig;

use rig::runge_kutta;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

const MASS: f64 = 0.5;
/// Natural frequency and the drive's in rad/s.
const OWN: f64 = 150.0;
const DRIVE: f64 = 95.0;
const FORCE: f64 = 4.0;
const INTERVAL: f64 = 4e-3;
/// Mass in kg of the oscillator with a cubic stiffness.
const OSCILLATOR: f64 = 0.4;

fn stickslip(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// A column of a CSV by its place.
fn of_column(csv: &str, at: usize) -> Vec<f64> {
    let cells = csv.lines().skip(1).map(|row| row.split(',').nth(at));
    cells.map(|cell| cell.unwrap().parse().unwrap()).collect()
}

/// Displacement in m of `m y'' + m w^2 y = F sin(W t)` from rest.
fn response(t: f64) -> f64 {
    let gain = FORCE / MASS / (OWN * OWN - DRIVE * DRIVE);
    gain * ((DRIVE * t).sin() - DRIVE / OWN * (OWN * t).sin())
}

/// A campaign of one run without a belt and without friction, its force written in mN; `keys` belong to the run.
fn campaign(keys: &str, row: impl Fn(usize) -> Option<f64>) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut csv = String::from("time_s,tip_displacement_m,shaker [mN],load [N]\n");
    for i in 0..700 {
        if let Some(t) = row(i) {
            let (y, push) = (response(t), 1e3 * FORCE * (DRIVE * t).sin());
            let _ = writeln!(csv, "{t},{y},{push},{}", t - 0.1);
        }
    }
    std::fs::write(folder.path().join("shaken.csv"), csv).unwrap();
    let text = format!(
        "[beam]\nnatural_frequencies_hz = [{}]\ndamping_ratios = [0.0]\nmass_kg = {MASS}\ntip_values = [1.0]\n\
         [[run]]\nfile = \"shaken.csv\"\n{keys}",
        OWN / std::f64::consts::TAU
    );
    std::fs::write(folder.path().join("campaign.toml"), text).unwrap();
    folder
}

const STILL: &str =
    "belt_velocity_m_per_s = 0\nnormal_force_n = 0\nexternal_force_column = \"shaker\"\n";

fn even(i: usize) -> Option<f64> {
    Some(INTERVAL * i as f64)
}

fn nrmse(folder: &Path) -> f64 {
    compared(folder)["nrmse"].as_f64().unwrap()
}

/// What `compare` says of the run.
fn compared(folder: &Path) -> Value {
    let output = stickslip(&["compare", ".", "--json"], folder);
    assert!(output.status.success(), "{}", said(&output));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    json["runs"][0].clone()
}

// Source: closed form of the undamped oscillator under a sine, from rest; 17 samples a period of the drive.
#[test]
fn val_compare_follows_a_measured_force() {
    let with = |keys: &str| nrmse(campaign(&format!("{STILL}{keys}"), even).path());
    let band_limited = with("");
    assert!(band_limited < 2e-3, "{band_limited}");
    let linear = with("input_interpolation = \"linear\"\n");
    // A straight line takes (W h)^2/12 = 1.2 % off the force.
    assert!((0.008..0.016).contains(&linear), "{linear}");
    let held = with("input_interpolation = \"held\"\n");
    assert!(held > 10.0 * linear, "{held}");
    // Without even samples there are straight lines, across the gap too.
    let gap = |i: usize| even(i).filter(|_| !(300..303).contains(&i));
    let uneven = compared(campaign(STILL, gap).path());
    let remark = "external_force from column 'shaker', linear";
    assert!(uneven["remarks"].to_string().contains(remark), "{uneven}");
    assert!(uneven["nrmse"].as_f64().unwrap() > linear);
}

// Source: the same closed form: nothing rubs, so that all of the motion is the shaker's.
#[test]
fn val_observe_takes_off_what_a_shaker_does() {
    let keys = format!("{STILL}input_interpolation = \"band_limited\"\n");
    let folder = campaign(&keys, even);
    let words = [
        "observe",
        "shaken.csv",
        "--campaign",
        ".",
        "--method",
        "kalman",
    ];
    let output = stickslip(&words, folder.path());
    assert!(output.status.success(), "{}", said(&output));
    let csv = std::fs::read_to_string(folder.path().join("observer/force.csv")).unwrap();
    let force = of_column(&csv, 1);
    let rms = (force.iter().map(|f| f * f).sum::<f64>() / force.len() as f64).sqrt();
    assert!(rms < 0.05 * FORCE, "{rms} N");
}

// Source: closed form w = F_0 t^2/(2 m) + r t^3/(6 m) of a free mass under F_0 + r t; with friction it breaks away at
// mu_s F_N/r.
#[test]
fn val_simulate_takes_inputs_from_a_file() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("in.csv"),
        "time,external_force [kN]\n0,0.002\n0.5,0.004\n1.25,0.007\n",
    )
    .unwrap();
    let last = |load: &str| {
        let mut arguments = vec!["simulate", "--input", "in.csv", "--belt-velocity", "0"];
        arguments.extend([
            "--normal-force",
            load,
            "--duration",
            "1.25",
            "--step",
            "0.25",
        ]);
        arguments.extend(["--set", "mode_count=1", "--set", "mode[1].frequency=0"]);
        arguments.extend(["--set", "mode[1].mass=2", "--set", "mode[1].tip_value=1"]);
        arguments.extend(["--set", "friction.law=3", "--set", "friction.mu_s=0.5"]);
        arguments.extend(["--set", "friction.mu_k=0.5"]);
        arguments.extend(["--variables", "tip_displacement,last_transition_time"]);
        let output = stickslip(&arguments, folder.path());
        assert!(output.status.success(), "{}", said(&output));
        let text = String::from_utf8(output.stdout).unwrap();
        let row = text.lines().last().unwrap();
        let cells: Vec<f64> = row.split(',').map(|c| c.parse().unwrap()).collect();
        (cells[1], cells[2])
    };
    // 2 N + 4 N/s t throughout.
    let (t, mass): (f64, f64) = (1.25, 2.0);
    let way = |force: f64, t: f64| (0.5 * force * t * t + 4.0 * t.powi(3) / 6.0) / mass;
    let (free, _) = last("0");
    assert!((free / way(2.0, t) - 1.0).abs() < 1e-10, "{free}");
    let (held, away) = last("8");
    assert!((away - 0.5).abs() < 1e-10, "{away}");
    assert!((held / way(0.0, t - away) - 1.0).abs() < 1e-8, "{held}");
}

#[test]
fn inputs_that_do_not_fit_are_refused_with_what_to_do() {
    let message = |keys: &str, command: &str| {
        let folder = campaign(keys, even);
        let output = stickslip(&[command, "."], folder.path());
        assert_eq!(output.status.code(), Some(2), "{keys}: {}", said(&output));
        said(&output)
    };
    let cases = [
        ("normal_force_n = 1\n", "lacks belt_velocity_m_per_s"),
        (
            "belt_velocity_m_per_s = 0\nnormal_force_n = 1\nnormal_force_column = \"load\"\n",
            "both normal_force_n and normal_force_column",
        ),
        (
            "belt_velocity_m_per_s = 0\nnormal_force_column = \"load\"\n",
            "sample 1: normal force -0.1 N is below zero",
        ),
        (
            "belt_velocity_m_per_s = 0\nnormal_force_n = 1\nexternal_force_column = \"shakre\"\n",
            "shaker",
        ),
        (
            "belt_velocity_column = \"load\"\nnormal_force_n = 1\n",
            "where a velocity is needed",
        ),
    ];
    for (keys, part) in cases {
        let text = message(keys, "compare");
        assert!(text.contains(part), "{part}: {text}");
    }
    let gap = |i: usize| even(i).filter(|_| i != 300);
    let folder = campaign(
        &format!("{STILL}input_interpolation = \"band_limited\"\n"),
        gap,
    );
    let text = said(&stickslip(&["compare", "."], folder.path()));
    assert!(
        text.contains("1 gaps") && text.contains("\"linear\""),
        "{text}"
    );
    let folder = campaign(STILL, even);
    let arguments = ["compare", ".", "--set", "external_force=1"];
    let text = said(&stickslip(&arguments, folder.path()));
    assert!(text.contains("is an input"), "{text}");
}

/// What `try` says of a campaign in `folder` with effects added.
fn tried(folder: &Path, effects: &[&str]) -> Value {
    let added = effects.iter().flat_map(|effect| ["--add", effect]);
    let arguments: Vec<&str> = ["try", ".", "-o", "tried"]
        .into_iter()
        .chain(added)
        .collect();
    let output = stickslip(&arguments, folder);
    assert!(output.status.success(), "{}", said(&output));
    let text = std::fs::read_to_string(folder.join("tried/diagnosis.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Standard normal numbers: sums of twelve even ones.
fn noise(random: &mut fastrand::Rng) -> f64 {
    (0..12).map(|_| random.f64()).sum::<f64>() - 6.0
}

/// A force in N that holds six sines, like a shaker's.
fn shaking(t: f64) -> f64 {
    let lines = [3.1, 7.7, 12.9, 18.3, 23.1, 31.7];
    let sines = lines.iter().enumerate();
    sines
        .map(|(i, f)| (std::f64::consts::TAU * f * t + 1.7 * i as f64).sin())
        .sum()
}

/// What `try` makes of the cubic stiffness hidden in an oscillator that [`shaking`] drives, classical Runge-Kutta at a hundredth of
/// the sample interval. `column` heads what the record has of the drive, `share` times its force in N; `beam` and `run` are keys of
/// campaign.toml.
fn finds_the_cubic_stiffness(column: &str, share: f64, [beam, run]: [&str; 2]) {
    let (mass, damper, spring, cubic) = (OSCILLATOR, 2.5, 6000.0, 4.0e8);
    let rates = |t: f64, [y, v]: [f64; 2]| {
        [
            v,
            (shaking(t) - damper * v - spring * y - cubic * y.powi(3)) / mass,
        ]
    };
    let (mut state, h) = ([0.0, 0.0], 1e-5);
    let mut random = fastrand::Rng::with_seed(3);
    let mut csv = format!("time_s,tip_displacement_m,{column}\n");
    for i in 0..1500 {
        let t = 1e-3 * f64::from(i);
        let y = state[0] + 2e-7 * noise(&mut random);
        let _ = writeln!(csv, "{t},{y},{}", share * shaking(t));
        for k in 0..100 {
            state = runge_kutta::step(rates, t + h * f64::from(k), state, h);
        }
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("shaken.csv"), csv).unwrap();
    let frequency = (spring / mass).sqrt() / std::f64::consts::TAU;
    let ratio = damper / (2.0 * (spring * mass).sqrt());
    let text = format!(
        "[beam]\nnatural_frequencies_hz = [{frequency}]\ndamping_ratios = [{ratio}]\nmass_kg = {mass}\n\
         tip_values = [1.0]\n{beam}[[run]]\nfile = \"shaken.csv\"\n{run}"
    );
    // What a mass on a spring has of a shaking clamp has to be stated, and only that.
    for (text, asks) in [
        (text.replace("clamp_shares = [1.0]\n", ""), !beam.is_empty()),
        (text, false),
    ] {
        std::fs::write(folder.path().join("campaign.toml"), text).unwrap();
        let output = stickslip(&["check", "."], folder.path());
        let checked = String::from_utf8_lossy(&output.stdout);
        assert_eq!(checked.contains("state clamp_shares"), asks, "{checked}");
    }
    let json = tried(folder.path(), &["cubic_stiffness"]);
    let step = &json["error_ladder"].as_array().unwrap()[2];
    let left = step["holdout_over_noise"].as_f64().unwrap();
    assert!(left < 1.3, "{step}");
    let found = &json["candidates"][0]["parameters"]["cubic_stiffness.coefficient"];
    let found = found.as_f64().unwrap_or_else(|| panic!("{json}"));
    assert!((found / cubic - 1.0).abs() < 0.01, "{found} N/m^3");
}

// Source: classical Runge-Kutta.
#[test]
fn val_a_shaken_oscillator_shows_its_cubic_stiffness() {
    finds_the_cubic_stiffness("shaker [N]", 1.0, ["", STILL]);
}

// Source: classical Runge-Kutta; relative to a clamp with acceleration a, a mass m moves as under the force -m a.
#[test]
fn val_an_oscillator_on_a_shaking_clamp_shows_its_cubic_stiffness() {
    let run =
        "belt_velocity_m_per_s = 0\nnormal_force_n = 0\nclamp_acceleration_column = \"frame\"\n";
    let beam = "clamp_shares = [1.0]\n";
    finds_the_cubic_stiffness("frame [m/s^2]", -1.0 / OSCILLATOR, [beam, run]);
}

/// A carriage of 95 kg that a servo drive moves along `path`, its force in N held for each ms: viscous friction of 203.5 N s/m, dry
/// friction of 20.4 N and a constant force of 3.2 N; explicit steps of 20 us. The CSV text, with 2 um of noise.
fn driven_carriage(path: impl Fn(f64) -> f64, seed: u64) -> String {
    let (mass, viscous, dry, offset) = (95.0, 203.5, 20.4, 3.2);
    let h = 2e-5;
    let (mut x, mut v, mut sticks) = (path(0.0), 0.0, true);
    let mut random = fastrand::Rng::with_seed(seed);
    let mut csv = String::from("time_s,tip_displacement_m,external_force_n\n");
    for i in 0..6000 {
        let t = 1e-3 * f64::from(i);
        let motor: f64 = 35.0 * (240.0 * (160.0 * (path(t) - x) - v)).clamp(-10.0, 10.0);
        let measured = x + 2e-6 * noise(&mut random);
        let _ = writeln!(csv, "{t},{measured},{motor}");
        for _ in 0..50 {
            let push = motor + offset;
            if sticks && push.abs() <= dry {
                continue;
            }
            let way = if sticks { push.signum() } else { v.signum() };
            let next = v + h * (push - viscous * v - dry * way) / mass;
            sticks = next * way <= 0.0;
            let next = if sticks { 0.0 } else { next };
            x += 0.5 * h * (v + next);
            v = next;
        }
    }
    csv
}

// Source: explicit steps of 20 us; the constants are near those published for a servo axis (Janot, Gautier and Brunot 2019,
// workshop on nonlinear system identification benchmarks).
#[test]
fn val_a_servo_axis_shows_its_viscous_guide_and_the_direction_in_which_it_slides_more_easily() {
    let folder = tempfile::tempdir().unwrap();
    let tau = std::f64::consts::TAU;
    let slow = |t: f64| 0.12 * (tau * 0.31 * t).sin() + 0.02 * (tau * 1.3 * t).sin();
    let fast = |t: f64| 0.09 * (tau * 0.43 * t).sin() + 0.03 * (tau * 0.9 * t).cos();
    let mut text = String::from(
        "[beam]\nnatural_frequencies_hz = [0]\ndamping_ratios = [0]\nmass_kg = 95.5\nmass_std_kg = 1\n\
         tip_values = [1]\n[channels]\nexternal_force_column = \"external_force_n\"\ninput_interpolation = \"held\"\n",
    );
    for (name, csv) in [
        ("slow", driven_carriage(slow, 5)),
        ("fast", driven_carriage(fast, 6)),
    ] {
        std::fs::write(folder.path().join(format!("{name}.csv")), csv).unwrap();
        let _ = write!(
            text,
            "[[run]]\nfile = \"{name}.csv\"\nbelt_velocity_m_per_s = 0\nnormal_force_n = 900\n"
        );
    }
    std::fs::write(folder.path().join("campaign.toml"), &text).unwrap();
    let value = |of: &Value| of["value"].as_f64().unwrap();
    let json = tried(folder.path(), &["term_constant_force"]);
    let rate = &json["calibrated"]["mode[1].damping_rate"];
    let off = value(rate) - 203.5 / 95.0;
    let std = rate["std"].as_f64().unwrap();
    assert!(off.abs() < 3.0 * std && std < 0.1, "{rate}");
    let repaired = std::fs::read_to_string(folder.path().join("tried/StickSlipBeam.ssv")).unwrap();
    let free = "name=\"mode[1].frequency\"><ssv:Real value=\"0.0\"";
    assert!(repaired.contains(free), "{repaired}");
    // A guide of which it is stated that it does not brake leaves the braking to friction.
    let at = folder.path().join("campaign.toml");
    std::fs::write(
        &at,
        text.replace("[channels]", "damping_rates_per_s = [0]\n[channels]"),
    )
    .unwrap();
    let without = tried(folder.path(), &["viscous_friction", "term_constant_force"]);
    assert!(without["calibrated"].get("mode[1].damping_rate").is_none());
    for (json, place) in [(&json, 0), (&without, 1)] {
        assert_eq!(json["verdict"], "effect_found", "{}", json["summary"]);
        let force = value(&json["effects"][place]["parameters"]["f"]);
        assert!((force / 3.2 - 1.0).abs() < 0.01, "{force} N");
        let mass = value(&json["calibrated"]["mass"]);
        assert!((mass / 95.0 - 1.0).abs() < 0.002, "{mass} kg");
    }
}

/// A carriage of 3.1 kg with dry friction of 8 N and a damper of 18 N s/m one way and 11 N s/m the other, which a force with rising
/// frequency moves: `amplitude` in N, the first frequency in Hz. Steps of 20 us of the trapezoidal rule; the CSV text, with 5 um of noise.
fn carriage_on_a_one_way_damper(amplitude: f64, frequency: f64, seed: u64) -> String {
    let (mass, dry) = (3.1, 8.0);
    let h = 2e-5;
    let tau = std::f64::consts::TAU;
    let force = |t: f64| amplitude * (tau * (frequency + 0.15 * t) * t).sin();
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    let mut random = fastrand::Rng::with_seed(seed);
    let mut csv = String::from("time_s,tip_displacement_m,external_force_n\n");
    for i in 0..3000 {
        let t = 1e-3 * f64::from(i);
        let _ = writeln!(csv, "{t},{},{}", x + 5e-6 * noise(&mut random), force(t));
        for k in 0..50 {
            let push = force(t + h * (f64::from(k) + 0.5));
            if v == 0.0 && push.abs() <= dry {
                continue;
            }
            let way = if v == 0.0 { push.signum() } else { v.signum() };
            // What is left of the step after the carriage has turned is passed from rest.
            let (mut from, mut left, mut way) = (v, h, way);
            loop {
                let damper = if way > 0.0 { 18.0 } else { 11.0 };
                let rate = 0.5 * left * damper / mass;
                let next = (from * (1.0 - rate) + left * (push - dry * way) / mass) / (1.0 + rate);
                if next * way >= 0.0 {
                    x += 0.5 * left * (from + next);
                    v = next;
                    break;
                }
                let share = from / (from - next);
                x += 0.5 * share * left * from;
                (from, left) = (0.0, left * (1.0 - share));
                v = 0.0;
                if push.abs() <= dry {
                    break;
                }
                way = push.signum();
            }
        }
    }
    csv
}

// Source: a simulation of its own, by the trapezoidal rule; 18 and 11 N s/m.
#[test]
fn val_a_carriage_on_a_one_way_damper_shows_by_how_much_the_ways_differ() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from(
        "[beam]\nnatural_frequencies_hz = [0]\ndamping_ratios = [0]\nmass_kg = 3.08\nmass_std_kg = 0.05\n\
         tip_values = [1]\n[channels]\nexternal_force_column = \"external_force_n\"\n",
    );
    for (seed, (amplitude, frequency)) in [(30.0, 0.8), (22.0, 1.3), (26.0, 0.5)]
        .into_iter()
        .enumerate()
    {
        let name = format!("run{seed}.csv");
        let csv = carriage_on_a_one_way_damper(amplitude, frequency, seed as u64);
        std::fs::write(folder.path().join(&name), csv).unwrap();
        let _ = write!(
            text,
            "[[run]]\nfile = \"{name}\"\nbelt_velocity_m_per_s = 0\nnormal_force_n = 30.4\n"
        );
    }
    std::fs::write(folder.path().join("campaign.toml"), &text).unwrap();
    // Nothing holds it in place, so that it need not come back.
    let checked = stickslip(&["check", "."], folder.path());
    assert!(checked.status.success(), "{}", said(&checked));
    let output = String::from_utf8(checked.stdout).unwrap();
    assert!(output.contains("Nothing contradicts"), "{output}");
    let json = tried(folder.path(), &["term_asymmetric_damping"]);
    assert_eq!(json["verdict"], "effect_found", "{}", json["summary"]);
    let damper = &json["effects"][0]["parameters"]["c"];
    let (value, std) = (
        damper["value"].as_f64().unwrap(),
        damper["std"].as_f64().unwrap(),
    );
    assert!((value - 7.0).abs() < 4.0 * std && std < 0.05, "{damper}");
    // A belt that rests has no speed that could be misstated.
    assert!(json["inputs"].get("belt_velocity.scale").is_none());
    assert!(json["inputs"].get("normal_force.scale").is_some());
}

#[test]
fn a_pushed_mass_without_a_spring_is_brought_to_the_noise() {
    let folder = tempfile::tempdir().unwrap();
    let mut push = String::from("time,external_force\n");
    for i in 0..1500 {
        let t = 2e-3 * f64::from(i);
        let force = 9.0 * (2.1 * t).sin() + 6.0 * (5.3 * t + 0.4).sin();
        let _ = writeln!(push, "{t},{force}");
    }
    std::fs::write(folder.path().join("push.csv"), &push).unwrap();
    let simulated = [
        "simulate",
        "--set",
        "mode_count=1",
        "--set",
        "mode[1].frequency=0",
        "--set",
        "mode[1].damping_ratio=0",
        "--set",
        "mode[1].mass=2",
        "--set",
        "mode[1].tip_value=1",
        "--set",
        "friction.level=1.02",
        "--belt-velocity",
        "0",
        "--normal-force",
        "8",
        "--input",
        "push.csv",
        "--duration",
        "2.99",
        "--step",
        "2e-3",
        "-o",
        "motion.csv",
    ];
    let output = stickslip(&simulated, folder.path());
    assert!(output.status.success(), "{}", said(&output));
    let motion = std::fs::read_to_string(folder.path().join("motion.csv")).unwrap();
    let names: Vec<&str> = motion.lines().next().unwrap().split(',').collect();
    let at = names
        .iter()
        .position(|n| n.starts_with("tip_displacement"))
        .unwrap();
    let mut random = fastrand::Rng::with_seed(5);
    let mut csv = String::from("time_s,tip_displacement_m,push [N]\n");
    let rows = motion.lines().skip(1).zip(push.lines().skip(1));
    for (moved, pushed) in rows {
        let cells: Vec<&str> = moved.split(',').collect();
        let y: f64 = cells[at].parse::<f64>().unwrap() + 1e-6 * noise(&mut random);
        let force = pushed.split(',').nth(1).unwrap();
        let _ = writeln!(csv, "{},{y},{force}", cells[0]);
    }
    std::fs::write(folder.path().join("drive.csv"), csv).unwrap();
    let text = "[beam]\nnatural_frequencies_hz = [0]\ndamping_ratios = [0]\nmass_kg = 2\ntip_values = [1.0]\n\
                [[run]]\nfile = \"drive.csv\"\nbelt_velocity_m_per_s = 0\nnormal_force_n = 8\n\
                external_force_column = \"push\"\ninput_interpolation = \"linear\"\n";
    std::fs::write(folder.path().join("campaign.toml"), text).unwrap();
    let json = tried(folder.path(), &["viscous_friction"]);
    let steps = json["error_ladder"].as_array().unwrap();
    let calibrated = steps[1]["holdout_over_noise"].as_f64().unwrap();
    assert!(calibrated < 1.3, "{steps:?}");
    // The friction force of the simulation, by the observer.
    let output = stickslip(&["observe", "drive.csv", "--campaign", "."], folder.path());
    assert!(output.status.success(), "{}", said(&output));
    let friction = names.iter().position(|n| n.starts_with("friction_force"));
    let truth = of_column(&motion, friction.unwrap());
    let force = std::fs::read_to_string(folder.path().join("observer/force.csv")).unwrap();
    let off = of_column(&force, 1);
    let squares = off.iter().zip(&truth).map(|(f, t)| (f - t).powi(2));
    let size: f64 = truth.iter().map(|t| t * t).sum();
    let error = (squares.sum::<f64>() / size).sqrt();
    assert!(error < 0.2, "{error}");
}
