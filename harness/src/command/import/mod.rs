//! `stickslip import`: loggers' files as a campaign folder.

mod list;
mod toml_file;

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::new_folder::{self, must_be_free};
use crate::error::Error;
use crate::file_kind::{Wanted as Kind, explain};
use crate::measurement::Campaign;
use crate::measurement::logger::{self, Imported, Input, Source, Wanted};
use crate::output::print;

pub use toml_file::Entry;

/// Options of `import`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Files of loggers, one run each: CSV, MATLAB (.mat), HDF5, UFF/UNV (data set 58), WAV, Parquet, TDMS
    #[arg(value_name = "FILE", required = true)]
    files: Vec<PathBuf>,
    /// Folder to write: campaign.toml and a CSV for each run; new or empty
    #[arg(short, long, value_name = "CAMPAIGN", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// Show the channels of each file instead: name, unit, samples, rate, range
    #[arg(long)]
    list: bool,
    /// Channel of times [default: found by name and unit, or the file's sample rate]
    #[arg(long, value_name = "NAME", conflicts_with = "rate")]
    time: Option<String>,
    /// Samples per second, for files without times
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Channel of the tip displacement [default: found by unit and name]
    #[arg(long, value_name = "NAME")]
    displacement: Option<String>,
    /// Channel of the tip velocity, where a vibrometer measured that in place of a displacement
    #[arg(long, value_name = "NAME", conflicts_with = "displacement")]
    velocity: Option<String>,
    /// Channel of the tip acceleration, where an accelerometer measured that in place of a displacement
    #[arg(long, value_name = "NAME", conflicts_with_all = ["displacement", "velocity"])]
    acceleration: Option<String>,
    /// Belt velocity: a value in m/s (0 without a belt), a channel, or mean:CHANNEL; separated by commas, one for each file
    #[arg(
        long,
        value_name = "V|NAME",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    belt_velocity: Vec<String>,
    /// Normal force: a value in N (0 without contact), a channel, or mean:CHANNEL; separated by commas, one for each file
    #[arg(
        long,
        value_name = "F|NAME",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    normal_force: Vec<String>,
    /// Force on the tip (shaker, hammer, motor): a channel, or a value in N
    #[arg(
        long,
        value_name = "NAME",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    external_force: Vec<String>,
    /// Acceleration of the clamp, to which displacements are relative: a channel, or a value in m/s^2
    #[arg(
        long,
        value_name = "NAME",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    clamp_acceleration: Vec<String>,
    /// Unit in place of the file's, as mm: of the displacement (velocity, acceleration), or of CHANNEL; may be repeated
    #[arg(long, value_name = "[CHANNEL=]UNIT")]
    unit: Vec<String>,
    /// Factor behind the unit (m per V, -1 turns the sign): of the displacement (velocity, acceleration), or of CHANNEL; may be repeated
    #[arg(long, value_name = "[CHANNEL=]FACTOR", allow_hyphen_values = true)]
    scale: Vec<String>,
    /// First time that is taken, in s of the file
    #[arg(long, value_name = "S")]
    start: Option<f64>,
    /// Last time that is taken, in s of the file
    #[arg(long, value_name = "S")]
    end: Option<f64>,
    /// Leave out samples that are no numbers (NaN, empty), as gaps
    #[arg(long)]
    skip_missing: bool,
    /// TOML file with [beam], as in a campaign.toml: what is known of the structure
    #[arg(long, value_name = "FILE")]
    beam: Option<PathBuf>,
    /// Name of the campaign [default: the folder's]
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    if arguments.list {
        return arguments
            .files
            .iter()
            .try_for_each(|file| list::show(&logger::read(file)?));
    }
    print(&perform(arguments)?)
}

/// Imports and writes the campaign; tells what was understood.
///
/// # Errors
/// Options or files that can't be used, a folder that is not empty or can't be written.
pub fn perform(arguments: &Arguments) -> Result<String, Error> {
    let Some(output) = &arguments.output else {
        return Err(Error::Usage {
            problem: "import needs -o CAMPAIGN, the folder to write".into(),
        });
    };
    must_be_free(output)?;
    let beam = arguments.beam.as_deref().map(beam_of).transpose()?;
    let wanted = wanted(arguments)?;
    let (mut runs, mut told) = (Vec::new(), String::new());
    for (file, wanted) in arguments.files.iter().zip(&wanted) {
        let run = logger::read(file)?.import(wanted)?;
        let name = file.file_name().unwrap_or(file.as_os_str());
        let _ = writeln!(told, "{}: {}", name.display(), run.understood);
        runs.push(run);
    }
    let stems = arguments.files.iter().map(|file| {
        let stem = file.file_stem().unwrap_or(file.as_os_str());
        stem.to_string_lossy().into_owned()
    });
    let names = run_names(stems);
    let sources: Vec<Entry> = names
        .iter()
        .zip(&arguments.files)
        .zip(&runs)
        .map(|((name, file), run)| Entry { name, file, run })
        .collect();
    write(output, arguments.name.as_deref(), beam.as_deref(), &sources)?;
    let samples: usize = runs.iter().map(|run| run.time.len()).sum();
    let place = output.display();
    let _ = writeln!(
        told,
        "{place}: {} run(s), {samples} samples. Next: stickslip check {place}",
        runs.len()
    );
    if beam.is_none() {
        told += "Fill in [beam] in campaign.toml before `diagnose`: nothing is known of the structure yet.\n";
    }
    Ok(told)
}

