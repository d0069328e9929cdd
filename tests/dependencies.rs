//! The dependencies in `<ModelStructure>` are true: every known that is listed changes the unknown for some
//! parameters, and none that is not listed does. Looked for in the model itself, with effects off, on one by
//! one, all on, and all but one, in stick and in both directions of slip.
//!
//! `UPDATE_DEPENDENCIES=1 cargo test --release --test dependencies` writes the list anew.

use std::collections::{BTreeMap, BTreeSet};
use stickslip_tests::exchange::STATES;
use stickslip_tests::root;
use stickslip_tests::slave::{OK, Slave};
use stickslip_tests::variables::{XML, reference};

/// Results that change at transitions only: what decides these decides them.
const DISCRETE: [&str; 4] = [
    "contact_mode",
    "transition_count",
    "last_transition_time",
    "dwell_time",
];

struct Description {
    /// Continuous outputs and rates.
    unknowns: Vec<String>,
    /// Parameters of each effect with a value at which it is on.
    effects: Vec<Vec<(String, f64)>>,
    nominal: BTreeMap<String, f64>,
}

fn read() -> Description {
    let document = roxmltree::Document::parse(&XML).unwrap();
    let variables: Vec<_> = document
        .descendants()
        .filter(|n| n.has_tag_name("ScalarVariable"))
        .map(|n| {
            (
                n,
                n.attribute("name").unwrap(),
                n.first_element_child().unwrap(),
            )
        })
        .collect();
    let unknowns = variables
        .iter()
        .filter(|(n, name, real)| {
            let output = n.attribute("causality") == Some("output") && !DISCRETE.contains(name);
            output || real.has_attribute("derivative")
        })
        .map(|(_, name, _)| (*name).to_owned())
        .collect();
    let nominal = |(_, name, real): &(_, &str, roxmltree::Node)| {
        let value = real.attribute("nominal")?.parse().ok()?;
        Some(((*name).to_owned(), value))
    };
    let effects = document
        .descendants()
        .filter(|n| n.has_tag_name("Effect"))
        .map(|effect| {
            effect
                .children()
                .filter(|n| n.has_tag_name("Parameter"))
                .map(|p| {
                    let name = p.attribute("name").unwrap();
                    let typical = p.attribute("typical").unwrap().parse().unwrap();
                    (
                        format!("{}.{name}", effect.attribute("id").unwrap()),
                        typical,
                    )
                })
                .collect()
        })
        .collect();
    Description {
        unknowns,
        effects,
        nominal: variables.iter().filter_map(nominal).collect(),
    }
}

/// An instance with these parameters that starts in a mode; with as many modes as there is room for.
fn instance(set: &[&(String, f64)], mode: f64) -> Slave {
    for modes in [8, 7] {
        let slave = Slave::new_exchange();
        for (name, value) in set {
            assert_eq!(slave.set(name, *value), OK, "{name}");
        }
        assert_eq!(slave.set_integer("mode_count", modes), OK);
        if mode == 0.0 {
            assert_eq!(slave.set_integer("start.contact", 1), OK);
        } else {
            assert_eq!(slave.set("q_dot[1]", mode), OK);
        }
        assert_eq!(slave.enter(), OK);
        if slave.exit() == OK {
            assert_eq!(slave.plain_call("fmi2EnterContinuousTimeMode"), OK);
            return slave;
        }
    }
    panic!("{set:?} does not start");
}

fn values(slave: &Slave, unknowns: &[u32]) -> Vec<u64> {
    let mut values = vec![0.0; unknowns.len()];
    assert_eq!(
        slave.get_into(unknowns, &mut values),
        OK,
        "{:?}",
        slave.messages()
    );
    values.into_iter().map(f64::to_bits).collect()
}

/// Adds what is seen with one set of parameters.
fn look(set: &[&(String, f64)], of: &Description, found: &mut [BTreeSet<String>]) {
    let unknowns: Vec<u32> = of.unknowns.iter().map(|n| reference(n)).collect();
    for mode in [-1.0, 0.0, 1.0] {
        let slave = instance(set, mode);
        let mut random = 0.3_f64;
        // Any place will do where nothing is at a special value.
        let base: Vec<f64> = STATES
            .iter()
            .map(|name| {
                random = (random * 997.0).fract();
                let shift = if name == "q_dot[1]" { mode } else { 0.0 };
                shift + (0.1 + random) * 0.2 * of.nominal[name]
            })
            .collect();
        assert_eq!(slave.set_time(0.0123), OK);
        assert_eq!(slave.set_states(&base), OK);
        assert_eq!(slave.set("external_force", 7.0), OK);
        assert_eq!(slave.set("clamp_acceleration", 3.0), OK);
        let before = values(&slave, &unknowns);
        let mut note = |known: &str| {
            for ((a, b), found) in values(&slave, &unknowns)
                .iter()
                .zip(&before)
                .zip(&mut *found)
            {
                if a != b {
                    found.insert(known.to_owned());
                }
            }
        };
        for (name, value, usual) in [
            ("belt_velocity", 0.137, 0.1),
            ("normal_force", 137.0, 100.0),
            ("external_force", 13.7, 7.0),
            ("clamp_acceleration", 4.1, 3.0),
        ] {
            assert_eq!(slave.set(name, value), OK);
            note(name);
            assert_eq!(slave.set(name, usual), OK);
        }
        for (i, name) in STATES.iter().enumerate() {
            let mut states = base.clone();
            states[i] += 0.137 * of.nominal[name];
            assert_eq!(slave.set_states(&states), OK);
            note(name);
        }
    }
}

#[test]
fn the_dependencies_of_the_description_are_those_of_the_model() {
    let of = read();
    let mut found = vec![BTreeSet::new(); of.unknowns.len()];
    let none = of.effects.len();
    look(&[], &of, &mut found);
    look(
        &of.effects.iter().flatten().collect::<Vec<_>>(),
        &of,
        &mut found,
    );
    for one in 0..none {
        let alone: Vec<_> = of.effects[one].iter().collect();
        look(&alone, &of, &mut found);
        let others = of.effects.iter().enumerate().filter(|(i, _)| *i != one);
        look(
            &others.flat_map(|(_, e)| e).collect::<Vec<_>>(),
            &of,
            &mut found,
        );
    }
    let mut table: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for (name, knowns) in of.unknowns.iter().zip(&found) {
        table.insert(name, knowns.clone());
    }
    for name in DISCRETE {
        table.insert(name, table["friction_force"].clone());
    }
    let text: String = table
        .iter()
        .map(|(name, knowns)| {
            let list: String = knowns.iter().map(|k| format!(" {k}")).collect();
            format!("{name}:{list}\n")
        })
        .collect();
    let file = root().join("modelDescription/dependencies.txt");
    if std::env::var_os("UPDATE_DEPENDENCIES").is_some() {
        std::fs::write(&file, &text).unwrap();
    }
    let committed = std::fs::read_to_string(&file).unwrap();
    for (a, b) in text.lines().zip(committed.lines()) {
        assert_eq!(a, b);
    }
    assert_eq!(text.lines().count(), committed.lines().count());
    // No effect makes everything depend on everything.
    assert_eq!(table["der(q[1])"], BTreeSet::from(["q_dot[1]".to_owned()]));
    assert!(!table["tip_displacement"].contains("normal_force"));
    assert!(table["friction_force"].contains("belt_distance"));
}
