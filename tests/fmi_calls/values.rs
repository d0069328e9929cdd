//! fmi2GetXXX and fmi2SetXXX (FMI 2.0.5, section 2.1.7).

use crate::{RESULTS, advance, assert_refused, results};
use stickslip_tests::slave::{OK, Slave};
use stickslip_tests::variables::{XML, reference};

/// Every variable: name, element, causality, start value.
pub fn variables() -> Vec<(String, String, String, Option<String>)> {
    let document = roxmltree::Document::parse(&XML).unwrap();
    document
        .descendants()
        .filter(|node| node.has_tag_name("ScalarVariable"))
        .map(|node| {
            let typed = node.first_element_child().unwrap();
            (
                node.attribute("name").unwrap().to_owned(),
                typed.tag_name().name().to_owned(),
                node.attribute("causality").unwrap().to_owned(),
                typed.attribute("start").map(str::to_owned),
            )
        })
        .collect()
}

#[test]
fn every_variable_can_be_read_and_has_the_start_value_of_the_description() {
    let slave = Slave::new();
    assert_eq!(slave.enter(), OK);
    for (name, element, _, start) in variables() {
        let value = if element == "Real" {
            slave.get(&name)
        } else {
            f64::from(slave.get_integer(&name))
        };
        assert!(value.is_finite(), "{name}");
        if let Some(start) = start {
            assert_eq!(value, start.parse::<f64>().unwrap(), "{name}");
        }
    }
}

#[test]
fn every_settable_real_refuses_nan_and_infinity_and_every_result_refuses_all() {
    let slave = Slave::new();
    for (name, element, _, start) in variables() {
        match (element.as_str(), start) {
            ("Real", Some(start)) => {
                for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                    assert_refused(&slave, slave.set(&name, value), &name);
                }
                assert_eq!(slave.set(&name, start.parse().unwrap()), OK, "{name}");
            }
            ("Real", None) => assert_refused(&slave, slave.set(&name, 1.0), "a result"),
            (_, Some(start)) => {
                assert_refused(&slave, slave.set_integer(&name, 1000), &name);
                assert_refused(&slave, slave.set_integer(&name, -1000), &name);
                assert_eq!(slave.set_integer(&name, start.parse().unwrap()), OK);
            }
            (_, None) => assert_refused(&slave, slave.set_integer(&name, 1), "a result"),
        }
    }
}

#[test]
fn fixed_parameters_stay_as_they_are_once_the_run_has_begun_and_tunable_ones_do_not() {
    let slave = Slave::started();
    let document = roxmltree::Document::parse(&XML).unwrap();
    let (mut fixed, mut tunable) = (0, 0);
    for node in document.descendants() {
        let Some(real) = node
            .first_element_child()
            .filter(|n| n.has_tag_name("Real"))
        else {
            continue;
        };
        let (Some(name), Some(start)) = (node.attribute("name"), real.attribute("start")) else {
            continue;
        };
        let status = slave.set(name, start.parse().unwrap());
        if node.attribute("variability") == Some("tunable") {
            tunable += 1;
            assert_eq!(status, OK, "{name}");
        } else if node.attribute("causality") != Some("input") {
            fixed += 1;
            assert_refused(&slave, status, "fixed once the run has begun");
        }
    }
    assert!(fixed > 20 && tunable > 100, "{fixed} {tunable}");
    for name in ["mode_count", "friction.law", "start.contact"] {
        assert_refused(
            &slave,
            slave.set_integer(name, 1),
            "fixed once the run has begun",
        );
    }
    assert_eq!(slave.set("belt_velocity", 0.2), OK);
    assert_eq!(slave.set("normal_force", 0.0), OK);
    assert_refused(
        &slave,
        slave.set("normal_force", -1.0),
        "normal_force = -1 N",
    );
}

#[test]
fn tunable_parameters_take_effect_at_once_and_roll_back() {
    let slave = Slave::started();
    let mut time = 0.0;
    while slave.get_integer("contact_mode") != -1 {
        assert_eq!(slave.step(time, 1e-3), OK);
        time += 1e-3;
    }
    let mut state = slave.state();
    let (before, force) = (results(&slave), slave.get("friction_force"));
    let count = slave.get_integer("transition_count");
    assert_eq!(slave.set("friction.level", 0.5), OK);
    assert!((slave.get("friction_force") - 0.5 * force).abs() < 1e-9);
    assert_eq!(slave.get_integer("transition_count"), count);
    // An effect that comes in brings its states along, at the values set before the run.
    assert_eq!(slave.set("sensor_lag.time_constant", 1e-4), OK);
    assert_eq!(slave.get("measured_displacement"), 0.0);
    advance(&slave, time, 1e-3, 30);
    assert!(slave.get("measured_displacement") != 0.0);
    assert_eq!(slave.set_state(state), OK);
    assert_eq!(results(&slave), before);
    let plain = Slave::started();
    advance(&plain, 0.0, 1e-3, (time * 1e3).round() as u32);
    advance(&slave, time, 1e-3, 30);
    advance(&plain, time, 1e-3, 30);
    assert_eq!(results(&slave), results(&plain));
    slave.free_state(&mut state);
    // What can't be is refused when it is to be used, and can be corrected.
    let at = slave.last_successful_time().unwrap();
    let now = results(&slave);
    assert_eq!(slave.set("mode[1].mass", 0.0), OK);
    assert_refused(&slave, slave.step(at, 1e-3), "mass");
    assert_eq!(slave.set("mode[1].mass", 0.427), OK);
    assert_eq!(results(&slave), now);
    assert_eq!(slave.step(at, 1e-3), OK);
}

