//! The modal state observer: contact force and friction characteristic from a measured tip
//! displacement (Stelter 1992, section 5, and beyond).
//!
//! A pure library on slices in SI units; it knows nothing of FMUs or files.

pub mod characteristic;
pub mod curve;
pub mod dwell;
mod error;
pub mod frequencies;
pub mod grid;
#[cfg(test)]
mod identity;
mod kernel;
pub mod laws;
pub mod offset;
pub mod pole_observer;
pub mod poles;
pub mod segmentation;
pub mod smoother;
pub mod stick_slip;
pub mod structure;
pub mod whiteness;

pub use characteristic::{Bin, BinSettings, Contact, NormalForce, friction_characteristic};
pub use curve::{CurveSettings, FrictionCurve, friction_curve};
pub use dwell::{BreakAway, DwellResult, break_away};
pub use error::ObserverError;
pub use frequencies::{FrequencyEstimate, estimate_frequencies};
pub use grid::UniformRecord;
pub use laws::{FittedParameter, FrictionLaw, LawFit, LawPoints, fit_laws};
pub use offset::{Estimate, drift, offset_from_symmetry};
pub use pole_observer::{Observed, TimeForm, observe};
pub use poles::PoleRule;
pub use segmentation::{Phase, PhaseMode, SegmentSettings, segments};
pub use smoother::{Settings, Smoothed, smooth};
pub use stick_slip::{BeltVelocity, StickSlip, StickSlipSettings, smooth_stick_slip};
pub use structure::{ForceModel, Mode, Structure};
pub use whiteness::Whiteness;
