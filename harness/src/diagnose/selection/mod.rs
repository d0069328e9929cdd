//! Which hypothesis: the search, its comparison by evidence, the decision.

mod as_given;
pub mod bootstrap;
pub mod by_chance;
pub mod decision;
pub mod discrepancy;
pub mod elimination;
pub mod extension;
pub mod fitted_model;
pub mod follow;
pub mod forms;
pub mod full_refit;
pub mod further_fits;
pub mod lengthening;
pub mod lost_runs;
pub mod next_measurement;
pub mod outcome;
pub mod race;
mod replacement;
pub mod roughness;
pub mod screening;
pub mod search;
pub mod select;
pub mod smoothness;
pub mod subset_search;
pub mod tested;
pub mod ties;
pub mod windows;
