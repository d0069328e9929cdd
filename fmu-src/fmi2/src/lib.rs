//! The stick-slip beam as an FMI 2.0 model, for co-simulation and for model exchange, and the belt drive that goes
//! with it, for co-simulation: the C interface and nothing else. Which of the two an instance is, its GUID says.
//!
//! Every exported function goes through [`guard::with_instance`]: it refuses NULL, checks the calling
//! sequence, catches panics and reports faults to the master's logger. `unsafe` occurs only where
//! pointers of the master are read or written; each place says why it is sound.
#![warn(unsafe_op_in_unsafe_fn)]
#![warn(clippy::undocumented_unsafe_blocks)]

use beam_physics as physics;

mod beam;
mod directional;
mod drive;
mod energy;
mod exchange;
mod experiment;
pub mod exports;
mod fmu_state;
mod guard;
mod instance;
pub mod lifecycle;
mod log;
mod model;
mod resource;
mod setup;
mod slave;
mod states;
pub mod status;
mod tangent;
mod tunable;
pub mod types;
mod values;

pub use exports::*;
