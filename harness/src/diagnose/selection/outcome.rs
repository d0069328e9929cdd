//! What a selection found.

use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::Care;
use crate::diagnose::model::library::is_library_effect;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::decision::log_prior;
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::tested::Tested;
use crate::diagnose::validation::forecast::Forecast;
use crate::diagnose::validation::segment_errors;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::error::Error;
use crate::parallel::parallel;

/// Single effects that are judged on the runs kept out, the best ones.
const SINGLES_JUDGED: usize = 8;
/// Pairs that are listed, the best ones.
const PAIRS_LISTED: usize = 5;

/// Why a term beyond the catalogue stands at the end of a path.
pub struct Beyond {
    /// What explains the data too, but not as well; `None` where nothing else does.
    pub rival: Option<String>,
    /// How far its posterior is above that rival's, or the calibrated model's, nats.
    pub gain: f64,
}

/// A first answer that does not hold on the runs kept out of its fit.
pub struct Contradiction {
    /// The answer, in words.
    pub answer: String,
    /// The runs.
    pub runs: Vec<String>,
    /// Its error there, in words: that of a quarter of the segments, or of those that are lost of the run that is met worst.
    pub error: String,
}

/// All that a selection found.
pub struct Selection {
    /// The reference model with nominal values, judged with start states fitted.
    pub as_given: SegmentErrors,
    /// The same on what was kept out.
    pub as_given_holdout: SegmentErrors,
    /// Its forecasts of the runs kept out.
    pub as_given_forecasts: Vec<Forecast>,
    /// The reference model calibrated by itself: it depends on the campaign alone, not on what is tried.
    pub alone: FittedModel,
    /// The same, or where that is better, fitted again from the optimum of an effect: what effects are compared with, so that
    /// none seems to gain what the reference model could by itself.
    pub calibrated: FittedModel,
    /// Single effects, best first.
    pub singles: Vec<FittedModel>,
    /// Pairs tried, best first.
    pub pairs: Vec<FittedModel>,
    /// Names of the pairs that were compared to first order and not fitted; empty where something explains the data.
    pub untried: Vec<String>,
    /// Effects beside an adequate hypothesis that were tested and not fitted.
    pub tested: Vec<Tested>,
    /// The path from the calibrated model: one effect more each time.
    pub path: Vec<FittedModel>,
    /// Whether the last of the path (or the calibrated model) is down to the noise.
    pub explained: bool,
    /// Whether the path is believed for what the break-aways tell, though it does not come down to the noise.
    pub by_break_aways: bool,
    /// The term beyond the catalogue at the end of the path, if it needs one.
    pub beyond: Option<Beyond>,
    /// Whether the path ends with what explains most while something else is missing too
    /// ([`super::discrepancy`]).
    pub is_incomplete: bool,
    /// What was found first and did not hold on the runs kept out then, which are fitted now.
    pub contradicted: Option<Contradiction>,
    /// Whether it was stopped before its end.
    pub stopped: bool,
    /// Whether the effects were named by hand, so that no other was tried.
    pub by_hand: bool,
    /// Gain below which an effect counts as chance.
    pub threshold: f64,
    /// For each step of the path, the largest gains by chance in simulated campaigns; empty unless asked for.
    pub by_chance: Vec<Vec<f64>>,
}

impl Selection {
    /// The calibrated model of the error ladder: the one calibrated by itself, so that every command shows the same. Only where
    /// the better one explains the data it takes the place, since the verdict rests on it then.
    pub fn calibration(&self) -> &FittedModel {
        if self.calibrated.reaches_floor() {
            &self.calibrated
        } else {
            &self.alone
        }
    }

    /// Adds a last step, a term beyond the catalogue that was fitted after the search.
    pub(crate) fn go_on_with(&mut self, problem: &Problem, mut model: FittedModel) {
        if let Some(before) = self.path.last() {
            model.log_posterior = before.log_posterior + before.score() - model.score();
        }
        self.explained = model.reaches_floor();
        self.path.push(model);
        let (calibrated, singles) = (&self.calibrated, &self.singles);
        let beyond = beyond(problem, self.explained, &self.path, calibrated, singles);
        self.beyond = self.beyond.take().or(beyond);
    }

