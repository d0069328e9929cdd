//! What measured inputs do by themselves: how far the belt has run, and the motion that an external force and the clamp alone
//! make of a structure without friction.

use crate::measurement::{
    Excitation, InputSeries, InputSignals, InputTrack, Interpolation, Measurand, REFINEMENT, Run,
};
use crate::metric::line;
use crate::observer::{ForceModel, Structure};
use nalgebra::{DMatrix, DVector};

/// Distance that the belt of a run has passed.
pub enum BeltPath {
    /// At a constant velocity in m/s.
    Even(f64),
    /// At a velocity that was measured.
    Uneven {
        /// Interval of the distances in s.
        interval: f64,
        /// Distance in m since the run began.
        distance: Vec<f64>,
    },
}

impl BeltPath {
    /// Of a run whose belt has the velocities `belt` in m/s at an `interval` in s, where they vary.
    pub fn of(run: &Run, interval: f64, belt: Option<&[f64]>) -> Self {
        let Some(belt) = belt else {
            return Self::Even(run.belt_velocity);
        };
        let mut passed = 0.0;
        let steps = belt.windows(2).map(|v| 0.5 * interval * (v[0] + v[1]));
        let distance = std::iter::once(0.0).chain(steps.map(|step| {
            passed += step;
            passed
        }));
        Self::Uneven {
            interval,
            distance: distance.collect(),
        }
    }

    /// Distance in m at sample `k` of a record with this `interval` in s.
    pub fn at_sample(&self, k: usize, interval: f64) -> f64 {
        match self {
            Self::Even(velocity) => velocity * k as f64 * interval,
            Self::Uneven { .. } => self.at(k as f64 * interval),
        }
    }

    /// Distance in m at `time` in s since the run began.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Even(velocity) => velocity * time,
            Self::Uneven { interval, distance } => {
                let last = distance.len() - 1;
                let place = (time / interval).clamp(0.0, last as f64);
                let k = (place.floor() as usize).min(last.saturating_sub(1));
                let next = distance[(k + 1).min(last)];
                distance[k] + (place - k as f64) * (next - distance[k])
            }
        }
    }
}

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

/// Share of the noise up to which a motion may differ: its square adds a hundredth to what noise leaves.
const UNSEEN: f64 = 0.1;

/// Takes as few points for each sample of a band-limited excitation as show in no motion over a `horizon` in s: with them, the
/// excitation by itself makes the structure move as with all, within a share [`UNSEEN`] of the run's `noise`. Every point ends a
/// step of the integrator, and a mass follows nothing that is fast.
pub fn coarsen(structure: &Structure, run: &mut Run, horizon: f64, noise: f64) {
    let which: [fn(&mut InputSignals) -> &mut Excitation; 2] =
        [|i| &mut i.external_force, |i| &mut i.clamp_acceleration];
    for excitation in which {
        coarsen_one(structure, run, excitation, (horizon, noise));
    }
}

fn coarsen_one(
    structure: &Structure,
    run: &mut Run,
    excitation: fn(&mut InputSignals) -> &mut Excitation,
    (horizon, noise): (f64, f64),
) {
    let is_fine = |s: &InputSeries| s.interpolation == Interpolation::BandLimited;
    let series = &excitation(&mut run.inputs).series;
    if !series.as_ref().is_some_and(is_fine) {
        return;
    }
    let interval = run.sample_interval();
    let window = ((horizon / interval) as usize).max(2);
    let mut with = |points: usize| -> Vec<f64> {
        if let Some(series) = &mut excitation(&mut run.inputs).series {
            series.refinement = points;
        }
        let motion = driven_motion(structure, run, interval, run.time.len());
        let [q, q_dot] = motion.expect("an excitation acts");
        let seen = match run.measurand {
            Measurand::Displacement => q,
            Measurand::Velocity => q_dot,
            Measurand::Acceleration => q_dot.iter().map(|v| differences(v, interval)).collect(),
        };
        let modes = structure.modes().iter().zip(&seen);
        let sample = |k: usize| {
            modes
                .clone()
                .map(|(mode, q)| mode.sensor_value() * q[k])
                .sum()
        };
        (0..run.time.len()).map(sample).collect()
    };
    let all = with(REFINEMENT);
    for points in [1, 2, 4] {
        let coarse = with(points);
        let differences: Vec<f64> = all.iter().zip(&coarse).map(|(a, b)| a - b).collect();
        let unseen = differences
            .chunks(window)
            .all(|part| beside_a_line(part) <= UNSEEN * noise);
        if unseen {
            return;
        }
    }
    with(REFINEMENT);
}

