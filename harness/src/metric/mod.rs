//! Numbers that describe a stick-slip motion, and how far two of them differ.
//!
//! Each file is one metric: equation, symbols with units, when it holds, source. All take plain slices in SI units and
//! treat model and measurement alike, so that their imperfections cancel.

mod amplitude;
mod characteristics;
mod cycle;
mod integral;
mod interval;
mod line;
mod model_motion;
mod nrmse;
mod period;
mod resample;
mod residual;
mod rest;
mod spectrum;
mod stick;
mod stick_velocity;
mod velocity;

pub use amplitude::{amplitude, median, quantile, standard_deviation};
pub use characteristics::{Characteristics, HARMONICS, characteristics, stick_of};
pub use cycle::{Cycle, cycle_starts, mean_cycle, whole_cycles};
pub use integral::integral;
pub use interval::half_width;
pub use line::line;
pub use model_motion::ModelMotion;
pub use nrmse::nrmse;
pub use period::{Period, period};
pub use resample::{interpolate, resample};
pub use residual::{AlignedBlock, AlignedResidual, Block, Fit, align, aligned_residual, blocks};
pub use rest::{LEAST_REST, Rest, rest, velocity_from_rest};
pub use spectrum::{Spectrum, harmonics, spectrum};
pub use stick::{StickDetection, detect_stick, measured_stick, resting_stick, stick_fraction};
pub use stick_velocity::{MAD, StickVelocity, measured_stick_velocity, plateau, stick_velocity};
pub use velocity::velocity;
