//! `stickslip compare`: an FMU at every operating point of a measured campaign, and where they differ.

mod comparison;
mod driven_motion;
mod follow;
mod from_start_states;
mod further;
mod measured_start;
mod model_motion;
mod page;
mod pictures;
mod terminal;

use std::path::{Path, PathBuf};

use clap::Args;
use comparison::compare_run;

pub use comparison::{Curves, RunComparison};
use from_start_states::Held;
use further::Further;
pub use further::FurtherComparison;

use super::given_campaign::{self, Forced};
use super::operating_options::start_values;
use super::progress::Progress;
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

/// What a comparison finds.
#[derive(Debug)]
pub struct Compared {
    /// The runs, worst first.
    pub runs: Vec<RunComparison>,
    /// comparison.json.
    pub json: String,
    /// The table.
    pub text: String,
    limit: Option<f64>,
}

impl Compared {
    /// Whether the worst run keeps the limit of `--fail-above`.
    ///
    /// # Errors
    /// [`Error::GateFailed`] with the run.
    pub fn gate(&self) -> Result<(), Error> {
        match (self.runs.first(), self.limit) {
            (Some(worst), Some(limit)) if worst.exceeds(limit) => Err(Error::GateFailed {
                run: worst.name.clone(),
                value: worst.nrmse,
                limit,
            }),
            _ => Ok(()),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let progress = Progress::new(Progress::SHARE);
    let found = perform(arguments, &progress);
    progress.finish();
    let found = found?;
    if arguments.json {
        print_line(&found.json)?;
    } else {
        let report = arguments.output.join("report.html");
        print(&found.text)?;
        print_line(format_args!("Report: {}", report.display()))?;
    }
    found.gate()
}

/// Compares and writes report.html and comparison.json.
///
/// # Errors
/// Options, a campaign or an FMU that can't be used; a folder that can't be written; a stop.
pub fn perform(arguments: &Arguments, watch: &dyn Watch) -> Result<Compared, Error> {
    let limit = arguments.fail_above.map(positive).transpose()?;
    let settings = start_values(&arguments.settings)?;
    let campaign = given_campaign::load(&arguments.campaign, arguments.forced)?;
    // Before the work, so that a folder that cannot be made costs no time.
    make_folder(&arguments.output)?;
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    refuse_inputs(&fmu, &settings)?;
    let comparisons = compare(&fmu, &campaign, &settings, watch)?;

    let json = write_files(&fmu, &campaign, &comparisons, limit, &arguments.output)?;
    Ok(Compared {
        text: terminal::table(&campaign, &comparisons, limit),
        runs: comparisons,
        json,
        limit,
    })
}

/// Compares every run and writes report.html and comparison.json into `output`; prints nothing.
///
/// # Errors
/// An FMU that can't be run, or a folder that can't be written.
pub fn into_folder(fmu: &Fmu, campaign: &Campaign, output: &Path) -> Result<(), Error> {
    make_folder(output)?;
    let comparisons = compare(fmu, campaign, &[], &())?;
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
    let provenance = Provenance::of_campaign(campaign, Some(fmu))?;
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
    watch: &dyn Watch,
) -> Result<Vec<RunComparison>, Error> {
    if !campaign.beam.sensor.is_tip() {
        // Another FMU would be compared as if its sensor were there.
        fmu.variable("mode[1].sensor_ratio")?;
    }
    let samples = |run: &Run| run.time.len();
    let all = campaign.runs.iter().map(samples).sum();
    let held = Held::by(fmu)?;
    let further = Further::of(fmu, campaign)?;
    let (mut comparisons, mut before) = (Vec::new(), 0);
    for run in &campaign.runs {
        if watch.stop() {
            return Err(Error::Interrupted {
                what: "runs compared",
                done: comparisons.len(),
                of: campaign.runs.len(),
            });
        }
        let inside = InsideRun {
            watch,
            run,
            before,
            all,
        };
        inside.step("", 0, 1);
        comparisons.push(compare_run(
            fmu,
            &campaign.beam,
            (run, &further),
            (&held, settings),
            &inside,
        )?);
        before += samples(run);
    }
    // A run that cannot be scored (NaN) is the worst.
    comparisons.sort_by(|a, b| b.nrmse.total_cmp(&a.nrmse));
    Ok(comparisons)
}

/// The work on one run as a share of all; it counts samples.
struct InsideRun<'a> {
    watch: &'a dyn Watch,
    run: &'a Run,
    before: usize,
    all: usize,
}

impl Watch for InsideRun<'_> {
    fn step(&self, _: &str, done: usize, of: usize) {
        let share = done as f64 / of.max(1) as f64;
        let at = self.before + (share * self.run.time.len() as f64) as usize;
        self.watch.step(&self.run.name, at, self.all);
    }
    fn stop(&self) -> bool {
        self.watch.stop()
    }
}

#[derive(serde::Serialize)]
struct Summary<'a> {
    campaign: &'a str,
    fmu: &'a str,
    runs: &'a [RunComparison],
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
