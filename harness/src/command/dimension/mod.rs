//! `stickslip dimension`: correlation dimension of a measured or simulated series.

mod files;
mod page;
pub(super) mod pictures;
pub(super) mod series;
mod terminal;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};

use super::operating_options::OperatingOptions;
use super::progress::Progress;
use crate::dimension::{Analysis, Norm, Settings, analyse};
use crate::error::Error;
use crate::output::{make_folder, print, print_line, write_file};
use crate::provenance::Provenance;
use crate::watch::Watch;

pub use series::Series;

/// Norms, as the option has them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum NormOption {
    /// Largest difference of a component; the fastest
    Max,
    /// Root of the sum of squares
    Euclid,
}

/// Options of `dimension`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// CSV file with the series, one sample per line; a first column of times, if named time or time_s, gives the sampling
    #[arg(
        value_name = "SERIES.csv",
        required_unless_present = "fmu",
        conflicts_with = "fmu"
    )]
    series: Option<PathBuf>,
    /// Column of the CSV file [default: tip_displacement_m, tip_displacement, or the only one beside the time]
    #[arg(long, value_name = "NAME")]
    column: Option<String>,
    /// FMU to simulate instead of reading a series; "own" is this repository's StickSlipBeam, packed on the spot
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    #[command(flatten)]
    at: OperatingOptions,
    /// Output of the FMU to analyse
    #[arg(long, value_name = "NAME", default_value = "tip_displacement")]
    variable: String,
    /// Samples to simulate; with --fmu
    #[arg(long, value_name = "N", default_value_t = 15_000)]
    samples: usize,
    /// Sample interval in s; with --fmu
    #[arg(long, value_name = "S", default_value_t = 2.5e-4)]
    step: f64,
    /// Time to simulate before the first sample, in s; with --fmu
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    settle: f64,
    /// Add white noise this many dB below the standard deviation of the series
    #[arg(long, value_name = "DB")]
    noise_db: Option<f64>,
    /// Delay in samples [default: first minimum of the mutual information]
    #[arg(long, value_name = "N")]
    delay: Option<usize>,
    /// Theiler window in samples [default: from the space-time separation]
    #[arg(long, value_name = "N")]
    theiler: Option<usize>,
    /// Largest embedding dimension, 4 to 30
    #[arg(long, value_name = "M", default_value_t = 10)]
    max_dimension: usize,
    /// How the distance of two delay vectors is measured
    #[arg(long, value_enum, default_value = "max")]
    norm: NormOption,
    /// Smallest and largest radius of the scaling region, in the unit of the series, as LOW,HIGH [default: found]
    #[arg(long, value_name = "LOW,HIGH", value_delimiter = ',', num_args = 2)]
    region: Option<Vec<f64>>,
    /// Every N-th vector only is the first of a pair; 1 counts all pairs [default: 1, the delay above 60000 samples]
    #[arg(long, value_name = "N")]
    thin: Option<usize>,
    /// Surrogate series to compare with, 19 to 999
    #[arg(long, value_name = "N", default_value_t = 39)]
    surrogates: usize,
    /// Seed of surrogates, noise and dither
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Add even noise of one step's width to a rounded series
    #[arg(long)]
    dither: bool,
    /// Folder for dimension.json, correlation_sum.csv and dimension.html
    #[arg(short, long, value_name = "DIR", default_value = "dimension")]
    output: PathBuf,
    /// Print dimension.json instead of the summary
    #[arg(long)]
    json: bool,
}

/// What is said of a series.
pub struct Analysed {
    /// The series.
    pub series: Series,
    /// The whole.
    pub analysis: Analysis,
    /// dimension.json.
    pub json: String,
    /// The summary.
    pub text: String,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let progress = Progress::new(Progress::SHARE);
    let found = perform(arguments, &progress);
    progress.finish();
    let found = found?;
    if arguments.json {
        print_line(&found.json)
    } else {
        print(&found.text)?;
        let report = arguments.output.join("dimension.html");
        print_line(format_args!("Report: {}", report.display()))
    }
}

/// Analyses and writes the files.
///
/// # Errors
/// Options or a series that can't be used, an FMU that gives up, a folder that can't be written.
pub fn perform(arguments: &Arguments, watch: &dyn Watch) -> Result<Analysed, Error> {
    let series = series::get(arguments)?;
    let settings = Settings {
        delay: arguments.delay,
        theiler: arguments.theiler,
        max_dimension: arguments.max_dimension,
        norm: match arguments.norm {
            NormOption::Max => Norm::Maximum,
            NormOption::Euclid => Norm::Euclidean,
        },
        thin: arguments.thin,
        region: arguments.region.as_ref().map(|r| (r[0], r[1])),
        surrogates: arguments.surrogates,
        seed: arguments.seed,
        dither: arguments.dither,
    };
    let analysis =
        analyse(&series.values, &settings, watch).map_err(|source| Error::Dimension {
            series: series.name.clone(),
            source,
        })?;
    make_folder(&arguments.output)?;
    let into = |name: &str| arguments.output.join(name);
    let file = arguments.series.as_deref().or(arguments.fmu.as_deref());
    let read = file.filter(|file| *file != Path::new("own"));
    let provenance = Provenance::of(&read.into_iter().collect::<Vec<_>>())?;
    let json = files::json(&series, &analysis, &provenance);
    write_file(&into("dimension.json"), json.as_bytes())?;
    write_file(
        &into("correlation_sum.csv"),
        files::sums(&analysis).as_bytes(),
    )?;
    let page = page::html(&series, &analysis, &provenance);
    write_file(&into("dimension.html"), page.as_bytes())?;
    Ok(Analysed {
        text: terminal::summary(&series, &analysis),
        series,
        analysis,
        json,
    })
}
