//! Finds the physical effect that a model lacks, from a measured campaign.

pub mod data;
pub mod estimation;
pub mod explanation;
pub mod initialisation;
pub mod model;
pub mod result;
pub mod selection;
pub mod stages;
pub mod thresholds;
pub mod validation;
