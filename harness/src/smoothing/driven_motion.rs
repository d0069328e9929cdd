//! What measured inputs do by themselves: the motion that an external force and the clamp alone make of a structure without
//! friction.

use crate::measurement::{Excitation, InputSeries, InputTrack, Run};
use crate::observer::{ForceModel, Structure};
use nalgebra::{DMatrix, DVector};

/// An input of a run at `count` instants an `interval` in s apart, in its own unit.
pub fn sampled(series: &InputSeries, run: &Run, interval: f64, count: usize) -> Vec<f64> {
    let track = track(series, run);
    let at = |k: usize| {
        let t = k as f64 * interval;
        track.piece(t, t).0
    };
    (0..count).map(at).collect()
}

fn track(series: &InputSeries, run: &Run) -> InputTrack {
    let since: Vec<f64> = run.time.iter().map(|t| t - run.time[0]).collect();
    InputTrack::of(series, &since, f64::NEG_INFINITY)
}

/// Modal motion that the excitations of a run alone make, from rest: with friction, the motion is the sum of this one and that of
/// the friction force alone, since the structure is linear.
///
/// ```text
/// q_j'' + 2 D_j w_j q_j' + w_j^2 q_j = phi_j F_ext / m_j - g_j a,   q_j(0) = q_j'(0) = 0
/// ```
///
/// a is the acceleration of the clamp and `g_j phi_j` the mode's clamp share. q_j in m and q_j' in m/s at `count` instants an
/// `interval` in s apart, mode after mode; `None` without an excitation. Exact for straight lines from knot to knot.
pub fn driven_motion(
    structure: &Structure,
    run: &Run,
    interval: f64,
    count: usize,
) -> Option<[Vec<Vec<f64>>; 2]> {
    let of = |excitation: &Excitation| forced_motion(structure, run, excitation, (interval, count));
    let mut shaken = of(&run.inputs.clamp_acceleration);
    for motion in shaken.iter_mut().flatten() {
        for (mode, values) in structure.modes().iter().zip(motion) {
            let phi = mode.tip_value;
            // A mode that does not move the tip is not seen there either.
            let force_per_acceleration = if phi == 0.0 {
                0.0
            } else {
                -mode.clamp_share * mode.mass_kg / (phi * phi)
            };
            values.iter_mut().for_each(|v| *v *= force_per_acceleration);
        }
    }
    match (of(&run.inputs.external_force), shaken) {
        (Some(mut pushed), Some(shaken)) => {
            let both = pushed.iter_mut().flatten().zip(shaken.iter().flatten());
            for (sum, part) in both {
                sum.iter_mut().zip(part).for_each(|(a, b)| *a += b);
            }
            Some(pushed)
        }
        (pushed, shaken) => pushed.or(shaken),
    }
}

/// Modal motion from rest under a force at the tip that has the values of an excitation; `None` where it does nothing.
fn forced_motion(
    structure: &Structure,
    run: &Run,
    excitation: &Excitation,
    (interval, count): (f64, usize),
) -> Option<[Vec<Vec<f64>>; 2]> {
    if !excitation.acts() {
        return None;
    }
    let track = excitation.series.as_ref().map(|s| track(s, run));
    let modes = structure.modes();
    let model = ForceModel::IntegratedRandomWalk;
    let (force, slope) = (2 * modes.len(), 2 * modes.len() + 1);
    let scale = structure.force_scale();
    let slope_scale = scale / modes[0].rate();
    let mut known: Option<(f64, DMatrix<f64>)> = None;
    let mut z = DVector::zeros(2 * modes.len() + 2);
    let mut q = vec![vec![0.0; count]; modes.len()];
    let mut q_dot = q.clone();
    for k in 1..count {
        let (mut t, next) = ((k - 1) as f64 * interval, k as f64 * interval);
        // Rounding of sums of times makes no piece.
        let sliver = 1e-6 * interval;
        while t < next - sliver {
            let knot = track.as_ref().and_then(|track| track.next_knot(t + sliver));
            let end = knot.filter(|knot| *knot < next - sliver).unwrap_or(next);
            let (value, rate) = match &track {
                Some(track) => track.piece(t, end),
                None => (excitation.constant, 0.0),
            };
            z[force] = scale * value;
            z[slope] = slope_scale * rate;
            let tau = end - t;
            let transition = match &known {
                Some((of, transition)) if (of - tau).abs() < sliver => transition,
                _ => &known.insert((tau, structure.transition(model, tau))).1,
            };
            z = transition * z;
            t = end;
        }
        for (j, mode) in modes.iter().enumerate() {
            q[j][k] = z[2 * j];
            q_dot[j][k] = z[2 * j + 1] * mode.rate();
        }
    }
    Some([q, q_dot])
}

