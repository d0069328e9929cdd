//! The diagnosis as it is written: ladder, estimates, words.

pub mod assemble;
pub(crate) mod beyond_catalogue;
pub mod curve_formula;
pub mod diagnosis;
pub mod error_ladder;
mod found_constants;
pub mod further_sensors;
pub mod hysteresis;
pub mod remarks;
pub mod run_sets;
mod shape;
mod standings;
pub mod summary;
pub mod unknown;