    /// Judges the best candidates on the runs kept out, briefly.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn judge_candidates(&mut self, problem: &Problem) -> Result<(), Error> {
        judge_candidates(
            problem,
            &self.calibrated,
            &mut self.singles,
            &mut self.pairs,
        )
    }

    /// Takes a path whose last hypothesis explains the data.
    pub(crate) fn explained_by(&mut self, problem: &Problem, path: Vec<FittedModel>) {
        self.beyond = beyond(problem, true, &path, &self.calibrated, &self.singles);
        self.path = path;
        self.explained = true;
        self.is_incomplete = false;
        self.untried.clear();
        // Gains by chance were those beside another path.
        self.by_chance.clear();
        self.threshold = -log_prior(problem, 1);
    }

    /// Takes the gains by chance into account, for each step of the path those of all simulated campaigns.
    pub fn judge_by_chance(&mut self, gains: Vec<Vec<f64>>) {
        let all = gains.iter().flatten().copied();
        self.threshold = all.fold(self.threshold, f64::max);
        self.by_chance = gains;
    }

    /// The effects that were named by hand, in words; `None` where the catalogue was searched.
    pub fn tried_by_hand(&self, problem: &Problem) -> Option<String> {
        if !self.by_hand {
            return None;
        }
        let tried = self.path.last().map(|c| name(problem, &c.choices));
        Some(tried.unwrap_or_else(|| "nothing".to_owned()))
    }

    /// Pairs that stand beside the single effects: the best ones, none where one effect is enough.
    pub fn listed_pairs(&self) -> &[FittedModel] {
        let one_is_enough = self.explained && self.path.len() < 2;
        let count = if one_is_enough { 0 } else { PAIRS_LISTED };
        &self.pairs[..self.pairs.len().min(count)]
    }
}

/// What is beyond the catalogue in a hypothesis that explains the data: a term at the end of its path.
pub(super) fn beyond(
    problem: &Problem,
    explained: bool,
    path: &[FittedModel],
    calibrated: &FittedModel,
    singles: &[FittedModel],
) -> Option<Beyond> {
    let best = path.last().filter(|_| explained)?;
    let has_library_effect = |c: &FittedModel| {
        let mut effects = c.choices.iter().map(|choice| choice.effect);
        effects.any(|e| is_library_effect(&problem.catalogue[e].id))
    };
    if !has_library_effect(best) {
        return None;
    }
    let rival = std::iter::once(calibrated)
        .chain(singles)
        .filter(|c| c.reaches_floor() && !c.leaves_runs() && !has_library_effect(c))
        .max_by(|a, b| a.log_posterior.total_cmp(&b.log_posterior));
    Some(Beyond {
        rival: rival.map(|r| match r.choices.is_empty() {
            true => "the calibrated model".to_owned(),
            false => name(problem, &r.choices),
        }),
        gain: best.log_posterior - rival.unwrap_or(calibrated).log_posterior,
    })
}

/// Judges the best candidates on the runs kept out, briefly; not those that fit worse than the reference model.
///
/// # Errors
/// An FMU that can't be run.
pub(super) fn judge_candidates(
    problem: &Problem,
    calibrated: &FittedModel,
    singles: &mut [FittedModel],
    pairs: &mut [FittedModel],
) -> Result<(), Error> {
    let listed = pairs.len().min(PAIRS_LISTED);
    let mut all: Vec<&mut FittedModel> = singles
        .iter_mut()
        .take(SINGLES_JUDGED)
        .chain(&mut pairs[..listed])
        .filter(|c| !calibrated.is_before(c))
        .collect();
    let all_fitted: Vec<&FittedHypothesis> = all.iter().map(|c| &c.fitted).collect();
    let judgements = parallel(&all_fitted, |fitted| {
        segment_errors::held_out(problem, fitted, Care::Brief)
    })?;
    for (model, judgement) in all.iter_mut().zip(judgements) {
        model.holdout = Some(judgement);
    }
    Ok(())
}
