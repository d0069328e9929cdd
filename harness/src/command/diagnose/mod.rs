//! `stickslip diagnose`: which physical effect the model lacks, from a measured campaign.

mod report;
mod search;
mod terminal;

use crate::command::given_campaign::Forced;
use crate::command::progress::Progress;
use crate::command::{given_campaign, pack};
use crate::diagnose::data::hold_out::HoldOut;
use crate::diagnose::result::diagnosis::Diagnosis;
use crate::diagnose::selection::by_chance::gains_by_chance;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::Campaign;
use crate::output::{make_folder, print, print_line, tell};
use crate::watch::Watch;
use clap::Args;
use std::ops::Range;
use std::path::PathBuf;

pub use report::{report, written_json};
use search::searched;
pub use search::{Null, Search, UNFINISHED, diagnose};
use terminal::costs;
pub use terminal::terminal;

/// Options of `diagnose`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder with campaign.toml and the CSV files, or the path of campaign.toml
    #[arg(value_name = "CAMPAIGN")]
    campaign: PathBuf,
    /// FMU to diagnose, one of another make with its <name>.effects.toml beside it [default: this repository's StickSlipBeam,
    /// packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Folder for diagnosis.json, report.html, model.toml, the .ssv and the repaired .fmu
    #[arg(short, long, value_name = "DIR", default_value = "diagnosis")]
    output: PathBuf,
    /// Which runs are kept out of every fit, to be forecast
    #[arg(long, value_enum, default_value_t)]
    hold_out: HoldOut,
    /// Folder of effects of your own (TOML, as for pack --effect) that take part
    #[arg(long, value_name = "DIR")]
    library: Option<PathBuf>,
    /// Campaigns without the effect to simulate and search in full, for the chance that the gain is chance; each takes about
    /// as long as the search itself
    #[arg(long, value_name = "COUNT", default_value_t = 0)]
    null: usize,
    /// Print diagnosis.json instead of the summary
    #[arg(long)]
    json: bool,
    /// Tell on standard error how long each stage took and what was computed
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    forced: Forced,
}

impl Arguments {
    /// diagnosis.json, as it was written.
    ///
    /// # Errors
    /// A file that can't be read.
    pub fn written_json(&self) -> Result<String, Error> {
        written_json(&self.output)
    }
}

/// Campaigns that may be simulated for the chance of a gain by chance: enough for one in a thousand.
const MOST_NULL: usize = 10_000;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let progress = Progress::new(Progress::STAGES);
    let diagnosis = perform(arguments, &progress);
    progress.finish();
    let diagnosis = diagnosis?;
    if arguments.verbose {
        tell(costs(&progress, &diagnosis).trim_end());
    }
    if progress.stop() {
        tell(format_args!(
            "Stopped before the end. What was fitted is kept in {}: the same command goes on from there.",
            arguments.output.join(UNFINISHED).display()
        ));
    }
    if arguments.json {
        print_line(arguments.written_json()?)
    } else {
        print(&terminal(&diagnosis))?;
        let report = arguments.output.join("report.html");
        print_line(format_args!("Report: {}", report.display()))
    }
}

/// Diagnoses and writes everything into the folder of the options. A stop ends it early, with what was
/// found until then.
///
/// # Errors
/// Options, a campaign or an FMU that can't be used; a folder that can't be written.
pub fn perform(arguments: &Arguments, watch: &dyn Watch) -> Result<Diagnosis, Error> {
    perform_with(arguments, Null::Simulate(arguments.null), watch)
}

/// The same with gains by chance found in this way, whatever the options say of them.
///
/// # Errors
/// As [`perform`].
pub fn perform_with(
    arguments: &Arguments,
    null: Null,
    watch: &dyn Watch,
) -> Result<Diagnosis, Error> {
    let (fmu, campaign, search) = given(arguments, null)?;
    diagnose(&fmu, &campaign, &search, &arguments.output, watch)
}

/// For each step of the diagnosis, the largest gains by chance in those of the simulated campaigns that `which`
/// numbers. The search goes before; fits that lie in the folder of the options are not made again.
///
/// # Errors
/// As [`perform`].
pub fn perform_null(
    arguments: &Arguments,
    which: Range<usize>,
    watch: &dyn Watch,
) -> Result<Vec<Vec<f64>>, Error> {
    let (fmu, campaign, search) = given(arguments, Null::Later)?;
    searched(
        &fmu,
        &campaign,
        &search,
        &arguments.output,
        watch,
        |problem, selection| gains_by_chance(problem, selection, which, watch),
    )
}

/// What the options say, and the folder of results.
fn given(arguments: &Arguments, null: Null) -> Result<(Fmu, Campaign, Search), Error> {
    if arguments.null > MOST_NULL {
        return Err(Error::Option {
            option: "--null",
            value: arguments.null.to_string(),
            rule: format!("campaigns would take months; give {MOST_NULL} or less"),
        });
    }
    let campaign = given_campaign::load(&arguments.campaign, arguments.forced)?;
    make_folder(&arguments.output)?;
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let search = Search {
        null,
        hold_out: arguments.hold_out,
        library: match &arguments.library {
            Some(folder) => pack::own_effects::of_folder(folder)?,
            None => Vec::new(),
        },
    };
    Ok((fmu, campaign, search))
}
