//! Beam and belt drive as two FMUs in an SSP, coupled both ways in foreign masters, against the beam alone with the
//! drive as an effect inside it (`belt_drive_compliance`): the same equations without a coupling. What remains is the
//! error of exchanging the coupling quantities at communication points only, and theory says how it falls with the
//! communication step H: as H where inputs are held constant, as H^2 where they are extrapolated with their
//! derivative (Arnold, Clauss and Schierz 2013, Archive of Mechanical Engineering 60:75).

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use stickslip_tests::peers::{python, run, validators};
use stickslip_tests::root;
use stickslip_tests::slave::{OK, Slave};

/// The operating point that `stickslip system` writes, with the drive as an effect of the beam.
const MONOLITHIC: [(&str, f64); 7] = [
    ("belt_velocity", 0.1),
    ("normal_force", 60.0),
    ("presliding_compliance.bristle_stiffness", 5e5),
    ("presliding_compliance.bristle_damping", 60.0),
    ("belt_drive_compliance.mass", 1.5),
    ("belt_drive_compliance.stiffness", 2e4),
    ("belt_drive_compliance.damping", 50.0),
];
/// Communication steps, length of the runs and distance of the times compared, in s.
const STEPS: [f64; 3] = [5e-5, 2.5e-5, 1.25e-5];
const STOP: f64 = 0.05;
const EVERY: f64 = 1e-3;
/// Namespace of OMSimulator's annotations.
const OMS: &str =
    "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";

/// Displacements of the tip in m, every `EVERY` s, with these start values besides.
fn monolithic(others: &[(&str, f64)]) -> Vec<f64> {
    let slave = Slave::new();
    for (name, value) in MONOLITHIC.iter().chain(others) {
        assert_eq!(slave.set(name, *value), OK, "{name}");
    }
    slave.start_at(0.0);
    (0..(STOP / EVERY).round() as u32)
        .map(|k| {
            assert_eq!(slave.step(f64::from(k) * EVERY, EVERY), OK);
            slave.get("tip_displacement")
        })
        .collect()
}

fn written(folder: &Path) -> PathBuf {
    let file = folder.join("belt_drive.ssp");
    stickslip::command::system::write(&file).expect("writes the archive");
    file
}

/// Runs jobs of tests/peers/run_system.py.
fn coupled(folder: &Path, jobs: &Value) -> Value {
    let (input, output) = (folder.join("jobs.json"), folder.join("results.json"));
    std::fs::write(&input, jobs.to_string()).unwrap();
    run(python()
        .arg(root().join("tests/peers/run_system.py"))
        .args([&written(folder), &input, &output]));
    serde_json::from_str(&std::fs::read_to_string(&output).unwrap()).unwrap()
}

fn displacements(result: &Value) -> Vec<f64> {
    let values = result["tip_displacement"].as_array().unwrap();
    values.iter().map(|v| v.as_f64().unwrap()).collect()
}

/// Root mean square of the difference over that of the reference.
fn error(there: &[f64], here: &[f64]) -> f64 {
    assert_eq!(there.len(), here.len());
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let difference = square(&mut there.iter().zip(here).map(|(a, b)| a - b));
    (difference / square(&mut here.iter().copied())).sqrt()
}

#[test]
fn val_the_coupling_error_falls_with_the_step_as_theory_says() {
    // Truth: the monolithic simulation, at a tolerance of 1e-10, and the theory's order.
    let folder = tempfile::tempdir().unwrap();
    let masters = [
        ("fmpy", 1.0),
        ("fmpy, SSP", 1.0),
        ("libcosim", 1.0),
        ("ecos", 1.0),
        ("fmpy, input derivatives", 2.0),
    ];
    let mut jobs = Vec::new();
    for (master, _) in masters {
        for step in STEPS {
            jobs.push(json!({"master": master, "step": step, "stop": STOP, "every": EVERY}));
        }
    }
    let results = coupled(folder.path(), &Value::Array(jobs));
    let here = monolithic(&[]);
    let mut runs = results.as_array().unwrap().chunks(STEPS.len());
    for (master, order) in masters {
        let errors: Vec<f64> = runs
            .next()
            .unwrap()
            .iter()
            .map(|result| error(&displacements(result), &here))
            .collect();
        let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
        for (step, error) in STEPS.iter().zip(&errors) {
            println!("{master}: H = {step:e} s, error {error:.2e}");
        }
        for found in orders {
            assert!(
                (found - order).abs() < 0.1,
                "{master}: order {found}, not {order}"
            );
        }
    }
}

