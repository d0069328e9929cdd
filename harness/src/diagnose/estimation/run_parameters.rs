//! Run-specific parameters, fitted while all that the runs share is held.

use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::estimation::fit_options::{Care, FitOptions};
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::parameter::Scale;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::Simulator;

/// Fits what is a run's own; phases from several starts.
pub fn learn(
    simulator: &mut dyn Simulator,
    h: &Hypothesis,
    data: &Observations,
    start: Point,
    options: FitOptions,
    care: Care,
) -> Fit {
    let phases: Vec<(usize, usize)> = h
        .per_run
        .iter()
        .enumerate()
        .flat_map(|(run, parameters)| {
            parameters
                .iter()
                .enumerate()
                .filter(|(_, k)| k.is_phase())
                .map(move |(i, _)| (run, i))
        })
        .collect();
    if phases.is_empty() {
        return fit_states_then_all(&mut Fitter::new(simulator, h, data, options), start, care);
    }
    debug_assert!(
        phases
            .iter()
            .all(|&(run, i)| h.per_run[run][i].scale == Scale::Linear)
    );
    // The phase of each run is looked for on a circle of starts, all runs at once, run by run the best.
    let quick = FitOptions {
        iterations: 2,
        share: 0.5,
        reinitialise: false,
        ..options
    };
    let mut best: Vec<(f64, f64)> = vec![(f64::INFINITY, 0.0); h.per_run.len()];
    for step in 0..6 {
        let mut point = start.clone();
        for &(run, i) in &phases {
            point.per_run[run][i] = f64::from(step) * std::f64::consts::TAU / 6.0;
        }
        let fit = Fitter::new(simulator, h, data, quick).run(point);
        for &(run, i) in &phases {
            let mut errors: Vec<f64> = data
                .segments
                .iter()
                .zip(&fit.mean_square)
                .filter(|(s, _)| s.run == run)
                .map(|(_, m)| m.ln())
                .collect();
            errors.sort_by(f64::total_cmp);
            errors.truncate((errors.len() * 4).div_ceil(5));
            let score: f64 = errors.iter().sum();
            if score < best[run].0 && !errors.is_empty() {
                best[run] = (score, fit.point.per_run[run][i]);
            }
        }
    }
    let mut point = start;
    for &(run, i) in &phases {
        point.per_run[run][i] = best[run].1;
    }
    fit_states_then_all(&mut Fitter::new(simulator, h, data, options), point, care)
}

/// Start states first, then with them what is a run's own; twice, since a segment that was lost at first is
/// often found once the friction level is right.
fn fit_states_then_all(fitter: &mut Fitter, start: Point, care: Care) -> Fit {
    let settled = fitter.fit_initial_states(start);
    let first = fitter.run(settled.point);
    if care == Care::Brief {
        return first;
    }
    let settled = fitter.fit_initial_states(first.point);
    fitter.run(settled.point)
}
