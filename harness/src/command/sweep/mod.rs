//! `stickslip sweep`: the motions of the model over one or two parameters.

pub mod figures;
mod json;
mod orbits;
mod page;
mod pictures;
pub mod plan;
mod store;
pub mod table;
mod terminal;

use std::path::{Path, PathBuf};

use beam_physics::sweep::{Chain, Rule, Section};
use clap::{Args, ValueEnum};

use super::operating_options::start_values;
use super::progress::Progress;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::output::{print, print_line, write_file};
use crate::provenance::Provenance;
use crate::report::svg_file;
use crate::watch::Watch;
use orbits::Branches;
use plan::{Axis, Plan, Row, StartKind};
use store::Store;

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
    orbits: bool,
    /// FMU whose start values are used [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the table and the coexisting motions as JSON
    #[arg(long)]
    json: bool,
    /// Prepare the folder and print the points as JSON, without computing them (for clusters)
    #[arg(long, conflicts_with = "json")]
    plan: bool,
    /// Folder for sweep.csv, section.csv, sweep.html and sweep.svg
    #[arg(short, long, value_name = "DIR", default_value = "stickslip-sweep")]
    output: PathBuf,
}

/// Peaks that a point may be followed for: some hours of motion, days of computing.
const MOST_PEAKS: usize = 1_000_000;
/// Periods of the stroboscopic section, s: no vibration of a beam is faster, no study lasts longer.
const SHORTEST_PERIOD: f64 = 1e-6;
const LONGEST_PERIOD: f64 = 1e4;
/// Threads that may be started.
const MOST_THREADS: usize = 1024;

/// What a study finds.
#[derive(Debug)]
pub struct Swept {
    /// The table and the coexisting motions.
    pub json: String,
    /// The summary.
    pub text: String,
    /// Displacements in m at the section points, row by row.
    pub section: Vec<Vec<f64>>,
}

/// Runs the command.
///
/// # Errors
/// As [`perform`].
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    if arguments.plan {
        return print_line(planned(arguments)?);
    }
    let progress = Progress::new(Progress::STEPS);
    let found = perform(arguments, &progress);
    progress.finish();
    let found = found?;
    if arguments.json {
        print_line(&found.json)
    } else {
        print(&found.text)?;
        let report = arguments.output.join("sweep.html");
        print_line(format_args!("Report: {}", report.display()))
    }
}

/// The points still to be computed, as JSON, and a folder prepared for them.
///
/// # Errors
/// Names, ranges or folders that can't be used.
pub fn planned(arguments: &Arguments) -> Result<String, Error> {
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let plan = plan_of(arguments, &fmu)?;
    let rows = plan.rows();
    Store::open(&arguments.output, &plan, &rows)?;
    Ok(json::tasks(&plan, &rows, &arguments.output))
}

/// Computes the points of one chain only, on one thread, into the folder of the options: no tables are
/// sorted, nothing is drawn. For clusters, whose workers have folders of their own.
///
/// # Errors
/// As [`perform`]; a chain that the study does not have.
pub fn perform_chain(arguments: &Arguments, chain: usize, watch: &dyn Watch) -> Result<(), Error> {
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let plan = plan_of(arguments, &fmu)?;
    let rows = plan.rows();
    let mut chains = plan.chains(&rows);
    if chain >= chains.len() {
        return Err(Error::Option {
            option: "--plan",
            value: format!("chain {chain}"),
            rule: format!("is not among the {} of this study", chains.len()),
        });
    }
    let mut store = Store::open(&arguments.output, &plan, &rows)?;
    compute_chains(
        &plan,
        &rows,
        vec![chains.swap_remove(chain)],
        &mut store,
        (1, &arguments.output),
        watch,
    )
}

/// Computes the study and writes its files.
///
/// # Errors
/// Names, ranges or folders that can't be used; a disk that is full; a stop by the user. Points that fail are no error:
/// they are in the table with their reasons.
pub fn perform(arguments: &Arguments, watch: &dyn Watch) -> Result<Swept, Error> {
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let plan = plan_of(arguments, &fmu)?;
    let rows = plan.rows();
    let threads = threads(arguments.threads)?;
    let into = |name: &str| arguments.output.join(name);
    let store = compute(&plan, &rows, &arguments.output, threads, watch)?;
    let branches = if arguments.orbits {
        orbits::find(&plan, &rows, &store.done, &store.carried, watch)
    } else {
        Branches::default()
    };
    if arguments.orbits {
        write_file(
            &into("orbits.csv"),
            orbits::orbits_csv(&plan, &branches).as_bytes(),
        )?;
        let bifurcations = orbits::bifurcations_csv(&plan, &branches);
        write_file(&into("bifurcations.csv"), bifurcations.as_bytes())?;
    }
    let section = store.section(&plan, &rows)?;
    let study = Study::new(&plan, &rows, store.done, section, branches);
    let picture = pictures::main(&study);
    write_file(&into("sweep.svg"), svg_file(&picture).as_bytes())?;
    let files: Vec<&Path> = arguments.fmu.as_deref().into_iter().collect();
    let provenance = Provenance::of(&files)?;
    let html = page::html(&study, &provenance);
    write_file(&into("sweep.html"), html.as_bytes())?;
    Ok(Swept {
        json: json::results(&study, &provenance),
        text: terminal::summary(&study),
        section: study.section,
    })
}

