//! Loading and running a foreign FMU, and the messages for files that are none. With the feature `fmi-crate` all of it
//! runs on the second backend.

mod foreign;

use foreign::Foreign;
use stickslip::error::Error;
use stickslip::fmu::{Causality, Fmu, Instance, Kind};

const X: u32 = 0;
const OMEGA: u32 = 2;
const STEPS: u32 = 0;

fn started(fmu: &Fmu, omega: f64) -> Instance {
    let mut instance = fmu.instantiate("probe").unwrap();
    instance.set_real(&[OMEGA], &[omega]).unwrap();
    instance.initialize(0.0, Some(10.0), Some(1e-6)).unwrap();
    instance
}

fn x(instance: &mut Instance) -> f64 {
    let mut value = [0.0];
    instance.get_real(&[X], &mut value).unwrap();
    value[0]
}

fn run(instance: &mut Instance, from: usize, to: usize) {
    for i in from..to {
        instance.do_step(i as f64 * 0.01, 0.01).unwrap();
    }
}

#[test]
fn val_the_oscillator_swings_as_the_cosine() {
    let probe = Foreign::new("probe");
    let fmu = Fmu::load(&probe.fmu()).unwrap();
    let mut instance = started(&fmu, 3.0);
    run(&mut instance, 0, 100);
    assert!((x(&mut instance) - 3.0_f64.cos()).abs() < 1e-12);
    let mut steps = [0];
    instance.get_integer(&[STEPS], &mut steps).unwrap();
    assert_eq!(steps, [100]);
    instance.terminate().unwrap();
}

#[test]
fn the_description_keeps_units_types_enumerations_and_annotations() {
    let probe = Foreign::new("probe");
    let fmu = Fmu::load(&probe.fmu()).unwrap();
    let description = fmu.description();
    let position = fmu.variable("x").unwrap();
    assert_eq!(
        (position.kind, position.causality, position.unit.as_deref()),
        (Kind::Real, Causality::Output, Some("m"))
    );
    assert_eq!(position.start_number(), Some(1.0));
    assert!(position.is_settable() && !fmu.variable("steps").unwrap().is_settable());
    assert_eq!(fmu.variable("omega").unwrap().min, Some(0.0));
    assert_eq!(
        description.enum_name(fmu.variable("mode").unwrap(), -1),
        Some("Left")
    );
    assert_eq!(
        description.vendor_annotation("Hand"),
        Some("<Tool name=\"Hand\"><Card id=\"one\"/></Tool>")
    );
    assert_eq!(description.default_experiment.step, Some(0.01));
}

#[test]
fn states_return_to_the_bit_and_travel_between_instances_as_bytes() {
    let probe = Foreign::new("probe");
    let fmu = Fmu::load(&probe.fmu()).unwrap();
    let (mut a, mut b) = (started(&fmu, 3.0), started(&fmu, 5.0));
    run(&mut a, 0, 10);
    let state = a.save_state().unwrap();
    run(&mut a, 10, 20);
    let first = x(&mut a);
    a.restore_state(&state).unwrap();
    run(&mut a, 10, 20);
    assert_eq!(x(&mut a).to_bits(), first.to_bits());

    assert!(matches!(
        b.restore_state(&state),
        Err(Error::ForeignState { .. })
    ));
    let bytes = a.serialize_state(&state).unwrap();
    let copy = b.deserialize_state(&bytes).unwrap();
    b.restore_state(&copy).unwrap();
    run(&mut b, 10, 20);
    assert_eq!(x(&mut b).to_bits(), first.to_bits());

    // A released slot is used again and holds the new state.
    a.release_state(state).unwrap();
    let later = a.save_state().unwrap();
    run(&mut a, 20, 30);
    a.restore_state(&later).unwrap();
    assert_eq!(x(&mut a).to_bits(), first.to_bits());
    assert!(
        b.deserialize_state(&bytes[1..])
            .unwrap_err()
            .to_string()
            .contains("fmi2DeSerializeFMUstate")
    );
}

#[test]
fn reset_is_as_new() {
    let probe = Foreign::new("probe");
    let fmu = Fmu::load(&probe.fmu()).unwrap();
    let mut instance = started(&fmu, 3.0);
    run(&mut instance, 0, 10);
    instance.reset().unwrap();
    instance.initialize(0.0, None, None).unwrap();
    run(&mut instance, 0, 100);
    assert!(
        (x(&mut instance) - 2.0_f64.cos()).abs() < 1e-12,
        "omega is 2 again"
    );
}

#[test]
fn one_fmu_serves_several_threads() {
    let probe = Foreign::new("probe");
    let fmu = Fmu::load(&probe.fmu()).unwrap();
    std::thread::scope(|scope| {
        for omega in 1..=4 {
            let fmu = &fmu;
            scope.spawn(move || {
                for _ in 0..50 {
                    let mut instance = started(fmu, f64::from(omega));
                    run(&mut instance, 0, 100);
                    assert!((x(&mut instance) - f64::from(omega).cos()).abs() < 1e-12);
                }
            });
        }
    });
}

