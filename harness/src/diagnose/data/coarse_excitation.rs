//! Excitations with as few points as the motion needs.

use crate::measurement::{
    Between, Excitation, InputSeries, InputSignals, Interpolation, Measurand, Run, on_lines,
};
use crate::metric::line;
use crate::observer::Structure;
use crate::smoothing::{differences, driven_motion};

/// Share of the noise up to which a motion may differ: its square adds a hundredth to what noise leaves.
const UNSEEN: f64 = 0.1;

/// Samples from one knot to the next of a coarse excitation, the most first.
const LINES: [usize; 4] = [16, 8, 4, 2];

/// Takes of an excitation that is sampled evenly as few knots as show in no motion over a `horizon` in s: straight lines over several
/// samples, or so many points for each sample of a band-limited one. With them, the excitation by itself makes the structure move as with
/// all, within a share [`UNSEEN`] of the run's `noise`. Every knot ends a step of the integrator, and a mass follows nothing that is fast.
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
    let Some(stated) = excitation(&mut run.inputs).series.clone() else {
        return;
    };
    if Interpolation::usual(&run.sampling) != Interpolation::BandLimited {
        return;
    }
    let interval = run.sample_interval();
    let window = ((horizon / interval) as usize).max(2);
    let time = run.time.clone();
    let mut motion = |series: &InputSeries| -> Vec<f64> {
        excitation(&mut run.inputs).series = Some(series.clone());
        let motion = driven_motion(structure, run, interval, time.len());
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
        (0..time.len()).map(sample).collect()
    };
    let all = motion(&stated);
    let mut is_unseen = |series: &InputSeries| {
        let coarse = motion(series);
        let differences: Vec<f64> = all.iter().zip(&coarse).map(|(a, b)| a - b).collect();
        let mut windows = differences.chunks(window);
        windows.all(|part| beside_a_line(part) <= UNSEEN * noise)
    };
    let lines = LINES
        .iter()
        .map(|samples| on_lines(&stated, &time, *samples));
    let with_points = |points: usize| InputSeries {
        between: Between::BandLimited(points),
        ..stated.clone()
    };
    let points = match stated.between {
        Between::BandLimited(_) => vec![1, 2, 4],
        _ => Vec::new(),
    };
    let mut coarse = lines.chain(points.into_iter().map(with_points));
    let found = coarse.find(&mut is_unseen);
    excitation(&mut run.inputs).series = Some(found.unwrap_or(stated));
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
        let coarse = |of: (f64, Interpolation), modes: &[(f64, f64, f64, f64)], noise: f64| {
            let mut run = pushed(|t| (2.0 * PI * of.0 * t).sin(), None);
            let series = run.inputs.external_force.series.as_mut().unwrap();
            series.between = of.1.into();
            coarsen(&structure(modes), &mut run, 0.1, noise);
            run.inputs.external_force.series.unwrap().between
        };
        let points = |modes: &[(f64, f64, f64, f64)], noise: f64| {
            coarse((180.0, Interpolation::BandLimited), modes, noise)
        };
        // The force moves 1 kg by 1/(2 pi 180)^2 m = 0.8 um, at resonance with 1 % of damping by 40 um; with n points it has
        // (pi 0.18/n)^2/3 less: with 4 points 0.14 um less than with 8, root mean square, with 2 points 0.7 um.
        assert_eq!(points(&[(0.0, 0.0, 1.0, 1.0)], 1e-6), Between::Linear(2));
        let swings = [(180.0, 0.01, 1.0, 1.0)];
        assert_eq!(points(&swings, 3e-6), Between::BandLimited(4));
        assert_eq!(points(&swings, 1e-9), Interpolation::BandLimited.into());
        // At 12 Hz it moves 1 kg by 180 um: with lines over eight samples by less than 0.1 um less, not by less than a pm.
        let free = [(0.0, 0.0, 1.0, 1.0)];
        for way in [
            Interpolation::BandLimited,
            Interpolation::Linear,
            Interpolation::Held,
        ] {
            assert_eq!(coarse((12.0, way), &free, 1e-6), Between::Linear(8));
            assert_eq!(coarse((12.0, way), &free, 1e-11), way.into());
        }
    }
}
