//! Campaigns as Python values: read from a folder, and written from arrays.

use std::path::{Path, PathBuf};

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use stickslip::command::import::{Entry, beam_of_text, run_names, write};
use stickslip::measurement::logger::{Imported, Input};
use stickslip::measurement::{Campaign, Measurand};

use crate::raised::raised;

/// A campaign's folder as a dictionary: name, what is known of the beam, and the runs with their signals in SI units.
///
/// # Errors
/// A campaign that can't be read, as an exception of `stickslip.errors`.
#[pyfunction]
pub fn load_campaign(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let campaign = py
        .detach(|| Campaign::load(&path))
        .map_err(|error| raised(py, &error))?;
    let measurand = campaign.measurand();
    let beam = PyDict::new(py);
    beam.set_item(
        "natural_frequencies_hz",
        campaign.beam.natural_frequencies_hz,
    )?;
    beam.set_item("damping_ratios", campaign.beam.damping_ratios)?;
    beam.set_item("damping_rates_per_s", campaign.beam.damping_rates_per_s)?;
    beam.set_item("masses_kg", campaign.beam.masses_kg)?;
    beam.set_item("tip_values", campaign.beam.tip_values)?;
    let runs = PyList::empty(py);
    for run in campaign.runs {
        let inputs = PyDict::new(py);
        for (name, series) in run.inputs.series() {
            inputs.set_item(name, PyArray1::from_slice(py, &series.values))?;
        }
        let entry = PyDict::new(py);
        entry.set_item("name", run.name)?;
        entry.set_item("file", run.file)?;
        entry.set_item("belt_velocity", run.belt_velocity)?;
        entry.set_item("normal_force", run.normal_force)?;
        entry.set_item("time", PyArray1::from_vec(py, run.time))?;
        entry.set_item("measured", PyArray1::from_vec(py, run.measured))?;
        entry.set_item("inputs", inputs)?;
        entry.set_item("noise_std", run.noise.std)?;
        entry.set_item("sample_interval", run.sampling.interval)?;
        entry.set_item("understood", run.understood)?;
        runs.append(entry)?;
    }
    let out = PyDict::new(py);
    out.set_item("name", campaign.name)?;
    out.set_item("folder", campaign.folder)?;
    out.set_item("quantity", measurand.name())?;
    out.set_item("unit", measurand.unit())?;
    out.set_item("beam", beam)?;
    out.set_item("runs", runs)?;
    Ok(out)
}

/// An input of a run: one value, or one for each sample.
#[derive(FromPyObject)]
pub enum Given<'py> {
    /// SI unit.
    Constant(f64),
    /// SI unit.
    Series(PyReadonlyArray1<'py, f64>),
}

impl Given<'_> {
    fn input(&self) -> PyResult<Input> {
        Ok(match self {
            Given::Constant(value) => Input::Constant(*value),
            Given::Series(values) => Input::Series(values.as_slice()?.to_vec()),
        })
    }
}

/// A run: name, times in s, what was measured in its SI unit, belt velocity in m/s, normal force and external force in N,
/// acceleration of the clamp in m/s^2.
type Run<'py> = (
    String,
    PyReadonlyArray1<'py, f64>,
    PyReadonlyArray1<'py, f64>,
    Given<'py>,
    Given<'py>,
    Option<Given<'py>>,
    Option<Given<'py>>,
);

/// Writes a campaign of these runs into a new or empty folder. `quantity` is what was measured at the tip: displacement, velocity
/// or acceleration; `beam` the text of a TOML file with `[beam]`.
///
/// # Errors
/// Samples or a beam that can't be used, a folder that is not empty or can't be written, as exceptions of
/// `stickslip.errors`.
#[pyfunction]
pub fn write_campaign(
    py: Python<'_>,
    folder: PathBuf,
    name: Option<String>,
    beam: Option<String>,
    quantity: &str,
    runs: Vec<Run<'_>>,
) -> PyResult<()> {
    let named = |m: &Measurand| m.name() == quantity;
    let measurand = Measurand::ALL.into_iter().find(named).ok_or_else(|| {
        PyValueError::new_err(format!(
            "quantity is '{quantity}'; give 'displacement', 'velocity' or 'acceleration'"
        ))
    })?;
    let names = run_names(runs.iter().map(|run| run.0.clone()));
    let mut imported = Vec::new();
    for (name, time, measured, belt, load, force, clamp) in &runs {
        let lists = (time.as_slice()?.to_vec(), measured.as_slice()?.to_vec());
        let excitation = |given: &Option<Given<'_>>| given.as_ref().map(Given::input).transpose();
        let excitations = [excitation(force)?, excitation(clamp)?];
        let (belt, load) = (belt.input()?, load.input()?);
        let run = Imported::of_samples(name, measurand, lists, belt, load, excitations);
        imported.push(run.map_err(|error| raised(py, &error))?);
    }
    let entry = |(name, run)| Entry {
        name,
        file: Path::new("memory"),
        run,
    };
    let names = names.iter().map(String::as_str);
    let entries: Vec<Entry> = names.zip(&imported).map(entry).collect();
    let place = folder.join("campaign.toml");
    let beam = beam.map(|text| beam_of_text(&text, &place)).transpose();
    let beam = beam.map_err(|error| raised(py, &error))?;
    py.detach(|| write(&folder, name.as_deref(), beam.as_deref(), &entries))
        .map_err(|error| raised(py, &error))
}

/// JSON of a table as TOML text.
///
/// # Errors
/// ValueError: what TOML can't hold.
#[pyfunction]
pub fn toml_of_json(json: &str) -> PyResult<String> {
    let value: toml::Value =
        serde_json::from_str(json).map_err(|e| PyValueError::new_err(e.to_string()))?;
    toml::to_string(&value).map_err(|e| PyValueError::new_err(e.to_string()))
}
