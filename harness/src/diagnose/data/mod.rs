//! What was measured, cut: segments, contact phases, break-aways.

pub mod belt_speed;
pub mod break_away;
pub mod break_away_events;
mod clock_offset;
pub mod coarse_excitation;
pub mod contact_phase;
pub mod further_readings;
pub mod hold_out;
pub mod place_map;
pub(crate) mod place_prediction;
pub mod segment;
pub mod usable_run;
pub mod white_noise;
