//! The force that one free characteristic over relative velocity expects in slip.
//!
//! The median of `|F|/F_N` in bins of `|v_r|`, with a level of its own for each run; no law is assumed.

use crate::diagnose::model::problem::Problem;
use crate::metric::median;
use crate::smoothing::{SlipSample, slip_of_run};

/// Bins of the characteristic.
const BINS: usize = 40;

/// Slip samples of each run with the force that the free characteristic expects.
pub fn slip_samples(problem: &Problem) -> Vec<Vec<SlipSample>> {
    let mut runs: Vec<Vec<SlipSample>> = (0..problem.campaign.runs.len())
        .map(|r| slip_of_run(&problem.campaign.runs[r], &problem.smoothings[r]))
        .collect();
    let force = |r: usize| problem.campaign.runs[r].normal_force;
    let fastest = runs
        .iter()
        .flatten()
        .map(|s| s.relative_velocity.abs())
        .fold(0.0, f64::max)
        .max(1e-9);
    // Bins grow with velocity, as the characteristic flattens out.
    let bin = |v: f64| (((v.abs() / fastest).sqrt() * BINS as f64) as usize).min(BINS - 1);
    let mut level = vec![1.0; runs.len()];
    for _ in 0..2 {
        let mut ratios: Vec<Vec<f64>> = vec![Vec::new(); BINS];
        for (r, samples) in runs.iter().enumerate() {
            for s in samples {
                ratios[bin(s.relative_velocity)].push(s.force.abs() / (force(r) * level[r]));
            }
        }
        let characteristic: Vec<f64> = ratios.iter_mut().map(|v| median(v)).collect();
        for (r, samples) in runs.iter_mut().enumerate() {
            let mut per_run: Vec<f64> = Vec::new();
            for s in samples.iter_mut() {
                let expected = characteristic[bin(s.relative_velocity)] * force(r);
                per_run.push(s.force.abs() / expected);
                s.expected = -expected * level[r] * s.relative_velocity.signum();
            }
            let middle = median(&mut per_run);
            if middle > 0.0 {
                level[r] = middle;
            }
        }
    }
    runs
}
