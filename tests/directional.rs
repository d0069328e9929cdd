//! Directional derivatives (FMI 2.0.5, section 2.1.9) in both interfaces: against formulas for the reference
//! model, and against differences through the interface for every effect.

use std::f64::consts::PI;
use stickslip_tests::exchange::STATES;
use stickslip_tests::slave::{ERROR, OK, Slave};
use stickslip_tests::variables::{XML, reference};

const UNKNOWNS: [&str; 11] = [
    "tip_displacement",
    "tip_velocity",
    "tip_acceleration",
    "friction_force",
    "relative_velocity",
    "power_into_beam",
    "measured_displacement",
    "measured_velocity",
    "measured_acceleration",
    "belt_travel",
    "der(q_dot[1])",
];

fn derivative(slave: &Slave, unknown: &str, known: &str) -> f64 {
    let mut out = [f64::NAN];
    let status = slave.directional(&[reference(unknown)], &[reference(known)], &[1.0], &mut out);
    assert_eq!(status, OK, "{unknown} {known}: {:?}", slave.messages());
    out[0]
}

#[test]
fn val_derivatives_of_the_reference_model_are_those_of_its_equations() {
    // Truth: Stelter 1992, eqs. (2), (4), (7), differentiated by hand.
    let (mass, phi, w, d) = (0.427, 2.0, 2.0 * PI * 80.0, 0.000_15);
    let (mu_0, a1, v1, a2, c2) = (0.66, 0.5, 0.02, 0.5, 0.25);
    let normal: f64 = 100.0;
    let exchange = Slave::started_exchange(&[("q_dot[1]", 0.03), ("q[1]", 2e-4)]);
    let stepped = Slave::new();
    assert_eq!(
        (stepped.set("q_dot[1]", 0.03), stepped.set("q[1]", 2e-4)),
        (OK, OK)
    );
    stepped.start_at(0.0);
    for slave in [exchange, stepped] {
        // Backward slip: v_r = 2 * 0.03 - 0.1.
        let v: f64 = 0.04;
        let (fast, slow) = ((-v / v1).exp(), (-c2 * v).exp());
        let (f, g) = (1.0 - a1 + a1 * fast, 1.0 - a2 + a2 * slow);
        let mu = mu_0 * f * g;
        let slope = mu_0 * (-a1 / v1 * fast * g - c2 * a2 * slow * f);
        // F = mu(-v_r) F_N, so dF/dv_r = -mu' F_N.
        let by_velocity = -slope * normal;
        let cases = [
            ("friction_force", "belt_velocity", -by_velocity),
            ("friction_force", "normal_force", mu),
            ("friction_force", "q_dot[1]", phi * by_velocity),
            ("friction_force", "q_dot[2]", -phi * by_velocity),
            ("friction_force", "q[1]", 0.0),
            ("der(q_dot[1])", "q[1]", -w * w),
            (
                "der(q_dot[1])",
                "q_dot[1]",
                -2.0 * d * w + phi / mass * phi * by_velocity,
            ),
            ("der(q_dot[1])", "normal_force", phi / mass * mu),
            ("der(q_dot[2])", "normal_force", -phi / mass * mu),
            ("der(q_dot[1])", "external_force", phi / mass),
            ("der(q_dot[2])", "external_force", -phi / mass),
            ("friction_force", "external_force", 0.0),
            ("der(energy.external_work)", "external_force", phi * 0.03),
            // The mean of the mode shapes over the length (Blevins 1979, table 8-1: 2 sigma/k).
            ("der(q_dot[1])", "clamp_acceleration", -0.782_991_756),
            ("der(q_dot[2])", "clamp_acceleration", -0.433_935_895),
            ("friction_force", "clamp_acceleration", 0.0),
            ("der(q[1])", "q_dot[1]", 1.0),
            ("tip_displacement", "q[2]", -phi),
            ("tip_displacement", "belt_velocity", 0.0),
            ("relative_velocity", "belt_velocity", -1.0),
            ("belt_travel", "belt_distance", 1.0),
            ("der(belt_distance)", "belt_velocity", 1.0),
            ("der(energy.contact_dissipation)", "normal_force", mu * v),
        ];
        for (unknown, known, truth) in cases {
            let value = derivative(&slave, unknown, known);
            let error = (value - truth).abs();
            assert!(
                error <= 1e-8 * truth.abs().max(1.0),
                "{unknown} {known}: {value} {truth}"
            );
        }
    }
}

