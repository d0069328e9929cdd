//! What `diagnose` and `try` say of the demonstration, and that others can see it again: words, intervals, the ladder and the
//! files written. One diagnosis and two trials by hand serve all tests.

mod invariants;

use invariants::check_invariants;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

const DEMO: &str = "reference-data/demo";

fn stickslip(arguments: &[&str], folder: &Path) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(arguments)
        .arg("-o")
        .arg(folder)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    String::from_utf8(output.stdout).unwrap()
}

/// What a command left behind.
struct Done {
    folder: tempfile::TempDir,
    console: String,
    report: String,
    diagnosis: Value,
}

impl Done {
    fn by(arguments: &[&str]) -> Done {
        let folder = tempfile::tempdir().unwrap();
        let console = stickslip(arguments, folder.path());
        let read = |name| std::fs::read_to_string(folder.path().join(name)).unwrap();
        let (report, json) = (read("report.html"), read("diagnosis.json"));
        Done {
            diagnosis: serde_json::from_str(&json).unwrap(),
            console,
            report,
            folder,
        }
    }

    fn rung(&self, step: &str) -> &Value {
        let ladder = self.diagnosis["error_ladder"].as_array().unwrap();
        ladder.iter().find(|r| r["step"] == step).unwrap()
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

fn diagnosed() -> &'static Done {
    static DONE: OnceLock<Done> = OnceLock::new();
    DONE.get_or_init(|| Done::by(&["diagnose", DEMO]))
}

/// With an effect that is not the hidden one.
fn tried_in_vain() -> &'static Done {
    static DONE: OnceLock<Done> = OnceLock::new();
    DONE.get_or_init(|| Done::by(&["try", DEMO, "--add", "quadratic_drag"]))
}

/// With the hidden one.
fn tried_rightly() -> &'static Done {
    static DONE: OnceLock<Done> = OnceLock::new();
    DONE.get_or_init(|| Done::by(&["try", DEMO, "--add", "belt_periodic_friction"]))
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

#[test]
fn the_first_rungs_of_the_ladder_do_not_depend_on_what_is_tried() {
    for step in ["as given", "calibrated"] {
        let rung = diagnosed().rung(step);
        assert_eq!(rung, tried_in_vain().rung(step));
        assert_eq!(rung, tried_rightly().rung(step));
    }
}

/// The pictures' sentences are those of `diagnosis.json`, and stand before the comparison run by run.
#[test]
fn the_first_page_says_where_the_calibrated_model_fails() {
    let done = diagnosed();
    let statements = done.diagnosis["residual"]["statements"].as_array().unwrap();
    assert_eq!(statements.len(), 6);
    for statement in statements {
        let sentence = statement["statement"].as_str().unwrap();
        assert!(done.report.contains(sentence), "{sentence}");
    }
    let at = |text: &str| done.report.find(text).unwrap();
    assert!(at(">Where it fails</h2>") < at(">Compare: before and after</h2>"));
    let trial = tried_rightly().diagnosis["residual"]["statements"].clone();
    assert_eq!(
        trial,
        Value::Array(statements.clone()),
        "of the same calibrated model"
    );
}

#[test]
fn a_trial_speaks_only_of_what_was_tried() {
    let vain = tried_in_vain();
    assert_eq!(vain.diagnosis["verdict"], "unknown_effect");
    for text in [&vain.console, &vain.report] {
        assert!(text.contains("quadratic_drag"), "{}", vain.console);
        for claim in [
            "of the catalogue, nor two",
            "outside the catalogue is missing",
        ] {
            assert!(!text.contains(claim), "{claim}: {}", vain.console);
        }
    }
    let right = tried_rightly();
    assert_eq!(right.diagnosis["verdict"], "effect_found");
    for text in [&right.console, &right.report] {
        assert!(
            text.contains("No other effect was tried."),
            "{}",
            right.console
        );
        assert!(!text.contains("No other candidate"), "{}", right.console);
    }
}

/// The profile along the belt, of its own in each run, comes down to the noise as well as the periodic friction does.
#[test]
fn candidates_that_come_down_to_the_noise_too_are_named_with_what_speaks_against_them() {
    let done = diagnosed();
    let candidates = done.diagnosis["candidates"].as_array().unwrap();
    let others: Vec<&Value> = candidates
        .iter()
        .filter(|c| c["id"] != "belt_periodic_friction")
        .collect();
    // The first of them; what is left of a candidate may be small and still no noise.
    let as_well: Vec<&&Value> = others
        .iter()
        .filter(|c| number(&c["fit_over_noise"]) <= 1.12)
        .take(1)
        .collect();
    assert!(!as_well.is_empty(), "{candidates:#?}");
    for rival in as_well {
        let (id, error) = (
            rival["id"].as_str().unwrap(),
            number(&rival["fit_over_noise"]),
        );
        let said = format!("{id} reaches the noise level as well ({error:.2} times");
        for text in [&done.console, &done.report] {
            assert!(text.contains(&said), "{said}: {}", done.console);
            assert!(!text.contains("No other candidate"));
        }
    }
}

