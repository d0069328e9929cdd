//! fmi2DoStep with the steps that real masters send (FMI 2.0.5, section 4.2.2).

use crate::{advance, assert_refused, results};
use stickslip_tests::slave::{DISCARD, ERROR, OK, Slave};
use stickslip_tests::variables::reference;

/// Displacement (m), velocity (m/s) and belt travel (m) agree within `tolerance` of their usual size.
fn assert_close(a: &Slave, b: &Slave, tolerance: f64) {
    for (name, scale) in [
        ("tip_displacement", 1e-3),
        ("tip_velocity", 0.1),
        ("belt_travel", 0.1),
    ] {
        let (x, y) = (a.get(name), b.get(name));
        assert!(
            (x - y).abs() <= tolerance * scale,
            "{name}: {x:e} and {y:e}"
        );
    }
}

#[test]
fn impossible_steps_are_refused() {
    let slave = Slave::started();
    let before = results(&slave);
    for step in [0.0, -0.0, -1e-3, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_refused(&slave, slave.step(0.0, step), "communicationStepSize");
    }
    for point in [f64::NAN, f64::INFINITY, 1.0, -1.0, 1e300] {
        assert_refused(&slave, slave.step(point, 1e-3), "currentCommunicationPoint");
    }
    assert_eq!(results(&slave), before);
    advance(&slave, 0.0, 1e-3, 10);
}

#[test]
fn a_wrong_communication_point_does_not_freeze_the_run() {
    let (a, b) = (Slave::started(), Slave::started());
    advance(&a, 0.0, 1e-3, 50);
    advance(&b, 0.0, 1e-3, 25);
    assert_eq!(b.step(0.0, 1e-3), ERROR);
    assert_eq!(b.step(0.5, 1e-3), ERROR);
    advance(&b, 0.025, 1e-3, 25);
    assert_close(&a, &b, 1e-12);
}

#[test]
fn jitter_drift_and_a_tiny_last_step_change_nothing() {
    let clean = Slave::started();
    assert_eq!(clean.step(0.0, 0.3), OK);
    // FMPy, libcosim: points k h, steps that differ in the last digits.
    let jittered = Slave::started();
    for i in 0..300_u32 {
        let (from, to) = (f64::from(i) * 1e-3, f64::from(i + 1) * 1e-3);
        let noise = 1.0 + 1e-14 * f64::from(i % 7);
        assert_eq!(jittered.step(from, (to - from) * noise), OK);
    }
    assert_close(&clean, &jittered, 1e-10);
    // ecos: time added up; OMSimulator: a last step of 2e-14 s to reach the stop time.
    let drifting = Slave::started();
    let (mut time, step) = (0.0, 1e-3 * (1.0 - 1e-13));
    for _ in 0..300 {
        assert_eq!(drifting.step(time, step), OK);
        time += step;
    }
    assert_eq!(drifting.step(time, 0.3 - time), OK);
    assert_eq!(drifting.step(0.3, 1.95e-14), OK);
    assert_close(&clean, &drifting, 1e-10);
    // A clock a little behind ours must not take us back.
    let late = Slave::started();
    for i in 0..300_u32 {
        assert_eq!(late.step(f64::from(i) * 1e-3 - 1e-11, 1e-3), OK);
    }
    assert_eq!(late.step(0.3 - 1e-11, 1e-11), OK);
    assert_close(&clean, &late, 1e-10);
}

#[test]
fn a_denormal_step_is_a_step() {
    let slave = Slave::started();
    advance(&slave, 0.0, 1e-3, 20);
    let before = results(&slave);
    assert_eq!(slave.step(0.02, 5e-324), OK);
    assert_eq!(results(&slave), before);
}

#[test]
fn the_stop_time_is_respected_but_not_to_the_last_digit() {
    let slave = Slave::new();
    assert_eq!(slave.experiment(None, 0.0, Some(0.1)), OK);
    assert_eq!((slave.enter(), slave.exit()), (OK, OK));
    assert_eq!(slave.step(0.0, 0.05), OK);
    assert_refused(&slave, slave.step(0.05, 0.06), "stop time");
    assert_eq!(slave.step(0.05, 0.05 + 1e-13), OK);
    let free = Slave::new();
    assert_eq!(
        free.experiment(None, 0.0, None),
        OK,
        "the garbage stop time is ignored"
    );
    assert_eq!((free.enter(), free.exit()), (OK, OK));
    assert_eq!(free.step(0.0, 50.0), OK);
}

#[test]
fn experiments_that_make_no_sense_are_refused() {
    let slave = Slave::new();
    assert_refused(&slave, slave.setup(f64::NAN), "startTime");
    assert_refused(&slave, slave.experiment(None, 1.0, Some(0.0)), "stopTime");
    assert_refused(
        &slave,
        slave.experiment(None, 0.0, Some(f64::NAN)),
        "stopTime",
    );
    assert_refused(
        &slave,
        slave.experiment(Some(f64::NAN), 0.0, None),
        "tolerance",
    );
    assert_refused(&slave, slave.experiment(Some(0.0), 0.0, None), "tolerance");
    assert_eq!(slave.experiment(Some(1e-6), 0.0, Some(1.0)), OK);
}

