//! What was measured, cut and smoothed: segments, contact phases, break-aways.

pub mod belt_speed;
pub mod break_away;
pub mod break_away_events;
mod clock_offset;
pub mod contact_phase;
pub mod driven_motion;
pub mod further_readings;
pub mod hold_out;
pub mod place_map;
pub(crate) mod place_prediction;
pub mod segment;
pub mod slip_samples;
pub mod smooth_run;
pub mod smoothing;
pub mod usable_run;
pub mod velocity_level;
pub mod white_noise;
