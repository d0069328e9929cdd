//! Long work that the page orders: a fit, score tests, a diagnosis, a rung that is kept, files.

mod diagnosing;
mod fitting;
mod scoring;

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::desk::Desk;
use super::export;
use super::ladder::{Origin, Rung};
use super::model::{Draft, Starts, hypothesis};
use super::preview::{Predicted, careful_to_its_end};
use crate::diagnose::estimation::fit::{Fit, FittedHypothesis};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::validation::forecast::forecasts;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::Campaign;

pub use scoring::Score;

/// Work asked for.
#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Job {
    /// Keeps a model as a rung.
    Keep {
        /// The model.
        draft: Draft,
        /// The rung that it starts from.
        base: u64,
        /// The rung's name.
        name: String,
    },
    /// Fits a model from where it stands.
    Fit {
        /// The model.
        draft: Draft,
        /// The rung that it starts from.
        base: u64,
        /// Names of the parameters that move; all where it is left out.
        free: Option<Vec<String>>,
    },
    /// Tests which effect would help most beside a model.
    Score {
        /// The model.
        draft: Draft,
        /// The rung that it starts from.
        base: u64,
    },
    /// Diagnoses the campaign.
    Diagnose {},
    /// Writes a rung's files.
    Export {
        /// The rung.
        rung: u64,
    },
}

impl Job {
    /// In words.
    pub fn name(&self) -> &'static str {
        match self {
            Job::Keep { .. } => "keeping a rung",
            Job::Fit { .. } => "a fit",
            Job::Score { .. } => "the score test",
            Job::Diagnose {} => "a diagnosis",
            Job::Export { .. } => "the export",
        }
    }
}

/// What work found.
#[derive(Debug, Clone, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Finding {
    /// A rung was added.
    Rung {
        /// Its number.
        id: u64,
        /// What must be said of it.
        note: String,
    },
    /// Effects, the most promising first.
    Scores {
        /// They.
        scores: Vec<Score>,
        /// What must be said of them.
        note: String,
    },
    /// A diagnosis was made.
    Diagnosis {
        /// Its summary.
        summary: String,
        /// The rung with what it found.
        rung: u64,
        /// Its files, within the output folder.
        files: Vec<String>,
        /// The command line that does the same.
        command: String,
    },
    /// Files were written.
    Files {
        /// They, within the output folder.
        files: Vec<String>,
        /// The command lines that do the same.
        commands: Vec<String>,
    },
}

/// What all work needs.
pub struct Bench<'a> {
    /// Questions, orders, board.
    pub desk: &'a Desk,
    /// The campaign, smoothed and cut.
    pub problem: &'a Problem<'a>,
    /// The campaign as it was read.
    pub campaign: &'a Campaign,
    /// The FMU without the library.
    pub fmu: &'a Fmu,
    /// The campaign's path as given.
    pub given: &'a Path,
}

/// Does what was asked for.
///
/// # Errors
/// Whatever the work fails with.
pub fn work(bench: &Bench, job: Job) -> Result<Finding, Error> {
    match job {
        Job::Keep { draft, base, name } => {
            let name = match name.trim() {
                "" => default_name(&draft),
                name => name.chars().take(LONGEST_NAME).collect(),
            };
            keep(bench, &draft, base, (Origin::Hand, name), None)
        }
        Job::Fit { draft, base, free } => fitting::fit(bench, &draft, base, free),
        Job::Score { draft, base } => scoring::score(bench, &draft, base),
        Job::Diagnose {} => diagnosing::diagnose(bench),
        Job::Export { rung } => export::export(bench, rung),
    }
}

/// Characters of the longest name of a rung.
const LONGEST_NAME: usize = 120;

/// A model in a few words: its effects.
pub fn default_name(draft: &Draft) -> String {
    if draft.effects.is_empty() {
        return "without effects".to_owned();
    }
    let ids: Vec<&str> = draft.effects.keys().map(String::as_str).collect();
    ids.join(" + ")
}

/// Where the segments of a rung start, with the hypothesis that they belong to.
pub fn starts_of(
    bench: &Bench,
    rung: u64,
) -> Result<Option<(crate::diagnose::model::hypothesis::Hypothesis, Starts)>, Error> {
    let (draft, starts) = bench.desk.read(|board| {
        let ladder = board.ladder.as_ref();
        let ladder = ladder.ok_or_else(|| super::desk::closed(None))?;
        let rung = ladder.rung(rung)?;
        Ok::<_, Error>((rung.draft.clone(), rung.starts.clone()))
    })?;
    let Some(starts) = starts else {
        return Ok(None);
    };
    Ok(Some((hypothesis(bench.problem, &draft)?, starts)))
}

/// A model with its starts found, from a rung.
pub fn settled(bench: &Bench, draft: &Draft, base: u64) -> Result<Predicted, Error> {
    let from = starts_of(bench, base)?;
    let from = from.as_ref().map(|(h, starts)| (h, starts));
    careful_to_its_end(bench.problem, draft, from)
}

/// The hypothesis and fit that a prediction stands for.
pub fn as_fitted(predicted: &Predicted) -> FittedHypothesis {
    FittedHypothesis {
        hypothesis: predicted.hypothesis.clone(),
        fit: Fit::unfitted(predicted.point.clone(), predicted.mean_square.clone()),
    }
}

/// Adds a rung, with the error of its forecasts. Starts are looked for from those of `reached`, else from those of the base.
pub fn keep(
    bench: &Bench,
    draft: &Draft,
    base: u64,
    (origin, name): (Origin, String),
    reached: Option<&Predicted>,
) -> Result<Finding, Error> {
    let problem = bench.problem;
    bench
        .desk
        .progress(|p| p.words = "forecasting the runs kept out".into());
    let predicted = match reached {
        Some(reached) => {
            let starts = reached.starts();
            careful_to_its_end(problem, draft, Some((&reached.hypothesis, &starts)))?
        }
        None => settled(bench, draft, base)?,
    };
    let forecast = forecast_error(problem, &as_fitted(&predicted))?;
    let starts = predicted.starts();
    bench.desk.change_ladder(|ladder| {
        let id = ladder.next_id();
        ladder.rungs.push(Rung {
            id,
            name,
            origin,
            before: Some(base),
            draft: draft.clone(),
            errors: predicted.errors.clone(),
            forecast,
            starts: Some(starts),
        });
        ladder.base = id;
        ladder.draft = draft.clone();
        let lost = predicted.errors.ran_away;
        let note = match lost {
            0 => String::new(),
            lost => format!("The motion runs away in {lost} segments."),
        };
        Ok(Finding::Rung { id, note })
    })
}

/// Root mean square of the errors of one-cycle forecasts of the runs kept out; `None` where none can be forecast.
pub fn forecast_error(problem: &Problem, fitted: &FittedHypothesis) -> Result<Option<f64>, Error> {
    let found = forecasts(problem, fitted)?;
    let squares: f64 = found.iter().map(|f| f.one_cycle_nrmse.powi(2)).sum();
    let mean = (squares / found.len() as f64).sqrt();
    Ok(mean.is_finite().then_some(mean))
}
