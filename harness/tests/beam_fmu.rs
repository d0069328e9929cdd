//! Our own FMU through the harness: what the diagnosis relies on.

use stickslip::command::pack;
use stickslip::fmu::{Fmu, Instance};

fn load() -> (tempfile::TempDir, Fmu) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(pack::FILE_NAME);
    pack::pack(&path).unwrap();
    let fmu = Fmu::load(&path).unwrap();
    (folder, fmu)
}

fn start(fmu: &Fmu, instance: &mut Instance) {
    let settable = fmu
        .real_references(&["belt_velocity", "normal_force", "q[1]", "q_dot[1]"])
        .unwrap();
    instance
        .set_real(&settable, &[0.1, 100.0, 1.1e-3, 0.05])
        .unwrap();
    instance.initialize(0.0, None, None).unwrap();
}

fn run(fmu: &Fmu, instance: &mut Instance) -> Vec<u64> {
    let displacement = fmu.real_references(&["tip_displacement"]).unwrap();
    let mut value = [0.0];
    (0..2000)
        .map(|i| {
            instance.do_step(f64::from(i) * 1e-4, 1e-4).unwrap();
            instance.get_real(&displacement, &mut value).unwrap();
            value[0].to_bits()
        })
        .collect()
}

#[test]
fn every_contract_variable_is_there_with_its_unit() {
    let (_folder, fmu) = load();
    let units = [
        ("belt_velocity", "m/s"),
        ("normal_force", "N"),
        ("tip_displacement", "m"),
        ("tip_velocity", "m/s"),
        ("measured_displacement", "m"),
        ("mode[1].frequency", "Hz"),
        ("mode[1].mass", "kg"),
    ];
    for (name, unit) in units {
        assert_eq!(
            fmu.variable(name).unwrap().unit.as_deref(),
            Some(unit),
            "{name}"
        );
    }
    let mode = fmu.variable("contact_mode").unwrap();
    assert_eq!(fmu.description().enum_name(mode, 0), Some("Stick"));
    assert!(
        fmu.description().vendor_annotation("StickSlip").is_some(),
        "the cards of the effects travel in the file"
    );
}

#[test]
fn a_reset_or_restored_instance_repeats_its_motion_to_the_bit() {
    let (_folder, fmu) = load();
    let mut instance = fmu.instantiate("beam").unwrap();
    start(&fmu, &mut instance);
    let state = instance.save_state().unwrap();
    let first = run(&fmu, &mut instance);
    instance.restore_state(&state).unwrap();
    assert!(run(&fmu, &mut instance) == first, "after a restored state");
    instance.reset().unwrap();
    start(&fmu, &mut instance);
    assert!(run(&fmu, &mut instance) == first, "after a reset");
}

#[cfg(feature = "fmi-crate")]
#[test]
fn val_both_backends_give_the_same_bits() {
    use stickslip::fmu::Backend;
    let (_folder, fmu) = load();
    let motions = [Backend::FmiRs, Backend::FmiCrate].map(|backend| {
        let fmu = Fmu::load_with(fmu.path(), backend).unwrap();
        let mut instance = fmu.instantiate("beam").unwrap();
        start(&fmu, &mut instance);
        run(&fmu, &mut instance)
    });
    assert!(motions[0] == motions[1]);
}