#[test]
fn tuning_to_the_same_values_disturbs_nothing_and_stick_goes_on_sticking() {
    let (plain, tuned) = (Slave::started(), Slave::started());
    for i in 0..100 {
        let point = f64::from(i) * 1e-3;
        assert_eq!(tuned.set("friction.mu_0", 0.66), OK);
        assert_eq!(tuned.set("third_mode.damping_ratio", 1e-3 * point), OK);
        assert_eq!((plain.step(point, 1e-3), tuned.step(point, 1e-3)), (OK, OK));
        let difference = plain.get("tip_displacement") - tuned.get("tip_displacement");
        // A parameter of an effect that is off: the model is built anew at every step, the motion is the same.
        assert!(difference.abs() < 1e-10, "{difference:e}");
        assert_eq!(
            plain.get_integer("contact_mode"),
            tuned.get_integer("contact_mode")
        );
    }
}

#[test]
fn unknown_references_and_wrong_types_are_refused() {
    let slave = Slave::started();
    for vr in [0, 9, 9000, 65_535, u32::MAX] {
        assert_refused(&slave, slave.get_into(&[vr], &mut [0.0]), "value reference");
        assert_refused(&slave, slave.set_all(&[vr], &[0.0]), "value reference");
    }
    let mode = reference("contact_mode");
    assert_refused(&slave, slave.get_into(&[mode], &mut [0.0]), "Enumeration");
    assert_refused(
        &slave,
        slave.set_integer("belt_velocity", 1),
        "is of type Real",
    );
    assert_refused(&slave, slave.call_on("fmi2GetBoolean", mode), "as Boolean");
    assert_refused(
        &slave,
        slave.call_on("fmi2GetString", reference("tip_velocity")),
        "as String",
    );
    assert_refused(&slave, slave.call_on("fmi2SetBoolean", mode), "as Boolean");
    assert_refused(&slave, slave.call_on("fmi2SetString", mode), "as String");
}

#[test]
fn setting_several_is_all_or_nothing() {
    let slave = Slave::new();
    let names = ["belt_velocity", "friction.mu_0", "normal_force"].map(reference);
    assert_refused(
        &slave,
        slave.set_all(&names, &[0.2, 0.5, -3.0]),
        "normal_force",
    );
    assert_eq!(slave.enter(), OK);
    assert_eq!(slave.get("belt_velocity"), 0.1);
    assert_eq!(slave.get("friction.mu_0"), 0.66);
    let twice = [names[0], names[0]];
    assert_eq!(slave.set_all(&twice, &[0.2, 0.3]), OK);
    assert_eq!(
        slave.get("belt_velocity"),
        0.3,
        "the last of duplicates holds"
    );
}

#[test]
fn impossible_parameters_stop_the_initialisation_until_they_are_corrected() {
    for (name, bad, good) in [
        ("mode[1].mass", 0.0, 0.427),
        ("mode[2].mass", 0.0, 0.427),
        ("friction.v1", 0.0, 0.02),
        ("friction.a1", 1.5, 0.5),
        ("presliding_compliance.bristle_stiffness", -1.0, 0.0),
    ] {
        let slave = Slave::new();
        assert_eq!(
            slave.set(name, bad),
            OK,
            "values come in any order, so they are judged at the end"
        );
        assert_eq!(slave.enter(), OK);
        assert_refused(&slave, slave.exit(), name);
        assert_eq!(slave.set(name, good), OK);
        assert_eq!(slave.exit(), OK);
        let fresh = Slave::started();
        advance(&slave, 0.0, 1e-3, 20);
        advance(&fresh, 0.0, 1e-3, 20);
        assert_eq!(results(&slave), results(&fresh));
    }
}

