//! What rivals are worth once a simulated run has joined those measured, all their constants fitted anew.

use super::simulated::simulated;
use crate::diagnose::contender::Contender;
use crate::diagnose::fit::Fit;
use crate::diagnose::hypothesis::Hypothesis;
use crate::diagnose::judge::{self, Care};
use crate::diagnose::predictor::Point;
use crate::diagnose::screen::Screen;
use crate::diagnose::search::Trial;
use crate::diagnose::session::Session;
use crate::diagnose::unexplained::median;
use crate::error::Error;
use crate::measurement::{Campaign, Run};

/// The runs that rivals would make at an operating point, and how all rivals fare on them as they stand.
pub(super) struct Prospect {
    /// Least median error over the noise of a rival on a run that another made, its constants as they are.
    pub separation: f64,
    /// For each rival the run that it makes, and each rival on that run alone.
    runs: Vec<(Run, Vec<Judged>)>,
}

impl Prospect {
    /// The runs at a belt velocity in m/s and a normal force in N; `None` if a motion can't be simulated or judged there.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn new(
        session: &Session,
        rivals: &[&Contender],
        point: (f64, f64),
    ) -> Result<Option<Self>, Error> {
        let mut separation = f64::INFINITY;
        let mut runs = Vec::new();
        for truth in rivals {
            let Some(run) = simulated(session, truth, point)? else {
                return Ok(None);
            };
            let Some(judged) = judged_alone(session, rivals, &run)? else {
                return Ok(None);
            };
            let others = rivals
                .iter()
                .zip(&judged)
                .filter(|(r, _)| is_other(r, truth));
            separation = others.fold(separation, |least, (_, j)| least.min(j.error));
            runs.push((run, judged));
        }
        Ok(Some(Self { separation, runs }))
    }

    /// Least distance in score of a rival behind the one that made the run, all of them fitted to all runs.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn gain(
        &self,
        session: &Session,
        screen: &Screen,
        rivals: &[&Contender],
    ) -> Result<f64, Error> {
        let mut least = f64::INFINITY;
        for (t, (run, judged)) in self.runs.iter().enumerate() {
            let scores = together(session, screen, rivals, run, judged)?;
            let others = rivals
                .iter()
                .zip(&scores)
                .filter(|(r, _)| is_other(r, rivals[t]));
            least = others.fold(least, |least, (_, score)| least.min(score - scores[t]));
        }
        Ok(least)
    }
}

fn is_other(rival: &Contender, truth: &Contender) -> bool {
    rival.effects() != truth.effects()
}

/// A rival on a simulated run alone.
struct Judged {
    /// Median error over the noise.
    error: f64,
    /// Positions of what is the run's own.
    own: Vec<f64>,
}

/// Every rival as on a run kept out of its fit: only what is the run's own is estimated. `None` for a motion without cycles, or one
/// that the observer refuses.
fn judged_alone(
    session: &Session,
    rivals: &[&Contender],
    run: &Run,
) -> Result<Option<Vec<Judged>>, Error> {
    let campaign = Campaign {
        runs: vec![run.clone()],
        ..session.campaign.clone()
    };
    let Ok(alone) = Session::new(session.fmu, &campaign) else {
        return Ok(None);
    };
    let mut all = Vec::new();
    for rival in rivals {
        let trial = carried(session, &alone, rival)?;
        let judged = judge::held_out(&alone, &trial, Care::Thorough)?;
        let error = judged.quantile(0.5);
        if !error.is_finite() {
            return Ok(None);
        }
        all.push(Judged {
            error,
            own: judged.point.own[0].clone(),
        });
    }
    Ok(Some(all))
}

/// Scores of the rivals on the shots measured and those of the simulated run, each fitted to all of them.
fn together(
    session: &Session,
    screen: &Screen,
    rivals: &[&Contender],
    run: &Run,
    own: &[Judged],
) -> Result<Vec<f64>, Error> {
    let mut campaign = session.campaign.clone();
    campaign.runs.push(run.clone());
    let mut more = Session::new(session.fmu, &campaign)?;
    more.held_out = session.held_out.iter().copied().chain([false]).collect();
    let all = Screen::new(&more);
    let mut scores = Vec::new();
    for (rival, judged) in rivals.iter().zip(own) {
        let h = more.hypothesis(&rival.choices)?;
        let start = joined(&h, screen, &all, rival, &judged.own);
        scores.push(all.fitted_from(&rival.choices, start)?.score());
    }
    Ok(scores)
}

/// Where a rival stands on the measured runs and on the one that was judged alone.
fn joined(
    h: &Hypothesis,
    measured: &Screen,
    all: &Screen,
    rival: &Contender,
    own: &[f64],
) -> Point {
    let found = &rival.trial.fit.point;
    let mut start = Point::centre(h, &all.shots);
    start.shared.clone_from(&found.shared);
    let last = start.own.len() - 1;
    start.own[..last].clone_from_slice(&found.own);
    start.own[last].copy_from_slice(own);
    for (k, shot) in all.shots.iter().enumerate() {
        let same = |s: &crate::diagnose::shot::Shot| (s.run, s.first) == (shot.run, shot.first);
        if let Some(i) = measured.shots.iter().position(same) {
            start.put(k, found.start(i));
        }
    }
    start
}

/// A contender as a hypothesis of a session with the simulated run alone, its level and offset believed near those found.
fn carried(session: &Session, alone: &Session, contender: &Contender) -> Result<Trial, Error> {
    let mut hypothesis = alone.hypothesis(&contender.choices)?;
    let (old, found) = (&contender.trial.hypothesis, &contender.trial.fit.point);
    let fitted = || (0..session.held_out.len()).filter(|&r| !session.held_out[r]);
    for knob in &mut hypothesis.own[0] {
        if knob.support.is_some() || knob.is_phase() || knob.prior_std == 0.0 {
            continue;
        }
        let mut values: Vec<f64> = fitted()
            .filter_map(|r| {
                let i = old.own[r].iter().position(|k| k.name == knob.name)?;
                Some(found.own[r][i])
            })
            .collect();
        if !values.is_empty() {
            knob.prior = knob.value(median(&mut values));
        }
    }
    let centre = Point::centre(&hypothesis, &[]);
    let fit = Fit {
        point: Point {
            shared: found.shared.clone(),
            ..centre
        },
        trimmed: f64::NAN,
        misfit: f64::NAN,
        log_evidence: f64::NEG_INFINITY,
        mean_square: Vec::new(),
        covariance: None,
    };
    Ok(Trial { hypothesis, fit })
}