/// Each effect of the catalogue at its typical strength, alone, and all that go together.
fn effects() -> Vec<Vec<(String, f64)>> {
    let document = roxmltree::Document::parse(&XML).unwrap();
    let mut sets: Vec<Vec<(String, f64)>> = document
        .descendants()
        .filter(|n| n.has_tag_name("Effect"))
        .map(|effect| {
            let id = effect.attribute("id").unwrap();
            let parameters = effect.children().filter(|n| n.has_tag_name("Parameter"));
            parameters
                .map(|p| {
                    let typical = p.attribute("typical").unwrap().parse().unwrap();
                    (format!("{id}.{}", p.attribute("name").unwrap()), typical)
                })
                .collect()
        })
        .collect();
    assert!(sets.len() >= 16);
    sets.push(sets.iter().flatten().cloned().collect());
    sets
}

fn set_all(slave: &Slave, set: &[(String, f64)], mode: f64) {
    for (name, value) in set {
        assert_eq!(slave.set(name, *value), OK, "{name}");
    }
    if mode == 0.0 {
        assert_eq!(slave.set_integer("start.contact", 1), OK);
    } else {
        assert_eq!(slave.set("q_dot[1]", 0.06 * mode), OK);
        assert_eq!(slave.set("q[1]", 3e-4), OK);
    }
}

fn read(slave: &Slave) -> Vec<f64> {
    let mut values = [0.0; UNKNOWNS.len()];
    assert_eq!(slave.get_into(&UNKNOWNS.map(reference), &mut values), OK);
    values.to_vec()
}

/// Compares with a difference quotient; `size` is the usual magnitude of each unknown over that of the known.
fn compare(derivatives: &[f64], quotient: &[f64], what: &str) {
    const SIZES: [f64; UNKNOWNS.len()] =
        [1e-3, 0.1, 1e3, 50.0, 0.1, 5.0, 1e-3, 0.1, 1e3, 1e-3, 1e3];
    for (((a, b), name), size) in derivatives.iter().zip(quotient).zip(UNKNOWNS).zip(SIZES) {
        let allowed = 2e-5 * (a.abs().max(b.abs()) + size);
        assert!((a - b).abs() <= allowed, "{what}: {name} {a} {b}");
    }
}

#[test]
fn derivatives_through_every_effect_are_the_differences_in_model_exchange() {
    let knowns: Vec<String> = STATES
        .iter()
        .filter(|name| !name.starts_with("energy."))
        .cloned()
        .chain(
            [
                "belt_velocity",
                "normal_force",
                "external_force",
                "clamp_acceleration",
            ]
            .map(str::to_owned),
        )
        .collect();
    for set in effects() {
        for mode in [-1.0, 0.0, 1.0] {
            let slave = Slave::new_exchange();
            set_all(&slave, &set, mode * if mode > 0.0 { 2.0 } else { 1.0 });
            slave.start_at(0.0);
            assert_eq!(slave.plain_call("fmi2EnterContinuousTimeMode"), OK);
            let states = slave.states();
            let mut nominals = states.clone();
            assert_eq!(
                slave.fill("fmi2GetNominalsOfContinuousStates", &mut nominals),
                OK
            );
            for known in &knowns {
                let place = STATES.iter().position(|name| name == known);
                let size = match (place, known.as_str()) {
                    (Some(place), _) => nominals[place],
                    (None, "belt_velocity") => 0.1,
                    (None, _) => 100.0,
                };
                let mut derivatives = [0.0; UNKNOWNS.len()];
                let (unknowns, seed) = (UNKNOWNS.map(reference), [size]);
                let status =
                    slave.directional(&unknowns, &[reference(known)], &seed, &mut derivatives);
                assert_eq!(status, OK, "{set:?} {known}: {:?}", slave.messages());
                let h = 1e-5;
                let at = |by: f64| {
                    if let Some(place) = place {
                        let mut moved = states.clone();
                        moved[place] += by * size;
                        assert_eq!(slave.set_states(&moved), OK);
                    } else {
                        let usual = if known == "belt_velocity" { 0.1 } else { 100.0 };
                        assert_eq!(slave.set(known, usual + by * size), OK);
                    }
                    read(&slave)
                };
                let (a, b) = (at(-h), at(h));
                at(0.0);
                let quotient: Vec<f64> =
                    a.iter().zip(&b).map(|(a, b)| (b - a) / (2.0 * h)).collect();
                compare(
                    &derivatives,
                    &quotient,
                    &format!("{set:?}, mode {mode}, {known}"),
                );
            }
        }
    }
}

