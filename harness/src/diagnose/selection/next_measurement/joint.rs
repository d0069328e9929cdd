//! What rivals are worth once a simulated run has joined those measured, all their constants fitted anew.

use super::simulated::simulated;
use crate::diagnose::estimation::fit::{Fit, FittedHypothesis};
use crate::diagnose::estimation::fit_options::Care;
use crate::diagnose::estimation::nesting::widen_per_run;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::validation::segment_errors;
use crate::error::Error;
use crate::measurement::{Campaign, Run};
use crate::metric::median;

/// The runs that rivals would make at an operating point, and how all rivals fare on them as they stand.
pub(crate) struct Prospect {
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
        problem: &Problem,
        rivals: &[&FittedModel],
        point: (f64, f64),
    ) -> Result<Option<Self>, Error> {
        let mut separation = f64::INFINITY;
        let mut runs = Vec::new();
        for truth in rivals {
            let Some(run) = simulated(problem, truth, point)? else {
                return Ok(None);
            };
            let Some(judged) = judged_alone(problem, rivals, &run)? else {
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
        problem: &Problem,
        screen: &Screen,
        rivals: &[&FittedModel],
    ) -> Result<f64, Error> {
        let mut least = f64::INFINITY;
        for (t, (run, judged)) in self.runs.iter().enumerate() {
            let scores = together(problem, screen, rivals, run, judged)?;
            let others = rivals
                .iter()
                .zip(&scores)
                .filter(|(r, _)| is_other(r, rivals[t]));
            least = others.fold(least, |least, (_, score)| least.min(score - scores[t]));
        }
        Ok(least)
    }
}

fn is_other(rival: &FittedModel, truth: &FittedModel) -> bool {
    rival.effects() != truth.effects()
}

/// A rival on a simulated run alone.
struct Judged {
    /// Median error over the noise.
    error: f64,
    /// What is the run's own, ...
    parameters: Vec<Parameter>,
    /// ... and its positions.
    per_run: Vec<f64>,
}

/// Every rival as on a run kept out of its fit: only what is the run's own is estimated. `None` for a motion without cycles, or one
/// that the observer refuses.
fn judged_alone(
    problem: &Problem,
    rivals: &[&FittedModel],
    run: &Run,
) -> Result<Option<Vec<Judged>>, Error> {
    let campaign = Campaign {
        runs: vec![run.clone()],
        ..problem.campaign.clone()
    };
    let Ok(alone) = Problem::new(problem.fmu, &campaign) else {
        return Ok(None);
    };
    let mut all = Vec::new();
    for rival in rivals {
        let fitted = carried(problem, &alone, rival)?;
        let judged = segment_errors::held_out(&alone, &fitted, Care::Thorough)?;
        let error = judged.quantile(0.5);
        if !error.is_finite() {
            return Ok(None);
        }
        all.push(Judged {
            error,
            parameters: fitted.hypothesis.per_run[0].clone(),
            per_run: judged.point.per_run[0].clone(),
        });
    }
    Ok(Some(all))
}

/// Scores of the rivals on the segments measured and those of the simulated run, each fitted to all of them.
fn together(
    problem: &Problem,
    screen: &Screen,
    rivals: &[&FittedModel],
    run: &Run,
    per_run: &[Judged],
) -> Result<Vec<f64>, Error> {
    let mut campaign = problem.campaign.clone();
    campaign.runs.push(run.clone());
    let mut more = Problem::new(problem.fmu, &campaign)?;
    more.held_out = problem.held_out.iter().copied().chain([false]).collect();
    let all = Screen::new(&more);
    let mut scores = Vec::new();
    for (rival, judged) in rivals.iter().zip(per_run) {
        let h = more.hypothesis(&rival.choices)?;
        let start = joined(&h, screen, &all, rival, judged);
        scores.push(all.fitted_from(&rival.choices, start)?.score());
    }
    Ok(scores)
}

/// Where a rival stands on the measured runs and on the one that was judged alone.
fn joined(
    h: &Hypothesis,
    measured: &Screen,
    all: &Screen,
    rival: &FittedModel,
    judged: &Judged,
) -> Point {
    let found = &rival.fitted.fit.point;
    let mut start = Point::centre(h, &all.segments);
    start.shared.clone_from(&found.shared);
    let fitted = rival.fitted.hypothesis.per_run.iter().zip(&found.per_run);
    let judged = (&judged.parameters, &judged.per_run);
    // Whether break-aways tell the values along the belt may differ between the campaigns.
    for (run, (few, known)) in fitted.chain([judged]).enumerate() {
        widen_per_run((few, known), &h.per_run[run], &mut start.per_run[run]);
    }
    for (k, segment) in all.segments.iter().enumerate() {
        let same = |s: &crate::diagnose::data::segment::Segment| {
            (s.run, s.first) == (segment.run, segment.first)
        };
        if let Some(i) = measured.segments.iter().position(same) {
            start.put(k, found.start(i));
        }
    }
    start
}

/// A model as a hypothesis of a problem with the simulated run alone, its level and offset believed near those found.
fn carried(
    problem: &Problem,
    alone: &Problem,
    model: &FittedModel,
) -> Result<FittedHypothesis, Error> {
    let mut hypothesis = alone.hypothesis(&model.choices)?;
    let (old, found) = (&model.fitted.hypothesis, &model.fitted.fit.point);
    let fitted = || (0..problem.held_out.len()).filter(|&r| !problem.held_out[r]);
    for parameter in &mut hypothesis.per_run[0] {
        if parameter.support.is_some() || parameter.is_phase() || parameter.prior_std == 0.0 {
            continue;
        }
        let mut values: Vec<f64> = fitted()
            .filter_map(|r| {
                let i = old.per_run[r]
                    .iter()
                    .position(|k| k.name == parameter.name)?;
                Some(found.per_run[r][i])
            })
            .collect();
        if !values.is_empty() {
            parameter.prior = parameter.value(median(&mut values));
        }
    }
    let centre = Point::centre(&hypothesis, &[]);
    let fit = Fit::unfitted(
        Point {
            shared: found.shared.clone(),
            ..centre
        },
        Vec::new(),
    );
    Ok(FittedHypothesis { hypothesis, fit })
}
