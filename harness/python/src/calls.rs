//! Commands, each called with its command line.

use std::ffi::OsString;
use std::path::PathBuf;

use numpy::PyArray1;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use stickslip::cli::{Asked, Command, parse};
use stickslip::command::{
    blind_test, check, compare, diagnose, dimension, effects, import, observe, simulate, sweep,
    try_effects,
};
use stickslip::error::Error;
use stickslip::measurement::Measurand;
use stickslip::parallel::on_this_thread;
use stickslip::watch::Watch;

use crate::raised::raised;
use crate::supervised::supervised;

/// What a command returns: what it prints, and its signals.
struct Returned {
    /// What it prints with `--json`.
    json: String,
    /// What it prints without.
    text: String,
    signals: Signals,
}

/// Signals that become numpy arrays.
enum Signals {
    None,
    Motion(simulate::Simulated),
    Runs(Vec<compare::RunComparison>),
    Observation(Box<observe::Observation>),
    Series(Box<dimension::Analysed>),
    Section(Vec<Vec<f64>>),
}

/// Runs a command line, without the program's name, and returns a dictionary: `json`, `text` and the signals of the command.
/// `alone` keeps the work on one thread; `program` is the file whose content says which program a blind test is of.
///
/// # Errors
/// The command's, as exceptions of `stickslip.errors`.
#[pyfunction]
#[pyo3(signature = (words, progress=None, alone=false, program=None))]
pub fn perform<'py>(
    py: Python<'py>,
    words: Vec<String>,
    progress: Option<Py<PyAny>>,
    alone: bool,
    program: Option<PathBuf>,
) -> PyResult<Bound<'py, PyDict>> {
    let command = command(py, &words)?;
    let work = |watch: &dyn Watch| {
        let work = || performed(&command, program.unwrap_or_default(), watch);
        if alone { on_this_thread(work) } else { work() }
    };
    let returned = supervised(py, line(&words), progress.as_ref(), work)?;
    let out = PyDict::new(py);
    out.set_item("json", returned.json)?;
    out.set_item("text", returned.text)?;
    returned.signals.put(&out)?;
    Ok(out)
}

/// The points of a study still to be computed, as JSON, and its folder prepared.
///
/// # Errors
/// As [`perform`].
#[pyfunction]
pub fn plan(py: Python<'_>, words: Vec<String>) -> PyResult<String> {
    let arguments = sweep_arguments(py, &words)?;
    supervised(py, line(&words), None, |_| sweep::planned(&arguments))
}

/// The whole command line, as results name it.
pub fn line(words: &[String]) -> Vec<String> {
    let program = std::iter::once("stickslip".to_owned());
    program.chain(words.iter().cloned()).collect()
}

/// The command of a command line.
///
/// # Errors
/// A command line that can't be read.
pub fn command(py: Python<'_>, words: &[String]) -> PyResult<Command> {
    let asked = parse(line(words).into_iter().map(OsString::from));
    match asked.map_err(|error| raised(py, &error))? {
        Asked::For(cli) => cli
            .command
            .ok_or_else(|| PyValueError::new_err("no command")),
        Asked::Text(text) => Err(PyValueError::new_err(text)),
    }
}

/// The options of a `sweep`.
///
/// # Errors
/// A command line of another command, or one that can't be read.
pub fn sweep_arguments(py: Python<'_>, words: &[String]) -> PyResult<sweep::Arguments> {
    match command(py, words)? {
        Command::Sweep(arguments) => Ok(arguments),
        _ => Err(PyValueError::new_err("not a sweep")),
    }
}

/// The options of a `diagnose`.
///
/// # Errors
/// As [`sweep_arguments`].
pub fn diagnose_arguments(py: Python<'_>, words: &[String]) -> PyResult<diagnose::Arguments> {
    match command(py, words)? {
        Command::Diagnose(arguments) => Ok(arguments),
        _ => Err(PyValueError::new_err("not a diagnosis")),
    }
}

