//! Independent tools from the Python package index, each set of them in a virtual environment of its own below the
//! build folder, installed on first use (delete it to start afresh).

use crate::{build_folder, root};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The folder of programs of the masters' and validators' environment, with everything in
/// tests/peers/requirements.txt.
pub fn programs() -> &'static Path {
    static PROGRAMS: OnceLock<PathBuf> = OnceLock::new();
    PROGRAMS.get_or_init(|| environment("peers-venv", "tests/peers/requirements.txt"))
}

/// The masters' Python. ecos looks for its libraries beside the environment's own.
pub fn python() -> Command {
    let mut command = Command::new(programs().join("python"));
    let libraries = programs().parent().expect("the environment").join("lib");
    command.env("LD_LIBRARY_PATH", libraries);
    command
}

/// The folder of programs of an environment with what the file `requirements` of the repository lists.
pub fn environment(name: &str, requirements: &str) -> PathBuf {
    let target = build_folder()
        .parent()
        .expect("target/<profile>")
        .to_owned();
    let folder = target.join(name);
    let programs = folder.join("bin");
    let requirements = root().join(requirements);
    let wanted = fs::read_to_string(&requirements).expect("committed");
    // What has been installed last; written only once everything is there.
    let stamp = folder.join("installed.txt");
    if fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return programs;
    }
    run(Command::new("python3").arg("-m").arg("venv").arg(&folder));
    let pip = [
        "-m",
        "pip",
        "install",
        "--quiet",
        "--disable-pip-version-check",
        "-r",
    ];
    run(Command::new(programs.join("python"))
        .args(pip)
        .arg(&requirements));
    fs::write(&stamp, wanted).expect("target is writable");
    programs
}

/// What the validators of FMPy and of the FMU manipulation toolbox say of an FMU.
pub fn validators(fmu: &Path) -> [String; 2] {
    let validate = run(Command::new(programs().join("fmpy"))
        .arg("validate")
        .arg(fmu));
    let check = run(Command::new(programs().join("fmutool"))
        .arg("-input")
        .arg(fmu)
        .arg("-check"));
    [validate, check]
}

/// Runs a program to its end and gives what it has printed; fails the test where it fails.
pub fn run(command: &mut Command) -> String {
    let out = command
        .output()
        .unwrap_or_else(|error| panic!("{command:?}: {error}"));
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    let errors = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{command:?}\n{text}\n{errors}");
    text + &errors
}