#[test]
fn the_system_names_a_master_algorithm_for_omsimulator() {
    // OMSimulator refuses a system whose annotation does not say of which kind it is. `oms-ma`, with a fixed step, is
    // that of weakly coupled systems (its User's Guide, "SSP Support"); other masters ignore annotations.
    let folder = tempfile::tempdir().unwrap();
    run(std::process::Command::new("python3")
        .args(["-m", "zipfile", "-e"])
        .arg(written(folder.path()))
        .arg(folder.path()));
    let text = std::fs::read_to_string(folder.path().join("SystemStructure.ssd")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let master = document
        .descendants()
        .find(|node| node.has_tag_name((OMS, "FixedStepMaster")))
        .expect("a master algorithm");
    assert_eq!(master.attribute("description"), Some("oms-ma"));
    let step: f64 = master.attribute("stepSize").unwrap().parse().unwrap();
    assert!(STEPS.contains(&step), "{step}");
    let parents: Vec<_> = master.ancestors().skip(1).collect();
    assert!(parents[0].has_tag_name((OMS, "SimulationInformation")));
    assert!(parents[1].has_tag_name((OMS, "Annotations")));
    assert_eq!(parents[2].attribute("type"), Some("org.openmodelica"));
    assert_eq!(parents[4].tag_name().name(), "System");
    assert!(
        document
            .descendants()
            .any(|n| n.tag_name().name() == "DefaultExperiment")
    );
}

#[test]
fn a_rigid_contact_loses_the_inertia_of_the_tip_where_the_belts_velocity_is_held() {
    // Why the system has bristles (docs/adr/0011): in rigid stick the force depends on the belt's acceleration, of
    // which a master that holds inputs says nothing, however small its step.
    let folder = tempfile::tempdir().unwrap();
    let rigid = [
        ("presliding_compliance.bristle_stiffness", 0.0),
        ("presliding_compliance.bristle_damping", 0.0),
    ];
    let starts: serde_json::Map<_, _> = rigid
        .iter()
        .map(|(name, value)| ((*name).to_owned(), json!(value)))
        .collect();
    let job = |master: &str| {
        json!({"master": master, "step": STEPS[2], "stop": STOP, "every": EVERY,
            "starts": {"beam": starts}})
    };
    let jobs = json!([job("fmpy"), job("fmpy, input derivatives")]);
    let results = coupled(folder.path(), &jobs);
    let here = monolithic(&rigid);
    let [held, extrapolated] = [0, 1].map(|i| error(&displacements(&results[i]), &here));
    println!("rigid contact: held {held:.2e}, with derivatives {extrapolated:.2e}");
    assert!((5e-3..2e-2).contains(&held), "{held}");
    assert!(extrapolated < 0.2 * held, "{extrapolated} {held}");
}

#[test]
fn val_the_archive_passes_the_schema_of_ssp_and_the_validators() {
    // Truth: the XML schema of SSP 1.0, and the validators of FMPy and of the FMU manipulation toolbox.
    let folder = tempfile::tempdir().unwrap();
    let file = written(folder.path());
    let text = run(python()
        .arg(root().join("tests/peers/validate_ssp.py"))
        .arg(&file)
        .arg(folder.path().join("unpacked")));
    assert!(text.contains("valid: SystemStructure.ssd"), "{text}");
    let fmu = folder.path().join("unpacked/resources/BeltDrive.fmu");
    let [problems, text] = validators(&fmu);
    assert_eq!(problems.trim(), "No problems found.");
    assert!(text.contains("No semantic error"), "{text}");
    assert!(!text.contains("WARN") && !text.contains("ERROR "), "{text}");
}
