//! `stickslip effects`: the physical effects that an FMU offers, what each one is, and what it does to the motion.

mod motion;
mod page;

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use super::operating_options::OperatingOptions;
use super::pack::widened::with_effects;
use crate::diagnose::model::library;
use crate::error::Error;
use crate::fmu::effect_card::{EffectCard, EffectParameter, Role, candidates};
use crate::output::{make_folder, print, print_line, write_file};
use crate::report::number;

/// Options of `effects`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Effect to be explained, e.g. third_mode; without it all are listed
    #[arg(value_name = "ID")]
    id: Option<String>,
    /// FMU to ask [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// List the effects beyond the catalogue that a diagnosis tries where none of the catalogue explains the data
    #[arg(long)]
    library: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    /// Folder to write ID.html to: the explanation with pictures of what the effect does, at its typical strength or that given by --set
    #[arg(short, long, value_name = "DIR", requires = "id")]
    output: Option<PathBuf>,
    #[command(flatten)]
    at: OperatingOptions,
}

/// Effects of an FMU.
#[derive(Debug)]
pub struct Listed {
    /// All of them, or the one asked for, as JSON.
    pub json: Value,
    /// The list, or the card of the one asked for.
    pub text: String,
    /// The page that was written.
    pub report: Option<PathBuf>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let found = perform(arguments)?;
    // JSON stays alone on the standard output.
    if arguments.json {
        return print_line(
            serde_json::to_string_pretty(&found.json).expect("numbers and texts have a JSON form"),
        );
    }
    print(&found.text)?;
    match &found.report {
        Some(file) => print_line(format_args!("Report: {}", file.display())),
        None => Ok(()),
    }
}

/// Lists or explains, and writes the page where one is asked for.
///
/// # Errors
/// Options or an FMU that can't be used, an effect that it does not have, a folder that can't be
/// written.
pub fn perform(arguments: &Arguments) -> Result<Listed, Error> {
    if arguments.at.is_given() && arguments.output.is_none() {
        return Err(Error::Option {
            option: "--output",
            value: "none".into(),
            rule: "is given, and an operating point or --set only says at what the pictures are drawn; add -o DIR".into(),
        });
    }
    let mut fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let path = fmu.path().to_owned();
    let mut catalogue = candidates(&fmu)?;
    let is_elsewhere = |id: &String| !catalogue.iter().any(|c| c.id == *id);
    let of_library = arguments.library || arguments.id.as_ref().is_some_and(is_elsewhere);
    if let (true, Some(widened)) = (of_library, with_effects(&fmu, &library::FILES)?) {
        catalogue = candidates(&widened)?;
        if arguments.library {
            catalogue.retain(|c| library::is_library_effect(&c.id));
        }
        fmu = widened;
    }
    let chosen = match &arguments.id {
        Some(id) => vec![&catalogue[find(&catalogue, id, &path)?]],
        None => catalogue.iter().collect(),
    };
    let mut report = None;
    if let (Some(folder), [effect]) = (&arguments.output, &chosen[..]) {
        let html = page::html(&fmu, effect, &arguments.at.read()?)?;
        make_folder(folder)?;
        let file = folder.join(format!("{}.html", effect.id));
        write_file(&file, html.as_bytes())?;
        report = Some(file);
    }
    let (json, text) = if arguments.id.is_some() {
        (to_json(chosen[0]), card(chosen[0]))
    } else {
        let all = chosen.iter().map(|c| to_json(c)).collect();
        (Value::Array(all), list(&chosen, arguments.library))
    };
    Ok(Listed { json, text, report })
}

/// Index in the catalogue of the effect with an identifier.
///
/// # Errors
/// An identifier that the FMU does not declare.
pub fn find(catalogue: &[EffectCard], id: &str, fmu: &std::path::Path) -> Result<usize, Error> {
    catalogue
        .iter()
        .position(|c| c.id == id)
        .ok_or_else(|| Error::UnknownEffect {
            path: fmu.to_owned(),
            id: id.to_owned(),
            nearest: crate::wording::nearest(id, catalogue.iter().map(|c| c.id.as_str())),
        })
}

