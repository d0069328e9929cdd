//! Model exchange through the C interface: an integrator of the test's own, against golden transition times
//! and against co-simulation.

use std::ffi::c_int;
use stickslip_tests::exchange::{EventInfo, Integration, STATES};
use stickslip_tests::root;
use stickslip_tests::slave::{DISCARD, ERROR, OK, Slave};
use stickslip_tests::variables::reference;

/// Results compared, with their usual magnitude in SI units.
const RESULTS: [(&str, f64); 15] = [
    ("tip_displacement", 1e-3),
    ("tip_velocity", 0.1),
    ("tip_acceleration", 100.0),
    ("friction_force", 50.0),
    ("relative_velocity", 0.1),
    ("power_into_beam", 5.0),
    ("measured_displacement", 1e-3),
    ("belt_travel", 0.1),
    ("dwell_time", 1e-2),
    ("last_transition_time", 0.1),
    ("energy.stored", 0.1),
    ("energy.belt_work", 0.1),
    ("energy.contact_dissipation", 0.1),
    ("energy.structural_dissipation", 0.1),
    ("belt_distance", 0.1),
];

fn results(slave: &Slave) -> Vec<f64> {
    let mut values = [0.0; RESULTS.len()];
    let references = RESULTS.map(|(name, _)| reference(name));
    assert_eq!(slave.get_into(&references, &mut values), OK);
    values.to_vec()
}

/// Worst difference over the usual magnitude.
fn worst(a: &[f64], b: &[f64]) -> f64 {
    let scaled = |i: usize| (a[i] - b[i]).abs() / RESULTS[i].1;
    (0..RESULTS.len()).map(scaled).fold(0.0, f64::max)
}

#[test]
fn val_transition_times_are_the_golden_ones() {
    // Truth: reference-data/computed/golden/events.json, three independent integrators.
    let file = root().join("reference-data/computed/golden/events.json");
    let cases: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    for case in &cases.as_array().unwrap()[..3] {
        let x = |i: usize| case["initial_state"][i].as_f64().unwrap();
        let slave = Slave::started_exchange(&[
            ("normal_force", case["normal_force_n"].as_f64().unwrap()),
            (
                "belt_velocity",
                case["belt_velocity_m_per_s"].as_f64().unwrap(),
            ),
            ("q[1]", x(0)),
            ("q_dot[1]", x(1)),
            ("q[2]", x(2)),
            ("q_dot[2]", x(3)),
        ]);
        let mut integration = Integration::new(&slave, 0.0, &|_, _| {});
        for (i, event) in case["events"].as_array().unwrap()[..12].iter().enumerate() {
            let time = event[0].as_f64().unwrap();
            integration.run(time + 1e-6, 4e-6);
            assert_eq!(slave.get_integer("transition_count"), i as c_int + 1);
            let mine = slave.get("last_transition_time");
            assert!((mine - time).abs() < 1e-7, "{mine} {time}");
        }
    }
}

/// Parameters; end in s and step in s of the plain integrator; worst difference allowed.
type Case = (&'static [(&'static str, f64)], f64, f64, f64);

/// Every effect with states, the friction laws without series, and a start in slip.
const CASES: [Case; 9] = [
    (&[], 0.05, 4e-6, 1e-5),
    (
        &[
            ("belt_velocity", 0.06),
            ("normal_force", 60.0),
            ("q[1]", 1e-4),
        ],
        0.05,
        4e-6,
        1e-5,
    ),
    (&[("third_mode.frequency", 1404.0)], 0.03, 2e-6, 1e-5),
    (
        &[
            ("belt_drive_compliance.mass", 2.0),
            ("belt_drive_compliance.stiffness", 8e4),
            ("belt_drive_compliance.damping", 20.0),
        ],
        0.03,
        4e-6,
        1e-5,
    ),
    (
        &[
            ("frictional_lag.time_constant", 3e-4),
            ("sensor_lag.time_constant", 1e-4),
        ],
        0.03,
        4e-6,
        1e-5,
    ),
    (
        &[
            ("presliding_compliance.bristle_stiffness", 5e5),
            ("presliding_compliance.bristle_damping", 60.0),
        ],
        0.02,
        2e-6,
        1e-4,
    ),
    (
        &[
            ("static_friction_aging.gain", 0.1),
            ("belt_periodic_friction.amplitude", 0.05),
        ],
        0.03,
        4e-6,
        1e-5,
    ),
    (
        &[
            ("axial_load.softening", 1e-5),
            ("base_excitation.amplitude", 5.0),
            ("cubic_stiffness.coefficient", 1e8),
            ("normal_force_modulation.amplitude", 0.1),
            ("normal_force_coupling.coefficient", 20.0),
            ("viscous_friction.coefficient", 0.05),
            ("friction_drift.change", 0.1),
            ("quadratic_drag.coefficient", 1.0),
        ],
        0.03,
        4e-6,
        1e-5,
    ),
    (
        &[("friction.v1", 0.03), ("mode[1].damping_ratio", 0.01)],
        0.03,
        4e-6,
        1e-5,
    ),
];