#[test]
fn intervals_are_of_95_percent_and_say_so_wherever_they_stand() {
    let done = diagnosed();
    let amplitude = &done.diagnosis["effects"][0]["parameters"]["amplitude"];
    let half = 1.96 * number(&amplitude["std"]);
    let said = format!(
        "amplitude = {:.4e} +- {half:.1e} (95 %)",
        number(&amplitude["value"])
    );
    assert!(done.console.contains(&said), "{said}: {}", done.console);
    assert!(done.report.contains("± is half the 95 % interval"));
}

/// Phase, friction level and start states differ from run to run; the FMU holds them for each.
#[test]
fn comparing_with_the_calibrated_fmu_shows_the_last_errors_of_the_ladder_again() {
    for done in [diagnosed(), tried_in_vain()] {
        let is_named = !done.diagnosis["effects"].as_array().unwrap().is_empty();
        let ladder = done.diagnosis["error_ladder"].as_array().unwrap();
        let rung = if is_named {
            ladder.last().unwrap()
        } else {
            done.rung("calibrated")
        };
        let folder = tempfile::tempdir().unwrap();
        let fmu = done.file("StickSlipBeam.fmu");
        let console = stickslip(
            &["compare", DEMO, "--fmu", fmu.to_str().unwrap()],
            folder.path(),
        );
        assert!(console.contains("NRMSE from start states"), "{console}");
        let json = std::fs::read_to_string(folder.path().join("comparison.json")).unwrap();
        let comparison: Value = serde_json::from_str(&json).unwrap();
        let runs = done.diagnosis["runs"].as_array().unwrap();
        for (run, last) in runs.iter().zip(rung["by_run"].as_array().unwrap()) {
            let compared = comparison["runs"].as_array().unwrap();
            let compared = compared.iter().find(|c| c["name"] == run["name"]).unwrap();
            let again = number(&compared["nrmse_from_start_states"]);
            let ratio = again / number(last);
            assert!(
                (0.8..1.2).contains(&ratio),
                "{}: {again} for {last}",
                run["name"]
            );
        }
        let csv = format!("runs/{}.csv", runs[0]["name"].as_str().unwrap());
        assert!(done.file(&csv).is_file(), "{csv}");
    }
}

