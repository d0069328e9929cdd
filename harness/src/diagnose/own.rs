//! What each run has of its own, fitted while all that the runs share is held.

use super::fit::{Data, Effort, Fit, Fitter};
use super::hypothesis::Hypothesis;
use super::judge::Care;
use super::knob::Scale;
use super::predictor::{Point, Predictor};

/// Fits what is a run's own; phases from several starts.
pub fn learn<'a>(
    predictor: &mut Predictor<'a>,
    h: &'a Hypothesis,
    data: &Data,
    start: Point,
    effort: Effort,
    care: Care,
) -> Fit {
    let phases: Vec<(usize, usize)> = h
        .own
        .iter()
        .enumerate()
        .flat_map(|(run, knobs)| {
            knobs
                .iter()
                .enumerate()
                .filter(|(_, k)| k.is_phase())
                .map(move |(i, _)| (run, i))
        })
        .collect();
    if phases.is_empty() {
        return settle_and_run(&mut Fitter::new(predictor, h, data, effort), start, care);
    }
    debug_assert!(
        phases
            .iter()
            .all(|&(run, i)| h.own[run][i].scale == Scale::Linear)
    );
    // The phase of each run is looked for on a circle of starts, all runs at once, run by run the best.
    let quick = Effort {
        iterations: 2,
        share: 0.5,
        revive: false,
        ..effort
    };
    let mut best: Vec<(f64, f64)> = vec![(f64::INFINITY, 0.0); h.own.len()];
    for step in 0..6 {
        let mut point = start.clone();
        for &(run, i) in &phases {
            point.own[run][i] = f64::from(step) * std::f64::consts::TAU / 6.0;
        }
        let fit = Fitter::new(predictor, h, data, quick).run(point);
        for &(run, i) in &phases {
            let mut errors: Vec<f64> = data
                .shots
                .iter()
                .zip(&fit.mean_square)
                .filter(|(s, _)| s.run == run)
                .map(|(_, m)| m.ln())
                .collect();
            errors.sort_by(f64::total_cmp);
            errors.truncate((errors.len() * 4).div_ceil(5));
            let score: f64 = errors.iter().sum();
            if score < best[run].0 && !errors.is_empty() {
                best[run] = (score, fit.point.own[run][i]);
            }
        }
    }
    let mut point = start;
    for &(run, i) in &phases {
        point.own[run][i] = best[run].1;
    }
    settle_and_run(&mut Fitter::new(predictor, h, data, effort), point, care)
}

/// Start states first, then with them what is a run's own; twice, since a shot that was lost at first is
/// often found once the friction level is right.
fn settle_and_run(fitter: &mut Fitter, start: Point, care: Care) -> Fit {
    let settled = fitter.settle(start);
    let first = fitter.run(settled.point);
    if care == Care::Brief {
        return first;
    }
    let settled = fitter.settle(first.point);
    fitter.run(settled.point)
}
