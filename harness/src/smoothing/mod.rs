//! A run by the smoother, whatever was measured and whatever drives it: motion, contact phases and friction force.
//!
//! The smoother of [`crate::observer`] sees one channel of a structure that a friction force alone moves. Here a run is made ready
//! for it and what it finds is completed: what an external force or the clamp does by itself is taken off first and put on again,
//! and what a velocity or an acceleration leaves open is set by the friction expected.

mod belt_in_stick;
mod belt_path;
mod driven_motion;
mod level;
mod prepared;
#[cfg(test)]
pub(crate) mod pushed_run;
mod slip_samples;
mod smoothed_run;

pub use belt_in_stick::belt_in_stick;
pub use belt_path::BeltPath;
pub use driven_motion::{differences, driven_motion, sampled};
pub use level::missing_force;
pub use prepared::{Prepared, smoother_settings};
pub use slip_samples::{SlipSample, slip_of_run};
pub use smoothed_run::{Smoothing, smooth_run, trusted_signal};
