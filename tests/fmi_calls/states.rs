//! States: taken, restored, serialised (FMI 2.0.5, section 2.1.8), and fmi2Reset.

use crate::{advance, assert_refused, results};
use std::ptr;
use stickslip_tests::slave::{ERROR, OK, Slave};

/// A model with effects that have states of their own.
fn rich() -> Slave {
    let slave = Slave::new();
    for (name, value) in [
        ("third_mode.frequency", 1404.0),
        ("belt_drive_compliance.mass", 2.0),
        ("belt_drive_compliance.stiffness", 8e4),
        ("belt_drive_compliance.damping", 20.0),
        ("sensor_lag.time_constant", 1e-4),
        ("static_friction_aging.gain", 0.1),
    ] {
        assert_eq!(slave.set(name, value), OK, "{name}");
    }
    slave.start_at(0.0);
    slave
}

#[test]
fn a_restored_run_repeats_itself_to_the_bit() {
    for make in [Slave::started, rich] {
        // Times in stick and in slip, at the start, and right after a step that ends on a transition.
        for before in [0, 1, 5, 9, 14, 23, 37] {
            let slave = make();
            advance(&slave, 0.0, 1e-3, before);
            let from = f64::from(before) * 1e-3;
            let mut state = slave.state();
            let at = results(&slave);
            advance(&slave, from, 7.3e-4, 60);
            let first = results(&slave);
            assert_eq!(slave.set_state(state), OK);
            assert_eq!(results(&slave), at);
            advance(&slave, from, 7.3e-4, 60);
            assert_eq!(results(&slave), first);
            // The same in a fresh instance, by way of bytes.
            let bytes = slave.serialize(state);
            let other = Slave::new();
            let mut copy = other.deserialize(&bytes).unwrap();
            assert_eq!(other.set_state(copy), OK);
            advance(&other, from, 7.3e-4, 60);
            assert_eq!(results(&other), first);
            assert_eq!(
                other.get_integer("transition_count"),
                slave.get_integer("transition_count")
            );
            assert_eq!(other.free_state(&mut copy), OK);
            assert_eq!(slave.free_state(&mut state), OK);
        }
    }
}

#[test]
fn several_states_live_side_by_side_and_can_be_overwritten() {
    let slave = Slave::started();
    let mut states = Vec::new();
    let mut seen = Vec::new();
    for i in 0..20_u32 {
        states.push(slave.state());
        seen.push(results(&slave));
        advance(&slave, f64::from(i) * 1e-3, 1e-3, 1);
    }
    for i in [7, 19, 0, 12] {
        assert_eq!(slave.set_state(states[i]), OK);
        assert_eq!(results(&slave), seen[i]);
    }
    let mut reused = states[3];
    let address = reused;
    assert_eq!(slave.state_into(&mut reused), OK);
    assert_eq!(reused, address, "an existing state is overwritten in place");
    assert_eq!(slave.set_state(states[0]), OK);
    assert_eq!(slave.set_state(reused), OK);
    assert_eq!(results(&slave), seen[12]);
    for state in &mut states {
        assert_eq!(slave.free_state(state), OK);
    }
    assert_eq!(slave.free_state(&mut ptr::null_mut()), OK);
}

#[test]
fn a_state_takes_an_instance_out_of_any_phase() {
    let slave = Slave::started();
    advance(&slave, 0.0, 1e-3, 10);
    let mut state = slave.state();
    let at = results(&slave);
    assert_eq!(slave.terminate(), OK);
    assert_eq!(slave.set_state(state), OK);
    assert_eq!(results(&slave), at);
    advance(&slave, 0.01, 1e-3, 1);
    assert_eq!(slave.reset(), OK);
    assert_eq!(slave.set_state(state), OK);
    advance(&slave, 0.01, 1e-3, 1);
    slave.free_state(&mut state);
}

#[test]
fn inputs_set_after_restoring_take_effect() {
    let slave = Slave::started();
    advance(&slave, 0.0, 1e-3, 10);
    let mut state = slave.state();
    let mut ends = Vec::new();
    for velocity in [0.1, 0.2, 0.1] {
        assert_eq!(slave.set_state(state), OK);
        assert_eq!(slave.set("belt_velocity", velocity), OK);
        advance(&slave, 0.01, 1e-3, 20);
        ends.push(results(&slave));
    }
    slave.free_state(&mut state);
    assert_eq!(ends[0], ends[2]);
    assert_ne!(ends[0], ends[1]);
}

#[test]
fn broken_bytes_are_refused() {
    let slave = rich();
    advance(&slave, 0.0, 1e-3, 10);
    let mut state = slave.state();
    let bytes = slave.serialize(state);
    let size = bytes.len();
    let refused = |bytes: &[u8]| {
        assert_eq!(slave.deserialize(bytes).err(), Some(ERROR));
        assert!(slave.messages()[0].text.contains("nothing was changed"));
    };
    for length in [1, 8, 19, 20, 27, size / 2, size - 1] {
        refused(&bytes[..length]);
    }
    refused(&[0; 100]);
    refused(&[bytes.clone(), vec![0]].concat());
    for place in (0..size).step_by(97) {
        let mut flipped = bytes.clone();
        flipped[place] ^= 0x10;
        refused(&flipped);
    }
    let at = results(&slave);
    assert_eq!(slave.set_state(state), OK);
    assert_eq!(results(&slave), at);
    assert_eq!(
        slave.serialize(state),
        bytes,
        "the same state gives the same bytes"
    );
    slave.free_state(&mut state);
}

#[test]
fn reset_is_as_good_as_new_from_every_phase() {
    let fresh = Slave::started();
    advance(&fresh, 0.0, 1e-3, 100);
    let expected = results(&fresh);
    let stir: [fn(&Slave); 6] = [
        |_| {},
        |s| assert_eq!(s.set("friction.mu_0", 0.3), OK),
        |s| {
            assert_eq!(s.set("third_mode.frequency", 1404.0), OK);
            s.start_at(3.0);
        },
        |s| {
            assert_eq!(s.set("q[1]", 1e-3), OK);
            s.start_at(0.0);
            advance(s, 0.0, 1e-3, 17);
            assert_eq!(s.set("belt_velocity", 0.2), OK);
        },
        |s| {
            s.start_at(0.0);
            assert_eq!(s.terminate(), OK);
        },
        |s| {
            // Initialisation that fails.
            assert_eq!(s.set("mode[1].mass", 0.0), OK);
            assert_eq!(s.enter(), OK);
            assert_refused(s, s.exit(), "mass");
        },
    ];
    let slave = Slave::new();
    for _ in 0..30 {
        for stir in stir {
            stir(&slave);
            assert_eq!(slave.reset(), OK);
            slave.start_at(0.0);
            advance(&slave, 0.0, 1e-3, 100);
            assert_eq!(results(&slave), expected);
            assert_eq!(slave.reset(), OK);
        }
    }
}
