//! Runs that a fit lost while it came down to the noise on the others.
//!
//! The friction level of a run is its own; once it has wandered off, every shot of the run is lost, and lost shots have
//! no say. What the other runs found brings it back: their level, with the start states of the smoother, and then what is its
//! own, phases all round, while all that the runs share is held, as for a run that was kept out.

use super::contender::Contender;
use super::fit::Effort;
use super::judge::Care;
use super::own;
use super::predictor::Point;
use super::search::effort;
use super::session::Session;
use super::shot::Shot;
use super::unexplained::median;
use crate::error::Error;

/// Median error of a run over the noise up to which it has arrived, ...
const ARRIVED: f64 = 1.5;
/// ... and beyond which it is lost.
const LOST: f64 = 3.0;
/// Jacobians for what is their own.
const STEPS: usize = 3;

/// Where to fit a contender from so that the runs that it lost get another chance; `None` if it lost none, or more
/// than it found.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(super) fn without_loss(
    session: &Session,
    contender: &Contender,
    shots: &[Shot],
) -> Result<Option<Point>, Error> {
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
        return Ok(None);
    }
    let h = &contender.trial.hypothesis;
    let mut point = contender.trial.fit.point.clone();
    point.share_own(h, &arrived, &lost);
    let of_lost: Vec<usize> = (0..shots.len())
        .filter(|&k| lost.contains(&shots[k].run))
        .collect();
    let their_shots: Vec<Shot> = of_lost.iter().map(|&k| shots[k].clone()).collect();
    let mut theirs = Point::centre(h, &their_shots);
    theirs.shared.clone_from(&point.shared);
    theirs.own.clone_from(&point.own);
    let mut predictor = session.predictor(h)?;
    let effort = Effort {
        shared: false,
        ..effort(STEPS)
    };
    let data = session.data(&their_shots);
    let found = own::learn(&mut predictor, h, &data, theirs, effort, Care::Brief).point;
    for &run in &lost {
        point.own[run].clone_from(&found.own[run]);
    }
    for (i, &k) in of_lost.iter().enumerate() {
        point.put(k, found.start(i));
    }
    Ok(Some(point))
}
