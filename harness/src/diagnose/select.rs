//! Which effect: every candidate is fitted, judged, and added one after another while it helps.

use super::hypothesis::Choice;
use super::judge::{self, Judgement};
use super::knob::Knob;
use super::search::{self, BRIEF, THOROUGH, Trial, baseline, search, variants};
use super::session::{Session, parallel};
use super::shot::Shot;
use crate::error::Error;
use std::sync::Mutex;

/// Every how many-th pair of shots is used while candidates are compared.
const SCREEN_EVERY: usize = 3;
/// Single effects with which pairs are formed when none alone is enough.
const PAIR_LEADERS: usize = 3;
/// A score above this many times that of a hypothesis at the noise floor rules another one out.
const CLEARLY_WORSE: f64 = 1.5;
/// A pair whose median error over the noise is below this after a brief search gets a thorough one.
const PROMISING: f64 = 4.0;
/// Effects added at most.
pub const MOST_EFFECTS: usize = 2;
/// A hypothesis explains the data if the median error is at most this many times the noise, ...
pub const FLOOR_MEDIAN: f64 = 1.12;
/// ... and so is the error of three shots in four.
pub const FLOOR_QUARTILE: f64 = 1.45;

/// Told what is being worked on.
pub trait Watch: Sync {
    /// A step of work begins: what, and its share of the whole.
    fn step(&self, what: &str, done: usize, of: usize);
    /// Whether to stop at the next opportunity.
    fn stop(&self) -> bool;
}

/// A hypothesis with its fit and judgements.
pub struct Contender {
    /// Effects that are on.
    pub choices: Vec<Choice>,
    /// Hypothesis and fit.
    pub trial: Trial,
    /// On the runs fitted.
    pub fit: Judgement,
    /// On what was kept out.
    pub holdout: Option<Judgement>,
}

impl Contender {
    fn new(session: &Session, choices: Vec<Choice>, trial: Trial, shots: &[usize]) -> Self {
        let fit = judge::of_fit(session, shots, &trial.fit);
        Self {
            choices,
            trial,
            fit,
            holdout: None,
        }
    }

    /// Number of parameters, those of the runs included.
    pub fn size(&self) -> usize {
        let free = |k: &&Knob| k.prior_std > 0.0;
        self.trial.hypothesis.shared.iter().filter(free).count()
            + self
                .trial
                .hypothesis
                .own
                .iter()
                .flatten()
                .filter(free)
                .count()
    }

    /// What contenders are ranked by: the trimmed objective with a price on parameters, lower is better.
    pub fn score(&self, samples: f64) -> f64 {
        self.fit.trimmed + 0.5 * self.size() as f64 * samples.ln()
    }

    /// Whether the errors are down to the noise.
    pub fn reaches_floor(&self) -> bool {
        self.fit.quantile(0.5) <= FLOOR_MEDIAN && self.fit.quantile(0.75) <= FLOOR_QUARTILE
    }
}

/// All that a selection found.
pub struct Selection {
    /// The reference model with nominal values, judged with start states fitted.
    pub as_given: Judgement,
    /// The same on what was kept out.
    pub as_given_holdout: Judgement,
    /// The calibrated reference model.
    pub calibrated: Contender,
    /// Single effects, best first.
    pub singles: Vec<Contender>,
    /// Pairs tried, best first.
    pub pairs: Vec<Contender>,
    /// The path from the calibrated model: one effect more each time.
    pub path: Vec<Contender>,
    /// Whether the last of the path (or the calibrated model) is down to the noise.
    pub explained: bool,
    /// Samples that the comparison rests on.
    pub samples: f64,
    /// Whether it was stopped before its end.
    pub stopped: bool,
}