#[test]
fn derivatives_by_inputs_are_the_differences_at_communication_points() {
    for set in effects() {
        let start = || {
            let slave = Slave::new();
            set_all(&slave, &set, -1.0);
            slave.start_at(0.0);
            assert_eq!(slave.step(0.0, 1e-4), OK);
            slave
        };
        let slave = start();
        for (known, usual, size) in [
            ("belt_velocity", 0.1, 0.1),
            ("normal_force", 100.0, 100.0),
            ("external_force", 0.0, 10.0),
            ("clamp_acceleration", 0.0, 10.0),
        ] {
            let mut derivatives = [0.0; UNKNOWNS.len()];
            let unknowns = UNKNOWNS.map(reference);
            assert_eq!(
                slave.directional(&unknowns, &[reference(known)], &[size], &mut derivatives),
                OK
            );
            let h = 1e-5;
            let at = |by: f64| {
                let other = start();
                assert_eq!(other.set(known, usual + by * size), OK);
                read(&other)
            };
            let (a, b) = (at(-h), at(h));
            let quotient: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (b - a) / (2.0 * h)).collect();
            compare(&derivatives, &quotient, &format!("{set:?}, {known}"));
        }
    }
}

#[test]
fn derivatives_by_parameters_and_start_values_are_the_differences_in_initialization_mode() {
    for (known, value, size) in [
        ("friction.mu_0", 0.66, 0.66),
        ("mode[1].frequency", 80.0, 80.0),
        ("q[1]", 3e-4, 1e-3),
        ("q_dot[1]", -0.06, 0.1),
        ("normal_force", 100.0, 100.0),
        ("sensor.offset", 0.0, 1e-3),
        ("third_mode.frequency", 1404.0, 1404.0),
    ] {
        let at = |by: f64| {
            let slave = Slave::new();
            set_all(&slave, &[("third_mode.frequency".to_owned(), 1404.0)], -1.0);
            assert_eq!(slave.set(known, value + by * size), OK);
            assert_eq!(slave.enter(), OK);
            slave
        };
        let slave = at(0.0);
        let mut derivatives = [0.0; UNKNOWNS.len()];
        let unknowns = UNKNOWNS.map(reference);
        let status = slave.directional(&unknowns, &[reference(known)], &[size], &mut derivatives);
        assert_eq!(status, OK, "{known}: {:?}", slave.messages());
        let h = 1e-5;
        let (a, b) = (read(&at(-h)), read(&at(h)));
        let quotient: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (b - a) / (2.0 * h)).collect();
        compare(&derivatives, &quotient, known);
    }
}

#[test]
fn a_seed_of_several_knowns_gives_the_sum_and_wrong_variables_are_refused() {
    let slave = Slave::started_exchange(&[("q_dot[1]", 0.03)]);
    let (force, one, two) = (
        reference("friction_force"),
        reference("belt_velocity"),
        reference("normal_force"),
    );
    let mut sum = [0.0];
    assert_eq!(
        slave.directional(&[force], &[one, two], &[0.5, -3.0], &mut sum),
        OK
    );
    let parts = 0.5 * derivative(&slave, "friction_force", "belt_velocity")
        - 3.0 * derivative(&slave, "friction_force", "normal_force");
    assert!(
        (sum[0] - parts).abs() < 1e-7 * parts.abs(),
        "{sum:?} {parts}"
    );
    assert_eq!(slave.directional(&[], &[], &[], &mut []), OK);
    assert_eq!(slave.directional(&[force], &[one], &[0.0], &mut sum), OK);
    assert_eq!(sum[0], 0.0);
    let mut out = [0.0];
    for (unknown, known, seed) in [
        (force, reference("friction.mu_0"), 1.0),
        (force, reference("tip_velocity"), 1.0),
        (reference("friction.mu_0"), one, 1.0),
        (reference("q[1]"), one, 1.0),
        (reference("contact_mode"), one, 1.0),
        (force, one, f64::NAN),
        (force, 4_000_000_000, 1.0),
    ] {
        assert_eq!(
            slave.directional(&[unknown], &[known], &[seed], &mut out),
            ERROR
        );
        assert!(!slave.messages().is_empty());
    }
    // At a normal force of zero there is a derivative to one side only.
    let lifted = Slave::started_exchange(&[("q_dot[1]", 0.03), ("normal_force", 0.0)]);
    let mu = derivative(&lifted, "friction_force", "normal_force");
    assert!((mu - 0.3728).abs() < 1e-4, "{mu}");
}
