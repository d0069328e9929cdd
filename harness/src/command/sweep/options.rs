//! Options of `sweep`, and the plan that they ask for.

use std::path::PathBuf;

use beam_physics::sweep::{Rule, Section};
use clap::{Args, ValueEnum};

use super::plan::{self, Axis, Plan, StartKind};
use crate::command::operating_options::start_values;
use crate::error::Error;
use crate::fmu::Fmu;

/// Sections, as the option has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SectionOption {
    /// w' = 0, falling: the peaks of the displacement
    Peak,
    /// The end of each stick
    Release,
    /// Once in each --strobe-period
    Strobe,
}

/// Options of `sweep`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Parameter or input of the FMU to vary; `stickslip simulate --list` shows all
    #[arg(long, value_name = "NAME")]
    parameter: String,
    /// Its lowest value, in the variable's unit
    #[arg(long, value_name = "VALUE", required_unless_present = "values")]
    from: Option<f64>,
    /// Its highest value
    #[arg(long, value_name = "VALUE", required_unless_present = "values")]
    to: Option<f64>,
    /// Number of values, ends included
    #[arg(long, value_name = "N", required_unless_present = "values")]
    points: Option<usize>,
    /// Its values instead of a range, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',',
        conflicts_with_all = ["from", "to", "points"])]
    values: Option<Vec<f64>>,
    /// Second parameter, for a map
    #[arg(long, value_name = "NAME")]
    second_parameter: Option<String>,
    /// Its lowest value
    #[arg(long, value_name = "VALUE", requires = "second_parameter")]
    second_from: Option<f64>,
    /// Its highest value
    #[arg(long, value_name = "VALUE", requires = "second_parameter")]
    second_to: Option<f64>,
    /// Number of its values
    #[arg(long, value_name = "N", requires = "second_parameter")]
    second_points: Option<usize>,
    /// Its values instead of a range, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',',
        requires = "second_parameter", conflicts_with_all = ["second_from", "second_to", "second_points"])]
    second_values: Option<Vec<f64>>,
    /// Value of any other variable, in its unit, or @FILE with one per line; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// How the points start; several separated by commas
    #[arg(
        long,
        value_name = "KIND",
        value_delimiter = ',',
        default_value = "fixed"
    )]
    start: Vec<StartKind>,
    /// Numbers of bends and velocities of the grid of starts
    #[arg(long, value_name = "BENDSxVELOCITIES", default_value = "5x3")]
    grid: String,
    /// Where the motion is looked at
    #[arg(long, value_name = "WHERE", default_value = "peak")]
    section: SectionOption,
    /// Period of the stroboscopic section in s
    #[arg(long, value_name = "S", required_if_eq("section", "strobe"))]
    strobe_period: Option<f64>,
    /// Peaks discarded as transient
    #[arg(long, value_name = "N", default_value_t = 200)]
    settle: usize,
    /// Peaks measured; repeated up to four times while the motion still settles
    #[arg(long, value_name = "N", default_value_t = 200)]
    cycles: usize,
    /// Follow periodic motions as branches, unstable ones too: orbits.csv, bifurcations.csv, dashed lines in the picture
    #[arg(long, conflicts_with_all = ["second_parameter", "plan"])]
    pub(super) orbits: bool,
    /// FMU whose start values are used [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    pub(super) fmu: Option<PathBuf>,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N")]
    pub(super) threads: Option<usize>,
    /// Print the table and the coexisting motions as JSON
    #[arg(long)]
    pub(super) json: bool,
    /// Prepare the folder and print the points as JSON, without computing them (for clusters)
    #[arg(long, conflicts_with = "json")]
    pub(super) plan: bool,
    /// Folder for sweep.csv, section.csv, sweep.html and sweep.svg
    #[arg(short, long, value_name = "DIR", default_value = "stickslip-sweep")]
    pub(super) output: PathBuf,
}

/// Peaks that a point may be followed for: some hours of motion, days of computing.
const MOST_PEAKS: usize = 1_000_000;
/// Periods of the stroboscopic section, s: no vibration of a beam is faster, no study lasts longer.
const SHORTEST_PERIOD: f64 = 1e-6;
const LONGEST_PERIOD: f64 = 1e4;
/// Threads that may be started.
const MOST_THREADS: usize = 1024;

/// One thread per core, unless the user says how many.
pub(super) fn threads(asked: Option<usize>) -> Result<usize, Error> {
    match asked {
        Some(n) if (1..=MOST_THREADS).contains(&n) => Ok(n),
        Some(n) => Err(Error::Option {
            option: "--threads",
            value: n.to_string(),
            rule: format!("is not possible; give 1 to {MOST_THREADS}"),
        }),
        None => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
    }
}

