//! What one fitted model leaves: errors, forecasts, whiteness, identifiability.

pub mod correlation_time;
pub mod estimate;
pub mod forecast;
pub mod forecast_band;
pub mod identifiability;
mod learned_run;
pub mod prior_conflict;
pub mod residual_whiteness;
pub mod segment_errors;
