//! `stickslip cross-check`: the files that the FMI Cross-Check asks of an exporting tool (FMI-CROSS-CHECK-RULES, section
//! 4.1): `fmus/2.0/cs/<platform>/StickSlip/<version>/<model>/` with FMU, reference result, options, inputs and readme.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use crate::command::operating_point::{OperatingPoint, Trajectory, record};
use crate::command::{open_fmu, repaired_model};
use crate::error::Error;
use crate::fmu::{Fmu, PLATFORM};
use crate::output::{make_folder, print_line, write_file};

/// Options of `cross-check`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder to write into
    #[arg(short, long, value_name = "FOLDER", default_value = "fmi-cross-check")]
    output: PathBuf,
}

/// Step of the results, and their length, in s.
const STEP: f64 = 1e-3;
const STOP: f64 = 0.5;
/// The results; at most ten are asked for.
const OUTPUTS: [&str; 7] = [
    "tip_displacement",
    "tip_velocity",
    "friction_force",
    "relative_velocity",
    "measured_displacement",
    "contact_mode",
    "transition_count",
];

/// A model: its name, start values, and what it shows.
struct Model {
    name: &'static str,
    starts: &'static [(&'static str, f64)],
    /// Rate of the belt's velocity in m/s^2 for a run with inputs.
    ramp: Option<f64>,
    shows: &'static str,
}

/// The rules ask for three at least.
const MODELS: [Model; 3] = [
    Model {
        name: "StickSlipBeam",
        starts: &[],
        ramp: None,
        shows: "stick and slip of the reference model at constant inputs",
    },
    Model {
        name: "StickSlipBeamThirdMode",
        starts: &[
            ("third_mode.frequency", 1404.0),
            ("static_friction_aging.gain", 0.1),
        ],
        ramp: None,
        shows: "states that effects add, and a static limit that grows in stick",
    },
    Model {
        name: "StickSlipBeamRamp",
        starts: &[("belt_velocity", 0.06), ("normal_force", 60.0)],
        ramp: Some(0.1),
        shows: "an input that varies (StickSlipBeamRamp_in.csv, linear between its rows)",
    },
];

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    for folder in write(&arguments.output)? {
        print_line(format_args!("Wrote {}", folder.display()))?;
    }
    Ok(())
}

/// Writes the files of all models below `folder`; gives their folders.
///
/// # Errors
/// An FMU that can't be packed or run, a folder that can't be written.
pub fn write(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let plain = open_fmu(None)?;
    let top = folder
        .join("fmus/2.0/cs")
        .join(PLATFORM)
        .join("StickSlip")
        .join(env!("CARGO_PKG_VERSION"));
    let mut folders = Vec::new();
    for model in &MODELS {
        let folder = top.join(model.name);
        make_folder(&folder)?;
        write_model(&plain, model, &folder)?;
        folders.push(folder);
    }
    Ok(folders)
}

fn write_model(plain: &Fmu, model: &Model, folder: &Path) -> Result<(), Error> {
    let file = |ending: &str| folder.join(format!("{}{ending}", model.name));
    let starts: Vec<(String, f64)> = model
        .starts
        .iter()
        .map(|(name, value)| ((*name).to_owned(), *value))
        .collect();
    repaired_model::write_fmu(plain, &starts, &file(".fmu"))?;
    let fmu = Fmu::load(&file(".fmu"))?;
    let run = simulate(&fmu, model)?;
    let mut csv = head(&OUTPUTS);
    for (i, time) in run.time.iter().enumerate() {
        let _ = write!(csv, "{time}");
        for values in &run.values {
            let _ = write!(csv, ",{}", values[i]);
        }
        csv.push('\n');
    }
    write_file(&file("_ref.csv"), csv.as_bytes())?;
    let options = format!("StartTime,0.0\nStopTime,{STOP}\nStepSize,{STEP}\nRelTol,1e-10\n");
    write_file(&file("_ref.opt"), options.as_bytes())?;
    if let Some(ramp) = model.ramp {
        let mut csv = head(&["belt_velocity", "normal_force"]);
        let (velocity, force) = inputs(&fmu)?;
        for time in [0.0, STOP] {
            let _ = writeln!(csv, "{time},{},{force}", velocity + ramp * time);
        }
        write_file(&file("_in.csv"), csv.as_bytes())?;
    }
    let readme = format!(
        "{}: {}.\n\nCo-simulation and model exchange in one FMU. Made by `stickslip cross-check`, version {}.\n",
        model.name,
        model.shows,
        env!("CARGO_PKG_VERSION")
    );
    write_file(&folder.join("readme.txt"), readme.as_bytes())
}

fn head(names: &[&str]) -> String {
    let mut line = String::from("\"time\"");
    for name in names {
        let _ = write!(line, ",\"{name}\"");
    }
    line + "\n"
}

/// Start values of belt velocity and normal force.
fn inputs(fmu: &Fmu) -> Result<(f64, f64), Error> {
    let start = |name: &str| Ok(fmu.variable(name)?.start_number().unwrap_or(0.0));
    Ok((start("belt_velocity")?, start("normal_force")?))
}

/// The run of a model. A ramp is stepped finely, with its value held in the middle of each step.
fn simulate(fmu: &Fmu, model: &Model) -> Result<Trajectory, Error> {
    const PARTS: usize = 50;
    let (belt_velocity, normal_force) = inputs(fmu)?;
    let point = OperatingPoint {
        belt_velocity,
        normal_force,
        settings: Vec::new(),
        ..OperatingPoint::default()
    };
    let mut instance = fmu.instantiate(model.name)?;
    point.start(fmu, &mut instance)?;
    let steps = (STOP / STEP).round() as usize;
    let Some(ramp) = model.ramp else {
        return record(fmu, &mut instance, &OUTPUTS, STEP, steps);
    };
    let velocity = fmu.real_references(&["belt_velocity"])?;
    let mut all = record(fmu, &mut instance, &OUTPUTS, STEP, 0)?;
    for i in 0..steps {
        for part in 0..PARTS {
            let at = |part: usize| (i * PARTS + part) as f64 * STEP / PARTS as f64;
            let (from, to) = (at(part), at(part + 1));
            instance.set_real(&velocity, &[belt_velocity + ramp * 0.5 * (from + to)])?;
            instance.do_step(from, to - from)?;
        }
        let row = record(fmu, &mut instance, &OUTPUTS, STEP, 0)?;
        all.time.push((i + 1) as f64 * STEP);
        for (values, new) in all.values.iter_mut().zip(row.values) {
            values.extend(new);
        }
    }
    Ok(all)
}
