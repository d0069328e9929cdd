//! val: the diagnosis on campaigns with known answers. Source: reference-data/computed/generator (Python, shares
//! nothing with this code); the answers are in truth.json files that the diagnosis does not read.

mod invariants;

use invariants::check_invariants;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn stickslip(arguments: &[&str], folder: &Path) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(arguments)
        .arg("-o")
        .arg(folder)
        .current_dir(root())
        .output()
        .unwrap()
}

fn read(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

/// Samples of each run that are diagnosed here: 170 ms, four cycles or more, in which all four answers are right already.
const BEGINNING: usize = 1700;

/// A campaign of the small blind set in a folder, the first `samples` of each run.
fn beginning_of(name: &str, samples: usize, folder: &Path) {
    let from = root().join("reference-data/computed/blind").join(name);
    std::fs::create_dir(folder.join(name)).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let to = folder.join(name).join(path.file_name().unwrap());
        let text = std::fs::read_to_string(&path).unwrap();
        let rows = match path.extension().is_some_and(|e| e == "csv") {
            true => 1 + samples,
            false => usize::MAX,
        };
        let lines: Vec<&str> = text.lines().take(rows).collect();
        std::fs::write(to, lines.join("\n")).unwrap();
    }
}

/// The small blind set but for its last campaign, in a folder: that takes longer than all others, and has a test for itself.
fn first_three(folder: &Path) {
    for name in ["001", "002", "003"] {
        beginning_of(name, BEGINNING, folder);
    }
    let mut truth = read(&root().join("reference-data/computed/blind/truth.json"));
    truth.as_array_mut().unwrap().truncate(3);
    std::fs::write(folder.join("truth.json"), truth.to_string()).unwrap();
}

#[test]
fn val_small_blind_set_is_answered_rightly() {
    let (campaigns, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    first_three(campaigns.path());
    let campaigns = campaigns.path().to_str().unwrap();
    let output = stickslip(&["blind-test", campaigns], folder.path());
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let cases = read(&folder.path().join("blind-test.json"));
    let cases = cases.as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        assert_eq!(case["right"], true, "{case:#}");
        let name = case["campaign"].as_str().unwrap();
        check_invariants(&read(&folder.path().join(name).join("diagnosis.json")));
        assert!(number(&case["over_noise"]) < 1.5, "{case:#}");
    }
    let error = number(&cases[1]["parameter_errors"]["cubic_stiffness.coefficient"][0]);
    assert!(
        error.abs() < 0.1,
        "cubic stiffness is {} % off",
        100.0 * error
    );
    // What an ideal test sees of the hidden effect: the inverse of the stated relative error, about.
    let diagnosed = read(&folder.path().join("002/diagnosis.json"));
    let found = &diagnosed["effects"][0]["parameters"]["coefficient"];
    let expected = number(&found["value"]) / number(&found["std"]);
    let power = number(&cases[1]["power"]["value"]);
    assert!((power / expected - 1.0).abs() < 0.2, "{power} {expected}");
    assert!(cases[0]["power"].is_null());
    check_resumption(campaigns, folder.path(), cases);
}