#[test]
fn the_order_of_setting_does_not_matter() {
    let sets: [(&str, f64); 6] = [
        ("third_mode.frequency", 1404.0),
        ("q[1]", 1e-3),
        ("friction.mu_0", 0.6),
        ("third_mode.state.displacement", 1e-6),
        ("q_dot[2]", 0.01),
        ("normal_force", 80.0),
    ];
    let mut outcomes = Vec::new();
    for turn in 0..sets.len() {
        for inside in 0..=sets.len() {
            let slave = Slave::new();
            for i in 0..sets.len() {
                if i == inside {
                    assert_eq!(slave.enter(), OK);
                }
                let (name, value) = sets[(i + turn) % sets.len()];
                assert_eq!(slave.set(name, value), OK);
                if i > inside {
                    // Looking at results in between must not freeze anything.
                    slave.get("tip_acceleration");
                }
            }
            if inside == sets.len() {
                assert_eq!(slave.enter(), OK);
            }
            assert_eq!(slave.exit(), OK);
            assert_eq!(slave.get("third_mode.state.displacement"), 1e-6);
            advance(&slave, 0.0, 1e-3, 20);
            outcomes.push(results(&slave));
        }
    }
    assert!(outcomes.iter().all(|outcome| *outcome == outcomes[0]));
}

#[test]
fn results_follow_what_is_set_during_initialisation() {
    let slave = Slave::new();
    assert_eq!(slave.enter(), OK);
    assert_eq!(slave.set("q[1]", 2e-3), OK);
    assert!((slave.get("tip_displacement") - 4e-3).abs() < 1e-15);
    assert_eq!(slave.set("sensor.offset", 1e-3), OK);
    assert!((slave.get("measured_displacement") - 5e-3).abs() < 1e-15);
    assert_eq!(slave.set("belt_velocity", 0.3), OK);
    assert_eq!(slave.get("relative_velocity"), -0.3);
    assert_eq!(slave.set("belt_travel.start", 0.7), OK);
    assert_eq!(slave.get("belt_travel"), 0.7);
    assert_eq!(slave.get_integer("contact_mode"), -1);
    assert_eq!(slave.set_integer("start.contact", 1), OK);
    assert_eq!(slave.set("q[1]", 0.0), OK);
    assert_eq!(slave.set("dwell_time.start", 0.25), OK);
    assert_eq!(slave.get_integer("contact_mode"), 0);
    assert_eq!(slave.get("relative_velocity"), 0.0);
    assert_eq!(slave.get("dwell_time"), 0.25);
    assert!(
        (slave.get("tip_velocity") - 0.3).abs() < 1e-15,
        "projected on the belt's velocity"
    );
}

#[test]
fn every_friction_law_and_number_of_modes_runs() {
    for law in 1..=5 {
        for modes in [1, 2, 8] {
            let slave = Slave::new();
            assert_eq!(slave.set_integer("friction.law", law), OK);
            assert_eq!(slave.set_integer("mode_count", modes), OK);
            slave.start_at(0.0);
            advance(&slave, 0.0, 1e-2, 10);
            for name in RESULTS {
                assert!(
                    slave.get(name).is_finite(),
                    "law {law}, {modes} modes, {name}"
                );
            }
        }
    }
}

#[test]
fn the_bristle_has_a_mode_of_its_own_and_settles_on_request() {
    let start = |settled: i32| {
        let slave = Slave::new();
        assert_eq!(
            slave.set("presliding_compliance.bristle_stiffness", 5e5),
            OK
        );
        assert_eq!(slave.set("presliding_compliance.bristle_damping", 60.0), OK);
        assert_eq!(slave.set_integer("start.effects", settled), OK);
        slave.start_at(0.0);
        assert_eq!(slave.get_integer("contact_mode"), 2);
        slave.get("presliding_compliance.state.deflection")
    };
    assert_eq!(start(0), 0.0);
    assert!(start(1) < 0.0, "{}", start(1));
}

#[test]
fn debug_logging_filters_by_category_and_refuses_unknown_ones() {
    let slave = Slave::new();
    assert_refused(
        &slave,
        slave.debug_logging(true, &[c"noSuchThing"]),
        "noSuchThing",
    );
    assert_eq!(slave.debug_logging(true, &[c"logStatusWarning"]), OK);
    assert_eq!(slave.debug_logging(true, &[c"logAll"]), OK);
    assert_eq!(slave.debug_logging(true, &[]), OK);
    assert_eq!(slave.debug_logging(false, &[]), OK);
    assert!(slave.messages().is_empty());
    assert_refused(&slave, slave.step(0.0, 1.0), "fmi2DoStep");
    let verbose = Slave::instantiate("x", 1, Some(stickslip_tests::variables::guid()), None, 1);
    let messages = verbose.unwrap_or_else(|m| panic!("{m:?}")).messages();
    assert_eq!(messages[0].category, "logEvents");
}

#[test]
fn percent_signs_in_messages_are_harmless() {
    let messages = Slave::instantiate("100%s%n", 1, Some("%s%n%d"), None, 0)
        .err()
        .unwrap();
    assert!(messages[0].text.contains("'%s%n%d'"));
}
