//! The argument of an unknown function along the measured runs: where the data lie, and what its memory makes of it.

use crate::diagnose::model::problem::Problem;
use crate::observer::PhaseMode;

/// What a function with a memory runs through: its value over what its argument is at that instant.
#[derive(Debug, Clone)]
pub struct Course {
    /// The quantity before the low-pass.
    pub instantaneous: Vec<f64>,
    /// The argument: low-passed, where it remembers.
    pub argument: Vec<f64>,
    /// Samples at which a cycle begins: each break-away.
    pub cycles: Vec<usize>,
}

/// The argument of a run at every sample of its smoothed motion; `None` for a name that is not known.
pub fn course(problem: &Problem, run: usize, name: &str, memory_s: Option<f64>) -> Option<Course> {
    let motion = &problem.smoothings[run].stick_slip;
    let smoothed = &motion.smoothed;
    let h = smoothed.sample_interval;
    let count = smoothed.displacement.len();
    let speed = |k: usize| motion.relative_velocity[k].abs();
    let instantaneous: Vec<f64> = match name {
        "w" => smoothed.displacement.clone(),
        "w_dot" => smoothed.velocity.clone(),
        "v_r" | "low_passed_v_r" => (0..count).map(speed).collect(),
        "time" => (0..count).map(|k| h * k as f64).collect(),
        "dwell" => dwell(problem, run),
        "normal_force" => load(problem, run, count),
        "low_passed_power" => (0..count)
            .map(|k| (smoothed.force[k] * motion.relative_velocity[k]).abs())
            .collect(),
        "low_passed_w" => smoothed.displacement.iter().map(|w| w.abs()).collect(),
        _ => return None,
    };
    let phases = motion.phases.windows(2);
    let leaves = |p: &&[crate::observer::Phase]| {
        p[0].mode == PhaseMode::Stick && p[1].mode != PhaseMode::Stick
    };
    Some(Course {
        argument: match memory_s {
            Some(tau) => low_passed(&instantaneous, h, tau),
            None => instantaneous.clone(),
        },
        instantaneous,
        cycles: phases.filter(leaves).map(|p| p[1].first).collect(),
    })
}

/// Normal force at each of `count` samples, N, as the campaign states it.
fn load(problem: &Problem, run: usize, count: usize) -> Vec<f64> {
    let run = &problem.campaign.runs[run];
    match &run.inputs.normal_force {
        Some(series) => series.values.iter().copied().take(count).collect(),
        None => vec![run.normal_force; count],
    }
}

/// Time since stick began at each sample, s; 0 in slip.
fn dwell(problem: &Problem, run: usize) -> Vec<f64> {
    let motion = &problem.smoothings[run].stick_slip;
    let h = motion.smoothed.sample_interval;
    let mut out = vec![0.0; motion.smoothed.displacement.len()];
    for phase in motion.phases.iter().filter(|p| p.mode == PhaseMode::Stick) {
        let past = phase.past.min(out.len());
        for (k, value) in out[..past].iter_mut().enumerate().skip(phase.first) {
            *value = (h * k as f64 - phase.start).max(0.0);
        }
    }
    out
}

/// `x' = (u - x)/tau` from the mean of u, the input held over each sample interval `h` in s.
pub fn low_passed(values: &[f64], h: f64, tau: f64) -> Vec<f64> {
    let keep = (-h / tau).exp();
    let mut x = values.iter().sum::<f64>() / values.len().max(1) as f64;
    let next = |u: &f64| {
        x = u + (x - u) * keep;
        x
    };
    values.iter().map(next).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_low_pass_comes_to_a_step_with_its_time_constant() {
        let step: Vec<f64> = (0..2000).map(|k| f64::from(u8::from(k >= 1000))).collect();
        let x = low_passed(&step, 1e-4, 0.01);
        let start = x[999];
        assert!(start < 0.01, "the mean at the start is forgotten: {start}");
        // After one time constant.
        assert!((x[1099] - (1.0 - (1.0 - start) * (-1.0f64).exp())).abs() < 1e-9);
    }
}