#[test]
fn a_failed_call_names_call_status_and_reason() {
    let probe = Foreign::new("probe");
    let fmu = Fmu::load(&probe.fmu()).unwrap();
    let mut instance = started(&fmu, 3.0);
    let error = instance.do_step(0.0, -0.01).unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("fmi2DoStep of instance 'probe' returned fmi2Error"),
        "{text}"
    );
    // The second backend hands the FMU's words to the crate `log` instead.
    if !cfg!(feature = "fmi-crate") {
        assert!(
            text.ends_with("probe: step size must be positive"),
            "{text}"
        );
    }
    assert_eq!(error.exit_code(), 3);
    assert!(instance.get_real(&[77], &mut [0.0]).is_err());
}

#[test]
fn numbers_must_fit_the_variable() {
    let probe = Foreign::new("probe");
    let fmu = Fmu::load(&probe.fmu()).unwrap();
    let mut instance = fmu.instantiate("probe").unwrap();
    for (name, good, bad) in [("mode", -1.0, 0.5), ("flag", 1.0, 2.0)] {
        let variable = fmu.variable(name).unwrap();
        instance.set_number(variable, good).unwrap();
        assert!(matches!(
            instance.set_number(variable, bad),
            Err(Error::VariableValue { .. })
        ));
    }
}

#[test]
#[cfg_attr(
    feature = "fmi-crate",
    ignore = "that backend parses the file once more, and refuses these"
)]
fn valid_files_that_other_importers_refuse_are_read() {
    let probe = Foreign::new("probe");
    let path = probe.with_xml(|xml| {
        xml.replace(
            "<fmiModelDescription ",
            "<fmiModelDescription xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" ",
        )
        .replace(
            "start=\"0\"/></ScalarVariable>",
            "start=\"0\"/><Annotations><Tool name=\"T\"/></Annotations></ScalarVariable>",
        )
    });
    assert_eq!(Fmu::load(&path).unwrap().description().variables.len(), 6);
}

#[test]
fn messages_for_files_that_are_no_usable_fmu() {
    let probe = Foreign::new("probe");
    let mut messages = Vec::new();
    let mut refuse = |path: &std::path::Path| {
        let result = Fmu::load(path).and_then(|fmu| fmu.instantiate("probe").map(drop));
        let error = result.expect_err("this file must be refused");
        assert_eq!(error.exit_code(), 2, "{error}");
        let text = error
            .to_string()
            .replace(&path.display().to_string(), "probe.fmu");
        // The loader's own words carry a temporary path.
        messages.push(text.split("/stickslip-fmu-").next().unwrap().to_owned());
    };
    refuse("nowhere.fmu".as_ref());
    let whole = std::fs::read(probe.fmu()).unwrap();
    for cut in [0, 10, whole.len() / 2, whole.len() - 1] {
        let path = probe.fmu();
        std::fs::write(&path, &whole[..cut]).unwrap();
        refuse(&path);
    }
    refuse(&probe.zip(&[("readme.txt", b"hello")]));
    refuse(&probe.zip(&[("modelDescription.xml", b"<oops")]));
    refuse(&probe.zip(&[("modelDescription.xml", b"<svg/>")]));
    refuse(&probe.with_xml(|xml| xml.replace("fmiVersion=\"2.0\"", "fmiVersion=\"3.0\"")));
    refuse(&probe.with_xml(|xml| xml.replace("CoSimulation", "ModelExchange")));
    refuse(&probe.with_xml(|xml| xml.replace("causality=\"local\"", "causality=\"lokal\"")));
    let xml = include_bytes!("foreign/probe.xml").as_slice();
    refuse(&probe.zip(&[
        ("modelDescription.xml", xml),
        ("binaries/win99/probe.dll", b"MZ"),
    ]));
    let binary = format!("binaries/{}/probe.so", stickslip::fmu::PLATFORM);
    refuse(&probe.zip(&[("modelDescription.xml", xml), (&binary, b"not a library")]));
    refuse(&probe.with_xml(|xml| xml.replace("{probe}", "{other}")));
    if !cfg!(feature = "fmi-crate") {
        insta::assert_snapshot!(messages.join("\n"));
    }
}

#[test]
fn unknown_variables_get_a_suggestion() {
    let probe = Foreign::new("probe");
    let fmu = Fmu::load(&probe.fmu()).unwrap();
    let text = fmu.variable("omeg").unwrap_err().to_string();
    assert!(text.contains("did you mean 'omega'"), "{text}");
}

#[cfg(feature = "fmi-crate")]
#[test]
fn val_both_backends_give_the_same_bits() {
    use stickslip::fmu::Backend;
    let probe = Foreign::new("probe");
    let path = probe.fmu();
    let values = [Backend::FmiRs, Backend::FmiCrate].map(|backend| {
        let fmu = Fmu::load_with(&path, backend).unwrap();
        let mut instance = started(&fmu, 3.3);
        run(&mut instance, 0, 137);
        x(&mut instance).to_bits()
    });
    assert_eq!(values[0], values[1]);
}
