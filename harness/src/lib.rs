//! The harness: loads an FMU, compares it with measurements, finds the missing effect.
//!
//! It knows a model by its .fmu file alone, so it works on other people's FMUs.
//! Imports go one way: `command` -> {`diagnose`, `smoothing`, `observer`, `dimension`, `check`, `metric`, `report`} -> {`measurement`, `fmu`}.
#![deny(unsafe_code)]
// Printing goes through `output::print`, which survives a reader that goes and a disk that is full; `println!` panics.
#![cfg_attr(not(test), deny(clippy::print_stdout, clippy::print_stderr))]

pub mod check;
pub mod cli;
pub mod command;
pub mod diagnose;
pub mod dimension;
pub mod error;
pub mod exit;
pub mod file_kind;
pub mod fmu;
pub mod measurement;
pub mod metric;
pub mod observer;
pub mod output;
pub mod parallel;
pub mod provenance;
pub mod report;
pub mod smoothing;
pub mod watch;
mod wording;
