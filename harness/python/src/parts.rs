//! Parts of long work, for clusters: each process does one in a folder of its own.

use pyo3::prelude::*;

use stickslip::command::diagnose::{self, Null};
use stickslip::command::sweep;
use stickslip::parallel::on_this_thread;
use stickslip::watch::Watch;

use crate::calls::{diagnose_arguments, line, sweep_arguments};
use crate::supervised::supervised;

/// Computes one chain of a study into the folder of the command line.
///
/// # Errors
/// The command's, as exceptions of `stickslip.errors`.
#[pyfunction]
pub fn sweep_chain(py: Python<'_>, words: Vec<String>, chain: usize) -> PyResult<()> {
    let arguments = sweep_arguments(py, &words)?;
    let work = |watch: &dyn Watch| sweep::perform_chain(&arguments, chain, watch);
    supervised(py, line(&words), None, work)
}

/// Diagnoses and keeps the fits in the folder of the command line, for [`null_gains`]; returns JSON and text.
///
/// # Errors
/// As [`sweep_chain`].
#[pyfunction]
#[pyo3(signature = (words, progress=None))]
pub fn diagnose_later(
    py: Python<'_>,
    words: Vec<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    diagnose_with(py, words, Null::Later, progress)
}

/// Diagnoses with gains by chance that are known; returns JSON and text.
///
/// # Errors
/// As [`sweep_chain`].
#[pyfunction]
#[pyo3(signature = (words, gains, progress=None))]
pub fn diagnose_known(
    py: Python<'_>,
    words: Vec<String>,
    gains: Vec<Vec<f64>>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    diagnose_with(py, words, Null::Known(gains), progress)
}

fn diagnose_with(
    py: Python<'_>,
    words: Vec<String>,
    null: Null,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, String)> {
    let arguments = diagnose_arguments(py, &words)?;
    supervised(py, line(&words), progress.as_ref(), |watch| {
        let found = diagnose::perform_with(&arguments, null, watch)?;
        Ok((arguments.written_json()?, diagnose::terminal(&found)))
    })
}

/// The largest gains by chance for each step of a diagnosis, in the simulated campaigns from number `first` up to but not
/// with `end`.
///
/// # Errors
/// As [`sweep_chain`].
#[pyfunction]
pub fn null_gains(
    py: Python<'_>,
    words: Vec<String>,
    first: usize,
    end: usize,
) -> PyResult<Vec<Vec<f64>>> {
    let arguments = diagnose_arguments(py, &words)?;
    supervised(py, line(&words), None, |watch| {
        on_this_thread(|| diagnose::perform_null(&arguments, first..end, watch))
    })
}
