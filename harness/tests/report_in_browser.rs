//! Reports in a browser: every figure is drawn, and nothing fails on the way.
//!
//! `cargo test --release -p stickslip --test report_in_browser -- --ignored`, about two minutes. `STICKSLIP_CHROMIUM` names
//! the browser where it is not `chromium`.

use std::path::{Path, PathBuf};
use std::process::Command;

const DEMO: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../reference-data/demo");
const LARGEST: u64 = 6_000_000;

/// Runs a command and returns the folder of what it wrote.
fn written_by(arguments: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let done = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(arguments)
        .arg("-o")
        .arg(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success(), "{arguments:?}: {said}");
    folder
}

/// The document as it stands after its scripts, all sections open, and what they wrote to the console.
fn opened(page: &Path) -> (String, Vec<String>) {
    let profile = tempfile::tempdir().unwrap();
    let browser = std::env::var("STICKSLIP_CHROMIUM").unwrap_or_else(|_| "chromium".into());
    let done = Command::new(&browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu"])
        .args(["--enable-logging=stderr", "--virtual-time-budget=60000"])
        .arg(format!("--user-data-dir={}", profile.path().display()))
        .arg("--dump-dom")
        .arg(format!("file://{}#all", page.display()))
        .output()
        .unwrap_or_else(|e| panic!("{browser}: {e}; set STICKSLIP_CHROMIUM"));
    let log = String::from_utf8_lossy(&done.stderr).into_owned();
    let console = log.lines().filter(|l| l.contains("CONSOLE"));
    (
        String::from_utf8_lossy(&done.stdout).into_owned(),
        console.map(str::to_owned).collect(),
    )
}

/// At least so many figures, each of them drawn, and no word on the console.
fn is_drawn(page: &Path, at_least: usize) {
    let size = std::fs::metadata(page).unwrap().len();
    assert!(size <= LARGEST, "{}: {size} bytes", page.display());
    let (document, console) = opened(page);
    assert!(console.is_empty(), "{}: {console:#?}", page.display());
    let figures = document.matches("<figure id=").count();
    let drawn = document.matches("data-drawn=\"yes\"").count();
    assert!(figures >= at_least, "{}: {figures} figures", page.display());
    assert_eq!(drawn, figures, "{}", page.display());
    // Plotly's own element, with axes in it.
    let with_axes = document.matches("class=\"cartesianlayer\"").count();
    assert_eq!(with_axes, figures, "{}", page.display());
}

fn run_of_demo() -> PathBuf {
    Path::new(DEMO).join("run01.csv")
}

#[test]
#[ignore = "needs Chromium"]
fn reports_of_a_campaign_are_drawn() {
    is_drawn(
        &written_by(&["compare", DEMO]).path().join("report.html"),
        18,
    );
    let tried = written_by(&["try", DEMO, "--add", "belt_periodic_friction"]);
    is_drawn(&tried.path().join("report.html"), 20);
}

#[test]
#[ignore = "needs Chromium"]
fn reports_of_a_record_are_drawn() {
    let run = run_of_demo();
    let run = run.to_str().unwrap();
    let observed = written_by(&["observe", run, "--campaign", DEMO]);
    is_drawn(&observed.path().join("observer.html"), 5);
    let dimension = written_by(&["dimension", run]);
    is_drawn(&dimension.path().join("dimension.html"), 5);
}

#[test]
#[ignore = "needs Chromium"]
fn reports_of_the_model_are_drawn() {
    let swept = written_by(&[
        "sweep",
        "--parameter",
        "belt_velocity",
        "--from",
        "0.05",
        "--to",
        "0.1",
        "--points",
        "4",
    ]);
    is_drawn(&swept.path().join("sweep.html"), 5);
    let effect = written_by(&["effects", "belt_periodic_friction"]);
    is_drawn(&effect.path().join("belt_periodic_friction.html"), 2);
}
