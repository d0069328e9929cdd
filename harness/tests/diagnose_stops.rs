//! What is left of a diagnosis that is stopped, and what simulated campaigns say of chance.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};
use stickslip::command::diagnose::{Null, Search, diagnose};
use stickslip::command::open_fmu;
use stickslip::diagnose::result::diagnosis::{Diagnosis, Verdict};
use stickslip::measurement::Campaign;
use stickslip::watch::Watch;

fn demo() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo")
}

/// The first half of each run of the demonstration: two searches to their end take half as long.
fn short_demo() -> Campaign {
    let mut campaign = Campaign::load(&demo()).unwrap();
    for run in &mut campaign.runs {
        *run = run.beginning(2400);
    }
    campaign
}

/// Says stop once so many steps have been reported.
struct StopAfter(AtomicUsize);

impl Watch for StopAfter {
    fn step(&self, _: &str, _: usize, _: usize) {
        let left = self.0.load(Ordering::Relaxed);
        self.0.store(left.saturating_sub(1), Ordering::Relaxed);
    }
    fn stop(&self) -> bool {
        self.0.load(Ordering::Relaxed) == 0
    }
}

#[test]
fn a_diagnosis_that_is_stopped_keeps_what_was_finished_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = open_fmu(None).unwrap();
    let campaign = Campaign::load(&demo()).unwrap();
    // The calibration of the reference model and some candidates.
    let watch = StopAfter(AtomicUsize::new(5));
    let diagnosis = diagnose(&fmu, &campaign, &Search::default(), folder.path(), &watch).unwrap();
    let tried = diagnosis.candidates.len();
    assert!(
        (1..16).contains(&tried),
        "{tried} candidates were tried before the stop"
    );
    assert!(
        diagnosis.remarks.iter().any(|r| r.contains("Stopped")),
        "{:?}",
        diagnosis.remarks
    );
    // Where nothing reached the noise, nothing is named.
    let reached = diagnosis.candidates.iter().any(|c| c.fit_over_noise < 1.5);
    assert!(reached || diagnosis.verdict != Verdict::EffectFound);
    for file in ["diagnosis.json", "report.html", "model.toml"] {
        assert!(folder.path().join(file).is_file(), "{file} is missing");
    }
}

#[test]
fn a_diagnosis_that_was_stopped_goes_on_and_ends_as_if_it_had_not_been() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = open_fmu(None).unwrap();
    let campaign = short_demo();
    let search = Search {
        null: Null::Simulate(1),
        ..Search::default()
    };
    let run = |name: &str, watch: &dyn Watch| {
        let output = folder.path().join(name);
        std::fs::create_dir_all(&output).unwrap();
        let diagnosis = diagnose(&fmu, &campaign, &search, &output, watch).unwrap();
        (diagnosis, output.join("unfinished.fits").is_file())
    };
    let without_counters = |diagnosis: &Diagnosis| {
        let mut json = serde_json::to_value(diagnosis).unwrap();
        // How much was computed is what resuming changes.
        json.as_object_mut().unwrap().remove("counters");
        json
    };
    let (_, kept) = run("stopped", &StopAfter(AtomicUsize::new(12)));
    assert!(kept, "what was fitted is gone");
    let (resumed, kept) = run("stopped", &());
    assert!(!kept, "a finished diagnosis leaves unfinished work");
    let (at_once, _) = run("at once", &());
    assert_eq!(without_counters(&resumed), without_counters(&at_once));
    let (rest, all) = (&resumed.counters, &at_once.counters);
    assert!(rest.fits < all.fits, "{rest:?} of {all:?}");
    chance_gains_less_than_the_effect(&at_once);
}

/// What a campaign that is simulated without the effect says of a diagnosis.
fn chance_gains_less_than_the_effect(diagnosis: &Diagnosis) {
    assert_eq!(diagnosis.verdict, Verdict::EffectFound);
    assert_eq!(diagnosis.gains_by_chance.len(), diagnosis.effects.len());
    let by_chance = &diagnosis.gains_by_chance[0];
    assert_eq!(by_chance.len(), 1);
    let evidence = &diagnosis.effects[0].evidence;
    assert!(evidence.threshold >= by_chance[0]);
    // What is there gains far more than what is not.
    assert!(evidence.gain > 10.0 * by_chance[0].max(1.0), "{evidence:?}");
    // One campaign in which chance gains less: at most one in two.
    assert_eq!(evidence.p_value, Some(0.5));
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_command_cleanly_with_its_files_written() {
    let folder = tempfile::tempdir().unwrap();
    let output = folder.path().join("diagnosis");
    let mut child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .arg("diagnose")
        .arg(demo())
        .arg("-o")
        .arg(&output)
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while !output.is_dir() {
        assert!(begun.elapsed() < Duration::from_secs(60), "no folder");
        std::thread::sleep(Duration::from_millis(20));
    }
    // The folder is made before the FMU is packed; a search takes many times as long.
    std::thread::sleep(Duration::from_secs(4));
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(
        killed.success(),
        "the diagnosis had ended before the signal"
    );
    let status = child.wait().unwrap();
    assert!(status.success(), "{status}");
    let text = std::fs::read_to_string(output.join("diagnosis.json")).unwrap();
    let diagnosis: Value = serde_json::from_str(&text).unwrap();
    let remarks = diagnosis["remarks"].to_string();
    assert!(remarks.contains("Stopped"), "{remarks}");
    if diagnosis["verdict"] == "unknown_effect" {
        let summary = diagnosis["summary"].to_string();
        assert!(summary.contains("not decided"), "{summary}");
    }
}
