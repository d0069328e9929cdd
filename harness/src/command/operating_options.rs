//! The options that choose an operating point and start values, the same for every command that has them.

use std::path::Path;

use clap::Args;

use crate::error::Error;
use crate::file_kind::{Wanted, explain};

/// Belt velocity where none is given, m/s.
const BELT_VELOCITY: f64 = 0.1;
/// Normal force where none is given, N.
const NORMAL_FORCE: f64 = 100.0;

/// The options.
#[derive(Debug, Args)]
pub struct OperatingOptions {
    /// Belt velocity in m/s, any sign; also as --set belt_velocity=... [default: 0.1; none in observe]
    #[arg(long, value_name = "M/S")]
    belt_velocity: Option<f64>,
    /// Normal force in N; also as --set normal_force=... [default: 100; none in observe]
    #[arg(long, value_name = "N")]
    normal_force: Option<f64>,
    /// Start value of any variable of the FMU, in the variable's unit, or @FILE with one per line; may be repeated
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
}

/// What the options say.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// Belt velocity, m/s, where it is given.
    pub belt_velocity: Option<f64>,
    /// Normal force, N, where it is given.
    pub normal_force: Option<f64>,
    /// The other start values, by variable name.
    pub settings: Vec<(String, f64)>,
}

impl Said {
    /// Belt velocity, m/s, and normal force, N, with the usual values where none are given.
    pub fn load(&self) -> (f64, f64) {
        (
            self.belt_velocity.unwrap_or(BELT_VELOCITY),
            self.normal_force.unwrap_or(NORMAL_FORCE),
        )
    }
}

impl OperatingOptions {
    /// Whether any of them is given.
    pub fn is_given(&self) -> bool {
        self.belt_velocity.is_some() || self.normal_force.is_some() || !self.settings.is_empty()
    }

    /// Takes the two ways to give belt velocity and normal force together. Of several `--set` of one name the last counts.
    ///
    /// # Errors
    /// [`Error::Option`]: a `--set` that can't be read, or two ways that contradict each other.
    pub fn read(&self) -> Result<Said, Error> {
        let mut settings = start_values(&self.settings)?;
        let mut take = |name: &str| {
            let last = settings.iter().rfind(|(n, _)| n == name).map(|(_, v)| *v);
            settings.retain(|(n, _)| n != name);
            last
        };
        let velocity = take("belt_velocity");
        let force = take("normal_force");
        Ok(Said {
            belt_velocity: one("--belt-velocity", self.belt_velocity, velocity, "m/s")?,
            normal_force: one("--normal-force", self.normal_force, force, "N")?,
            settings,
        })
    }
}

/// The value that the option and `--set` agree on.
fn one(
    option: &'static str,
    own: Option<f64>,
    set: Option<f64>,
    unit: &str,
) -> Result<Option<f64>, Error> {
    match (own, set) {
        (Some(own), Some(set)) if own != set => {
            let name = option.trim_start_matches("--").replace('-', "_");
            Err(Error::Option {
                option,
                value: own.to_string(),
                rule: format!(
                    "{unit} contradicts --set {name}={set} ({set} {unit}); give one of them"
                ),
            })
        }
        _ => Ok(own.or(set)),
    }
}

/// Start values as `--set` gives them: NAME=VALUE, or @FILE with one per line.
///
/// # Errors
/// A text that is no NAME=VALUE, a file that can't be read.
pub fn start_values(options: &[String]) -> Result<Vec<(String, f64)>, Error> {
    let mut settings = Vec::new();
    for text in options {
        match text.strip_prefix('@') {
            Some(file) => settings.extend(settings_of(Path::new(file))?),
            None => settings.push(setting(text)?),
        }
    }
    Ok(settings)
}

/// Start values from a file: one NAME=VALUE per line; lines that begin with `#` are comments.
fn settings_of(file: &Path) -> Result<Vec<(String, f64)>, Error> {
    let read = || -> Result<Vec<(String, f64)>, Error> {
        let text = std::fs::read_to_string(file).map_err(Error::read(file))?;
        text.lines()
            .map(str::trim)
            .filter(|line| !line.is_empty() && !line.starts_with('#'))
            .map(setting)
            .collect()
    };
    read().map_err(|error| explain(error, file, Wanted::Settings))
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
