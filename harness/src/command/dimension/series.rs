//! Where the series comes from: a CSV file or an FMU.

use std::path::Path;

use super::Arguments;
use crate::command::operating_point::{OperatingPoint, record};
use crate::error::Error;
use crate::file_kind::{Wanted, explain};
use crate::measurement::read_column;

/// A series at even times.
pub struct Series {
    /// What it is, for the reader.
    pub name: String,
    /// The quantity.
    pub quantity: String,
    /// Its unit; empty where it is not known.
    pub unit: String,
    /// Sample interval, s; `None` for a file without times.
    pub interval: Option<f64>,
    /// Samples; NaN where missing.
    pub values: Vec<f64>,
}

/// Steps that may be simulated.
const MOST_STEPS: f64 = 1e8;
/// Time that may be simulated, s.
const MOST_TIME: f64 = 1e6;

/// The series that the options ask for.
pub fn get(arguments: &Arguments) -> Result<Series, Error> {
    let mut series = match (&arguments.series, &arguments.fmu) {
        (Some(_), _) if arguments.at.is_given() => {
            return Err(Error::Usage {
                problem: "--belt-velocity, --normal-force and --set go with --fmu, a series has its operating point in it".into(),
            });
        }
        (Some(path), _) => read(path, arguments.column.as_deref())?,
        (None, fmu) => simulate(fmu.as_deref(), arguments)?,
    };
    if let Some(decibel) = arguments.noise_db {
        add_noise(&mut series.values, decibel, arguments.seed);
        series.name += &format!(", noise {decibel} dB below");
    }
    Ok(series)
}

fn read(path: &Path, column: Option<&str>) -> Result<Series, Error> {
    let table = read_column(path, column).map_err(|error| explain(error, path, Wanted::Table))?;
    // Names end in their unit, as in tip_displacement_m, where the header does not state one.
    let of_name = || {
        ["m", "mm", "um", "v", "n"]
            .into_iter()
            .find(|u| table.name.ends_with(&format!("_{u}")))
    };
    let unit = table.unit.or_else(of_name);
    Ok(Series {
        name: path.display().to_string(),
        quantity: table.name.replace('_', " "),
        unit: unit.unwrap_or_default().to_owned(),
        interval: table.interval,
        values: table.values,
    })
}

fn simulate(path: Option<&Path>, arguments: &Arguments) -> Result<Series, Error> {
    let refuse = |option, value: f64, rule: &str| Error::Option {
        option,
        value: value.to_string(),
        rule: rule.into(),
    };
    if !(arguments.step > 0.0 && arguments.step.is_finite()) {
        return Err(refuse(
            "--step",
            arguments.step,
            "s is not possible; give a time greater than zero",
        ));
    }
    if !(0.0..=MOST_TIME).contains(&arguments.settle) {
        return Err(refuse(
            "--settle",
            arguments.settle,
            "s is not possible; give 0 to 1e6 s",
        ));
    }
    let steps = arguments.settle / arguments.step + arguments.samples as f64;
    if steps > MOST_STEPS {
        return Err(Error::Option {
            option: "--samples",
            value: arguments.samples.to_string(),
            rule: format!(
                "and --settle {} s make {steps:.0} steps of {} s; at most {MOST_STEPS:.0e} are possible",
                arguments.settle, arguments.step
            ),
        });
    }
    if steps * arguments.step > MOST_TIME {
        return Err(refuse(
            "--step",
            arguments.step,
            &format!("s is not possible; settling and samples may take {MOST_TIME:.0e} s together"),
        ));
    }
    let said = arguments.at.read()?;
    let fmu = crate::command::open_fmu(path.filter(|p| *p != Path::new("own")))?;
    let (belt_velocity, normal_force) = said.load();
    let point = OperatingPoint {
        belt_velocity,
        normal_force,
        settings: said.settings,
        ..OperatingPoint::default()
    };
    let before = (arguments.settle / arguments.step).round() as usize;
    let mut instance = fmu.instantiate("dimension")?;
    point.start(&fmu, &mut instance)?;
    let names = [arguments.variable.as_str()];
    let steps = before + arguments.samples.max(1) - 1;
    let mut trajectory = record(&fmu, &mut instance, &names, arguments.step, steps)?;
    let values = trajectory.values.remove(0).split_off(before);
    let unit = fmu.variable(&arguments.variable)?.unit.clone();
    Ok(Series {
        name: format!(
            "{} at {normal_force} N, {belt_velocity} m/s",
            fmu.description().model_name,
        ),
        quantity: arguments.variable.replace('_', " "),
        unit: unit.unwrap_or_default(),
        interval: Some(arguments.step),
        values,
    })
}

/// White Gaussian noise, `decibel` below the standard deviation.
pub fn add_noise(values: &mut [f64], decibel: f64, seed: u64) {
    let there: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    let n = there.len().max(1) as f64;
    let mean = there.iter().sum::<f64>() / n;
    let variance = there.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
    let size = variance.sqrt() * 10f64.powf(-decibel / 20.0);
    let mut random = fastrand::Rng::with_seed(seed);
    for value in values {
        // Box and Muller.
        let radius = (-2.0 * (1.0 - random.f64()).ln()).sqrt();
        *value += size * radius * (std::f64::consts::TAU * random.f64()).cos();
    }
}
