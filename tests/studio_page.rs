//! The studio's page in a real headless Chromium, driven by Playwright, with axe-core for accessibility. Both are fetched on
//! first use, from PyPI and npm; nothing of them is committed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use stickslip_tests::peers::{environment, run};
use stickslip_tests::{build_folder, root};

/// The version of axe-core: its rules are what is promised.
const AXE: &str = "axe-core@4.14.1";

/// axe-core's script.
fn axe() -> PathBuf {
    let folder = build_folder().parent().expect("target/<profile>").join(AXE);
    let script = folder.join("package/axe.min.js");
    if !script.is_file() {
        fs::create_dir_all(&folder).expect("target is writable");
        run(Command::new("npm")
            .args(["pack", "--silent", AXE])
            .current_dir(&folder));
        let archives = fs::read_dir(&folder).expect("readable");
        let archive = archives
            .map(|entry| entry.expect("readable").path())
            .find(|path| path.extension().is_some_and(|e| e == "tgz"));
        run(Command::new("tar")
            .arg("xzf")
            .arg(archive.expect("fetched"))
            .current_dir(&folder));
    }
    script
}

/// Samples of each run that are put on the page: the first third, in which a diagnosis finds the effect already.
const BEGINNING: usize = 1600;

/// The beginning of each run of the demonstration, in a folder.
fn short_demo(folder: &Path) {
    fs::create_dir_all(folder).expect("target is writable");
    let files = fs::read_dir(root().join("reference-data/demo")).expect("readable");
    for entry in files {
        let path = entry.expect("readable").path();
        let text = fs::read_to_string(&path).expect("text");
        let rows = match path.extension().is_some_and(|e| e == "csv") {
            true => 1 + BEGINNING,
            false => usize::MAX,
        };
        let lines: Vec<&str> = text.lines().take(rows).collect();
        let name = path.file_name().expect("a file");
        fs::write(folder.join(name), lines.join("\n")).expect("target is writable");
    }
}

#[test]
#[ignore = "needs Chromium, npm and PyPI; .ci/run installs and runs it"]
fn a_user_finds_the_effect_on_the_page() {
    let python = environment("studio-venv", "tests/studio/requirements.txt").join("python");
    let folder = build_folder()
        .parent()
        .expect("target/<profile>")
        .join("studio-page");
    let program = build_folder().join("stickslip");
    assert!(
        program.is_file(),
        "{}: build all with `cargo build --release`",
        program.display()
    );
    let demo = folder.with_file_name("studio-demo");
    short_demo(&demo);
    let said = run(Command::new(python)
        .arg(root().join("tests/studio/page.py"))
        .arg(program)
        .arg(&demo)
        .arg(axe())
        .arg(&folder));
    println!("{said}");
}
