//! What `diagnose` and `try` say of the demonstration, and that others can see it again: words, intervals, the ladder and the
//! files written. One diagnosis and two trials by hand serve all tests.

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
    let as_well: Vec<&&Value> = others
        .iter()
        .filter(|c| number(&c["fit_over_noise"]) <= 1.12)
        .collect();
    assert!(!as_well.is_empty(), "{candidates:#?}");
    for rival in as_well {
        let (id, error) = (
            rival["id"].as_str().unwrap(),
            number(&rival["fit_over_noise"]),
        );
        let said = format!("{id} comes down to the noise as well ({error:.2} times");
        for text in [&done.console, &done.report] {
            assert!(text.contains(&said), "{said}: {}", done.console);
            assert!(!text.contains("No other candidate comes near"));
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
