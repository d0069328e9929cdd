//! val: a parameter study on a Dask cluster against the local run of the same study, a worker being killed in the middle.
//! Source: the tables of `stickslip sweep` on one machine; the comparison is harness/python/test_stickslip_dask.py.

use std::process::Command;
use stickslip_tests::peers::{environment, run};
use stickslip_tests::{build_folder, root};

#[test]
fn val_a_study_on_a_cluster_gives_the_local_tables_also_when_a_worker_dies() {
    // Built beside the tests whenever those of the whole workspace are.
    let command = build_folder().join("stickslip");
    assert!(
        command.is_file(),
        "{} is missing: run `cargo build --release` first",
        command.display()
    );
    let programs = environment("dask-venv", "harness/python/requirements.txt");
    let said = run(Command::new(programs.join("python"))
        .arg("test_stickslip_dask.py")
        .arg(command)
        .current_dir(root().join("harness/python")));
    assert!(said.contains("a worker was killed after"), "{said}");
}
