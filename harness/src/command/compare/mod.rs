//! `stickslip compare`: an FMU at every operating point of a measured campaign, and where they differ.

mod comparison;
mod driven_motion;
mod follow;
mod from_start_states;
mod model_motion;
mod page;
mod pictures;
mod terminal;

use std::path::{Path, PathBuf};

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use comparison::compare_run;

pub use comparison::RunComparison;
use from_start_states::Held;

use super::given_campaign::{self, Forced};
use super::operating_options::start_values;
use crate::error::Error;
use crate::fmu::{Causality, Fmu};
use crate::measurement::{Campaign, Run};
use crate::output::{make_folder, print, print_line, write_file};
use crate::provenance::Provenance;
use crate::watch::Watch;

/// Options of `compare`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder with campaign.toml and the CSV files, or the path of campaign.toml
    #[arg(value_name = "CAMPAIGN")]
    campaign: PathBuf,
    /// FMU to compare [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Folder for report.html and comparison.json
    #[arg(short, long, value_name = "DIR", default_value = "comparison")]
    output: PathBuf,
    /// Print comparison.json instead of the table
    #[arg(long)]
    json: bool,
    /// Start value of any variable of the FMU but its inputs, in the variable's unit, or @FILE with one per line; may be
    /// repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Exit with code 1 if any run's NRMSE is above this
    #[arg(long, value_name = "NRMSE")]
    fail_above: Option<f64>,
    #[command(flatten)]
    forced: Forced,
}

impl Arguments {
    /// Plain comparison, without a gate.
    pub fn of(campaign: PathBuf, fmu: Option<PathBuf>, output: PathBuf) -> Arguments {
        Arguments {
            campaign,
            fmu,
            output,
            json: false,
            settings: Vec::new(),
            fail_above: None,
            forced: Forced::default(),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let limit = arguments.fail_above.map(positive).transpose()?;
    let settings = start_values(&arguments.settings)?;
    let campaign = given_campaign::load(&arguments.campaign, arguments.forced)?;
    // Before the work, so that a folder that cannot be made costs no time.
    make_folder(&arguments.output)?;
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    refuse_inputs(&fmu, &settings)?;
    let comparisons = compare(&fmu, &campaign, &settings)?;

    let json = write_files(&fmu, &campaign, &comparisons, limit, &arguments.output)?;
    if arguments.json {
        print_line(json)?;
    } else {
        print(&terminal::table(&campaign, &comparisons, limit))?;
        let report = arguments.output.join(REPORT);
        print_line(format_args!("Report: {}", report.display()))?;
    }
    gate(&comparisons, limit)
}

/// Compares every run and writes report.html and comparison.json into `output`; prints nothing.
///
/// # Errors
/// An FMU that can't be run, or a folder that can't be written.
pub fn into_folder(fmu: &Fmu, campaign: &Campaign, output: &Path) -> Result<(), Error> {
    make_folder(output)?;
    let comparisons = compare(fmu, campaign, &[])?;
    write_files(fmu, campaign, &comparisons, None, output).map(drop)
}

/// Writes both files; the JSON text.
fn write_files(
    fmu: &Fmu,
    campaign: &Campaign,
    comparisons: &[RunComparison],
    limit: Option<f64>,
    output: &Path,
) -> Result<String, Error> {
    let provenance = Provenance::of_campaign(campaign, fmu.path())?;
    let json = provenance.json(&Summary {
        campaign: &campaign.name,
        fmu: &fmu.description().model_name,
        runs: comparisons,
    });
    write_file(&output.join("comparison.json"), json.as_bytes())?;
    write_file(
        &output.join(REPORT),
        page::html(fmu, campaign, comparisons, limit, &provenance).as_bytes(),
    )?;
    Ok(json)
}

/// The page.
const REPORT: &str = "report.html";

/// The campaign says what drives each run.
fn refuse_inputs(fmu: &Fmu, settings: &[(String, f64)]) -> Result<(), Error> {
    for (name, value) in settings {
        if fmu.variable(name)?.causality == Causality::Input {
            return Err(Error::Option {
                option: "--set",
                value: format!("{name}={value}"),
                rule: "is an input, which campaign.toml states for each run; change it there"
                    .into(),
            });
        }
    }
    Ok(())
}

/// Compares every run, worst first, with these start values beside what is known of the beam.
pub fn compare(
    fmu: &Fmu,
    campaign: &Campaign,
    settings: &[(String, f64)],
) -> Result<Vec<RunComparison>, Error> {
    // Hidden by itself where standard error is no terminal.
    let style = ProgressStyle::with_template(
        "{elapsed_precise} {bar:30} {percent} % {msg} (about {eta} left)",
    )
    .expect("the template is valid");
    let samples = |run: &Run| run.time.len() as u64;
    let bar = ProgressBar::new(campaign.runs.iter().map(samples).sum()).with_style(style);
    let held = Held::by(fmu)?;
    let (mut comparisons, mut before) = (Vec::new(), 0);
    for run in &campaign.runs {
        bar.set_message(run.name.clone());
        let inside = InsideRun {
            bar: &bar,
            before,
            samples: samples(run),
        };
        comparisons.push(compare_run(
            fmu,
            &campaign.beam,
            run,
            (&held, settings),
            &inside,
        )?);
        before += samples(run);
        bar.set_position(before);
    }
    bar.finish_and_clear();
    // A run that cannot be scored (NaN) is the worst.
    comparisons.sort_by(|a, b| b.nrmse.total_cmp(&a.nrmse));
    Ok(comparisons)
}

/// The bar while one run is in work; it counts samples.
struct InsideRun<'a> {
    bar: &'a ProgressBar,
    before: u64,
    samples: u64,
}

impl Watch for InsideRun<'_> {
    fn step(&self, _: &str, done: usize, of: usize) {
        let share = done as f64 / of.max(1) as f64;
        let at = self.before + (share * self.samples as f64) as u64;
        self.bar.set_position(at);
    }
    fn stop(&self) -> bool {
        false
    }
}

#[derive(serde::Serialize)]
struct Summary<'a> {
    campaign: &'a str,
    fmu: &'a str,
    runs: &'a [RunComparison],
}

fn gate(comparisons: &[RunComparison], limit: Option<f64>) -> Result<(), Error> {
    match (comparisons.first(), limit) {
        (Some(worst), Some(limit)) if worst.exceeds(limit) => Err(Error::GateFailed {
            run: worst.name.clone(),
            value: worst.nrmse,
            limit,
        }),
        _ => Ok(()),
    }
}

fn positive(limit: f64) -> Result<f64, Error> {
    if limit > 0.0 {
        return Ok(limit);
    }
    Err(Error::Option {
        option: "--fail-above",
        value: limit.to_string(),
        rule: "is not possible; give a number greater than zero, 0.1 is a good match".into(),
    })
}
