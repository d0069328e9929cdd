//! After how many section points a motion repeats.

use super::Crossing;
use crate::beam::Beam;
use crate::integrate::State;

/// Distance of states, as a share of the motion's amplitude, below which they count as the same.
pub(super) const SAME: f64 = 1e-5;
/// How much better a period fits than shorter ones do.
const CLEARER: f64 = 50.0;
/// Repetitions that are asked for, and the fewest points compared.
const REPETITIONS: usize = 2;
const FEWEST: usize = 8;

/// Distance of two states in m: each mode counts by what it contributes at the tip,
/// `sqrt(sum phi_j^2 [(q_j - p_j)^2 + (q_j' - p_j')^2 / w_j^2])`.
pub(super) fn distance(beam: &Beam, a: &State, b: &State) -> f64 {
    let modes = beam.modes().iter().enumerate();
    let parts = modes.map(|(j, m)| {
        let q = a[2 * j] - b[2 * j];
        let v = (a[2 * j + 1] - b[2 * j + 1]) / m.angular_frequency();
        m.tip_value * m.tip_value * (q * q + v * v)
    });
    parts.sum::<f64>().sqrt()
}

/// The least number of section points after which the motion repeats; `None` if it does not.
///
/// The last points are compared with those `p` before: all of at least 8, and of two periods, must agree within 1e-5
/// of the amplitude (m), and fifty times better than at any shorter period: a motion that spirals into a fixed point
/// comes nearly back after a few turns long before it repeats. Periods longer than a third of the points are not
/// recognised.
pub fn period_of(beam: &Beam, points: &[Crossing], amplitude: f64) -> Option<usize> {
    let n = points.len();
    let mut nearest = f64::INFINITY;
    for p in 1..=n / 3 {
        let compared = (REPETITIONS * p).max(FEWEST);
        if compared + p > n {
            return None;
        }
        let largest = (n - compared..n)
            .map(|k| distance(beam, &points[k].state, &points[k - p].state))
            .fold(0.0, f64::max);
        if largest < SAME * amplitude {
            // Whatever comes later repeats this one.
            return (largest * CLEARER < nearest).then_some(p);
        }
        nearest = nearest.min(largest);
    }
    None
}
