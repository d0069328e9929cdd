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

/// What a run at an operating point would tell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Promise {
    /// Least median error over the noise of a rival on a run that another made, its constants as they are.
    pub separation: f64,
    /// Least distance in score of a rival behind the one that made the run, all of them fitted to all runs.
    pub gain: f64,
}

/// What a run at a point would tell; `None` if a motion can't be simulated or judged there, or if a rival does as well on it as it
/// stands, its friction level, offset, phases and start states apart (below `tells` times the noise).
///
/// # Errors
/// An FMU that can't be run.
pub(super) fn promise(
    session: &Session,
    screen: &Screen,
    rivals: &[&Contender],
    point: (f64, f64),
    tells: f64,
) -> Result<Option<Promise>, Error> {
    let mut least = Promise {
        separation: f64::INFINITY,
        gain: f64::INFINITY,
    };
    for (t, truth) in rivals.iter().enumerate() {
        let Some(run) = simulated(session, truth, point)? else {
            return Ok(None);
        };
        let Some(own) = judged_alone(session, rivals, &run)? else {
            return Ok(None);
        };
        for (o, judged) in own.iter().enumerate() {
            if rivals[o].effects() != truth.effects() {
                least.separation = least.separation.min(judged.error);
            }
        }
        if !(least.separation >= tells) {
            return Ok(None);
        }
        let scores = together(session, screen, rivals, &run, &own)?;
        for (o, score) in scores.iter().enumerate() {
            if rivals[o].effects() != truth.effects() {
                least.gain = least.gain.min(score - scores[t]);
            }
        }
    }
    Ok(Some(least))
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
        scores.push(all.fitted_from(&rival.choices, start)?.score(all.samples));
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
        objective: f64::NAN,
        trimmed: f64::NAN,
        mean_square: Vec::new(),
        covariance: None,
    };
    Ok(Trial { hypothesis, fit })
}