pub(super) fn plan_of(arguments: &Arguments, fmu: &Fmu) -> Result<Plan, Error> {
    let mut base = plan::base(fmu)?;
    let settings = start_values(&arguments.settings)?;
    let mut axes = vec![axis(
        fmu,
        &arguments.parameter,
        ["--from", "--to", "--points", "--values"],
        (arguments.from, arguments.to, arguments.points),
        arguments.values.as_deref(),
    )?];
    if let Some(second) = &arguments.second_parameter {
        if *second == arguments.parameter {
            return Err(Error::SweepVariable {
                name: second.clone(),
                problem: "it is both parameters; give two different ones".into(),
            });
        }
        axes.push(axis(
            fmu,
            second,
            [
                "--second-from",
                "--second-to",
                "--second-points",
                "--second-values",
            ],
            (
                arguments.second_from,
                arguments.second_to,
                arguments.second_points,
            ),
            arguments.second_values.as_deref(),
        )?);
    }
    for (name, value) in &settings {
        if axes.iter().any(|a| a.name == *name) {
            return Err(Error::SweepVariable {
                name: name.clone(),
                problem: "it is varied; leave it out of --set".into(),
            });
        }
        plan::set_checked(&mut base, fmu, name, *value)?;
    }
    let counts = |option: &'static str, value: usize, least: usize| {
        let rule = if value < least {
            format!("is too few to classify a motion; give {least} or more")
        } else if value > MOST_PEAKS {
            format!("is too many to be computed; give {MOST_PEAKS} or less")
        } else {
            return Ok(());
        };
        Err(Error::Option {
            option,
            value: value.to_string(),
            rule,
        })
    };
    counts("--settle", arguments.settle, 4)?;
    counts("--cycles", arguments.cycles, 10)?;
    let mut starts = arguments.start.clone();
    let mut seen = Vec::new();
    starts.retain(|s| {
        let new = !seen.contains(s);
        seen.push(*s);
        new
    });
    Ok(Plan {
        axes,
        settings,
        starts,
        grid: grid(&arguments.grid)?,
        rule: Rule {
            settle: arguments.settle,
            cycles: arguments.cycles,
            section: section(arguments)?,
            ..Rule::default()
        },
        base,
        guid: fmu.description().guid.clone(),
    })
}

fn section(arguments: &Arguments) -> Result<Section, Error> {
    Ok(match arguments.section {
        SectionOption::Peak => Section::Peak,
        SectionOption::Release => Section::Release,
        SectionOption::Strobe => {
            let period = arguments.strobe_period.unwrap_or_default();
            if !(SHORTEST_PERIOD..=LONGEST_PERIOD).contains(&period) {
                return Err(Error::Option {
                    option: "--strobe-period",
                    value: period.to_string(),
                    rule: format!(
                        "s is no period that can be followed; give {SHORTEST_PERIOD:e} s to {LONGEST_PERIOD:e} s"
                    ),
                });
            }
            Section::Stroboscopic { period }
        }
    })
}

fn grid(text: &str) -> Result<(usize, usize), Error> {
    let parsed = text
        .split_once('x')
        .and_then(|(a, b)| Some((a.parse::<usize>().ok()?, b.parse::<usize>().ok()?)))
        .filter(|(a, b)| (1..=1000).contains(a) && (1..=1000).contains(b));
    parsed.ok_or_else(|| Error::Option {
        option: "--grid",
        value: text.to_owned(),
        rule: "is not two numbers from 1 to 1000; for example --grid 5x3".into(),
    })
}

/// A parameter's values from its options, named `options` for messages.
fn axis(
    fmu: &Fmu,
    name: &str,
    options: [&'static str; 4],
    (from, to, points): (Option<f64>, Option<f64>, Option<usize>),
    list: Option<&[f64]>,
) -> Result<Axis, Error> {
    let unit = fmu.variable(name)?.unit.clone().unwrap_or_default();
    let refuse = |option: &'static str, value: String, rule: String| {
        Err(Error::Option {
            option,
            value,
            rule,
        })
    };
    let values = match list {
        Some([]) => {
            return refuse(
                options[3],
                String::new(),
                "is empty; give numbers separated by commas".into(),
            );
        }
        Some(list) => {
            for (i, value) in list.iter().enumerate() {
                if list[..i].contains(value) {
                    return refuse(
                        options[3],
                        value.to_string(),
                        format!("{unit} is there twice; give each value once"),
                    );
                }
            }
            list.to_vec()
        }
        None => {
            let missing = |option: &'static str| Error::Option {
                option,
                value: String::new(),
                rule: format!("is missing for {name}; give a range or {}", options[3]),
            };
            let from = from.ok_or_else(|| missing(options[0]))?;
            let to = to.ok_or_else(|| missing(options[1]))?;
            let points = points.ok_or_else(|| missing(options[2]))?;
            if from > to {
                return refuse(
                    options[0],
                    from.to_string(),
                    format!(
                        "{unit} lies above {} {to} {unit}; swap them, and use --start down for the way back",
                        options[1]
                    ),
                );
            }
            if points == 0 || points > 1_000_000 {
                return refuse(
                    options[2],
                    points.to_string(),
                    "is not possible; give 1 to 1000000".into(),
                );
            }
            if (points == 1) != (from == to) {
                return refuse(
                    options[2],
                    points.to_string(),
                    format!(
                        "does not fit a range from {from} to {to} {unit}; one value needs equal ends, a range two points or more"
                    ),
                );
            }
            plan::even(from, to, points)
        }
    };
    for value in &values {
        plan::check(fmu, name, *value)?;
    }
    Ok(Axis {
        name: name.into(),
        unit,
        values,
    })
}
