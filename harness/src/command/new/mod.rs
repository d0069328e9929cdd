//! `stickslip new`: a commented campaign with an example, to begin with.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::new_folder;
use crate::error::Error;
use crate::measurement::Campaign;
use crate::output::{print, print_line};
use crate::wording::{nearest, suggestion};

/// Options of `new`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// What to begin with, as --list shows
    #[arg(value_name = "TEMPLATE", required_unless_present = "list")]
    template: Option<String>,
    /// Folder to write; new or empty
    #[arg(value_name = "DIR", required_unless_present = "list")]
    output: Option<PathBuf>,
    /// List the templates instead
    #[arg(long)]
    list: bool,
}

/// A campaign to begin with.
struct Template {
    name: &'static str,
    /// The machine, in one sentence.
    sentence: &'static str,
    /// Names and contents.
    files: &'static [(&'static str, &'static str)],
}

macro_rules! files {
    ($($folder:literal / $name:literal),+) => {
        &[$(($name, include_str!(concat!($folder, "/", $name)))),+]
    };
}

const TEMPLATES: [Template; 5] = [
    Template {
        name: "beam-on-belt",
        sentence: "A cantilever whose tip a moving belt drags along by dry friction, two modes.",
        files: files!(
            "beam-on-belt" / "campaign.toml",
            "beam-on-belt" / "README.md",
            "beam-on-belt" / "machine.svg",
            "beam-on-belt" / "run01.csv",
            "beam-on-belt" / "run02.csv"
        ),
    },
    Template {
        name: "mass-on-belt",
        sentence: "A block on a spring, held on a moving belt: one mode.",
        files: files!(
            "mass-on-belt" / "campaign.toml",
            "mass-on-belt" / "README.md",
            "mass-on-belt" / "machine.svg",
            "mass-on-belt" / "run01.csv",
            "mass-on-belt" / "run02.csv"
        ),
    },
    Template {
        name: "pin-on-disc",
        sentence: "A pin in an elastic holder, pressed on a turning disc, as in a tribometer.",
        files: files!(
            "pin-on-disc" / "campaign.toml",
            "pin-on-disc" / "README.md",
            "pin-on-disc" / "machine.svg",
            "pin-on-disc" / "run01.csv",
            "pin-on-disc" / "run02.csv"
        ),
    },
    Template {
        name: "sliding-drive",
        sentence: "A carriage on a guide with friction, moved by a measured motor force; no spring.",
        files: files!(
            "sliding-drive" / "campaign.toml",
            "sliding-drive" / "README.md",
            "sliding-drive" / "machine.svg",
            "sliding-drive" / "run01.csv"
        ),
    },
    Template {
        name: "oscillator",
        sentence: "A mass on a spring, driven by a measured force, without contact.",
        files: files!(
            "oscillator" / "campaign.toml",
            "oscillator" / "README.md",
            "oscillator" / "machine.svg",
            "oscillator" / "run01.csv"
        ),
    },
];

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let (Some(name), Some(output), false) =
        (&arguments.template, &arguments.output, arguments.list)
    else {
        return print(&list());
    };
    let template = find(name)?;
    let files = template.files.iter();
    let files: Vec<(String, Vec<u8>)> = files
        .map(|(name, content)| ((*name).to_owned(), content.as_bytes().to_vec()))
        .collect();
    new_folder::write(output, &files, |folder| Campaign::load(folder).map(drop))?;
    let place = output.display();
    print_line(format_args!(
        "{place}: {} file(s). Read {place}/README.md, then: stickslip check {place}, stickslip compare {place}",
        files.len()
    ))
}

fn find(name: &str) -> Result<&'static Template, Error> {
    let found = TEMPLATES.iter().find(|template| template.name == name);
    found.ok_or_else(|| Error::Option {
        option: "TEMPLATE",
        value: format!("'{name}'"),
        rule: format!(
            "is none{}; `stickslip new --list` shows all",
            suggestion(&nearest(name, TEMPLATES.iter().map(|t| t.name)))
        ),
    })
}

/// Names of the templates, each with its machine in a sentence.
pub fn templates() -> impl Iterator<Item = (&'static str, &'static str)> {
    TEMPLATES.iter().map(|t| (t.name, t.sentence))
}

/// The campaign.toml of a template, which says what is known of its structure.
///
/// # Errors
/// A name that is none.
pub fn structure(name: &str) -> Result<&'static str, Error> {
    let files = find(name)?.files;
    let found = files.iter().find(|(name, _)| *name == "campaign.toml");
    Ok(found.map_or("", |(_, text)| text))
}

fn list() -> String {
    let mut text = String::new();
    for template in &TEMPLATES {
        let _ = writeln!(text, "{:<14} {}", template.name, template.sentence);
    }
    text
}
