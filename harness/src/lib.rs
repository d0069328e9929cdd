//! The harness: loads an FMU, compares it with measurements and shows where they differ.
//!
//! It knows a model by its .fmu file alone, so it works on other people's FMUs.
//! Imports go one way: `command` -> {`metric`, `report`} -> {`measurement`, `fmu`}.
#![forbid(unsafe_code)]

pub mod error;
pub mod fmu;
pub mod measurement;
pub mod observer;
