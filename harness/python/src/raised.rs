//! The library's errors as exceptions of the package, with the same text.

use pyo3::prelude::*;

use stickslip::error::Error;
use stickslip::exit::Exit;

/// The exception of an error; its class says what the command's exit code says.
pub fn raised(py: Python<'_>, error: &Error) -> PyErr {
    let class = match error.exit() {
        Exit::GateFailed => "GateFailed",
        Exit::FmuFailed => "FmuFailed",
        Exit::NotWritten | Exit::ReaderGone => "NotWritten",
        Exit::Stopped => "Stopped",
        Exit::Done | Exit::BadInput => "BadInput",
    };
    let made = py
        .import("stickslip.errors")
        .and_then(|module| module.getattr(class))
        .and_then(|class| class.call1((error.line(),)));
    made.map_or_else(|failed| failed, PyErr::from_value)
}