/// Compares the catalogue on a campaign.
///
/// # Errors
/// An FMU that can't be run.
pub fn select(session: &Session, watch: &dyn Watch) -> Result<Selection, Error> {
    let indices = session.fit_shots(SCREEN_EVERY);
    let shots: Vec<Shot> = indices.iter().map(|&k| session.shots[k].clone()).collect();
    let samples = shots.iter().map(|s| s.count as f64).sum::<f64>() / search::STRIDE as f64;
    watch.step("calibrating the reference model", 0, 1);
    let (as_given, as_given_holdout) = as_given(session, &indices, &shots)?;
    let base = baseline(session, &shots)?;
    let base_trial = Contender::new(session, Vec::new(), base, &indices);
    let list: Vec<Choice> = (0..session.catalogue.len())
        .flat_map(|e| variants(session, e))
        .collect();
    let jobs: Vec<Vec<Choice>> = list.iter().map(|c| vec![c.clone()]).collect();
    let mut singles = compete(
        session,
        &jobs,
        &[&base_trial],
        &indices,
        &shots,
        samples,
        watch,
    )?;
    singles.sort_by(|a, b| a.score(samples).total_cmp(&b.score(samples)));
    // The reference model gets another try from each of the best candidates' nuisances.
    let calibrated = retry_baseline(session, base_trial, &singles, &indices, &shots)?;
    let enough =
        calibrated.reaches_floor() || singles.first().is_some_and(Contender::reaches_floor);
    let mut pairs = Vec::new();
    if !enough && !watch.stop() {
        let leaders: Vec<&Contender> = singles.iter().take(PAIR_LEADERS).collect();
        let mut jobs: Vec<Vec<Choice>> = Vec::new();
        let mut bases = Vec::new();
        for leader in &leaders {
            for choice in &list {
                let first = leader.choices[0].effect;
                let twice = jobs.iter().any(|j| {
                    j.len() == 2
                        && j[0].effect == choice.effect
                        && j[1].effect == first
                        && j[0] == *choice
                });
                if choice.effect != first && !twice {
                    jobs.push(vec![leader.choices[0].clone(), choice.clone()]);
                    bases.push(*leader);
                }
            }
        }
        pairs = compete(session, &jobs, &bases, &indices, &shots, samples, watch)?;
        pairs.sort_by(|a, b| a.score(samples).total_cmp(&b.score(samples)));
    }
    let stopped = watch.stop();
    let mut path = Vec::new();
    let mut explained = calibrated.reaches_floor();
    if let Some(best) = pairs.first().filter(|p| p.reaches_floor()) {
        let first = singles.iter().position(|s| s.choices[0] == best.choices[0]);
        if let Some(first) = first {
            path.push(singles.remove(first));
        }
        path.push(pairs.remove(0));
        explained = true;
    } else if singles
        .first()
        .is_some_and(|s| s.score(samples) < calibrated.score(samples))
    {
        let best = singles.remove(0);
        explained = best.reaches_floor();
        path.push(best);
    }
    Ok(Selection {
        as_given,
        as_given_holdout,
        calibrated,
        singles,
        pairs,
        path,
        explained,
        samples,
        stopped,
    })
}

/// Adds the effects with these indices one after another, whether they help or not.
///
/// # Errors
/// An FMU that can't be run.
pub fn follow(
    session: &Session,
    effects: &[usize],
    watch: &dyn Watch,
) -> Result<Selection, Error> {
    let indices = session.fit_shots(SCREEN_EVERY);
    let shots: Vec<Shot> = indices.iter().map(|&k| session.shots[k].clone()).collect();
    let samples = shots.iter().map(|s| s.count as f64).sum::<f64>() / search::STRIDE as f64;
    watch.step("calibrating the reference model", 0, 1 + effects.len());
    let (as_given, as_given_holdout) = as_given(session, &indices, &shots)?;
    let base = baseline(session, &shots)?;
    let calibrated = Contender::new(session, Vec::new(), base, &indices);
    let mut path: Vec<Contender> = Vec::new();
    for (done, &effect) in effects.iter().enumerate() {
        if watch.stop() {
            break;
        }
        watch.step(&session.catalogue[effect].id, 1 + done, 1 + effects.len());
        let base = path.last().unwrap_or(&calibrated);
        let mut forms = parallel(&variants(session, effect), |choice| {
            let mut choices = base.choices.clone();
            choices.push(choice.clone());
            let trial = search(session, &choices, &shots, &base.trial, THOROUGH)?;
            Ok(Contender::new(session, choices, trial, &indices))
        })?;
        forms.sort_by(|a, b| a.score(samples).total_cmp(&b.score(samples)));
        path.push(forms.swap_remove(0));
    }
    let explained = path.last().unwrap_or(&calibrated).reaches_floor();
    Ok(Selection {
        as_given,
        as_given_holdout,
        calibrated,
        singles: Vec::new(),
        pairs: Vec::new(),
        explained,
        samples,
        stopped: path.len() < effects.len(),
        path,
    })
}

