//! Measurement campaigns: a folder with `campaign.toml` and one CSV file per run.
//!
//! ```no_run
//! # fn main() -> Result<(), stickslip::error::Error> {
//! use stickslip::measurement::Campaign;
//! let campaign = Campaign::load("reference-data/demo".as_ref())?;
//! for run in &campaign.runs {
//!     println!("{}: {} samples, noise {:.1e} {}", run.name, run.time.len(), run.noise.std, run.measurand.unit());
//! }
//! # Ok(()) }
//! ```
//!
//! Everything is in SI units once loaded. Samples are kept as measured: gaps and uneven sampling are found and
//! reported, never filled.

mod band_limited;
mod campaign;
mod campaign_file;
mod cell;
mod column;
mod csv_table;
mod dialect;
mod encoding;
mod faults;
mod further_sensor;
mod header;
mod high_pass;
mod input_file;
mod input_lines;
mod inputs;
mod lines;
pub mod logger;
mod measurand;
mod measured_keys;
mod noise;
mod own_clock;
mod run;
mod run_file;
mod sampling;
mod sensor_place;
mod table;
mod uncertainty;
mod unit;

pub use campaign::{BeamKnowledge, Campaign, SingleRun};
pub(crate) use campaign_file::check::line_of;
pub use column::{Column, read_column};
pub use faults::{Fault, FaultKind};
pub use further_sensor::{
    BESIDE_JUMP, DelayBelief, FurtherRecord, FurtherSensor, LEAST_NOISE, Reading,
};
pub use input_file::read_inputs;
pub use input_lines::on_lines;
pub use inputs::{Between, Excitation, InputSeries, InputSignals, InputTrack, Interpolation};
pub use measurand::{Measurand, NoiseStd};
pub use noise::{Noise, of_one_sensor};
pub use run::{Role, Run};
pub use sampling::{Gap, Sampling};
pub use sensor_place::SensorPlace;
pub use uncertainty::{OfModes, Uncertainty};
pub(crate) use unit::factor_to_si;

#[cfg(test)]
mod bad_input;
#[cfg(test)]
mod logger_files;
#[cfg(test)]
mod measured_acceleration;
#[cfg(test)]
mod measured_velocity;
