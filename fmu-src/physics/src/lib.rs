//! Physics of an elastic structure rubbed by a moving belt: stick and slip, event-driven.
//!
//! Source of the reference model: P. Stelter, Nonlinear Vibrations of Structures Induced by Dry
//! Friction, Nonlinear Dynamics 3 (1992) 329-345. All quantities are in SI units.
#![forbid(unsafe_code)]

pub mod beam;
pub mod belt;
pub mod belt_drive;
#[cfg(test)]
mod conformance;
pub mod contact;
pub mod effects;
pub mod energy;
pub mod error;
pub mod expression;
pub mod friction;
pub mod hybrid;
pub mod integrate;
pub mod model;
pub mod parameters;
#[cfg(test)]
mod plain;
#[cfg(test)]
mod plain_comparison;
#[cfg(test)]
mod series_conformance;
pub mod simulate;
pub mod sweep;
pub mod unit;
