//! A hypothesis with its fit, and how it fares beside others.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::{FittedHypothesis, MOST_OVER_EXPECTED};
use crate::diagnose::estimation::fit_options::STRIDE;
use crate::diagnose::estimation::likelihood::Likelihood;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::thresholds::{CLAIMED, FLOOR_MEDIAN, FLOOR_QUARTILE, MOST_SPECTRAL_RATIO};
use crate::diagnose::validation::prior_conflict::prior_conflict;
use crate::diagnose::validation::segment_errors::SegmentErrors;
use crate::diagnose::validation::{residual_whiteness, segment_errors};
use crate::error::Error;

/// Whether errors are down to the noise and as white; a spectral ratio that could not be told is passed over.
pub fn is_floor(fit: &SegmentErrors, spectral_ratio: f64) -> bool {
    is_small(fit) && !(spectral_ratio > MOST_SPECTRAL_RATIO)
}

/// Whether errors are down to the noise, white or not.
pub(crate) fn is_small(fit: &SegmentErrors) -> bool {
    fit.quantile(0.5) <= FLOOR_MEDIAN && fit.quantile(0.75) <= FLOOR_QUARTILE
}

/// Whether errors are down to the noise, and no more segments lost than by chance.
pub(crate) fn is_met(fit: &SegmentErrors) -> bool {
    is_small(fit) && fit.unmet_runs.is_empty()
}

/// Whether the first of two fits to all segments, each with the number of runs that it leaves unmet, is the better one: it leaves fewer, or as
/// many with more evidence.
pub(crate) fn fits_better(
    (unmet, mine): (usize, &FittedHypothesis),
    (unmet_by_other, other): (usize, &FittedHypothesis),
) -> bool {
    let is_more_probable = mine.fit.log_evidence > other.fit.log_evidence;
    unmet < unmet_by_other || unmet == unmet_by_other && is_more_probable
}

/// What segments whose error is more than [`FLOOR_QUARTILE`] times the noise cost beyond what noise would, nats.
fn lost(problem: &Problem, segments: &[Segment], fitted: &FittedHypothesis) -> f64 {
    let of_segment = |(segment, mean_square): (&Segment, &f64)| {
        let noise = problem.noise[segment.run];
        if *mean_square <= (FLOOR_QUARTILE * noise).powi(2) {
            return 0.0;
        }
        let count = segment.counted() as f64 / STRIDE as f64;
        let likelihood = Likelihood::new(count, noise, 2 * fitted.hypothesis.modes);
        likelihood.loss(count * mean_square) - likelihood.loss(count * noise * noise)
    };
    segments
        .iter()
        .zip(&fitted.fit.mean_square)
        .map(of_segment)
        .sum()
}

/// A hypothesis with its fit and errors.
#[derive(Clone)]
pub struct FittedModel {
    /// Effects that are on.
    pub choices: Vec<Choice>,
    /// Hypothesis and fit.
    pub fitted: FittedHypothesis,
    /// On the runs fitted.
    pub fit: SegmentErrors,
    /// On what was kept out.
    pub holdout: Option<SegmentErrors>,
    /// What segments that are not met cost beyond what noise would, nats.
    pub lost: f64,
    /// How far from white what it leaves is ([`crate::diagnose::validation::residual_whiteness`]).
    pub spectral_ratio: f64,
    /// Number of samples that it was fitted to.
    pub samples: f64,
    /// Fitted to all segments of the runs fitted, once that was needed ([`super::full_refit`]).
    pub full_refit: Option<FittedHypothesis>,
    /// How many runs that fit does not meet.
    pub unmet_runs: usize,
    /// Whether that fit showed it to be wrong, or that of a model which loses no more segments.
    pub is_refuted: bool,
    /// Whether the search passed it over after first looks at it ([`super::race`]): it stands where the best of these brought it.
    pub is_passed_over: bool,
    /// Logarithm of its posterior, up to what is the same for all, nats; NaN before it was worked out.
    pub log_posterior: f64,
}