/// Other rigs have a run01 too.
#[test]
fn what_the_fmu_holds_for_one_record_is_not_used_for_another_of_the_same_name() {
    let folder = tempfile::tempdir().unwrap();
    let other = folder.path().join("other");
    std::fs::create_dir(&other).unwrap();
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(DEMO);
    for name in [
        "campaign.toml",
        "run01.csv",
        "run02.csv",
        "run03.csv",
        "run04.csv",
    ] {
        std::fs::copy(demo.join(name), other.join(name)).unwrap();
    }
    // The same record, told in other units: half as large.
    let file = other.join("campaign.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text + "\n[channels]\ndisplacement_scale = 0.5\n").unwrap();
    let fmu = diagnosed().file("StickSlipBeam.fmu");
    let arguments = [
        "compare",
        other.to_str().unwrap(),
        "--fmu",
        fmu.to_str().unwrap(),
        // A record that is half as large contradicts its belt speeds, and says so.
        "--force",
    ];
    let console = stickslip(&arguments, folder.path());
    assert!(!console.contains("NRMSE from start states"), "{console}");
}

/// What is predicted without another look shows the missing effect too: the calibrated model is soon lost, the repaired one is not.
fn check_forecast(diagnosis: &Value) {
    let ladder = diagnosis["error_ladder"].as_array().unwrap();
    let of = |i: usize, key: &str| number(&ladder[i][key]);
    let last = ladder.len() - 1;
    assert!(
        of(last, "forecast_nrmse") < 0.1 * of(1, "forecast_nrmse"),
        "{ladder:#?}"
    );
    assert!(
        of(last, "valid_time_s") > 3.0 * of(1, "valid_time_s"),
        "{ladder:#?}"
    );
    let forecasts = diagnosis["forecast"].as_array().unwrap();
    let held_out = diagnosis["runs"].as_array().unwrap().iter();
    let held_out = held_out.filter(|r| r["held_out"] == true).count();
    assert_eq!(forecasts.len(), held_out);
    for forecast in forecasts {
        let (valid, limit) = (
            number(&forecast["valid_time_s"]),
            number(&forecast["valid_time_limit_s"]),
        );
        assert!(limit > 0.0 && valid > 0.2 * limit, "{forecast:#}");
        assert!(number(&forecast["learned_s"]) >= 0.04, "{forecast:#}");
        for key in ["period_s", "amplitude_m", "stick_share"] {
            let (measured, predicted) = (
                number(&forecast[key]["measured"]),
                number(&forecast[key]["predicted"]),
            );
            assert!(
                (predicted / measured - 1.0).abs() < 0.1,
                "{key}: {forecast:#}"
            );
        }
    }
}

/// Friction that is wrong over most of the belt leaves errors far above the noise: at slip, at low frequencies, along the
/// belt. Beyond the modes' frequencies only noise is left.
fn check_where_it_fails(residual: &Value) {
    let slip = number(&residual["by_moment"]["slip"]);
    assert!(slip > 2.0, "{residual:#}");
    let spectrum = residual["by_frequency"].as_array().unwrap();
    let level = |from: f64, to: f64| {
        let inside = |line: &&Value| (from..to).contains(&number(&line["frequency_hz"]));
        let lines: Vec<f64> = spectrum
            .iter()
            .filter(inside)
            .map(|line| number(&line["over_noise"]))
            .collect();
        assert!(!lines.is_empty(), "no line from {from} to {to} Hz");
        lines.iter().sum::<f64>() / lines.len() as f64
    };
    assert!(level(50.0, 1000.0) > 3.0 * level(3000.0, 5000.0));
    let places = residual["by_belt_position"].as_array().unwrap();
    let worst = places
        .iter()
        .map(|p| number(&p["over_noise"]))
        .fold(0.0, f64::max);
    assert!(worst > slip.min(3.0), "{worst}");
    let runs = residual["by_operating_point"].as_array().unwrap();
    for run in runs {
        let of_run = places.iter().filter(|p| p["file"] == run["file"]).count();
        assert!(of_run > 3, "{of_run} places on the belt in {}", run["file"]);
    }
    check_statements(&residual["statements"]);
}

/// The sentences name the largest and the smallest of the numbers beside them.
fn check_statements(statements: &Value) {
    let statements = statements.as_array().unwrap();
    let over: Vec<&str> = statements
        .iter()
        .map(|s| s["over"].as_str().unwrap())
        .collect();
    let expected = [
        "contact_phase",
        "relative_velocity_and_displacement",
        "belt_position",
        "time",
        "operating_point",
        "frequency",
    ];
    assert_eq!(over, expected);
    for statement in statements.iter().filter(|s| s["depends"] == true) {
        let sentence = statement["statement"].as_str().unwrap();
        let mut intervals = statement["intervals"].as_array().unwrap().clone();
        assert!(sentence.contains("times the noise"), "{sentence}");
        if statement["over"] == "belt_position" {
            continue; // compared run by run
        }
        intervals.sort_by(|a, b| number(&a["over_noise"]).total_cmp(&number(&b["over_noise"])));
        for end in [&intervals[0], &intervals[intervals.len() - 1]] {
            let place = end["where"].as_str().unwrap();
            assert!(sentence.contains(place), "{place}: {sentence}");
        }
    }
    assert_eq!(statements[0]["depends"], true, "{:#}", statements[0]);
}

// Source: reference-data/demo/truth.json, by the Python generator.
#[test]
fn val_demonstration_names_friction_periodic_along_the_belt_and_the_repaired_fmu_shows_it() {
    let done = diagnosed();
    let diagnosis = &done.diagnosis;
    check_invariants(diagnosis);
    assert_eq!(diagnosis["verdict"], "effect_found");
    assert_eq!(diagnosis["effects"][0]["id"], "belt_periodic_friction");
    let truth = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .join(DEMO)
        .join("truth.json");
    let truth: Value = serde_json::from_str(&std::fs::read_to_string(truth).unwrap()).unwrap();
    let answer = if truth.is_array() { &truth[0] } else { &truth };
    let hidden = &answer["parameters"]["belt_periodic_friction"];
    for parameter in ["amplitude", "wavelength"] {
        let found = number(&diagnosis["effects"][0]["parameters"][parameter]["value"]);
        let true_value = number(&hidden[parameter]);
        assert!(
            (found / true_value - 1.0).abs() < 0.1,
            "{parameter}: {found} for {true_value}"
        );
    }
    let ladder = diagnosis["error_ladder"].as_array().unwrap();
    let error = |i: usize| number(&ladder[i]["holdout_nrmse"]);
    assert!(error(2) < 0.2 * error(1), "{ladder:#?}");
    check_forecast(diagnosis);
    check_where_it_fails(&diagnosis["residual"]);
    for file in [
        "report.html",
        "model.toml",
        "StickSlipBeam.ssv",
        "StickSlipBeam.fmu",
    ] {
        assert!(done.file(file).is_file(), "{file} is missing");
    }
}

/// Friction and normal force are one product: no record of the tip distinguishes a factor on one from a factor on the other.
#[test]
fn physics_on_friction_is_told_with_its_reading_as_a_normal_force() {
    let done = Done::by(&["try", DEMO, "--add", "term_friction_by_tip_velocity"]);
    let unknown = &done.diagnosis["unknown"];
    assert_eq!(unknown["target"], "friction");
    let other = &unknown["alternatives"][0];
    assert_eq!(other["target"], "normal_force");
    assert_eq!(other["argument"], unknown["argument"]);
    assert_eq!(other["is_same_motion"], true);
    assert_eq!(other["probability"], unknown["probability"]);
    let sentence = "The same motion of the tip: normal force over w dot.";
    assert!(done.report.contains(sentence), "{}", done.report.len());
}
