//! The extension module of the Python package `stickslip`: the library's commands with their results as Python values.
//!
//! Nothing is computed here. A call is a command line of `stickslip`; what it returns is what the command prints as JSON,
//! and its signals as numpy arrays.
#![forbid(unsafe_code)]

mod calls;
mod campaigns;
mod parts;
mod raised;
mod supervised;

use pyo3::prelude::*;

/// `stickslip._native`; the package's modules of Python are what users see.
#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::calls::{perform, plan};
    #[pymodule_export]
    use crate::campaigns::{load_campaign, toml_of_json, write_campaign};
    #[pymodule_export]
    use crate::parts::{diagnose_known, diagnose_later, null_gains, sweep_chain};

    use pyo3::prelude::*;

    /// Texts are for notebooks and files: no colours of a terminal in them.
    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        console::set_colors_enabled(false);
        Ok(())
    }
}
