//! A hypothesis with its fit, and how it fares beside others.

use super::hypothesis::Choice;
use super::judge::{self, Judgement};
use super::knob::Knob;
use super::scan::{self, Argument};
use super::search::{self, Trial};
use super::session::Session;
use super::shot::Shot;
use super::strain::strain;
use super::whiteness;
use crate::error::Error;

/// A hypothesis explains the data if the median error is at most this many times the noise, ...
pub const FLOOR_MEDIAN: f64 = 1.12;
/// ... and so is the error of three shots in four.
pub const FLOOR_QUARTILE: f64 = 1.45;

/// ...; and what is left is white, the power of its low frequencies at most this many times that of its high ones. True
/// models leave 0.85 to 1.0, a cubic stiffness fitted to a quadratic one down to 1.03 times the noise 1.44.
pub const FLOOR_COLOUR: f64 = 1.2;

/// Whether errors are down to the noise and as white; a colour that could not be told is passed over.
pub fn is_floor(fit: &Judgement, colour: f64) -> bool {
    fit.quantile(0.5) <= FLOOR_MEDIAN
        && fit.quantile(0.75) <= FLOOR_QUARTILE
        && !(colour > FLOOR_COLOUR)
}

/// A hypothesis with its fit and judgements.
#[derive(Clone)]
pub struct Contender {
    /// Effects that are on.
    pub choices: Vec<Choice>,
    /// Hypothesis and fit.
    pub trial: Trial,
    /// On the runs fitted.
    pub fit: Judgement,
    /// On what was kept out.
    pub holdout: Option<Judgement>,
    /// How far from white what it leaves is ([`super::whiteness`]).
    pub colour: f64,
    /// Number of samples that it was fitted to.
    pub samples: f64,
    /// Fitted to all shots of the runs fitted, once that was needed ([`super::whole`]).
    pub whole: Option<Trial>,
    /// Whether that fit showed it to be wrong.
    pub is_refuted: bool,
    /// Logarithm of its posterior, up to what is the same for all, nats; NaN before it was worked out.
    pub log_posterior: f64,
}

impl Contender {
    /// A contender whose fit is judged on the shots fitted.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn new(
        session: &Session,
        choices: Vec<Choice>,
        trial: Trial,
        indices: &[usize],
        shots: &[Shot],
    ) -> Result<Self, Error> {
        Ok(Self {
            fit: judge::of_fit(session, indices, &trial.fit),
            colour: whiteness::colour(session, shots, &trial)?,
            choices,
            trial,
            holdout: None,
            samples: shots.iter().map(|s| s.count as f64).sum::<f64>() / search::STRIDE as f64,
            whole: None,
            is_refuted: false,
            log_posterior: f64::NAN,
        })
    }

    /// Indices of its effects, sorted.
    pub fn effects(&self) -> Vec<usize> {
        let mut list: Vec<usize> = self.choices.iter().map(|c| c.effect).collect();
        list.sort_unstable();
        list
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

    /// Whether it has values of its own for each place that a run passes.
    pub fn is_local(&self) -> bool {
        let own = &self.trial.hypothesis.own;
        own.iter().flatten().any(|k| k.support.is_some())
    }

    /// What its last effect repeats with, and the frequency in Hz or wavelength in m found; `None` if it does not repeat.
    pub fn line(&self, session: &Session) -> Option<(Argument, f64)> {
        let effect = &session.catalogue[self.choices.last()?.effect];
        let (_, shape) = scan::periodic(effect)?;
        let name = format!("{}.{}", effect.id, effect.parameters[shape].name);
        let h = &self.trial.hypothesis;
        let i = h.shared_index(&name)?;
        let value = h.shared[i].value(self.trial.fit.point.shared[i]);
        Some((scan::argument(effect)?, value))
    }

    /// What contenders are ranked by, lower is better: the negative logarithm of the evidence, nats.
    pub fn score(&self) -> f64 {
        -self.trial.fit.log_evidence
    }

    /// Where it stands in a search, lower is better: what is adequate first, by its evidence; what is not by its objective
    /// and a price on parameters (Schwarz 1978), since evidence says nothing about a model that is known to be wrong.
    fn rank(&self) -> (bool, f64) {
        if self.reaches_floor() {
            return (false, self.score());
        }
        (
            true,
            self.fit.trimmed + 0.5 * self.size() as f64 * self.samples.ln(),
        )
    }

    /// Whether it stands before another in a search.
    pub fn is_before(&self, other: &Contender) -> bool {
        self.compare(other).is_lt()
    }

    /// The order of a search.
    pub fn compare(&self, other: &Contender) -> std::cmp::Ordering {
        let (mine, theirs) = (self.rank(), other.rank());
        mine.0.cmp(&theirs.0).then(mine.1.total_cmp(&theirs.1))
    }

    /// Whether the errors are down to the noise and as white, without a structure bent to that end, as far as is known.
    pub fn reaches_floor(&self) -> bool {
        !self.is_refuted && is_floor(&self.fit, self.colour) && strain(&self.trial).is_none()
    }
}

/// The name of a hypothesis: its effects.
pub fn name(session: &Session, choices: &[Choice]) -> String {
    choices
        .iter()
        .map(|c| session.catalogue[c.effect].id.as_str())
        .collect::<Vec<_>>()
        .join(" + ")
}
