//! Energies, and the promise that every variable can be read at any time (FMI 2.0.5, section 2.1.7).

use crate::advance;
use crate::values::variables;
use stickslip_tests::exchange::Integration;
use stickslip_tests::slave::{OK, Slave};
use stickslip_tests::variables::reference;

#[test]
fn energies_balance_also_across_a_change_of_inputs() {
    let slave = Slave::started();
    let read = || {
        [
            "stored",
            "belt_work",
            "contact_dissipation",
            "structural_dissipation",
            "external_work",
        ]
        .map(|name| slave.get(&format!("energy.{name}")))
    };
    let before = read();
    advance(&slave, 0.0, 1e-3, 333);
    assert_eq!(slave.set("belt_velocity", 0.07), OK);
    assert_eq!(slave.set("normal_force", 60.0), OK);
    assert_eq!(slave.set("external_force", 12.0), OK);
    assert_eq!(slave.set("clamp_acceleration", -4.0), OK);
    advance(&slave, 0.333, 1e-3, 333);
    let after = read();
    let [stored, work, contact, structure, pushed] = std::array::from_fn(|i| after[i] - before[i]);
    assert!(work > 1.0 && contact > 0.1 && structure > 0.0, "{after:?}");
    assert!(pushed.abs() > 1e-4, "{after:?}");
    let gap = work + pushed - stored - contact - structure;
    assert!(gap.abs() < 1e-7 * work, "{gap} of {work} J");
}

/// Work of the belt, heat in the contact and in the structure, in J.
fn energies(slave: &Slave) -> [f64; 3] {
    let names = ["belt_work", "contact_dissipation", "structural_dissipation"];
    names.map(|name| slave.get(&format!("energy.{name}")))
}

#[test]
fn energies_read_late_are_those_read_from_the_start_on() {
    let start = || {
        let slave = Slave::new();
        assert_eq!(slave.set("q[1]", 1e-4), OK);
        assert_eq!(slave.set("dwell_time.start", 1e-3), OK);
        slave.start_at(0.0);
        slave
    };
    // A step, inputs, parameters, and a look at the end alone.
    let play = |slave: &Slave, look: &dyn Fn(&Slave)| {
        look(slave);
        advance(slave, 0.0, 1e-3, 100);
        look(slave);
        assert_eq!(slave.set("belt_velocity", 0.07), OK);
        advance(slave, 0.1, 1e-3, 100);
        look(slave);
        assert_eq!(slave.set("friction.level", 1.05), OK);
        advance(slave, 0.2, 1e-3, 100);
        (energies(slave), slave.get("tip_displacement").to_bits())
    };
    let always = play(&start(), &|slave| {
        energies(slave);
    });
    let (late, motion) = play(&start(), &|_| {});
    assert_eq!(late, always.0);
    assert_eq!(motion, always.1);
    assert!(late[0] > 0.1, "{late:?}");
    // Set, but not yet in force.
    let pending = start();
    advance(&pending, 0.0, 1e-3, 100);
    assert_eq!(pending.set("friction.level", 1.05), OK);
    assert_eq!(pending.set("belt_velocity", 0.07), OK);
    let plain = start();
    energies(&plain);
    advance(&plain, 0.0, 1e-3, 100);
    assert_eq!(energies(&pending), energies(&plain));
    // After a return to a state from before the first look, also from bytes.
    let slave = start();
    advance(&slave, 0.0, 1e-3, 50);
    let mut state = slave.state();
    let bytes = slave.serialize(state);
    advance(&slave, 0.05, 1e-3, 20);
    energies(&slave);
    assert_eq!(slave.set_state(state), OK);
    let other = Slave::new();
    let mut copy = other.deserialize(&bytes).unwrap();
    assert_eq!(other.set_state(copy), OK);
    for slave in [&slave, &other] {
        advance(slave, 0.05, 1e-3, 50);
        assert_eq!(energies(slave), energies(&plain));
    }
    other.free_state(&mut copy);
    slave.free_state(&mut state);
}

/// Names of the variables that are refused, read in a call of its own each and all Reals at once.
fn unreadable(slave: &Slave) -> Vec<String> {
    let mut reals = Vec::new();
    let mut refused = Vec::new();
    for (name, element, ..) in variables() {
        let vr = reference(&name);
        let status = if element == "Real" {
            reals.push(vr);
            slave.get_into(&[vr], &mut [f64::NAN])
        } else {
            slave.call_on("fmi2GetInteger", vr)
        };
        if status != OK {
            refused.push(name);
        }
    }
    if slave.get_into(&reals, &mut vec![f64::NAN; reals.len()]) != OK {
        refused.push("all together".into());
    }
    refused
}

#[test]
fn every_variable_can_be_read_first_at_any_time_in_both_interfaces() {
    let none = Vec::<String>::new();
    for late in [0, 1, 7] {
        let slave = Slave::started();
        advance(&slave, 0.0, 1e-3, late);
        for k in 0..20_u32 {
            assert_eq!(unreadable(&slave), none, "after {late} + {k} steps");
            advance(&slave, f64::from(late + k) * 1e-3, 1e-3, 1);
        }
    }
    let slave = Slave::new_exchange();
    slave.start_at(0.0);
    assert_eq!(unreadable(&slave), none, "event mode");
    slave.new_discrete_states();
    assert_eq!(slave.plain_call("fmi2EnterContinuousTimeMode"), OK);
    let mut integration = Integration::new(&slave, 0.0, &|_, _| {});
    for k in 0..20_u32 {
        assert_eq!(unreadable(&slave), none, "model exchange, {k} steps");
        integration.run(f64::from(k + 1) * 1e-3, 2e-5);
    }
}