#[test]
fn both_interfaces_give_the_same_motion_with_every_effect() {
    for (set, end, h, allowed) in CASES {
        let there = Slave::new();
        for (name, value) in set {
            assert_eq!(there.set(name, *value), OK, "{name}");
        }
        there.start_at(0.0);
        results(&there);
        let here = Slave::started_exchange(set);
        assert!(worst(&results(&here), &results(&there)) < 1e-12, "{set:?}");
        let mut integration = Integration::new(&here, 0.0, &|_, _| {});
        let mut from = 0.0;
        for i in 1..=10 {
            let to = end * f64::from(i) / 10.0;
            assert_eq!(there.step(from, to - from), OK);
            integration.run(to, h);
            from = to;
            let difference = worst(&results(&here), &results(&there));
            assert!(
                difference < allowed,
                "{set:?} at {to}: {difference:e}\n{:?}\n{:?}",
                results(&here),
                results(&there)
            );
            for name in ["contact_mode", "transition_count"] {
                assert_eq!(
                    here.get_integer(name),
                    there.get_integer(name),
                    "{set:?} at {to}"
                );
            }
            let states: Vec<f64> = STATES.iter().map(|name| there.get(name)).collect();
            for ((name, a), b) in STATES.iter().zip(here.states()).zip(states) {
                assert!(
                    (a - b).abs() < allowed * b.abs().max(0.1),
                    "{name}: {a} {b}"
                );
            }
        }
    }
}

#[test]
fn a_belt_that_ramps_and_jumps_gives_the_same_motion_in_both() {
    let ramp = |t: f64| 0.1 + 0.5 * t;
    let there = Slave::started();
    let here = Slave::started_exchange(&[]);
    let follow = |slave: &Slave, t: f64| assert_eq!(slave.set("belt_velocity", ramp(t)), OK);
    let mut integration = Integration::new(&here, 0.0, &follow);
    for i in 0..10_u32 {
        let (from, to) = (f64::from(i) * 2e-3, f64::from(i + 1) * 2e-3);
        assert_eq!(there.set("belt_velocity", ramp(from)), OK);
        assert_eq!(there.set_rate("belt_velocity", 1, 0.5), OK);
        assert_eq!(there.step(from, to - from), OK);
        integration.run(to, 4e-6);
        let difference = (here.get("tip_displacement") - there.get("tip_displacement")).abs();
        // The lag of stick behind a belt that accelerates: 0.5 m/s^2 over 32 000 1/s for 20 ms.
        assert!(difference < 4e-7, "{difference:e} at {to}");
    }
    // A jump must come at an event (FMI 2.0.5, section 3.2.2).
    assert_eq!(here.plain_call("fmi2EnterEventMode"), OK);
    assert_eq!(here.set("belt_velocity", 0.3), OK);
    here.new_discrete_states();
    assert_eq!(here.plain_call("fmi2EnterContinuousTimeMode"), OK);
    assert_eq!(there.set("belt_velocity", 0.3), OK);
    assert_eq!(
        here.get_integer("contact_mode"),
        there.get_integer("contact_mode")
    );
    assert_eq!(here.get_integer("contact_mode"), -1);
}

#[test]
fn states_that_are_not_in_use_keep_their_value_and_have_the_rate_zero() {
    let slave = Slave::started_exchange(&[]);
    let used = ["q[1]", "q_dot[1]", "q[2]", "q_dot[2]", "belt_distance"];
    let mut states = slave.states();
    for (i, (name, x)) in STATES.iter().zip(&mut states).enumerate() {
        if !used.contains(&name.as_str()) {
            *x = i as f64;
        }
    }
    assert_eq!(slave.set_states(&states), OK);
    assert_eq!(slave.states(), states);
    for ((name, rate), x) in STATES.iter().zip(slave.derivatives()).zip(&states) {
        let energy = name.starts_with("energy.");
        if !energy && !used.contains(&name.as_str()) {
            assert_eq!(rate, 0.0, "{name}");
        }
        assert_eq!(slave.get(name), *x, "{name}");
        assert_eq!(slave.get(&format!("der({name})")), rate, "{name}");
    }
}