#[test]
fn the_start_time_shifts_the_run_and_nothing_else() {
    let zero = Slave::started();
    advance(&zero, 0.0, 1e-3, 100);
    for (start, tolerance) in [(-3.0, 1e-9), (17.0, 1e-9), (1e6, 1e-4)] {
        let slave = Slave::new();
        slave.start_at(start);
        advance(&slave, start, 1e-3, 100);
        assert_close(&zero, &slave, tolerance);
        let shift = slave.get("last_transition_time") - start - zero.get("last_transition_time");
        assert!(shift.abs() < 1e-8, "{shift}");
    }
}

#[test]
fn the_tighter_of_both_tolerances_holds() {
    let run = |own: f64, asked: Option<f64>| {
        let slave = Slave::new();
        assert_eq!(slave.set("tolerance", own), OK);
        assert_eq!(slave.experiment(asked, 0.0, None), OK);
        assert_eq!((slave.enter(), slave.exit()), (OK, OK));
        assert_eq!(slave.step(0.0, 0.2), OK);
        results(&slave)
    };
    assert_eq!(run(1e-9, Some(1e-3)), run(1e-9, None));
    assert_eq!(run(1e-6, Some(1e-9)), run(1e-9, None));
    assert_ne!(run(1e-6, None), run(1e-9, None));
}

#[test]
fn a_run_that_can_not_go_on_is_discarded_and_can_be_taken_up_again_after_reset() {
    let slave = Slave::new();
    // At this time a double resolves 1e-4 s: no step is small enough.
    slave.start_at(1e12);
    assert_eq!(slave.step(1e12, 1.0), DISCARD);
    let messages = slave.messages();
    assert_eq!(messages[0].category, "logStatusDiscard");
    assert!(messages[0].text.contains("no progress"), "{messages:?}");
    assert_eq!(slave.last_successful_time(), Some(1e12));
    assert!(slave.get("tip_displacement").is_finite());
    assert_refused(&slave, slave.step(1e12, 1.0), "step failed");
    assert_eq!(slave.reset(), OK);
    slave.start_at(0.0);
    let fresh = Slave::started();
    advance(&slave, 0.0, 1e-3, 50);
    advance(&fresh, 0.0, 1e-3, 50);
    assert_eq!(results(&slave), results(&fresh));
}

#[test]
fn the_last_successful_time_is_the_end_of_the_last_step() {
    let slave = Slave::started();
    assert_eq!(slave.step(0.0, 7.3e-4), OK);
    assert_eq!(slave.last_successful_time(), Some(7.3e-4));
}

#[test]
fn output_derivatives_are_the_slopes_of_the_outputs() {
    let slave = Slave::started();
    let names = [
        "tip_displacement",
        "tip_velocity",
        "tip_acceleration",
        "friction_force",
        "relative_velocity",
        "power_into_beam",
        "measured_displacement",
        "belt_travel",
        "dwell_time",
    ];
    let h = 1e-6;
    let mut checked = 0;
    for i in 1..200_u32 {
        let at = f64::from(i) * 1e-3;
        let from = slave.last_successful_time().unwrap();
        assert_eq!(slave.step(from, at - h - from), OK);
        let (count, a) = (
            slave.get_integer("transition_count"),
            names.map(|n| slave.get(n)),
        );
        assert_eq!(slave.step(at - h, h), OK);
        let rates = names.map(|n| slave.rate(n));
        assert_eq!(slave.step(at, h), OK);
        if slave.get_integer("transition_count") != count {
            continue;
        }
        let b = names.map(|n| slave.get(n));
        checked += 1;
        for ((name, rate), (a, b)) in names.iter().zip(rates).zip(a.iter().zip(b)) {
            let slope = (b - a) / (2.0 * h);
            // The difference quotient spans pieces of the integration, whose interpolants meet to
            // about 1e-8 of the velocity; its own rounding is about 1e-5.
            let allowed = 1e-3 * slope.abs().max(rate.abs()) + 1e-5;
            assert!(
                (rate - slope).abs() < allowed,
                "{name} at {at}: {rate} {slope}"
            );
        }
    }
    assert!(checked > 150, "{checked}");
}

#[test]
fn output_derivatives_of_other_orders_or_of_no_outputs_are_refused() {
    let slave = Slave::started();
    assert_eq!(slave.step(0.0, 1e-3), OK);
    assert_refused(
        &slave,
        slave.rate_into("tip_velocity", 2, &mut 0.0),
        "order",
    );
    assert_refused(
        &slave,
        slave.rate_into("tip_velocity", 0, &mut 0.0),
        "order",
    );
    assert_refused(
        &slave,
        slave.rate_into("friction.mu_0", 1, &mut 0.0),
        "no output",
    );
    assert_refused(
        &slave,
        slave.rate_into("contact_mode", 1, &mut 0.0),
        "Enumeration",
    );
    assert_eq!(reference("last_transition_time"), 18);
    assert_eq!(slave.rate("last_transition_time"), 0.0);
}