/// Writes a campaign of these runs; `beam` is the text of the tables [`beam_of_text`] keeps. Without a name it has the
/// folder's.
///
/// # Errors
/// A folder that is not empty or can't be written; runs that can't be used, of which nothing is left behind.
pub fn write(
    output: &Path,
    name: Option<&str>,
    beam: Option<&str>,
    runs: &[Entry],
) -> Result<(), Error> {
    let folder = output.file_name().unwrap_or(output.as_os_str());
    let folder = folder.to_string_lossy();
    let title = name.unwrap_or(&folder);
    let mut files = vec![(
        "campaign.toml".to_owned(),
        toml_file::text(title, beam, runs).into_bytes(),
    )];
    for Entry { name, run, .. } in runs {
        files.push((format!("{name}.csv"), csv(run).into_bytes()));
    }
    // What `check` and `compare` could not read is not left behind.
    new_folder::write(output, &files, |folder| {
        Campaign::load(folder).map(drop).map_err(|error| {
            let place = format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR);
            Error::LoggerFile {
                path: output.to_owned(),
                channel: None,
                problem: format!(
                    "the campaign can't be used: {}",
                    error.to_string().replace(&place, "")
                ),
                remedy: "nothing was written".into(),
            }
        })
    })
}

/// The run's samples, in SI units and full precision.
fn csv(run: &Imported) -> String {
    let inputs = [
        ("belt_velocity_m_per_s", Some(&run.belt_velocity)),
        ("normal_force_n", Some(&run.normal_force)),
        ("external_force_n", run.external_force.as_ref()),
        (
            "clamp_acceleration_m_per_s2",
            run.clamp_acceleration.as_ref(),
        ),
    ];
    let columns: Vec<(&str, &Vec<f64>)> = inputs
        .into_iter()
        .filter_map(|(name, input)| match input {
            Some(Input::Series(values)) => Some((name, values)),
            _ => None,
        })
        .collect();
    let mut text = format!("time_s,{}", run.measurand.usual_column());
    columns
        .iter()
        .for_each(|(name, _)| text.extend([",", name]));
    text.push('\n');
    for (i, (time, value)) in run.time.iter().zip(&run.measured).enumerate() {
        let _ = write!(text, "{time},{value:e}");
        for (_, values) in &columns {
            let _ = write!(text, ",{:e}", values[i]);
        }
        text.push('\n');
    }
    text
}

/// Names made unlike and fit for files on any file system.
pub fn run_names(wanted: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut taken: HashMap<String, usize> = HashMap::new();
    let mut names = Vec::new();
    for name in wanted {
        let fits = |c: char| {
            if c.is_alphanumeric() || "-_.".contains(c) {
                c
            } else {
                '_'
            }
        };
        let name: String = name.chars().map(fits).collect();
        // File systems may take capitals for small letters.
        let count = taken.entry(name.to_lowercase()).or_default();
        *count += 1;
        names.push(match *count {
            1 => name,
            number => format!("{name}_{number}"),
        });
    }
    names
}

/// What to take from each file.
fn wanted(arguments: &Arguments) -> Result<Vec<Wanted>, Error> {
    let count = arguments.files.len();
    let finite = |option: &'static str, value: Option<f64>| match value {
        Some(value) if !value.is_finite() => Err(Error::Option {
            option,
            value: value.to_string(),
            rule: "s is not possible; give a finite time".into(),
        }),
        value => Ok(value),
    };
    if let Some(rate) = arguments.rate
        && !(rate > 0.0 && rate <= 1e12)
    {
        return Err(Error::Option {
            option: "--rate",
            value: rate.to_string(),
            rule: "Hz is not possible; give samples per second, greater than zero".into(),
        });
    }
    let plain = Wanted {
        time: arguments.time.clone(),
        displacement: arguments.displacement.clone(),
        velocity: arguments.velocity.clone(),
        acceleration: arguments.acceleration.clone(),
        rate: arguments.rate,
        units: arguments
            .unit
            .iter()
            .map(|text| unit(text))
            .collect::<Result<_, _>>()?,
        scales: arguments
            .scale
            .iter()
            .map(|text| scale(text))
            .collect::<Result<_, _>>()?,
        skip_missing: arguments.skip_missing,
        start: finite("--start", arguments.start)?,
        end: finite("--end", arguments.end)?,
        ..Wanted::default()
    };
    let each = |option: &'static str, given: &[String]| -> Result<Vec<Option<Source>>, Error> {
        let sources: Vec<Option<Source>> = given
            .iter()
            .map(|text| source(option, text).map(Some))
            .collect::<Result<_, _>>()?;
        match sources.len() {
            0 => Ok(vec![None; count]),
            1 => Ok(vec![sources[0].clone(); count]),
            n if n == count => Ok(sources),
            n => Err(Error::Option {
                option,
                value: given.join(","),
                rule: format!(
                    "has {n} values for {count} file(s); give one for all or one for each"
                ),
            }),
        }
    };
    let belts = each("--belt-velocity", &arguments.belt_velocity)?;
    let loads = each("--normal-force", &arguments.normal_force)?;
    let forces = each("--external-force", &arguments.external_force)?;
    let clamps = each("--clamp-acceleration", &arguments.clamp_acceleration)?;
    let driven = belts.into_iter().zip(loads);
    let excited = forces.into_iter().zip(clamps);
    Ok(driven
        .zip(excited)
        .map(
            |((belt_velocity, normal_force), (external_force, clamp_acceleration))| Wanted {
                belt_velocity,
                normal_force,
                external_force,
                clamp_acceleration,
                ..plain.clone()
            },
        )
        .collect())
}

