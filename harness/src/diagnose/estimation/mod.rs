//! The fit of one hypothesis from one start: likelihood, sensitivities, normal equations.

#[cfg(test)]
mod bent_toy;
mod carried_starts;
pub mod curve_estimate;
pub mod drawn_starts;
pub mod fit;
pub mod fit_options;
pub mod fitter;
pub(crate) mod graduation;
mod information;
pub mod initial_states;
#[cfg(test)]
mod jump_toy;
#[cfg(test)]
mod latch_toy;
pub mod levenberg_marquardt;
pub mod likelihood;
#[cfg(test)]
mod linear_toy;
mod memory_left;
pub mod nesting;
pub mod normal_equations;
pub mod run_parameters;
pub(crate) mod scaled_matrix;
pub mod sensitivities;
mod start_prices;
