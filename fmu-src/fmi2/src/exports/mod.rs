//! The functions that a master calls: those of FMI 2.0 for both interfaces, for co-simulation and for model exchange, and a few
//! beyond the standard.
//!
//! # Safety
//! All functions rely on the master to keep the standard's promises about pointers: handles come from
//! `fmi2Instantiate` and are not used after `fmi2FreeInstance`, arrays have the announced lengths,
//! strings end with a zero byte, and one instance is used by one thread at a time.

mod exchange;
mod lifecycle;
mod states;
mod steps;
mod sweep;
mod tangent;
mod values;

pub use exchange::*;
pub use lifecycle::*;
pub use states::*;
pub use steps::*;
pub use sweep::*;
pub use tangent::*;
pub use values::*;
