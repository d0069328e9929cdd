//! The packed FMU in foreign tools: the validators of FMPy and of the FMU manipulation toolbox find
//! nothing, and FMPy (co-simulation and, with CVode, model exchange), libcosim, ecos, fmu-runner and a run resumed in
//! another process read the same numbers as a run through the C interface here.

use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use stickslip_tests::peers::{python, run, validators};
use stickslip_tests::root;
use stickslip_tests::slave::{OK, Slave};

/// Results compared, with their usual magnitude in SI units.
const RESULTS: [(&str, f64); 10] = [
    ("tip_displacement", 1e-3),
    ("tip_velocity", 0.1),
    ("tip_acceleration", 100.0),
    ("friction_force", 50.0),
    ("relative_velocity", 0.1),
    ("power_into_beam", 5.0),
    ("last_transition_time", 0.1),
    ("measured_displacement", 1e-3),
    ("belt_travel", 0.1),
    ("dwell_time", 1e-2),
];

/// An effect of a user's own, with a unit that the model does not know.
const OWN_EFFECT: &str = "id = 'stop'\ntitle = 'A stop'\ntarget = 'tip_force'\n\
    expression = '-k*max(w - 5e-4, 0)^3'\n[[parameter]]\nname = 'k'\nunit = 'kN/mm3'\n\
    min = 0\nmax = 1e12\ntypical = 1e11\n";

fn packed(folder: &Path) -> PathBuf {
    let file = folder.join("StickSlipBeam.fmu");
    stickslip::command::pack::pack(&file).expect("packs");
    file
}

#[test]
fn val_the_validators_of_fmpy_and_fmutool_find_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let effect = folder.path().join("stop.toml");
    std::fs::write(&effect, OWN_EFFECT).unwrap();
    let with_effect = folder.path().join("own.fmu");
    stickslip::command::pack::pack_with(&with_effect, &[effect]).expect("packs");
    for fmu in [packed(folder.path()), with_effect] {
        let [problems, text] = validators(&fmu);
        assert_eq!(problems.trim(), "No problems found.");
        for line in text.lines() {
            let info = line.starts_with("INFO ");
            assert!(
                info && !line.contains("WARN") && !line.contains("ERROR"),
                "{text}"
            );
        }
        assert!(text.contains("No semantic error"), "{text}");
    }
}

fn cases() -> Value {
    json!([
        {"name": "default", "stop": 1.0, "step": 1e-3, "starts": {}},
        {"name": "odd step, start in slip", "stop": 0.5, "step": 7.3e-4, "starts": {
            "belt_velocity": 0.06, "normal_force": 60.0, "q[1]": 1e-4, "q_dot[2]": 1e-3,
            "belt_travel.start": 0.3, "sensor.offset": 1e-4}},
        {"name": "effects", "stop": 0.3, "step": 1e-3, "starts": {
            "sensor_lag.time_constant": 1e-4, "static_friction_aging.gain": 0.1,
            "belt_periodic_friction.amplitude": 0.05}},
        {"name": "bristle", "stop": 0.3, "step": 1e-3, "starts": {
            "presliding_compliance.bristle_stiffness": 5e5,
            "presliding_compliance.bristle_damping": 60.0}},
    ])
}

/// The same run here: results at the end of every step of the size that masters use.
fn reference_run(case: &Value) -> Vec<(f64, [f64; 10], i32)> {
    let slave = Slave::new();
    for (name, value) in case["starts"].as_object().unwrap() {
        assert_eq!(slave.set(name, value.as_f64().unwrap()), OK, "{name}");
    }
    slave.start_at(0.0);
    let step = case["step"].as_f64().unwrap();
    let count = (case["stop"].as_f64().unwrap() / step).round() as u32;
    (0..count)
        .map(|k| {
            let (from, to) = (f64::from(k) * step, f64::from(k + 1) * step);
            assert_eq!(slave.step(from, to - from), OK);
            (
                to,
                RESULTS.map(|(name, _)| slave.get(name)),
                slave.get_integer("transition_count"),
            )
        })
        .collect()
}

