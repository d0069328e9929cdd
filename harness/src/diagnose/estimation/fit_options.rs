//! How a fit is done.

use serde::Serialize;

/// Every how many-th sample is used while searching.
pub const STRIDE: usize = 2;

/// Fall of the objective in nats that no verdict depends on: a thousandth of a tie.
const LEAST_FALL: f64 = 0.003;

/// How a fit is done.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct FitOptions {
    /// Largest number of Jacobians.
    pub iterations: usize,
    /// Every how many-th sample is used.
    pub stride: usize,
    /// Share of each segment that is used, from its start.
    pub share: f64,
    /// A fit ends once Q falls by less than this share in an iteration, ...
    pub tolerance: f64,
    /// ... or by less than this in nats: what is left then is a small part of what hypotheses differ by.
    pub least_fall: f64,
    /// Iterations in a row that gain less than that after which a fit ends.
    pub patience: usize,
    /// Whether shared and own parameters move, or only the start states.
    pub parameters: bool,
    /// Whether the shared parameters move.
    pub shared: bool,
    /// Whether segments that start in the wrong basin get other starts.
    pub reinitialise: bool,
    /// Whether other starts are drawn for them too, where most segments are met ([`super::drawn_starts`], [`super::carried_starts`]): for
    /// what is fitted to its end, and for runs kept out.
    pub draws: bool,
    /// How many times more than the residuals' count suggests the reference model's own parameters are held to what is
    /// believed of them: more than 1 while a model may still be far off, whose residuals are no noise.
    pub belief: f64,
    /// Whether segments that fit badly count by the logarithm of their squares, as in a search, where a model may still be far off; else the
    /// objective is that of the evidence.
    pub robust: bool,
    /// Whether, in a search, those that fit worst have none.
    pub trims: bool,
    /// Whether the parameters of the reference model that all runs share move at all.
    pub reference: bool,
    /// Whether the noise that is allowed for falls in the course of the fit ([`super::graduation`]).
    pub graduated: bool,
    /// A fit whose evidence can't reach this any more ends, nats: its hypothesis changes no verdict. Only at the noise and of the objective
    /// that is that of the evidence.
    pub least_evidence: f64,
}

impl FitOptions {
    /// Those of a search, with at most so many Jacobians.
    pub fn search(iterations: usize) -> Self {
        Self {
            iterations,
            stride: STRIDE,
            share: 1.0,
            tolerance: 1e-3,
            least_fall: LEAST_FALL,
            patience: 1,
            parameters: true,
            shared: true,
            reinitialise: true,
            draws: false,
            belief: 1.0,
            robust: true,
            trims: true,
            reference: true,
            graduated: false,
            least_evidence: f64::NEG_INFINITY,
        }
    }
}

/// With how much care a hypothesis is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Care {
    /// Every third of the segments kept out: enough to rank candidates.
    Brief,
    /// All of them.
    Thorough,
}