/// The reference model with its nominal values.
fn as_given(
    session: &Session,
    indices: &[usize],
    shots: &[Shot],
) -> Result<(Judgement, Judgement), Error> {
    use super::fit::{Data, Effort, Fitter};
    use super::predictor::{Point, Predictor};
    let h = session.hypothesis(&[])?;
    let mut predictor =
        Predictor::new(session.fmu, &session.references, &session.campaign.runs, &h)?;
    let effort = Effort {
        knobs: false,
        ..search::effort(5)
    };
    let data = Data {
        shots,
        noise: &session.noise,
        weight: 1.0,
    };
    let fit = Fitter::new(&mut predictor, &h, &data, effort).run(Point::centre(&h, shots));
    let on_fit = judge::of_fit(session, indices, &fit);
    let (_, test) = judge::held_out_shots(session);
    let test_shots: Vec<Shot> = test.iter().map(|&k| session.shots[k].clone()).collect();
    let data = Data {
        shots: &test_shots,
        noise: &session.noise,
        weight: 1.0,
    };
    let fit = Fitter::new(&mut predictor, &h, &data, effort).run(Point::centre(&h, &test_shots));
    Ok((on_fit, judge::of_fit(session, &test, &fit)))
}

/// Fits many hypotheses in parallel, each from the base it extends.
fn compete(
    session: &Session,
    jobs: &[Vec<Choice>],
    bases: &[&Contender],
    indices: &[usize],
    shots: &[Shot],
    samples: f64,
    watch: &dyn Watch,
) -> Result<Vec<Contender>, Error> {
    // Score of the best hypothesis that is down to the noise.
    let floor: Mutex<Option<f64>> = Mutex::new(None);
    let done = Mutex::new(0usize);
    let numbered: Vec<(usize, &Vec<Choice>)> = jobs.iter().enumerate().collect();
    let results = parallel(&numbered, |(i, choices)| {
        if watch.stop() {
            return Ok(None);
        }
        let base = bases[if bases.len() == 1 { 0 } else { *i }];
        let at_floor = || *floor.lock().unwrap_or_else(|e| e.into_inner());
        let brief = choices.len() > 1 || at_floor().is_some();
        let trial = search(
            session,
            choices,
            shots,
            &base.trial,
            if brief { BRIEF } else { THOROUGH },
        )?;
        let mut contender = Contender::new(session, (*choices).clone(), trial, indices);
        // A brief search rules a hypothesis out only by far; near the best it is done again thoroughly.
        let near = at_floor().is_none_or(|best| contender.score(samples) < CLEARLY_WORSE * best);
        if brief && near && (choices.len() == 1 || contender.fit.quantile(0.5) < PROMISING) {
            let again = search(session, choices, shots, &base.trial, THOROUGH)?;
            let again = Contender::new(session, (*choices).clone(), again, indices);
            if again.score(samples) < contender.score(samples) {
                contender = again;
            }
        }
        if contender.reaches_floor() {
            let mut best = floor.lock().unwrap_or_else(|e| e.into_inner());
            let score = contender.score(samples);
            *best = Some(best.map_or(score, |b| b.min(score)));
        }
        let mut done = done.lock().unwrap_or_else(|e| e.into_inner());
        *done += 1;
        watch.step(&name(session, choices), *done, jobs.len());
        Ok(Some(contender))
    })?;
    Ok(results.into_iter().flatten().collect())
}

/// The name of a hypothesis.
pub fn name(session: &Session, choices: &[Choice]) -> String {
    choices
        .iter()
        .map(|c| session.catalogue[c.effect].id.as_str())
        .collect::<Vec<_>>()
        .join(" + ")
}

/// Restarts the reference model from the best candidates' optima with their effects switched off.
fn retry_baseline(
    session: &Session,
    base: Contender,
    singles: &[Contender],
    indices: &[usize],
    shots: &[Shot],
) -> Result<Contender, Error> {
    use super::fit::{Data, Fitter};
    use super::predictor::{Point, Predictor};
    let mut best = base;
    for single in singles.iter().take(2) {
        let h = session.hypothesis(&[])?;
        let mut predictor =
            Predictor::new(session.fmu, &session.references, &session.campaign.runs, &h)?;
        let data = Data {
            shots,
            noise: &session.noise,
            weight: 1.0,
        };
        let mut start = Point::centre(&h, shots);
        let from = &single.trial.fit.point;
        start.shared.copy_from_slice(&from.shared[..h.shared.len()]);
        for (own, theirs) in start.own.iter_mut().zip(&from.own) {
            let count = own.len();
            own.copy_from_slice(&theirs[..count]);
        }
        for (state, theirs) in start.states.iter_mut().zip(&from.states) {
            let count = state.len();
            state.copy_from_slice(&theirs[..count]);
        }
        start.stuck.clone_from(&from.stuck);
        let fit = Fitter::new(&mut predictor, &h, &data, search::effort(8)).run(start);
        if fit.trimmed < best.fit.trimmed {
            best = Contender::new(
                session,
                Vec::new(),
                Trial {
                    hypothesis: h,
                    fit,
                    simulations: 0,
                },
                indices,
            );
        }
    }
    Ok(best)
}