#[test]
fn val_masters_agree_to_1e_9_and_model_exchange_to_1e_4() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = packed(folder.path());
    let (input, output) = (
        folder.path().join("cases.json"),
        folder.path().join("results.json"),
    );
    std::fs::write(&input, cases().to_string()).unwrap();
    run(python()
        .arg(root().join("tests/peers/run_masters.py"))
        .args([&fmu, &input, &output]));
    let results: Value = serde_json::from_str(&std::fs::read_to_string(&output).unwrap()).unwrap();
    for case in cases().as_array().unwrap() {
        let here = reference_run(case);
        let name = case["name"].as_str().unwrap();
        for (master, there) in results[name].as_object().unwrap() {
            let (compared, worst) = compare(&here, there);
            println!("{name}, {master}: {compared} times, worst {worst:.1e}");
            let exchange = master.contains("model exchange");
            let stop = if exchange { 0.12 } else { f64::INFINITY };
            let expected = here.iter().filter(|row| row.0 < stop + 1e-9).count();
            assert!(compared + 2 > expected, "{name}, {master}: {compared}");
            let allowed = if exchange { 1e-4 } else { 1e-9 };
            assert!(worst <= allowed, "{name}, {master}: {worst:e}");
        }
    }
}

#[test]
fn val_fmu_runner_reads_the_same_numbers() {
    // Truth: crate fmu-runner, an importer that shares nothing with those above.
    use fmu_runner::{Fmu, FmuInstance, fmi2Type};
    use std::collections::HashMap;
    let folder = tempfile::tempdir().unwrap();
    let fmu = Fmu::unpack(packed(folder.path())).expect("reads the archive and its description");
    let fmu = fmu
        .load(fmi2Type::fmi2CoSimulation)
        .expect("loads the binary");
    let instance = FmuInstance::instantiate(&fmu, false).expect("instantiates");
    let variables = instance.lib.variables();
    let case = &cases()[1];
    for (name, value) in case["starts"].as_object().unwrap() {
        let set = HashMap::from([(&variables[name], value.as_f64().unwrap())]);
        instance.set_reals(&set).expect("takes the start values");
    }
    instance.setup_experiment(0.0, None, None).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode().unwrap();
    let mut from = 0.0;
    for (to, values, _) in reference_run(case) {
        instance.do_step(from, to - from, true).unwrap();
        from = to;
        for ((name, _), value) in RESULTS.iter().zip(values) {
            let read = instance.get_reals(&[&variables[*name]]).unwrap();
            assert_eq!(read[&variables[*name]], value, "{name} at {to} s");
        }
    }
}

/// Number of common times and the worst difference, relative to the results' magnitudes.
fn compare(here: &[(f64, [f64; 10], i32)], there: &Value) -> (usize, f64) {
    let column = |name: &str| -> Vec<f64> {
        let values = there[name].as_array().unwrap_or_else(|| panic!("{name}"));
        values.iter().map(|v| v.as_f64().unwrap()).collect()
    };
    let times = column("time");
    let columns = RESULTS.map(|(name, _)| column(name));
    let transitions = column("transition_count");
    let (mut worst, mut compared) = (0.0_f64, BTreeSet::new());
    for (i, time) in times.iter().enumerate() {
        let Some((_, values, count)) = here.iter().find(|row| (row.0 - time).abs() < 1e-9) else {
            continue;
        };
        compared.insert(i);
        assert_eq!(f64::from(*count), transitions[i], "transitions at {time} s");
        for ((value, (_, scale)), column) in values.iter().zip(RESULTS).zip(&columns) {
            worst = worst.max((value - column[i]).abs() / scale.max(value.abs()));
        }
    }
    (compared.len(), worst)
}
