//! Runs that a fit lost while it came down to the noise on the others.
//!
//! The friction level of a run is its own; once it has wandered off, every shot of the run is lost, and lost shots have
//! no say. What the other runs found brings it back: their level, with the start states of the smoother.

use super::contender::Contender;
use super::predictor::Point;
use super::session::Session;
use super::shot::Shot;
use super::unexplained::median;

/// Median error of a run over the noise up to which it has arrived, ...
const ARRIVED: f64 = 1.5;
/// ... and beyond which it is lost.
const LOST: f64 = 3.0;

/// Where to fit a contender from so that the runs that it lost get another chance; `None` if it lost none, or more
/// than it found.
pub(super) fn without_loss(
    session: &Session,
    contender: &Contender,
    shots: &[Shot],
) -> Option<Point> {
    let errors = |run: usize| -> Option<f64> {
        let of_run = shots.iter().zip(&contender.trial.fit.mean_square);
        let mut ratios: Vec<f64> = of_run
            .filter(|(shot, _)| shot.run == run)
            .map(|(_, m)| m.sqrt() / session.noise[run])
            .collect();
        (!ratios.is_empty()).then(|| median(&mut ratios))
    };
    let of_runs: Vec<(usize, f64)> = (0..session.campaign.runs.len())
        .filter_map(|run| Some((run, errors(run)?)))
        .collect();
    let runs = |wanted: &dyn Fn(f64) -> bool| -> Vec<usize> {
        let some = of_runs.iter().filter(|(_, error)| wanted(*error));
        some.map(|(run, _)| *run).collect()
    };
    let (arrived, lost) = (runs(&|e| e <= ARRIVED), runs(&|e| e > LOST));
    if lost.is_empty() || arrived.len() < lost.len() {
        return None;
    }
    let h = &contender.trial.hypothesis;
    let centre = Point::centre(h, shots);
    let mut point = contender.trial.fit.point.clone();
    point.share_own(h, &arrived, &lost);
    for (k, _) in shots
        .iter()
        .enumerate()
        .filter(|(_, s)| lost.contains(&s.run))
    {
        point.put(k, centre.start(k));
    }
    Some(point)
}