fn performed(command: &Command, program: PathBuf, watch: &dyn Watch) -> Result<Returned, Error> {
    let plain = |json, text| Returned {
        json,
        text,
        signals: Signals::None,
    };
    Ok(match command {
        Command::Simulate(arguments) => Returned {
            json: "{}".to_owned(),
            text: String::new(),
            signals: Signals::Motion(simulate::perform(arguments, watch)?),
        },
        Command::Compare(arguments) => {
            let found = compare::perform(arguments, watch)?;
            found.gate()?;
            Returned {
                json: found.json,
                text: found.text,
                signals: Signals::Runs(found.runs),
            }
        }
        Command::Check(arguments) => {
            let found = check::perform(arguments)?;
            plain(found.json, found.text)
        }
        Command::Import(arguments) => plain("{}".to_owned(), import::perform(arguments)?),
        Command::Diagnose(arguments) => {
            let found = diagnose::perform(arguments, watch)?;
            plain(arguments.written_json()?, diagnose::terminal(&found))
        }
        Command::Try(arguments) => {
            let found = try_effects::perform(arguments, watch)?;
            plain(arguments.written_json()?, diagnose::terminal(&found))
        }
        Command::BlindTest(arguments) => {
            let found = blind_test::perform(arguments, &program, watch, &|_| Ok(()))?;
            found.whole()?;
            plain(found.json, found.text)
        }
        Command::Observe(arguments) => {
            let found = observe::perform(arguments)?;
            Returned {
                json: found.json,
                text: found.text,
                signals: Signals::Observation(Box::new(found.observation)),
            }
        }
        Command::Dimension(arguments) => {
            let found = dimension::perform(arguments, watch)?;
            Returned {
                json: found.json.clone(),
                text: found.text.clone(),
                signals: Signals::Series(Box::new(found)),
            }
        }
        Command::Sweep(arguments) => {
            let found = sweep::perform(arguments, watch)?;
            Returned {
                json: found.json,
                text: found.text,
                signals: Signals::Section(found.section),
            }
        }
        Command::Effects(arguments) => {
            let found = effects::perform(arguments)?;
            plain(found.json.to_string(), found.text)
        }
        _ => {
            return Err(Error::Usage {
                problem: "this command has no function in Python; use the program".into(),
            });
        }
    })
}

impl Signals {
    /// Puts the arrays into a dictionary.
    fn put(self, out: &Bound<'_, PyDict>) -> PyResult<()> {
        let py = out.py();
        match self {
            Signals::None => {}
            Signals::Motion(found) => {
                let values = PyDict::new(py);
                for (name, list) in found.names.iter().zip(found.trajectory.values) {
                    values.set_item(name, PyArray1::from_vec(py, list))?;
                }
                out.set_item("time", PyArray1::from_vec(py, found.trajectory.time))?;
                out.set_item("values", values)?;
                out.set_item("units", found.units)?;
            }
            Signals::Runs(runs) => {
                let list = PyList::empty(py);
                for run in runs {
                    let curves = PyDict::new(py);
                    let of =
                        |name: &str, values| curves.set_item(name, PyArray1::from_vec(py, values));
                    of("time", run.curves.time)?;
                    of("measured", run.curves.measured)?;
                    of("model", run.curves.model)?;
                    let measurand = run.curves.measurand;
                    let other = match measurand {
                        Measurand::Displacement => "model_velocity",
                        _ => "model_displacement",
                    };
                    of(other, run.curves.model_other)?;
                    of("residual", run.curves.residual)?;
                    // Stick shows at the tip alone.
                    if run.measured.stick_fraction.is_finite() {
                        let sticks = run.curves.measured_stick.sticks;
                        curves.set_item("sticks", PyArray1::from_vec(py, sticks))?;
                    }
                    curves.set_item("quantity", measurand.name())?;
                    curves.set_item("unit", measurand.unit())?;
                    list.append(curves)?;
                }
                out.set_item("curves", list)?;
            }
            Signals::Observation(found) => {
                let modes = PyArray1::from_vec(py, found.modes());
                let of = |name: &str, values| out.set_item(name, PyArray1::from_vec(py, values));
                of("time", found.time)?;
                of("measured", found.measured)?;
                of("force", found.force)?;
                of("force_std", found.force_std)?;
                of("displacement", found.displacement)?;
                of("velocity", found.velocity)?;
                of("relative_velocity", found.relative_velocity)?;
                out.set_item("mode", modes)?;
            }
            Signals::Series(found) => {
                let of = |name: &str, values| out.set_item(name, PyArray1::from_vec(py, values));
                of("series", found.series.values)?;
                of("radii", found.analysis.sum.radii)?;
                let counts = found.analysis.sum.counts.into_iter();
                let counts = counts.map(|list| PyArray1::from_vec(py, list));
                out.set_item("pairs", PyList::new(py, counts.collect::<Vec<_>>())?)?;
                let slopes = found.analysis.slopes.into_iter();
                let slopes = slopes.map(|list| PyArray1::from_vec(py, list));
                out.set_item("local_slopes", PyList::new(py, slopes.collect::<Vec<_>>())?)?;
            }
            Signals::Section(section) => {
                let lists = section.into_iter().map(|list| PyArray1::from_vec(py, list));
                out.set_item("section", PyList::new(py, lists.collect::<Vec<_>>())?)?;
            }
        }
        Ok(())
    }
}