/// Root mean square of what even samples have beside a straight line, which another start of the motion makes.
fn beside_a_line(samples: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = samples
        .iter()
        .enumerate()
        .map(|(k, y)| (k as f64, *y))
        .collect();
    let (intercept, slope) = line(&points);
    let squares = points
        .iter()
        .map(|(x, y)| (y - intercept - slope * x).powi(2));
    (squares.sum::<f64>() / samples.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::{Noise, Sampling};
    use crate::observer::Mode;
    use std::f64::consts::PI;

    /// A run pushed by `force`, sampled every ms.
    fn pushed(force: impl Fn(f64) -> f64, belt: Option<fn(f64) -> f64>) -> Run {
        let time: Vec<f64> = (0..1001).map(|k| 2.0 + 1e-3 * f64::from(k)).collect();
        let series = |of: &dyn Fn(f64) -> f64| InputSeries {
            column: "input".into(),
            values: time.iter().map(|t| of(t - 2.0)).collect(),
            interpolation: Interpolation::Linear,
            refinement: REFINEMENT,
        };
        Run {
            name: "pushed".into(),
            file: "pushed.csv".into(),
            further_files: Vec::new(),
            role: None,
            belt_velocity: 0.1,
            normal_force: 0.0,
            inputs: InputSignals {
                belt_velocity: belt.map(|of| series(&of)),
                external_force: Excitation {
                    series: Some(series(&force)),
                    constant: 0.0,
                },
                ..InputSignals::default()
            },
            measurand: Measurand::Displacement,
            measured: vec![0.0; time.len()],
            further: Vec::new(),
            sampling: Sampling::of(&time),
            noise: Noise {
                std: 1e-6,
                resolution: 1e-9,
            },
            time,
            faults: Vec::new(),
            understood: None,
        }
    }

    fn structure(modes: &[(f64, f64, f64, f64)]) -> Structure {
        let mode = |&(frequency_hz, damping_ratio, mass_kg, tip_value)| Mode {
            frequency_hz,
            damping_ratio,
            damping_rate: 0.0,
            mass_kg,
            tip_value,
            sensor_ratio: 1.0,
            clamp_share: 1.0,
        };
        Structure::new(modes.iter().map(mode).collect()).unwrap()
    }

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

    #[test]
    fn a_mass_needs_fewer_points_than_what_swings_fast() {
        let wave = |t: f64| (2.0 * PI * 180.0 * t).sin();
        let points = |modes: &[(f64, f64, f64, f64)], noise: f64| {
            let mut run = pushed(wave, None);
            let series = run.inputs.external_force.series.as_mut().unwrap();
            series.interpolation = Interpolation::BandLimited;
            coarsen(&structure(modes), &mut run, 0.1, noise);
            run.inputs.external_force.series.unwrap().refinement
        };
        // The force moves 1 kg by 1/(2 pi 180)^2 m = 0.8 um, at resonance with 1 % of damping by 40 um; with n points it has
        // (pi 0.18/n)^2/3 less: with 4 points 0.14 um less than with 8, root mean square, with 2 points 0.7 um.
        assert_eq!(points(&[(0.0, 0.0, 1.0, 1.0)], 1e-6), 1);
        assert_eq!(points(&[(180.0, 0.01, 1.0, 1.0)], 3e-6), 4);
        assert_eq!(points(&[(180.0, 0.01, 1.0, 1.0)], 1e-9), REFINEMENT);
    }

    #[test]
    fn a_belt_that_speeds_up_has_passed_its_integral() {
        let run = pushed(|_| 0.0, Some(|t| 0.1 + 0.4 * t));
        let series = run.inputs.belt_velocity.as_ref().unwrap();
        let belt = sampled(series, &run, 1e-3, 1001);
        let path = BeltPath::of(&run, 1e-3, Some(&belt));
        assert!((path.at(0.5) - (0.05 + 0.05)).abs() < 1e-12);
        assert!((path.at(0.5005) - (0.05005 + 0.2 * 0.5005_f64.powi(2))).abs() < 1e-6);
        assert_eq!(BeltPath::of(&run, 1e-3, None).at(2.0), 0.2);
    }
}
