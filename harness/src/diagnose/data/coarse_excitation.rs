//! Excitations with as few points as the motion needs.

use crate::measurement::{
    Excitation, InputSeries, InputSignals, Interpolation, Measurand, REFINEMENT, Run,
};
use crate::metric::line;
use crate::observer::Structure;
use crate::smoothing::{differences, driven_motion};

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
    use crate::smoothing::pushed_run::{pushed, structure};
    use std::f64::consts::PI;

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
}
