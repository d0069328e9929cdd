//! What a formula may look at.

use super::super::{ContactForce, Motion};
use crate::real::{Real, ZERO, real};

/// Quantities that every formula may use, with what they mean.
pub const QUANTITIES: [(&str, &str); 9] = [
    ("t", "time in s"),
    ("w", "tip displacement in m"),
    ("w_dot", "tip velocity in m/s"),
    ("v_r", "relative velocity w_dot - v_belt in m/s, 0 in stick"),
    ("v_abs", "sliding speed |v_r| in m/s, 0 in stick"),
    ("F_N", "normal force in N as given, before any effect"),
    ("v0", "belt velocity in m/s as given, before any effect"),
    (
        "s",
        "belt travel in m: the place on the belt where the tip stands",
    ),
    ("t_stick", "time in s since stick began, 0 in slip"),
];
/// Quantities that the rate of a state may use besides.
pub const RATE_QUANTITIES: [(&str, &str); 2] = [
    (
        "F",
        "friction force on the tip in N, positive along the belt's motion",
    ),
    ("stick", "1 in stick, 0 in slip"),
];

pub(super) const COUNT: usize = QUANTITIES.len();
/// First state of the effect among what varies.
pub(super) const FIRST_STATE: usize = COUNT + RATE_QUANTITIES.len();
/// Place of the quantity that is 1 in stick.
pub(super) const STICK: usize = COUNT + 1;
/// Most states of one user effect.
pub const MAX_USER_STATES: usize = 4;
/// All that varies: quantities, those of rates, states.
pub(super) const VARIABLE: usize = FIRST_STATE + MAX_USER_STATES;

/// Quantities that do not change during stick at constant normal force: v_r, v_abs, F_N, s.
pub(super) const CONSTANT_IN_STICK: [bool; COUNT] =
    [false, false, false, true, true, true, false, true, false];
/// Those of them that are constants of the equations, which s is not: s differs from stick to stick.
pub(super) const CONSTANT_IN_ALL_STICK: [bool; COUNT] =
    [false, false, false, true, true, true, false, false, false];
/// Quantities that depend on time and inputs alone: t, F_N, v0.
pub(super) const GIVEN: [bool; COUNT] =
    [true, false, false, false, false, true, true, false, false];
/// Place of the displacement w.
const DISPLACEMENT: usize = 1;

/// The values of all that varies.
pub(super) fn values(m: &Motion, x: &[Real]) -> [Real; VARIABLE] {
    let mut out = [ZERO; VARIABLE];
    out[..COUNT].copy_from_slice(&[
        m.time,
        m.displacement,
        m.velocity,
        m.relative_velocity,
        m.speed,
        m.normal_force,
        m.given_belt_velocity,
        m.travel,
        m.dwell,
    ]);
    out[FIRST_STATE..FIRST_STATE + x.len()].copy_from_slice(x);
    out
}

/// The same where the contact force is known too.
pub(super) fn values_with_force(
    m: &Motion,
    contact: &ContactForce,
    x: &[Real],
) -> [Real; VARIABLE] {
    let mut out = values(m, x);
    out[COUNT] = contact.force;
    out[STICK] = real(f64::from(u8::from(contact.stuck)));
    out
}

/// The same for a sensor, whose w is the reading so far.
pub(super) fn values_with_reading(m: &Motion, reading: Real, x: &[Real]) -> [Real; VARIABLE] {
    let mut out = values(m, x);
    out[DISPLACEMENT] = reading;
    out
}