impl FittedModel {
    /// A model whose fit is judged on the segments fitted.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn new(
        problem: &Problem,
        choices: Vec<Choice>,
        fitted: FittedHypothesis,
        indices: &[usize],
        segments: &[Segment],
    ) -> Result<Self, Error> {
        Ok(Self {
            fit: segment_errors::of_fit(problem, indices, &fitted.fit),
            lost: lost(problem, segments, &fitted),
            spectral_ratio: residual_whiteness::spectral_ratio(problem, segments, &fitted)?,
            choices,
            fitted,
            holdout: None,
            samples: segments.iter().map(|s| s.counted() as f64).sum::<f64>() / STRIDE as f64,
            full_refit: None,
            unmet_runs: 0,
            is_refuted: false,
            is_passed_over: false,
            log_posterior: f64::NAN,
        })
    }

    /// Indices of its effects, sorted.
    pub fn effects(&self) -> Vec<usize> {
        effects_of(&self.choices)
    }

    /// What a fit to its end may gain at most, nats: many times what its derivatives promise, and the segments that are not met.
    pub(crate) fn most_gain(&self) -> f64 {
        MOST_OVER_EXPECTED * self.fitted.fit.expected_fall + self.lost
    }

    /// Number of parameters, those of the runs included.
    pub fn size(&self) -> usize {
        let free = |k: &&Parameter| k.prior_std > 0.0;
        self.fitted.hypothesis.shared.iter().filter(free).count()
            + self
                .fitted
                .hypothesis
                .per_run
                .iter()
                .flatten()
                .filter(free)
                .count()
    }

    /// Whether it has values of its own for each place that a run passes.
    pub fn is_local(&self) -> bool {
        let per_run = &self.fitted.hypothesis.per_run;
        per_run.iter().flatten().any(|k| k.support.is_some())
    }

    /// Whether it leaves segments unmet that are worth a claim, once it was fitted to its end. The model that made the data meets all of
    /// them; what is missing in a few segments a score test on the others can't see.
    pub fn leaves_segments(&self) -> bool {
        self.lost > CLAIMED.ln()
    }

    /// Whether it is lost in a segment compared. The model that made the data is in hardly any.
    pub fn loses_segments(&self) -> bool {
        self.fit.lost() > 0
    }

    /// Whether it meets most of the segments compared and loses more of a run than by chance.
    pub(crate) fn leaves_runs(&self) -> bool {
        is_small(&self.fit) && !self.fit.unmet_runs.is_empty()
    }

    /// Whether it explains the data and leaves no segment.
    pub fn meets_all(&self) -> bool {
        self.reaches_floor() && !self.leaves_segments()
    }

    /// Whether it explains the data without values of its own along each run, which imitate much.
    pub fn is_answer(&self) -> bool {
        !self.is_local() && self.reaches_floor()
    }

    /// What models are ranked by, lower is better: the negative logarithm of the evidence, nats.
    pub fn score(&self) -> f64 {
        -self.fitted.fit.log_evidence
    }

    /// Where it stands in a search, lower is better: what is adequate first, by its evidence; what is not by its objective
    /// and a price on parameters (Schwarz 1978), since evidence says nothing about a model that is known to be wrong.
    fn rank(&self) -> (bool, f64) {
        if self.reaches_floor() {
            return (false, self.score());
        }
        // Of what meets most segments those that are lost tell the difference.
        let objective = match self.leaves_runs() {
            true => self.fitted.fit.misfit,
            false => self.fit.trimmed,
        };
        (
            true,
            objective + 0.5 * self.size() as f64 * self.samples.ln(),
        )
    }

    /// Whether it stands before another in a search.
    pub fn is_before(&self, other: &FittedModel) -> bool {
        self.compare(other).is_lt()
    }

    /// Whether it is the better of two fits of one hypothesis: on all segments where both were fitted to them.
    pub fn is_better_fit(&self, other: &FittedModel) -> bool {
        match (&self.full_refit, &other.full_refit) {
            (Some(mine), Some(theirs)) if self.reaches_floor() == other.reaches_floor() => {
                fits_better((self.unmet_runs, mine), (other.unmet_runs, theirs))
            }
            _ => self.is_before(other),
        }
    }

    /// The order of a search.
    pub fn compare(&self, other: &FittedModel) -> std::cmp::Ordering {
        let (mine, theirs) = (self.rank(), other.rank());
        mine.0.cmp(&theirs.0).then(mine.1.total_cmp(&theirs.1))
    }

    /// Whether the errors are down to the noise: whether what is left is white tells only a fit to all segments, run to its end.
    pub fn is_down_to_noise(&self) -> bool {
        !self.is_refuted && is_small(&self.fit)
    }

    /// Whether the errors are down to the noise and as white, without a structure bent to that end, as far as is known.
    pub fn reaches_floor(&self) -> bool {
        !self.is_refuted
            && is_floor(&self.fit, self.spectral_ratio)
            && prior_conflict(&self.fitted).is_none()
    }
}

/// Indices of the effects of a hypothesis, sorted.
pub(crate) fn effects_of<'c>(choices: impl IntoIterator<Item = &'c Choice>) -> Vec<usize> {
    let mut effects: Vec<usize> = choices.into_iter().map(|c| c.effect).collect();
    effects.sort_unstable();
    effects
}

/// The name of a hypothesis: its effects.
pub fn name(problem: &Problem, choices: &[Choice]) -> String {
    choices
        .iter()
        .map(|c| problem.catalogue[c.effect].id.as_str())
        .collect::<Vec<_>>()
        .join(" + ")
}
