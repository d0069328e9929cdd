//! The Python package: its wheel is built and installed into a virtual environment, and its own tests (harness/python/tests)
//! are run there, against FMPy, published values and local runs.

use std::process::Command;
use stickslip_tests::peers::{environment, run};
use stickslip_tests::{build_folder, root};

#[test]
#[ignore = "builds a wheel with cargo and runs for minutes; by name"]
fn the_package_of_the_wheel_passes_its_tests() {
    let package = root().join("harness/python");
    let programs = environment("python-venv", "harness/python/tests/requirements.txt");
    let target = build_folder();
    let pip = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
    ];
    // The dependencies are there already; the package itself is built anew.
    run(Command::new(programs.join("python"))
        .args(pip)
        .args(["--force-reinstall", "--no-deps"])
        .arg(&package)
        .env(
            "CARGO_TARGET_DIR",
            target.parent().expect("target/<profile>"),
        ));
    let said = run(Command::new(programs.join("python"))
        .args(["-m", "pytest", "--quiet", "--durations=5"])
        .current_dir(package.join("tests")));
    println!("{said}");
    assert!(
        said.contains(" passed") && !said.contains("skipped"),
        "{said}"
    );
}