/// Rates of change (1/s) of even samples `h` s apart, by central differences.
pub fn differences(values: &[f64], h: f64) -> Vec<f64> {
    let last = values.len() - 1;
    let slope = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(last));
        (values[b] - values[a]) / (h * (b - a).max(1) as f64)
    };
    (0..=last).map(slope).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::InputSignals;
    use crate::smoothing::pushed_run::{pushed, structure};

    #[test]
    fn val_a_force_that_rises_moves_a_spring_and_a_free_mass_as_the_closed_forms_say() {
        // Source: closed forms, x = a t^3/6 of a free mass and (c/k)(t - sin(w t)/w) of an undamped spring under F = c t.
        let (mass, w) = (0.5, std::f64::consts::TAU * 10.0);
        let run = pushed(|t| 3.0 * t, None);
        let both = structure(&[(0.0, 0.0, mass, 2.0), (10.0, 0.0, mass, -2.0)]);
        let [q, q_dot] = driven_motion(&both, &run, 1e-3, 1001).unwrap();
        for k in [0, 17, 500, 1000] {
            let t = 1e-3 * k as f64;
            let free = [
                2.0 * 3.0 * t.powi(3) / 6.0 / mass,
                2.0 * 3.0 * t * t / 2.0 / mass,
            ];
            let stiffness = mass * w * w;
            let spring = [
                -2.0 * 3.0 / stiffness * (t - (w * t).sin() / w),
                -2.0 * 3.0 / stiffness * (1.0 - (w * t).cos()),
            ];
            for (found, truth) in [
                (q[0][k], free[0]),
                (q_dot[0][k], free[1]),
                (q[1][k], spring[0]),
                (q_dot[1][k], spring[1]),
            ] {
                assert!((found - truth).abs() < 1e-9, "{t} s: {found} {truth}");
            }
        }
        let mut plain = run;
        plain.inputs = InputSignals::default();
        assert!(driven_motion(&both, &plain, 1e-3, 1001).is_none());
    }

    #[test]
    fn val_a_clamp_that_accelerates_leaves_masses_behind() {
        // Source: closed forms of x'' = -a of a free mass and x'' + w^2 x = -a of an undamped spring, a = 3 m/s^3 t, x relative to the
        // clamp; beside a force F on the tip the motions add up.
        let (mass, w) = (0.5, std::f64::consts::TAU * 10.0);
        let mut run = pushed(|t| 3.0 * t, None);
        let force = run.inputs.external_force.clone();
        run.inputs.clamp_acceleration = std::mem::take(&mut run.inputs.external_force);
        for (frequency, x) in [
            (
                0.0,
                Box::new(|t: f64| -0.5 * t.powi(3)) as Box<dyn Fn(f64) -> f64>,
            ),
            (
                10.0,
                Box::new(|t: f64| -3.0 / (w * w) * (t - (w * t).sin() / w)),
            ),
        ] {
            let one = structure(&[(frequency, 0.0, mass, -2.0)]);
            let [q, _] = driven_motion(&one, &run, 1e-3, 1001).unwrap();
            let mut both = run.clone();
            both.inputs.external_force = force.clone();
            let [of_both, _] = driven_motion(&one, &both, 1e-3, 1001).unwrap();
            both.inputs.clamp_acceleration = Excitation::default();
            let [of_force, _] = driven_motion(&one, &both, 1e-3, 1001).unwrap();
            for k in [0, 17, 500, 1000] {
                let (found, truth) = (-2.0 * q[0][k], x(1e-3 * k as f64));
                assert!(
                    (found - truth).abs() < 1e-9,
                    "{frequency} Hz, {k}: {found} {truth}"
                );
                assert!((of_both[0][k] - q[0][k] - of_force[0][k]).abs() < 1e-12);
            }
        }
    }
}
