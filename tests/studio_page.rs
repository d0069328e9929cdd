//! The studio's page in a real headless Chromium, driven by Playwright, with axe-core for accessibility. Both are fetched on
//! first use, from PyPI and npm; nothing of them is committed.

use std::fs;
use std::path::PathBuf;
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
    let said = run(Command::new(python)
        .arg(root().join("tests/studio/page.py"))
        .arg(program)
        .arg(root().join("reference-data/demo"))
        .arg(axe())
        .arg(&folder));
    println!("{said}");
}