#[test]
fn val_a_stiffness_that_is_none_of_the_catalogue_is_proposed_as_a_term() {
    let (campaigns, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    beginning_of("004", BEGINNING, campaigns.path());
    let campaign = campaigns.path().join("004");
    let output = stickslip(&["diagnose", campaign.to_str().unwrap()], folder.path());
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let diagnosis = read(&folder.path().join("diagnosis.json"));
    assert_eq!(diagnosis["verdict"], "unknown_effect");
    check_invariants(&diagnosis);
    let ladder = diagnosis["error_ladder"].as_array().unwrap();
    let left = number(&ladder[ladder.len() - 1]["holdout_over_noise"]);
    assert!(left < 1.5, "{left} times the noise");
    check_proposed_term(&diagnosis);
}

/// A test that has come to its end takes no diagnosis again, but for a campaign whose result is gone.
fn check_resumption(blind: &str, folder: &Path, cases: &[Value]) {
    std::fs::remove_file(folder.join("001/blind-case.json")).unwrap();
    std::fs::remove_file(folder.join("blind-test.json")).unwrap();
    let again = stickslip(&["blind-test", blind, "--json"], folder);
    let printed: Value = serde_json::from_slice(&again.stdout).unwrap();
    let campaigns = printed["campaigns"].as_array().unwrap();
    assert_eq!(campaigns[1..], cases[1..]);
    let untimed = |case: &Value| {
        let mut case = case.clone();
        for key in ["seconds", "processor_s", "provenance"] {
            assert!(case.as_object_mut().unwrap().remove(key).is_some());
        }
        case
    };
    assert_eq!(untimed(&campaigns[0]), untimed(&cases[0]));
    assert_ne!(campaigns[0]["seconds"], cases[0]["seconds"]);
    let all = printed["kinds"].as_array().unwrap().last().unwrap();
    assert_eq!((&all["campaigns"], &all["right"]), (&3.into(), &3.into()));
}

/// The hidden stiffness of campaign 004, quadratic in the deflection, is none of the catalogue's: its cubic one imitates it
/// down to the noise.
fn check_proposed_term(diagnosis: &Value) {
    let truth = read(&root().join("reference-data/computed/blind/truth.json"));
    let hidden = &truth[3]["parameters"]["outside:quadratic_stiffness"]["coefficient"];
    let terms = diagnosis["residual"]["proposed_terms"].as_array().unwrap();
    assert_eq!(terms.len(), 1, "{terms:#?}");
    assert_eq!(terms[0]["expression"], "-k*w^2");
    assert_eq!(terms[0]["fitted"], true);
    let k = &terms[0]["parameters"]["k"];
    let off = number(&k["value"]) - number(hidden);
    assert!(
        off.abs() < 3.0 * number(&k["std"]),
        "{k} where {hidden} is hidden"
    );
    // The term is a lead, no effect: the list of candidates is the catalogue's.
    let candidates = diagnosis["candidates"].as_array().unwrap();
    assert!(
        candidates
            .iter()
            .all(|c| !c["id"].as_str().unwrap().contains("term_"))
    );
}

#[test]
fn a_model_that_bends_the_structure_to_explain_the_data_is_not_believed() {
    let folder = tempfile::tempdir().unwrap();
    let campaign = folder.path().join("campaign");
    std::fs::create_dir(&campaign).unwrap();
    let nothing_hidden = root().join("reference-data/computed/blind/001");
    for entry in std::fs::read_dir(nothing_hidden).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, campaign.join(path.file_name().unwrap())).unwrap();
    }
    let file = campaign.join("campaign.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    // Four per cent off, where modal analysis misses a few tenths.
    let rough = text.replace(
        "natural_frequencies_hz = [80.0",
        "natural_frequencies_hz = [83.0",
    );
    assert_ne!(rough, text);
    std::fs::write(&file, rough).unwrap();
    let output = stickslip(
        &["try", campaign.to_str().unwrap(), "--add", "quadratic_drag"],
        folder.path(),
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let diagnosis = read(&folder.path().join("diagnosis.json"));
    assert_eq!(diagnosis["verdict"], "unknown_effect", "{diagnosis:#}");
    let summary = diagnosis["summary"].as_str().unwrap();
    assert!(summary.contains("mode[1].frequency"), "{summary}");
    assert!(
        summary.contains("the campaign says 83.00000 Hz"),
        "{summary}"
    );
}

#[test]
fn an_effect_that_the_fmu_does_not_declare_is_refused_before_any_work() {
    let folder = tempfile::tempdir().unwrap();
    let output = stickslip(
        &["try", "reference-data/demo", "--add", "belt_periodic"],
        folder.path(),
    );
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(message.contains("belt_periodic_friction"), "{message}");
}
