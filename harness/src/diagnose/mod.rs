//! Finds the physical effect that a model lacks, from a measured campaign.

pub mod candidate;
pub mod conclude;
pub mod contender;
pub mod dependence;
pub mod fit;
pub mod friction_prior;
pub mod hypothesis;
pub mod judge;
pub mod knob;
pub mod next_measurement;
mod null;
pub mod outcome;
mod pairs;
pub mod predictor;
pub mod propose;
pub mod replay;
pub mod residual;
pub mod scan;
pub mod screen;
pub mod search;
pub mod select;
pub mod session;
pub mod shot;
mod starts;
pub mod unexplained;
mod whiteness;
mod words;
