//! How well a fitted hypothesis predicts: on the runs it was fitted to and on those kept out.
//!
//! On a run kept out the common knobs stay as fitted. What each run has of its own (friction level,
//! offset, phases, profile) is estimated on every second shot of the run and judged on the others; start
//! states are estimated on the shot itself. Where no run can be kept out, the same is done with every
//! second shot of the runs there are.

use super::fit::{Effort, Fit, Fitter};
use super::hypothesis::Hypothesis;
use super::own;
use super::predictor::Point;
use super::search::{self, STRIDE, Trial};
use super::session::Session;
use super::shot::Shot;
use crate::error::Error;

/// Errors of prediction.
#[derive(Debug, Clone)]
pub struct Judgement {
    /// Root mean square error over the standard deviation of the displacement.
    pub nrmse: f64,
    /// The same for each run (NaN for runs not judged).
    pub by_run: Vec<f64>,
    /// Mean square error of each shot over the noise's, sorted.
    pub ratio: Vec<f64>,
    /// Objective without the worst fifth of the shots.
    pub trimmed: f64,
    /// Indices of the shots judged.
    pub shots: Vec<usize>,
    /// Mean square error of each of them in m^2.
    pub mean_square: Vec<f64>,
    /// Where the knobs stood for them.
    pub point: Point,
    /// Of a judgement on what was kept out, the shots that taught and those judged, and where all stood in the end.
    pub whole: Option<(Vec<usize>, Point)>,
}

impl Judgement {
    /// Root of the `share`-quantile of the mean square errors, in units of the noise.
    pub fn quantile(&self, share: f64) -> f64 {
        match self.ratio.len() {
            0 => f64::NAN,
            n => self.ratio[((n - 1) as f64 * share).round() as usize].sqrt(),
        }
    }
}

/// Judges a fit by its residuals.
pub fn of_fit(session: &Session, shots: &[usize], fit: &Fit) -> Judgement {
    let count = session.campaign.runs.len();
    let mut squares = vec![Vec::new(); count];
    let mut ratio = Vec::new();
    for (&k, m) in shots.iter().zip(&fit.mean_square) {
        let run = session.shots[k].run;
        squares[run].push(*m);
        ratio.push(m / session.noise[run].powi(2));
    }
    ratio.sort_by(f64::total_cmp);
    let by_run: Vec<f64> = squares
        .iter_mut()
        .zip(&session.spread)
        .map(|(s, spread)| typical(s).sqrt() / spread)
        .collect();
    let judged: Vec<f64> = by_run.iter().copied().filter(|v| v.is_finite()).collect();
    let nrmse = (judged.iter().map(|v| v * v).sum::<f64>() / judged.len() as f64).sqrt();
    Judgement {
        nrmse,
        by_run,
        ratio,
        trimmed: fit.trimmed,
        shots: shots.to_vec(),
        mean_square: fit.mean_square.clone(),
        point: fit.point.clone(),
        whole: None,
    }
}

/// Share of the shots of a run that an error leaves out: those that graze a transition, where the
/// prediction turns on the last digit of the start state even with the true model.
pub const GRAZING: f64 = 0.1;

/// Mean of the squares without the largest tenth; NaN if there are none.
pub fn typical(squares: &mut [f64]) -> f64 {
    squares.sort_by(f64::total_cmp);
    let kept = &squares[..squares.len() - (squares.len() as f64 * GRAZING) as usize];
    kept.iter().sum::<f64>() / kept.len() as f64
}

/// Shots on which a held-out judgement estimates what is a run's own, and those it judges.
pub fn held_out_shots(session: &Session) -> (Vec<usize>, Vec<usize>) {
    let none = !session.held_out.iter().any(|h| *h);
    let pick = |parity: usize| -> Vec<usize> {
        (0..session.campaign.runs.len())
            .filter(|&run| none || session.held_out[run])
            .flat_map(|run| {
                let of_run: Vec<usize> = (0..session.shots.len())
                    .filter(|&k| session.shots[k].run == run)
                    .collect();
                of_run
                    .into_iter()
                    .enumerate()
                    .filter(move |(i, _)| i % 2 == parity)
                    .map(|(_, k)| k)
                    .collect::<Vec<_>>()
            })
            .collect()
    };
    (pick(0), pick(1))
}

/// With how much care a hypothesis is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Care {
    /// Every third of the shots kept out: enough to rank candidates.
    Brief,
    /// All of them.
    Thorough,
}

/// Every how many-th of the shots kept out is used in a brief judgement.
const BRIEF_EVERY: usize = 3;

/// Judges a hypothesis on what its fit has not seen.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn held_out(session: &Session, trial: &Trial, care: Care) -> Result<Judgement, Error> {
    held_out_from(session, trial, care, None)
}