/// A finished study.
pub struct Study<'a> {
    /// What was asked for.
    pub plan: &'a Plan,
    /// The rows of its table.
    pub rows: &'a [Row],
    /// What came out, row by row.
    pub results: Vec<table::Result>,
    /// Displacements in m at the section points, row by row.
    pub section: Vec<Vec<f64>>,
    /// Branches of periodic motions, where they were asked for.
    pub branches: Branches,
}

impl<'a> Study<'a> {
    fn new(
        plan: &'a Plan,
        rows: &'a [Row],
        done: Vec<Option<table::Result>>,
        section: Vec<Vec<f64>>,
        branches: Branches,
    ) -> Self {
        let missing = || table::Result::failed("not computed");
        Self {
            plan,
            rows,
            results: done
                .into_iter()
                .map(|r| r.unwrap_or_else(missing))
                .collect(),
            section,
            branches,
        }
    }
}

/// One thread per core, unless the user says how many.
pub fn threads(asked: Option<usize>) -> Result<usize, Error> {
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

/// Computes what is not done yet into `folder`.
///
/// # Errors
/// As [`run`].
pub fn compute(
    plan: &Plan,
    rows: &[Row],
    folder: &Path,
    threads: usize,
    watch: &dyn Watch,
) -> Result<Store, Error> {
    let mut store = Store::open(folder, plan, rows)?;
    let chains = plan.chains(rows);
    compute_chains(plan, rows, chains, &mut store, (threads, folder), watch)?;
    store.sort(plan, rows)?;
    Ok(store)
}

/// Computes what is not done yet of these chains on so many threads; the folder is for messages.
fn compute_chains(
    plan: &Plan,
    rows: &[Row],
    chains: Vec<Chain>,
    store: &mut Store,
    (threads, folder): (usize, &Path),
    watch: &dyn Watch,
) -> Result<(), Error> {
    let of = chains.iter().map(|chain| chain.tasks.len()).sum();
    let left = chains.into_iter().filter_map(|c| remaining(c, store));
    let chains: Vec<Chain> = left.collect();
    let ahead: usize = chains.iter().map(|chain| chain.tasks.len()).sum();
    let mut done = of - ahead;
    let mut problem = None;
    let mut stopped = false;
    watch.step("points", done, of);
    beam_physics::sweep::run(&chains, &plan.rule, threads, |outcome| {
        let motion = outcome.motion.as_ref().map_err(ToString::to_string);
        if let Err(error) = store.add(outcome.id, &rows[outcome.id], motion) {
            problem = Some(error);
            return false;
        }
        done += 1;
        watch.step("points", done, of);
        stopped = watch.stop();
        !stopped
    });
    if let Some(error) = problem {
        return Err(error);
    }
    if stopped && done < of {
        return Err(Error::Stopped {
            what: "points",
            done,
            of,
            folder: folder.into(),
        });
    }
    Ok(())
}

/// A chain without what is done, carrying on from there; `None` where nothing is left.
fn remaining(mut chain: Chain, store: &Store) -> Option<Chain> {
    let is_done = |id: usize| store.done[id].is_some();
    let begun = chain.tasks.iter().take_while(|t| is_done(t.id)).count();
    let before = chain.tasks.drain(..begun).rev();
    chain.carried = before.map(|t| store.carried[t.id].clone()).find_map(|c| c);
    chain.tasks.retain(|t| !is_done(t.id));
    (!chain.tasks.is_empty()).then_some(chain)
}

fn plan_of(arguments: &Arguments, fmu: &Fmu) -> Result<Plan, Error> {
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
            format!("is too few to tell a motion; give {least} or more")
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
            even(from, to, points)
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

/// Even values, rounded to twelve digits so that 0.103 reads as such.
pub fn even(from: f64, to: f64, points: usize) -> Vec<f64> {
    let rounded = |v: f64| format!("{v:.11e}").parse().unwrap_or(v);
    (0..points)
        .map(|i| match i {
            0 => from,
            i if i + 1 == points => to,
            i => rounded(from + (to - from) * i as f64 / (points - 1) as f64),
        })
        .collect()
}