#[test]
fn a_restored_instant_goes_on_to_the_bit_also_from_bytes() {
    let set = [
        ("third_mode.frequency", 1404.0),
        ("static_friction_aging.gain", 0.1),
        ("sensor_lag.time_constant", 1e-4),
    ];
    let slave = Slave::started_exchange(&set);
    Integration::new(&slave, 0.0, &|_, _| {}).run(0.007, 1e-5);
    let mut state = slave.state();
    let finish = |slave: &Slave| {
        Integration::new(slave, 0.007, &|_, _| {}).run(0.02, 1e-5);
        results(slave)
            .into_iter()
            .map(f64::to_bits)
            .collect::<Vec<_>>()
    };
    let first = finish(&slave);
    assert_eq!(slave.set_state(state), OK);
    assert_eq!(finish(&slave), first);
    let bytes = slave.serialize(state);
    let other = Slave::new_exchange();
    let mut copy = other.deserialize(&bytes).unwrap();
    assert_eq!(other.set_state(copy), OK);
    assert_eq!(finish(&other), first);
    // A state of the other interface can't be taken over.
    let foreign = Slave::started();
    assert_eq!(foreign.deserialize(&bytes).err(), Some(ERROR));
    assert_eq!(foreign.set_state(state), ERROR);
    assert!(foreign.messages()[0].text.contains("model exchange"));
    other.free_state(&mut copy);
    slave.free_state(&mut state);
}

#[test]
fn reset_is_as_good_as_new() {
    let fresh = Slave::started_exchange(&[]);
    let slave = Slave::started_exchange(&[("third_mode.frequency", 1404.0)]);
    Integration::new(&slave, 0.0, &|_, _| {}).run(0.005, 1e-5);
    assert_eq!(slave.reset(), OK);
    slave.start_at(0.0);
    slave.new_discrete_states();
    assert_eq!(slave.plain_call("fmi2EnterContinuousTimeMode"), OK);
    for s in [&slave, &fresh] {
        Integration::new(s, 0.0, &|_, _| {}).run(0.005, 1e-5);
    }
    assert_eq!(results(&slave), results(&fresh));
}

#[test]
fn parameters_are_tuned_at_events_and_take_effect_at_once() {
    let slave = Slave::started_exchange(&[]);
    let mut integration = Integration::new(&slave, 0.0, &|_, _| {});
    while slave.get_integer("contact_mode") == 0 {
        integration.run(integration.time + 1e-3, 1e-5);
    }
    let before = slave.get("friction_force");
    assert_eq!(slave.set("friction.level", 0.5), ERROR);
    assert_eq!(slave.plain_call("fmi2EnterEventMode"), OK);
    assert_eq!(slave.set("friction.level", 0.5), OK);
    slave.new_discrete_states();
    assert!((slave.get("friction_force") - 0.5 * before).abs() < 1e-9);
    assert_eq!(slave.set("mode[1].mass", 0.0), OK);
    assert_eq!(
        slave.new_discrete_states_into(&mut EventInfo::default()),
        ERROR
    );
    assert_eq!(slave.set("mode[1].mass", 0.427), OK);
    slave.new_discrete_states();
    assert_eq!(slave.set_integer("mode_count", 3), ERROR);
}

#[test]
fn wrong_counts_and_states_that_are_no_numbers_are_refused() {
    let slave = Slave::started_exchange(&[]);
    let n = STATES.len();
    for name in [
        "fmi2GetContinuousStates",
        "fmi2GetDerivatives",
        "fmi2GetNominalsOfContinuousStates",
    ] {
        assert_eq!(slave.fill(name, &mut vec![0.0; n - 1]), ERROR, "{name}");
        assert_eq!(slave.fill(name, &mut vec![0.0; n + 1]), ERROR, "{name}");
        assert_eq!(slave.fill(name, &mut vec![0.0; n]), OK, "{name}");
    }
    assert_eq!(slave.fill("fmi2GetEventIndicators", &mut [0.0; 2]), ERROR);
    assert_eq!(slave.set_states(&vec![0.0; n - 1]), ERROR);
    assert_eq!(slave.set_states(&vec![f64::NAN; n]), ERROR);
    assert_eq!(slave.set_time(f64::NAN), ERROR);
    // States that lead out of what can be computed: the integrator may try again (fmi2Discard).
    assert_eq!(slave.set_states(&vec![1e300; n]), OK);
    assert_eq!(slave.fill("fmi2GetDerivatives", &mut vec![0.0; n]), DISCARD);
}

/// Explicit Euler steps of `h` s until a call is refused; the messages then.
fn euler(slave: &Slave, h: f64) -> String {
    let n = STATES.len();
    let (mut x, mut rates) = (slave.states(), vec![0.0; n]);
    for k in 0..100_000_u32 {
        assert_eq!(slave.set_time(f64::from(k) * h), OK);
        if slave.set_states(&x) != OK || slave.fill("fmi2GetDerivatives", &mut rates) != OK {
            return slave.messages().last().unwrap().text.clone();
        }
        x.iter_mut().zip(&rates).for_each(|(x, r)| *x += h * r);
    }
    panic!("no divergence with steps of {h} s");
}

