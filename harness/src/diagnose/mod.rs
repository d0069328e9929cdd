//! Finds the physical effect that a model lacks, from a measured campaign.

pub mod candidate;
pub mod fit;
pub mod hypothesis;
pub mod knob;
pub mod predictor;
pub mod shot;
