//! The wheel and the tests use one build of the harness: in what both depend on they switch on the same features.
//! A feature more in one of them compiles the harness, two minutes of it, once more for each.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;
use stickslip_tests::root;

/// Features of every dependency as `cargo tree` resolves them for these arguments.
fn features(arguments: &[&str]) -> BTreeMap<String, BTreeSet<String>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(cargo)
        .current_dir(root())
        .args(["tree", "--prefix", "none", "--format", "{p}|{f}"])
        .args(arguments)
        .output()
        .expect("cargo starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "cargo tree {arguments:?}: {said}");
    let mut all: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in String::from_utf8(output.stdout).expect("UTF-8").lines() {
        let Some((package, features)) = line.trim_end_matches(" (*)").split_once('|') else {
            continue;
        };
        let own = all.entry(package.to_owned()).or_default();
        own.extend(features.split(',').map(str::to_owned));
    }
    all
}

#[test]
fn the_wheel_is_linked_with_the_harness_that_the_tests_have_built() {
    let tests = features(&["--edges", "normal,build,dev"]);
    let wheel = features(&["--edges", "normal,build", "--package", "stickslip-python"]);
    let shared: Vec<&String> = wheel.keys().filter(|p| tests.contains_key(*p)).collect();
    assert!(shared.iter().any(|p| p.starts_with("nalgebra ")));
    for package in shared {
        assert_eq!(
            wheel[package], tests[package],
            "{package}: features of the wheel's build (left) and of the tests' (right); list those \
             that are missing in harness/python/Cargo.toml, or in [dev-dependencies] of Cargo.toml"
        );
    }
}