/// The same, what is a run's own (but for phases, which are looked for all round) and the start states being looked for
/// from where a smaller hypothesis, judged before, found them.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn held_out_from(
    session: &Session,
    trial: &Trial,
    care: Care,
    smaller: Option<(&Hypothesis, &Judgement)>,
) -> Result<Judgement, Error> {
    let (mut learn, mut test) = held_out_shots(session);
    if care == Care::Brief {
        // The same places in both, so that each shot judged follows one that teaches.
        let some = |list: Vec<usize>| list.into_iter().step_by(BRIEF_EVERY).collect();
        (learn, test) = (some(learn), some(test));
    }
    let h = &trial.hypothesis;
    let mut predictor = session.predictor(h)?;
    // What varies with the place on the belt can be learned only where the run passes: there every shot
    // teaches, and what is judged are the samples in between those used (every second).
    let local = h.own.iter().flatten().any(|k| k.support.is_some());
    let mut both: Vec<usize> = learn.iter().chain(&test).copied().collect();
    both.sort_unstable();
    let learn = if local { both.clone() } else { learn };
    let learn_shots = session.copies(&learn);
    let mut start = from_fitted_runs(session, trial, &learn_shots);
    if let Some((known, judged)) = smaller {
        let out: Vec<usize> = (0..session.held_out.len())
            .filter(|&run| session.held_out[run])
            .collect();
        take_over(h, &learn, &mut start, known, judged, &out);
    }
    let effort = Effort {
        iterations: match (care, local) {
            (Care::Brief, false) => 3,
            (Care::Thorough, false) => 6,
            // Many values of its own, from nothing known.
            (_, true) => 15,
        },
        stride: STRIDE,
        share: 1.0,
        tolerance: 1e-3,
        patience: 1,
        knobs: true,
        shared: false,
        revive: true,
        belief: 1.0,
        robust: true,
        reference: true,
    };
    let data = session.data(&learn_shots);
    let learned = own::learn(&mut predictor, h, &data, start, effort, care);
    // Both halves together, so that a start can be taken from the end of the shot before.
    let shots = session.copies(&both);
    let mut start = Point::centre(h, &shots);
    start.shared = learned.point.shared;
    start.own = learned.point.own;
    if let Some((known, judged)) = smaller {
        take_over(h, &both, &mut start, known, judged, &[]);
    }
    let data = session.data(&shots);
    let judged = Effort {
        stride: if local { 1 } else { STRIDE },
        ..effort
    };
    let fit = Fitter::new(&mut predictor, h, &data, judged).settle(start);
    let judged = of_fit(session, &test, &only(&fit, &both, &test));
    Ok(Judgement {
        whole: Some((both, fit.point)),
        ..judged
    })
}

/// Where what runs kept out have of their own is looked for: the shared knobs as fitted, and their own near those of the runs fitted.
///
/// Friction levels of runs on one rig lie near each other, perhaps far from what was believed of them.
pub(super) fn from_fitted_runs(session: &Session, trial: &Trial, shots: &[Shot]) -> Point {
    let h = &trial.hypothesis;
    let mut start = Point::centre(h, shots);
    start.shared.clone_from(&trial.fit.point.shared);
    let (out, fitted): (Vec<usize>, Vec<usize>) =
        (0..session.held_out.len()).partition(|&run| session.held_out[run]);
    for &run in &fitted {
        start.own[run].clone_from(&trial.fit.point.own[run]);
    }
    start.share_own(h, &fitted, &out);
    start
}

/// Takes the start states of the shots `list`, and what the runs `runs` have of their own, from where a smaller
/// hypothesis stood when it was judged.
fn take_over(
    h: &Hypothesis,
    list: &[usize],
    start: &mut Point,
    known: &Hypothesis,
    judged: &Judgement,
    runs: &[usize],
) {
    let Some((shots, point)) = &judged.whole else {
        return;
    };
    for &run in runs {
        let (smaller, larger) = (&known.own[run], &h.own[run]);
        search::widen_own(smaller, &point.own[run], larger, &mut start.own[run]);
    }
    for (place, k) in list.iter().enumerate() {
        let Some(there) = shots.iter().position(|s| s == k) else {
            continue;
        };
        search::widen_state(known, &point.states[there], h, &mut start.states[place]);
        start.stuck[place] = point.stuck[there];
    }
}

/// The part of a fit that belongs to some of its shots.
fn only(fit: &Fit, all: &[usize], wanted: &[usize]) -> Fit {
    let places: Vec<usize> = wanted
        .iter()
        .filter_map(|k| all.iter().position(|a| a == k))
        .collect();
    let mut point = fit.point.clone();
    point.states = places
        .iter()
        .map(|&i| fit.point.states[i].clone())
        .collect();
    point.stuck = places.iter().map(|&i| fit.point.stuck[i]).collect();
    Fit {
        mean_square: places.iter().map(|&i| fit.mean_square[i]).collect(),
        point,
        ..fit.clone()
    }
}
