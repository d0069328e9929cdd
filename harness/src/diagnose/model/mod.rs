//! Hypotheses and their parameters, and the simulator that predicts segments.

pub mod acting;
pub mod beam_constants;
pub mod belt_profile;
pub mod displacement_range;
pub mod finished_work;
pub mod friction_prior;
pub mod further_sensors;
pub mod hypothesis;
pub mod known_structure;
pub mod library;
pub mod observations;
pub mod parameter;
pub mod periodic;
pub mod point;
pub mod predictor;
pub mod problem;
pub mod profile_values;
pub mod references;
pub mod scales;
pub mod sensor_ratios;
pub mod similarity;
pub mod simulator;
pub mod stated_constants;
pub mod unknown_function;
pub mod variants;
pub mod work;
