//! `stickslip simulate`: one operating point of an FMU, as CSV.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::operating_point::{OperatingPoint, record};
use crate::error::Error;
use crate::fmu::{Causality, Fmu, Kind};
use crate::output::write_file;

/// Options of `simulate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// FMU to run [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Belt velocity in m/s, any sign
    #[arg(
        long,
        value_name = "M/S",
        default_value_t = 0.1,
        allow_negative_numbers = true
    )]
    belt_velocity: f64,
    /// Normal force in N
    #[arg(long, value_name = "N", default_value_t = 100.0)]
    normal_force: f64,
    /// Time to simulate, in s
    #[arg(long, value_name = "S", default_value_t = 2.0)]
    duration: f64,
    /// Output interval, which is also the communication step, in s
    #[arg(long, value_name = "S", default_value_t = 1e-4)]
    step: f64,
    /// Start value of any variable of the FMU, in the variable's unit, or @FILE with one per line; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Variables to write, separated by commas [default: every output]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    variables: Vec<String>,
    /// File to write [default: standard output]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// List the FMU's variables with unit and start value instead
    #[arg(long)]
    list: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let text = if arguments.list {
        list(&fmu)
    } else {
        simulate(&fmu, arguments)?
    };
    match &arguments.output {
        Some(path) => write_file(path, text.as_bytes()),
        None => match std::io::stdout().write_all(text.as_bytes()) {
            // A reader like `head` that has seen enough is no failure.
            Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::Write {
                path: "standard output".into(),
                source: error,
            }),
            _ => Ok(()),
        },
    }
}

fn simulate(fmu: &Fmu, arguments: &Arguments) -> Result<String, Error> {
    let settings = start_values(&arguments.settings)?;
    let step = positive("--step", arguments.step)?;
    let steps = (positive("--duration", arguments.duration)? / step)
        .round()
        .max(1.0);
    if steps > 1e8 {
        return Err(Error::Option {
            option: "--duration",
            value: arguments.duration.to_string(),
            rule: format!(
                "s is {steps:.0} steps of {step} s; at most 1e8 are possible, make --step larger"
            ),
        });
    }
    let point = OperatingPoint {
        belt_velocity: arguments.belt_velocity,
        normal_force: arguments.normal_force,
        settings,
    };
    let outputs = || {
        fmu.description()
            .variables
            .iter()
            .filter(|v| v.causality == Causality::Output && v.kind != Kind::String)
    };
    let names: Vec<&str> = match arguments.variables.as_slice() {
        [] => outputs().map(|v| v.name.as_str()).collect(),
        chosen => chosen.iter().map(String::as_str).collect(),
    };
    let mut instance = fmu.instantiate("simulate")?;
    point.start(fmu, &mut instance)?;
    let trajectory = record(fmu, &mut instance, &names, step, steps as usize)?;

    let mut csv = String::from("time");
    names.iter().for_each(|name| csv.extend([",", name]));
    csv.push('\n');
    for (i, time) in trajectory.time.iter().enumerate() {
        let _ = write!(csv, "{time}");
        for values in &trajectory.values {
            let _ = write!(csv, ",{}", values[i]);
        }
        csv.push('\n');
    }
    Ok(csv)
}

/// Start values as `--set` gives them: NAME=VALUE, or @FILE with one per line.
pub(super) fn start_values(options: &[String]) -> Result<Vec<(String, f64)>, Error> {
    let mut settings = Vec::new();
    for text in options {
        match text.strip_prefix('@') {
            Some(file) => settings.extend(settings_of(Path::new(file))?),
            None => settings.push(setting(text)?),
        }
    }
    Ok(settings)
}

fn positive(option: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(Error::Option {
        option,
        value: value.to_string(),
        rule: "s is not possible; give a time greater than zero".into(),
    })
}

/// Start values from a file: one NAME=VALUE per line; lines that begin with `#` are comments.
fn settings_of(file: &Path) -> Result<Vec<(String, f64)>, Error> {
    let text = std::fs::read_to_string(file).map_err(Error::read(file))?;
    text.lines()
        .map(str::trim)
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .map(setting)
        .collect()
}

fn setting(text: &str) -> Result<(String, f64), Error> {
    let parsed = text
        .split_once('=')
        .and_then(|(name, value)| Some((name.trim().to_owned(), value.trim().parse().ok()?)));
    let rule = || "is not NAME=VALUE with a number; for example --set mode_count=3".to_owned();
    parsed.ok_or_else(|| Error::Option {
        option: "--set",
        value: text.to_owned(),
        rule: rule(),
    })
}

fn list(fmu: &Fmu) -> String {
    let mut text = String::new();
    for v in &fmu.description().variables {
        let kind = format!("{:?}", v.causality).to_lowercase();
        let start = v
            .start
            .as_deref()
            .map(|s| format!("= {s}"))
            .unwrap_or_default();
        let unit = v.unit.as_deref().unwrap_or("");
        let _ = writeln!(
            text,
            "{:<12} {:<44} {start} {unit}  {}",
            kind, v.name, v.description
        );
    }
    text
}
