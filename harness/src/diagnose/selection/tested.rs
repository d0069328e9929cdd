//! Effects that were tested beside a hypothesis and not fitted to their end.

use crate::diagnose::model::hypothesis::Choice;

/// An effect beside a hypothesis, by the score test.
#[derive(Debug, Clone)]
pub struct Tested {
    /// The effects of the hypothesis, and the one more.
    pub choices: Vec<Choice>,
    /// Gain in evidence by it, nats: the expected one, or where a fit fell short of what could change the verdict.
    pub gain: f64,
    /// Expected fall of the negative logarithm of the likelihood by it, nats.
    pub fall: f64,
    /// That gain less the price of an effect more: logarithm of its odds against the hypothesis.
    pub log_odds: f64,
    /// Strength at which it would be named with even odds, in the unit of its strength; `None` where no derivative tells.
    pub detection_limit: Option<f64>,
}

impl Tested {
    /// The effects of the hypothesis that it was tested beside.
    pub fn beside(&self) -> &[Choice] {
        &self.choices[..self.choices.len() - 1]
    }
}
