//! The harness: loads the FMU, compares it with measurements and finds the missing effect.

pub mod observer;