fn list(catalogue: &[&EffectCard], of_library: bool) -> String {
    if catalogue.is_empty() {
        return "This FMU declares no effects; its annotation 'StickSlip' would list them.\n"
            .into();
    }
    let width = catalogue.iter().map(|c| c.id.len()).max().unwrap_or(0);
    let mut out = String::new();
    for effect in catalogue {
        let _ = writeln!(out, "{:<width$}  {}", effect.id, effect.title);
    }
    let _ = writeln!(
        out,
        "\n{} effects, {}. `stickslip effects ID` explains one.",
        catalogue.len(),
        match of_library {
            true => "tried where none of the catalogue explains the data",
            false => "all off by default",
        }
    );
    out
}

/// Width of wrapped text.
const COLUMNS: usize = 100;

fn card(effect: &EffectCard) -> String {
    let mut out = format!(
        "{}: {}\n\n    {}\n\n",
        effect.id, effect.title, effect.equation
    );
    out += &wrapped("", &effect.description);
    for (heading, text) in [
        ("How it shows: ", &effect.signature),
        ("What looks alike: ", &effect.confounders),
        ("Source: ", &effect.source),
    ] {
        if !text.is_empty() {
            out += "\n";
            out += &wrapped(heading, text);
        }
    }
    out += "\nParameters (FMU variable, value that means off, typical value, bounds):\n";
    let width = effect
        .parameters
        .iter()
        .map(|p| effect.id.len() + 1 + p.name.len())
        .max()
        .unwrap_or(0);
    for p in shown(effect) {
        let unit = if p.unit == "1" {
            String::new()
        } else {
            format!(" {}", p.unit)
        };
        let _ = writeln!(
            out,
            "  {:<width$}  {}{unit}, typical {}, {} to {}: {}",
            format!("{}.{}", effect.id, p.name),
            number(p.start, 4),
            number(p.typical, 4),
            number(p.min, 4),
            number(p.max, 4),
            p.description
        );
    }
    let nodes = effect
        .parameters
        .iter()
        .filter(|p| p.role == Role::Node)
        .count();
    if nodes > 1 {
        let _ = writeln!(out, "  ... {} more values of this kind", nodes - 1);
    }
    out
}

/// The parameters, of a profile's values the first only.
fn shown(effect: &EffectCard) -> impl Iterator<Item = &EffectParameter> {
    let first = effect.find_role(Role::Node);
    effect
        .parameters
        .iter()
        .enumerate()
        .filter(move |(i, p)| p.role != Role::Node || Some(*i) == first)
        .map(|(_, p)| p)
}

/// A heading and its text, broken into lines of [`COLUMNS`] characters.
fn wrapped(heading: &str, text: &str) -> String {
    let mut out = String::new();
    let mut line = heading.trim_end().to_owned();
    for word in text.split_whitespace() {
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > COLUMNS {
            out += &line;
            out += "\n";
            line.clear();
        }
        if !line.is_empty() {
            line += " ";
        }
        line += word;
    }
    out + &line + "\n"
}

fn role_name(role: Role) -> &'static str {
    match role {
        Role::Amplitude => "amplitude",
        Role::Shape => "shape",
        Role::Phase => "phase",
        Role::Node => "node",
        Role::Setting => "setting",
    }
}

fn to_json(effect: &EffectCard) -> Value {
    let parameters: Vec<Value> = effect
        .parameters
        .iter()
        .map(|p| {
            json!({
                "name": p.name, "variable": format!("{}.{}", effect.id, p.name), "description": p.description, "unit": p.unit,
                "off": p.start, "typical": p.typical, "min": p.min, "max": p.max, "role": role_name(p.role),
            })
        })
        .collect();
    let states: Vec<&str> = effect.states.iter().map(|s| s.name.as_str()).collect();
    json!({
        "id": effect.id, "title": effect.title, "equation": effect.equation, "description": effect.description,
        "source": effect.source, "signature": effect.signature, "confounders": effect.confounders,
        "parameters": parameters, "states": states,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_are_wrapped() {
        let text = wrapped("Source: ", &"word ".repeat(40));
        assert!(text.lines().all(|l| l.len() <= COLUMNS));
        assert!(text.starts_with("Source: word") && text.lines().count() == 3);
    }
}
