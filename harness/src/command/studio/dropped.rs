//! Files dropped on the page: their channels, and a campaign of them by the command `import`.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::Arc;

use axum::body::Bytes;
use axum::extract::{Json, Query, State};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::desk::{Desk, Order};
use super::server::Refused;
use crate::cli::{Asked, Command, parse};
use crate::command::{import as importing, new};
use crate::error::Error;
use crate::measurement::logger;
use crate::output::{make_folder, write_file};

/// Folder of dropped files within the output folder.
const FOLDER: &str = "dropped";
/// Folder of the campaigns made of them.
pub const CAMPAIGNS: &str = "imported";
/// Characters of the longest name.
const LONGEST_NAME: usize = 80;

#[derive(Deserialize)]
pub struct Named {
    name: String,
}

/// A channel of a dropped file.
#[derive(Serialize)]
struct Channel {
    name: String,
    unit: String,
    samples: usize,
    least: f64,
    most: f64,
    problem: Option<String>,
}

/// A name that is no path: letters, digits, points, dashes.
fn plain(name: &str) -> String {
    let last = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || ".-_".contains(c);
    let out: String = last
        .chars()
        .map(|c| if is_plain(c) { c } else { '_' })
        .take(LONGEST_NAME)
        .collect();
    match out.trim_start_matches('.') {
        "" => "file".to_owned(),
        rest => rest.to_owned(),
    }
}

/// The templates of structures.
pub async fn templates() -> Json<Value> {
    let list: Vec<Value> = new::templates()
        .map(|(name, sentence)| json!({ "name": name, "sentence": sentence }))
        .collect();
    Json(json!(list))
}

/// Takes a file and tells its channels.
pub async fn receive(
    State(desk): State<Arc<Desk>>,
    Query(named): Query<Named>,
    bytes: Bytes,
) -> Result<Json<Value>, Refused> {
    let name = plain(&named.name);
    let folder = desk.output.join(FOLDER);
    let path = folder.join(&name);
    let read = tokio::task::spawn_blocking(move || -> Result<Vec<Channel>, Error> {
        make_folder(&folder)?;
        write_file(&path, &bytes)?;
        let recording = logger::read(&path)?;
        let channel = |c: &logger::Channel| {
            let values = || c.samples().iter().copied().filter(|v| v.is_finite());
            Channel {
                name: c.name.clone(),
                unit: c.unit().to_owned(),
                samples: c.samples().len(),
                least: values().fold(f64::INFINITY, f64::min),
                most: values().fold(f64::NEG_INFINITY, f64::max),
                problem: c.problem(),
            }
        };
        Ok(recording.channels.iter().map(channel).collect())
    });
    let channels = read.await.map_err(internal)??;
    Ok(Json(json!({ "file": name, "channels": channels })))
}

fn internal(error: tokio::task::JoinError) -> Error {
    Error::Internal {
        problem: error.to_string(),
    }
}

/// How files become a campaign.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wanted {
    /// Dropped files, one run each.
    files: Vec<String>,
    /// Name of the campaign.
    name: String,
    /// Template whose structure is taken; none leaves it to the FMU.
    template: Option<String>,
    /// Channel of times; none finds it.
    time: Option<String>,
    /// Samples per second, for files without times.
    rate: Option<f64>,
    /// Channel of the displacement; none finds it, unless one of the next two is given.
    displacement: Option<String>,
    /// Channel of the velocity, where a vibrometer measured that.
    velocity: Option<String>,
    /// Channel of the acceleration, where an accelerometer measured that.
    acceleration: Option<String>,
    /// Its unit; none takes the file's.
    unit: Option<String>,
    /// Belt velocity of each file: a value in m/s or a channel.
    belt_velocity: Vec<String>,
    /// Normal force of each file: a value in N or a channel.
    normal_force: Vec<String>,
}

/// Makes a campaign of dropped files and opens it.
pub async fn import(
    State(desk): State<Arc<Desk>>,
    Json(wanted): Json<Wanted>,
) -> Result<Json<Value>, Refused> {
    let folder = desk.output.join(CAMPAIGNS).join(plain(&wanted.name));
    let line = line(&desk, &wanted, &folder)?;
    let told: Vec<String> = line
        .iter()
        .map(|part| quoted(&part.to_string_lossy()))
        .collect();
    let done = tokio::task::spawn_blocking(move || -> Result<(), Error> {
        match parse(line)? {
            Asked::For(cli) => match cli.command {
                Some(Command::Import(arguments)) => importing::perform(&arguments).map(drop),
                _ => unreachable!("the line begins with the command"),
            },
            Asked::Text(text) => Err(Error::Usage { problem: text }),
        }
    });
    done.await.map_err(internal)??;
    desk.order(Order::Open(folder))?;
    Ok(Json(json!({ "command": told.join(" ") })))
}

/// The command line that does the same.
fn line(desk: &Desk, wanted: &Wanted, folder: &std::path::Path) -> Result<Vec<OsString>, Error> {
    let mut line: Vec<OsString> = vec!["stickslip".into(), "import".into()];
    let files = desk.output.join(FOLDER);
    line.extend(
        wanted
            .files
            .iter()
            .map(|name| files.join(plain(name)).into()),
    );
    line.extend(["-o".into(), folder.into()]);
    let mut option = |name: &str, value: &str| line.push(format!("--{name}={value}").into());
    let texts = [
        ("time", &wanted.time),
        ("displacement", &wanted.displacement),
        ("velocity", &wanted.velocity),
        ("acceleration", &wanted.acceleration),
        ("unit", &wanted.unit),
    ];
    for (name, value) in texts {
        if let Some(value) = value {
            option(name, value);
        }
    }
    if let Some(rate) = wanted.rate {
        option("rate", &rate.to_string());
    }
    option("belt-velocity", &wanted.belt_velocity.join(","));
    option("normal-force", &wanted.normal_force.join(","));
    if let Some(template) = &wanted.template {
        let text = new::structure(template)?;
        let beam: PathBuf = files.join(format!("{}.toml", plain(template)));
        write_file(&beam, text.as_bytes())?;
        option("beam", &beam.to_string_lossy());
    }
    Ok(line)
}

/// A word of a command line as a shell takes it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_no_paths() {
        assert_eq!(plain("../../etc/passwd"), "passwd");
        assert_eq!(plain("C:\\data\\run 1.csv"), "run_1.csv");
        assert_eq!(plain(".."), "file");
        assert_eq!(plain(".hidden"), "hidden");
        assert_eq!(plain(&"x".repeat(500)).len(), LONGEST_NAME);
    }
}
