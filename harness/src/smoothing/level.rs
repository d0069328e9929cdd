//! What a measured velocity or acceleration leaves open: the level of force and deflection.
//!
//! A structure on springs that a constant force deflects has no velocity and no acceleration, so that these say nothing of that
//! force and of the deflection. The smoother finds both up to a level. Here the level is set by the friction expected: for a
//! diagnosis a belief like that of the friction constants, which the fit then starts from.

use super::slip_samples::{SlipSample, slip_of_run};
use super::smoothed_run::Smoothing;
use crate::measurement::{Measurand, Run};
use crate::metric::{interpolate, median};
use crate::observer::Structure;

/// By how much the friction expected in slip exceeds the smoothed force in the median, c in N; `None` where nothing slips.
pub fn missing_force(slip: &[SlipSample], run: &Run, friction: &dyn Fn(f64) -> f64) -> Option<f64> {
    let off = slip.iter().map(|s| missing(s, run, friction));
    let mut off: Vec<f64> = off.filter(|c| c.is_finite()).collect();
    (!off.is_empty()).then(|| median(&mut off))
}

/// By how much the friction expected exceeds the smoothed force in one sample, N.
fn missing(slip: &SlipSample, run: &Run, friction: &dyn Fn(f64) -> f64) -> f64 {
    let v = slip.relative_velocity;
    -v.signum() * friction(v.abs()) * run.normal_force - slip.force
}

/// Windows of the moving level in periods, to either side: with one cycle and a half each holds slip.
const PERIODS: f64 = 1.5;

/// Sets the level of force and displacement of a smoothed velocity or acceleration such that friction in slip is what is expected.
///
/// ```text
/// F + c,   q_j + phi_j c / (m_j w_j^2),   c = median over slip of (-sign(v_r) mu(|v_r|) F_N - F)
/// ```
///
/// `friction` is mu (1) over the relative speed in m/s. A velocity shows what a force does that changes slowly, so that c is one number
/// for the run. An acceleration does not: what its smoother finds drifts from slip to slip, by as much as the force itself within
/// half a second, and c follows as the median over a period and a half to either side (the cycle, or the lowest mode's). What friction
/// really does from one period to the next is lost there. Nothing changes where a displacement was measured, where a mass has no spring
/// (a constant force then shows), and where nothing slips.
pub fn settle(
    smoothing: &mut Smoothing,
    run: &Run,
    structure: &Structure,
    friction: &dyn Fn(f64) -> f64,
) {
    if run.measurand == Measurand::Displacement || structure.is_free() {
        return;
    }
    let slip = slip_of_run(run, smoothing);
    let level = match run.measurand {
        Measurand::Acceleration => {
            let missing = slip.iter().map(|s| (s.time, missing(s, run, friction)));
            let known: Vec<(f64, f64)> = missing.filter(|(_, c)| c.is_finite()).collect();
            Level::moving(&known, PERIODS * period(smoothing, structure))
        }
        _ => missing_force(&slip, run, friction).map(Level::constant),
    };
    let Some(level) = level else {
        return;
    };
    let smoothed = &mut smoothing.stick_slip.smoothed;
    let h = smoothed.sample_interval;
    let raise = |values: &mut [f64], compliance: f64| {
        let all = values.iter_mut().enumerate();
        all.for_each(|(k, v)| *v += compliance * level.at(k as f64 * h));
    };
    raise(&mut smoothed.force, 1.0);
    raise(&mut smoothed.displacement, structure.static_compliance());
    for (q, mode) in smoothed.q.iter_mut().zip(structure.modes()) {
        raise(q, mode.modal_compliance());
    }
}

/// Time of a cycle in s, or of the lowest mode's period, whichever is longer.
fn period(smoothing: &Smoothing, structure: &Structure) -> f64 {
    let frequencies = structure.modes().iter().map(|m| m.frequency_hz);
    let lowest = frequencies.fold(f64::INFINITY, f64::min);
    lowest.recip().max(smoothing.cycle)
}

/// A force in N over time in s.
struct Level {
    times: Vec<f64>,
    forces: Vec<f64>,
}

impl Level {
    fn constant(force: f64) -> Self {
        Self {
            times: vec![0.0],
            forces: vec![force],
        }
    }

    /// The median of the forces within `half` s to either side, at every `half`; straight lines between. `None` without a force.
    fn moving(forces: &[(f64, f64)], half: f64) -> Option<Self> {
        let (first, last) = (forces.first()?.0, forces.last()?.0);
        let mut level = Self {
            times: Vec::new(),
            forces: Vec::new(),
        };
        for i in 0..=((last - first) / half) as usize {
            let middle = first + half * (i as f64 + 0.5);
            let from = forces.partition_point(|(t, _)| *t < middle - half);
            let past = forces.partition_point(|(t, _)| *t <= middle + half);
            let mut within: Vec<f64> = forces[from..past].iter().map(|(_, f)| *f).collect();
            if !within.is_empty() {
                level.times.push(middle);
                level.forces.push(median(&mut within));
            }
        }
        (!level.times.is_empty()).then_some(level)
    }

    fn at(&self, time: f64) -> f64 {
        interpolate(&self.times, &self.forces, time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moving_level_follows_what_drifts_and_passes_over_gaps() {
        let drift = |t: f64| 20.0 + 30.0 * t;
        // Slip in the first third of each cycle of 30 ms, none for a while; a transition now and then that the median does not see.
        let forces: Vec<(f64, f64)> = (0..6000)
            .map(|k| 1e-4 * f64::from(k))
            .filter(|t| t % 0.03 < 0.01 && !(0.2..0.35).contains(t))
            .map(|t| (t, drift(t) + if t % 0.03 < 5e-4 { 500.0 } else { 0.0 }))
            .collect();
        let level = Level::moving(&forces, 0.045).unwrap();
        for t in [0.05, 0.15, 0.3, 0.5] {
            assert!((level.at(t) - drift(t)).abs() < 1.0, "{t}: {}", level.at(t));
        }
        assert!(Level::moving(&[], 0.045).is_none());
        let one = Level::moving(&[(0.1, 7.0)], 0.045).unwrap();
        assert_eq!((one.at(-1.0), one.at(9.0)), (7.0, 7.0));
    }
}
