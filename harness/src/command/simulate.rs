//! `stickslip simulate`: one operating point of an FMU, as CSV.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::operating_options::OperatingOptions;
use super::operating_point::{OperatingPoint, Trajectory, record_driven};
use crate::error::Error;
use crate::file_kind::{Wanted, explain};
use crate::fmu::{Causality, Drive, Fmu, Kind};
use crate::measurement::{Interpolation, read_inputs};
use crate::output::{print, write_file};
use crate::watch::Watch;

/// Options of `simulate`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// FMU to run [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    #[command(flatten)]
    at: OperatingOptions,
    /// Time to simulate, in s
    #[arg(long, value_name = "S", default_value_t = 2.0)]
    duration: f64,
    /// Output interval, which is also the communication step, in s
    #[arg(long, value_name = "S", default_value_t = 1e-4)]
    step: f64,
    /// CSV with a column `time` in s and one for each input that varies, under the FMU's name, as external_force
    #[arg(long, value_name = "CSV")]
    input: Option<PathBuf>,
    /// What inputs do between their samples: band-limited, linear or held [default: band-limited where these are even, else linear]
    #[arg(long, value_enum, requires = "input", hide_possible_values = true)]
    input_interpolation: Option<Interpolation>,
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

/// A motion with the names and units of what was recorded.
#[derive(Debug)]
pub struct Simulated {
    /// Names of the variables.
    pub names: Vec<String>,
    /// Their units; empty where there is none.
    pub units: Vec<String>,
    /// Times and values.
    pub trajectory: Trajectory,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let text = if arguments.list {
        list(&super::open_fmu(arguments.fmu.as_deref())?)
    } else {
        csv(&perform(arguments, &())?)
    };
    match &arguments.output {
        Some(path) => write_file(path, text.as_bytes()),
        None => print(&text),
    }
}

/// Simulates; nothing is written.
///
/// # Errors
/// Options or an FMU that can't be used; an FMU that gives up; a stop.
pub fn perform(arguments: &Arguments, watch: &dyn Watch) -> Result<Simulated, Error> {
    let fmu = &super::open_fmu(arguments.fmu.as_deref())?;
    let said = arguments.at.read()?;
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
    let (belt_velocity, normal_force) = said.load();
    let point = OperatingPoint {
        belt_velocity,
        normal_force,
        settings: said.settings,
        ..OperatingPoint::default()
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
    let tracks = match &arguments.input {
        Some(path) => read_inputs(path, arguments.input_interpolation)
            .map_err(|error| explain(error, path, Wanted::Table))?,
        None => Vec::new(),
    };
    let tracks = tracks.iter().map(|(name, t)| (name.as_str(), t.clone()));
    let drive = Drive::of(fmu, tracks.collect())?;
    let mut instance = drive.instance(fmu, "simulate")?;
    point.start_driven(fmu, &mut instance, Some(&drive))?;
    let samples = (step, steps as usize);
    let trajectory = record_driven(fmu, &mut instance, &names, samples, Some(&drive), watch)?;
    let unit = |name: &&str| Ok(fmu.variable(name)?.unit.clone().unwrap_or_default());
    Ok(Simulated {
        units: names.iter().map(unit).collect::<Result<_, Error>>()?,
        names: names.into_iter().map(str::to_owned).collect(),
        trajectory,
    })
}

fn csv(
    Simulated {
        names, trajectory, ..
    }: &Simulated,
) -> String {
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
    csv
}

/// Longest time that may be asked for, s: three centuries, more than any model of a machine is for.
const LONGEST: f64 = 1e10;

fn positive(option: &'static str, value: f64) -> Result<f64, Error> {
    if value > 0.0 && value <= LONGEST {
        return Ok(value);
    }
    let rule = if value > LONGEST {
        format!("s is not possible; give {LONGEST:.0e} s or less")
    } else {
        "s is not possible; give a time greater than zero".into()
    };
    Err(Error::Option {
        option,
        value: value.to_string(),
        rule,
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