fn source(option: &'static str, text: &str) -> Result<Source, Error> {
    let text = text.trim();
    let wrong = |rule: &str| Error::Option {
        option,
        value: format!("'{text}'"),
        rule: rule.to_owned(),
    };
    if text.is_empty() {
        return Err(wrong("is empty; give a value or the name of a channel"));
    }
    if let Some(name) = text.strip_prefix("mean:") {
        return Ok(Source::Mean(name.to_owned()));
    }
    match text.parse::<f64>() {
        Ok(value) if !value.is_finite() => Err(wrong("is not possible; give a finite value")),
        Ok(value) if option == "--normal-force" && value < 0.0 => {
            Err(wrong("N is not possible; it must not be negative"))
        }
        Ok(value) => Ok(Source::Value(value)),
        Err(_) => Ok(Source::Channel(text.to_owned())),
    }
}

/// `mm`, or `laser=mm`.
fn unit(text: &str) -> Result<(Option<String>, String), Error> {
    let (channel, unit) = named(text);
    if logger::is_unit(unit) {
        return Ok((channel, unit.to_owned()));
    }
    Err(Error::Option {
        option: "--unit",
        value: format!("'{text}'"),
        rule:
            "is no unit known; give one such as mm, um, m/s, N, ms, alone or as CHANNEL=UNIT, or \
               a factor with --scale"
                .into(),
    })
}

/// `1e-4`, or `laser=1e-4`.
fn scale(text: &str) -> Result<(Option<String>, f64), Error> {
    let (channel, factor) = named(text);
    match factor.trim().parse::<f64>() {
        Ok(factor) if factor.is_finite() && factor != 0.0 => Ok((channel, factor)),
        _ => Err(Error::Option {
            option: "--scale",
            value: format!("'{text}'"),
            rule: "is no factor; give a finite number other than zero, alone or as CHANNEL=FACTOR"
                .into(),
        }),
    }
}

fn named(text: &str) -> (Option<String>, &str) {
    match text.rsplit_once('=') {
        Some((channel, value)) => (Some(channel.trim().to_owned()), value.trim()),
        None => (None, text.trim()),
    }
}

/// The tables `[beam]`, `[uncertainty]` and `[rig]` of a TOML file, as text.
fn beam_of(path: &Path) -> Result<String, Error> {
    beam_of_text(
        &std::fs::read_to_string(path).map_err(Error::read(path))?,
        path,
    )
}

/// The tables `[beam]`, `[uncertainty]` and `[rig]` of a TOML text, as text; `path` is for messages.
///
/// # Errors
/// A text that is not TOML or has no `[beam]`.
pub fn beam_of_text(text: &str, path: &Path) -> Result<String, Error> {
    let wrong = |line: usize, problem: String| {
        let error = Error::CampaignFile {
            path: path.to_owned(),
            line,
            problem,
        };
        explain(error, path, Kind::Beam)
    };
    let parsed: toml::Table = text.parse().map_err(|e: toml::de::Error| {
        let before = e.span().map_or(0, |span| span.start);
        let line = 1 + text.bytes().take(before).filter(|b| *b == b'\n').count();
        wrong(line, e.message().replace('\n', "; "))
    })?;
    if !parsed.contains_key("beam") {
        return Err(wrong(
            1,
            "no table [beam] in this file; give one as in campaign.toml".into(),
        ));
    }
    let kept: toml::Table = parsed
        .into_iter()
        .filter(|(key, value)| {
            ["beam", "uncertainty", "rig"].contains(&key.as_str()) && value.is_table()
        })
        .collect();
    toml::to_string(&kept).map_err(|e| wrong(1, e.to_string()))
}