#[test]
fn a_fixed_step_that_is_too_long_is_named_with_the_fastest_rate() {
    // In stick a relative velocity decays with ten times the highest frequency, 2 pi 510 Hz, whose structural damping
    // ratio 1e-4 or so sets the limit of the explicit Euler method.
    let text = euler(&Slave::started_exchange(&[]), 1e-3);
    assert!(text.contains("last step, 1.000e-3 s"), "{text}");
    assert!(text.contains("fastest rate is 3.2044e4 1/s"), "{text}");
    assert!(text.contains("stable only with steps below"), "{text}");
    assert!(!text.contains("parameter is extreme"), "{text}");
    // A lag of 1e-5 s has the rate 1e5 1/s; stick is held ten times faster than that.
    let slave = Slave::started_exchange(&[("sensor_lag.time_constant", 1e-5)]);
    let text = euler(&slave, 2e-4);
    assert!(text.contains("last step, 2.000e-4 s"), "{text}");
    // Short steps are not blamed for states that no integrator would set.
    let slave = Slave::started_exchange(&[]);
    assert_eq!(slave.set_time(1e-9), OK);
    let n = STATES.len();
    assert_eq!(slave.set_states(&vec![1e300; n]), OK);
    assert_eq!(slave.fill("fmi2GetDerivatives", &mut vec![0.0; n]), DISCARD);
    let text = slave.messages().last().unwrap().text.clone();
    assert!(!text.contains("last step"), "{text}");
}

/// An instance of an FMU with a user's effect that moves the belt.
fn with_a_moved_belt(kind: c_int) -> Slave {
    let file = "id = 'surge'\ntitle = 'The belt surges'\ntarget = 'belt_velocity'\nexpression = 'a*v0'\n\
        [[parameter]]\nname = 'a'\nunit = '1'\nmin = 0\nmax = 1\ntypical = 0.1\n";
    let card = beam_model_description::UserCard::parse(file).unwrap();
    let layout = beam_model_description::Layout::with(vec![card]).unwrap();
    let none: [(&str, f64); 0] = [];
    let (_, guid) = layout.xml_with_starts(&none).unwrap();
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("effects")).unwrap();
    std::fs::write(folder.path().join("effects/surge.toml"), file).unwrap();
    let starts = layout.start_values_toml(&none, &guid).unwrap();
    std::fs::write(folder.path().join("start_values.toml"), starts).unwrap();
    let uri = format!("file://{}", folder.path().display());
    let slave = Slave::instantiate("user's", kind, Some(&guid), Some(&uri), 0);
    let slave = slave.unwrap_or_else(|m| panic!("{m:?}"));
    // Value reference of the first parameter of the first user's effect.
    assert_eq!(slave.set_all(&[9000], &[0.1]), OK);
    slave.start_at(0.0);
    slave
}

#[test]
fn a_users_effect_that_moves_the_belt_brings_a_state_of_its_own() {
    let (state, rate) = (9060, 9080);
    let read = |slave: &Slave, vr: u32| {
        let mut value = [f64::NAN];
        assert_eq!(slave.get_into(&[vr], &mut value), OK);
        value[0]
    };
    let here = with_a_moved_belt(0);
    here.new_discrete_states();
    assert_eq!(here.plain_call("fmi2EnterContinuousTimeMode"), OK);
    let count = STATES.len() + 1;
    let mut states = vec![f64::NAN; count];
    assert_eq!(here.fill("fmi2GetContinuousStates", &mut states), OK);
    assert_eq!(states[count - 1], 0.0);
    let mut rates = vec![f64::NAN; count];
    assert_eq!(here.fill("fmi2GetDerivatives", &mut rates), OK);
    assert!((rates[count - 1] - 0.1 * 0.1).abs() < 1e-15);
    assert_eq!(read(&here, rate), rates[count - 1]);
    let travel = here.get("belt_travel");
    states[count - 1] = 0.25;
    assert_eq!(here.set_states(&states), OK);
    assert_eq!(read(&here, state), 0.25);
    assert!((here.get("belt_travel") - travel - 0.25).abs() < 1e-15);
    let there = with_a_moved_belt(1);
    assert_eq!(there.step(0.0, 1e-3), OK);
    assert!((read(&there, state) - 0.01 * 1e-3).abs() < 1e-12);
    assert!((read(&there, rate) - 0.01).abs() < 1e-15);
}
