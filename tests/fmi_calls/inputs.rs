//! Inputs and their derivatives (FMI 2.0.5, section 4.2.1).

use crate::{advance, assert_refused, results};
use stickslip_tests::slave::{OK, Slave};

#[test]
fn setting_an_input_to_its_value_does_not_disturb_the_run() {
    let (plain, busy) = (Slave::started(), Slave::started());
    for i in 0..500 {
        let point = f64::from(i) * 1e-4;
        assert_eq!(busy.set("belt_velocity", 0.1), OK);
        assert_eq!(busy.set("normal_force", 100.0), OK);
        assert_eq!(busy.set("external_force", 0.0), OK);
        assert_eq!(busy.set("clamp_acceleration", 0.0), OK);
        assert_eq!(busy.set_rate("belt_velocity", 1, 0.0), OK);
        assert_eq!(busy.set_rate("external_force", 1, 0.0), OK);
        assert_eq!(busy.set_rate("clamp_acceleration", 1, 0.0), OK);
        assert_eq!(results(&busy), results(&plain));
        assert_eq!((plain.step(point, 1e-4), busy.step(point, 1e-4)), (OK, OK));
    }
    assert_eq!(results(&busy), results(&plain));
}

#[test]
fn a_set_input_shows_at_once_without_a_step() {
    let slave = Slave::started();
    advance(&slave, 0.0, 1e-3, 3);
    let velocity = slave.get("tip_velocity");
    assert_eq!(slave.set("belt_velocity", 0.5), OK);
    assert_eq!(slave.get("belt_velocity"), 0.5);
    assert!((slave.get("relative_velocity") - (velocity - 0.5)).abs() < 1e-15);
    assert_eq!(slave.get("tip_velocity"), velocity);
}

#[test]
fn a_ramp_by_derivatives_does_not_depend_on_the_step() {
    let run = |steps: u32, with_rate: bool| {
        let slave = Slave::started();
        let step = 0.1 / f64::from(steps);
        for i in 0..steps {
            let point = f64::from(i) * step;
            assert_eq!(slave.set("belt_velocity", 0.1 + 0.3 * point), OK);
            assert_eq!(slave.set("normal_force", 100.0 - 400.0 * point), OK);
            assert_eq!(slave.set("external_force", 150.0 * point - 5.0), OK);
            assert_eq!(slave.set("clamp_acceleration", 2.0 - 60.0 * point), OK);
            if with_rate {
                assert_eq!(slave.set_rate("belt_velocity", 1, 0.3), OK);
                assert_eq!(slave.set_rate("normal_force", 1, -400.0), OK);
                assert_eq!(slave.set_rate("external_force", 1, 150.0), OK);
                assert_eq!(slave.set_rate("clamp_acceleration", 1, -60.0), OK);
            }
            assert_eq!(slave.step(point, step), OK, "{:?}", slave.messages());
        }
        slave.get("tip_displacement")
    };
    let (coarse, fine, stairs) = (run(1, true), run(100, true), run(100, false));
    // A line that is stated again goes on: what was integrated ahead stays valid.
    assert!((coarse - fine).abs() < 1e-15, "{coarse} {fine}");
    assert!(
        (stairs - fine).abs() > 1e-8,
        "stairs are worse: {stairs} {fine}"
    );
}

#[test]
fn a_derivative_holds_for_one_step() {
    let (a, b) = (Slave::started(), Slave::started());
    for slave in [&a, &b] {
        assert_eq!(slave.set_rate("belt_velocity", 1, 2.0), OK);
        assert_eq!(slave.step(0.0, 0.01), OK);
    }
    assert_eq!(b.set("belt_velocity", 0.1), OK);
    assert_eq!(b.set_rate("belt_velocity", 1, 0.0), OK);
    advance(&a, 0.01, 0.01, 5);
    advance(&b, 0.01, 0.01, 5);
    assert_eq!(results(&a), results(&b));
}

#[test]
fn derivatives_that_make_no_sense_are_refused() {
    let slave = Slave::started();
    for order in [0, 2, -1] {
        assert_refused(&slave, slave.set_rate("belt_velocity", order, 1.0), "order");
    }
    for value in [f64::NAN, f64::INFINITY] {
        assert_refused(&slave, slave.set_rate("normal_force", 1, value), "finite");
    }
    assert_refused(
        &slave,
        slave.set_rate("friction.mu_0", 1, 0.0),
        "not an input",
    );
    assert_refused(
        &slave,
        slave.set_rate("tip_velocity", 1, 0.0),
        "not an input",
    );
    assert_refused(
        &slave,
        slave.set_rate("contact_mode", 1, 0.0),
        "Enumeration",
    );
    let (a, b) = (slave, Slave::started());
    advance(&a, 0.0, 1e-3, 20);
    advance(&b, 0.0, 1e-3, 20);
    assert_eq!(results(&a), results(&b));
}

#[test]
fn a_belt_at_rest_or_running_backwards_and_a_lifted_tip_are_legal() {
    for (velocity, force) in [(0.0, 100.0), (-0.1, 100.0), (0.1, 0.0), (0.0, 0.0)] {
        let slave = Slave::new();
        assert_eq!(slave.set("belt_velocity", velocity), OK);
        assert_eq!(slave.set("normal_force", force), OK);
        assert_eq!(slave.set("q[1]", 1e-3), OK);
        slave.start_at(0.0);
        advance(&slave, 0.0, 1e-2, 20);
        assert!(slave.get("tip_displacement").is_finite());
    }
    // Mirror image: the belt the other way round gives the motion the other way round.
    let mirror = Slave::new();
    assert_eq!(mirror.set("belt_velocity", -0.1), OK);
    mirror.start_at(0.0);
    let plain = Slave::started();
    advance(&mirror, 0.0, 1e-2, 20);
    advance(&plain, 0.0, 1e-2, 20);
    assert_eq!(
        mirror.get("tip_displacement"),
        -plain.get("tip_displacement")
    );
}

#[test]
fn a_belt_that_jumps_and_jumps_back_at_one_point_goes_on_as_before() {
    let (plain, jumpy) = (Slave::started(), Slave::started());
    advance(&plain, 0.0, 1e-3, 1);
    advance(&jumpy, 0.0, 1e-3, 1);
    assert_eq!(jumpy.get_integer("contact_mode"), 0);
    assert_eq!(jumpy.set("belt_velocity", 0.0864), OK);
    // A look makes the run follow the input: the tip slips.
    assert_eq!(jumpy.get_integer("contact_mode"), 1);
    assert!(jumpy.rate("tip_velocity").is_finite());
    assert_eq!(jumpy.set("belt_velocity", 0.1), OK);
    assert_eq!(jumpy.get_integer("contact_mode"), 0);
    for i in 1..100 {
        let point = f64::from(i) * 1e-3;
        assert_eq!((plain.step(point, 1e-3), jumpy.step(point, 1e-3)), (OK, OK));
        let difference = plain.get("tip_displacement") - jumpy.get("tip_displacement");
        assert!(difference.abs() < 1e-10, "{difference:e} at {point}");
    }
    let counts = [&plain, &jumpy].map(|s| s.get_integer("transition_count"));
    assert_eq!(counts[0] + 2, counts[1], "out of stick and back");
}
