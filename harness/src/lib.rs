//! The harness: loads an FMU, compares it with measurements, finds the missing effect.
//!
//! It knows a model by its .fmu file alone, so it works on other people's FMUs.
//! Imports go one way: `command` -> {`observer`, `dimension`, `diagnose`, `metric`, `report`} -> {`measurement`, `fmu`}.
#![deny(unsafe_code)]

pub mod cli;
pub mod command;
pub mod diagnose;
pub mod dimension;
pub mod error;
pub mod fmu;
pub mod measurement;
pub mod metric;
pub mod observer;
pub mod output;
pub mod parallel;
pub mod provenance;
pub mod report;
pub mod watch;
mod wording;
