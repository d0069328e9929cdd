//! Physics of an elastic structure rubbed by a moving belt: stick and slip, event-driven.
//!
//! Source of the reference model: P. Stelter, Nonlinear Vibrations of Structures Induced by Dry
//! Friction, Nonlinear Dynamics 3 (1992) 329-345. All quantities are in SI units.
#![forbid(unsafe_code)]

pub mod beam;
pub mod belt;
#[cfg(not(feature = "tangent"))]
pub mod belt_drive;
#[cfg(all(test, not(feature = "tangent")))]
mod conformance;
pub mod contact;
pub mod effects;
pub mod energy;
pub mod error;
pub mod expression;
pub mod friction;
#[cfg(not(feature = "tangent"))]
pub mod hybrid;
pub mod integrate;
pub mod model;
pub mod parameters;
#[cfg(all(test, not(feature = "tangent")))]
mod plain;
#[cfg(all(test, not(feature = "tangent")))]
mod plain_comparison;
pub mod real;
#[cfg(all(test, not(feature = "tangent")))]
mod series_conformance;
pub mod simulate;
#[cfg(not(feature = "tangent"))]
pub mod sweep;
#[cfg(feature = "tangent")]
pub mod tangent;
pub mod unit;
