//! The result must not depend on the communication step: with constant inputs, results at common
//! times agree to the bit, and to 1e-12 where the times differ in their last digits.

use std::collections::BTreeMap;
use stickslip_tests::slave::{OK, Slave};
use stickslip_tests::variables::reference;

const STEPS: [f64; 4] = [1e-5, 1e-4, 7.3e-4, 1e-2];
const STOP: f64 = 0.365;
const RESULTS: [(&str, f64); 9] = [
    ("tip_displacement", 1e-3),
    ("tip_velocity", 0.1),
    ("tip_acceleration", 100.0),
    ("friction_force", 50.0),
    ("relative_velocity", 0.1),
    ("measured_displacement", 1e-3),
    ("belt_travel", 0.1),
    ("dwell_time", 1e-2),
    ("last_transition_time", 1.0),
];

/// Results and their rates per s.
type Seen = ([f64; 9], [f64; 9]);

/// Times (as bits, which sort like the times) and results of a run with communication step `step`.
fn run(step: f64, effects: &[(&str, f64)]) -> BTreeMap<u64, Seen> {
    let slave = Slave::new();
    for (name, value) in effects {
        assert_eq!(slave.set(name, *value), OK, "{name}");
    }
    slave.start_at(0.0);
    let references = RESULTS.map(|(name, _)| reference(name));
    let mut seen = BTreeMap::new();
    let mut i = 0_u32;
    loop {
        let point = f64::from(i) * step;
        if point > STOP {
            return seen;
        }
        let length = f64::from(i + 1) * step - point;
        assert_eq!(slave.step(point, length), OK, "{:?}", slave.messages());
        let mut values = [0.0; 9];
        assert_eq!(slave.get_into(&references, &mut values), OK);
        let mut rates = [0.0; 9];
        assert_eq!(slave.rates_into(&references, &mut rates), OK);
        seen.insert((point + length).to_bits(), (values, rates));
        i += 1;
    }
}

fn compare(effects: &[(&str, f64)]) {
    let runs = STEPS.map(|step| run(step, effects));
    let (mut identical, mut close) = (0, 0);
    for fine in 0..STEPS.len() {
        for coarse in fine + 1..STEPS.len() {
            for (time, (values, rates)) in &runs[coarse] {
                if let Some((same, _)) = runs[fine].get(time) {
                    assert_eq!(
                        values.map(f64::to_bits),
                        same.map(f64::to_bits),
                        "at {} s with steps of {} and {} s",
                        f64::from_bits(*time),
                        STEPS[fine],
                        STEPS[coarse]
                    );
                    identical += 1;
                    continue;
                }
                let near = runs[fine].range(time - 8..=time + 8).next();
                let Some((at, (other, _))) = near else {
                    continue;
                };
                if values[8] != other[8] {
                    // A transition lies between the two times.
                    continue;
                }
                close += 1;
                // The difference of the times itself makes a difference of the results.
                let dt = (f64::from_bits(*time) - f64::from_bits(*at)).abs();
                for (i, (name, scale)) in RESULTS.iter().enumerate() {
                    let (a, b) = (values[i], other[i]);
                    let allowed = 1e-12 * scale.max(a.abs()) + 2.0 * rates[i].abs() * dt;
                    assert!((a - b).abs() <= allowed, "{name}: {a:e} {b:e}");
                }
            }
        }
    }
    println!("{identical} common times to the bit, {close} within 1e-12");
    assert!(identical > 100 && close > 10, "{identical} {close}");
}

#[test]
fn val_reference_model() {
    compare(&[]);
}

#[test]
fn val_with_effects_that_have_states() {
    compare(&[
        ("third_mode.frequency", 1404.0),
        ("sensor_lag.time_constant", 1e-4),
        ("static_friction_aging.gain", 0.1),
    ]);
}

#[test]
fn val_with_a_bristle() {
    compare(&[
        ("presliding_compliance.bristle_stiffness", 5e5),
        ("presliding_compliance.bristle_damping", 60.0),
    ]);
}
