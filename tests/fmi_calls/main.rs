//! Every call of the C interface that real masters make, rightly and wrongly: expected statuses,
//! messages, and never a crash. The cases follow complaints about other FMUs.

mod energies;
mod inputs;
mod instantiate;
mod sensor;
mod sequence;
mod states;
mod steps;
mod values;

use stickslip_tests::slave::{ERROR, OK, Slave};
use stickslip_tests::variables::reference;

/// Results that tell two motions apart.
const RESULTS: [&str; 8] = [
    "tip_displacement",
    "tip_velocity",
    "tip_acceleration",
    "friction_force",
    "relative_velocity",
    "measured_displacement",
    "belt_travel",
    "dwell_time",
];

/// The results now, as bits.
fn results(slave: &Slave) -> [u64; 8] {
    let mut values = [f64::NAN; 8];
    assert_eq!(slave.get_into(&RESULTS.map(reference), &mut values), OK);
    values.map(f64::to_bits)
}

/// Steps of `step` s from `from` s on.
fn advance(slave: &Slave, from: f64, step: f64, count: u32) {
    for i in 0..count {
        let point = from + f64::from(i) * step;
        assert_eq!(slave.step(point, step), OK, "{:?}", slave.messages());
    }
}

/// The call was refused, said why, and changed nothing.
fn assert_refused(slave: &Slave, status: i32, part: &str) {
    assert_eq!(status, ERROR);
    let messages = slave.messages();
    let last = messages.last().expect("a refusal is explained");
    assert_eq!(last.category, "logStatusError");
    assert!(last.text.contains(part), "'{}' lacks '{part}'", last.text);
}
