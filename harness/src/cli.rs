//! The command line.

use std::any::TypeId;
use std::ffi::OsString;

use clap::{Arg, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use crate::command::{
    blind_test, check, compare, cross_check, demo, diagnose, dimension, effects, import, new,
    observe, pack, simulate, studio, sweep, system, try_effects,
};

use crate::error::Error;
use crate::exit::Exit;

/// Compare a stick-slip beam's FMU with measurements.
///
/// Without a command: the demonstration.
#[derive(Debug, Parser)]
#[command(name = "stickslip", version, after_help = Exit::list(), term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run one operating point of an FMU and write its motion as CSV
    Simulate(simulate::Arguments),
    /// Run an FMU at every operating point of a measured campaign and show where they differ
    Compare(compare::Arguments),
    /// Turn loggers' files (CSV, MATLAB, HDF5, UFF, WAV, Parquet, TDMS) into a campaign
    Import(import::Arguments),
    /// Write a commented campaign with an example, to begin with
    New(new::Arguments),
    /// Look at a campaign's data before long work: units, signs, swapped files, sampling, sensor
    Check(check::Arguments),
    /// Pack the FMU and compare it with the campaign that ships in reference-data/demo
    Demo(demo::Arguments),
    /// Find the physical effect that the model lacks, from a measured campaign
    Diagnose(diagnose::Arguments),
    /// Add effects to the calibrated model by hand, one step of the error ladder at a time
    Try(try_effects::Arguments),
    /// Work with campaign, effects and error on one page in the browser, live
    Studio(studio::Arguments),
    /// Diagnose every campaign of a folder with known answers, and count
    BlindTest(blind_test::Arguments),
    /// Estimate friction force and friction characteristic from one measured run
    Observe(observe::Arguments),
    /// Correlation dimension of a measured or simulated series, and whether it has one
    Dimension(dimension::Arguments),
    /// Motions over one or two parameters: bifurcation diagram, map, table of periods and exponents
    Sweep(sweep::Arguments),
    /// The paper's numerical figures from this model, beside what the paper says of them
    Figures(sweep::figures::Arguments),
    /// List the physical effects that an FMU offers, or explain one
    Effects(effects::Arguments),
    /// Write StickSlipBeam.fmu
    Pack(pack::Arguments),
    /// Write a system of beam and belt drive, coupled both ways, as SSP
    System(system::Arguments),
    /// Write the files that the FMI Cross-Check asks of an exporting tool
    CrossCheck(cross_check::Arguments),
}

/// The commands by what a user wants; each stands in one group.
pub const GROUPS: [(&str, &[&str]); 5] = [
    ("Measure", &["new", "import", "check"]),
    ("Compare", &["demo", "compare", "simulate"]),
    (
        "Diagnose",
        &["studio", "diagnose", "try", "observe", "blind-test"],
    ),
    ("Study", &["effects", "sweep", "figures", "dimension"]),
    ("Exchange", &["pack", "system", "cross-check"]),
];

/// The page of `--help`, its commands in groups.
fn help_template(command: &clap::Command) -> String {
    use std::fmt::Write as _;
    let widest = command.get_subcommands().map(|c| c.get_name().len()).max();
    let wide = widest.unwrap_or(0);
    let mut text = String::from("{about-with-newline}\n{usage-heading} {usage}\n");
    for (group, names) in GROUPS {
        let _ = write!(text, "\n{group}:\n");
        for sub in names
            .iter()
            .filter_map(|name| command.find_subcommand(name))
        {
            let about = sub.get_about().map(ToString::to_string);
            let _ = writeln!(
                text,
                "  {:<wide$}  {}",
                sub.get_name(),
                about.unwrap_or_default()
            );
        }
    }
    text + "\nOptions:\n{options}\n\n{after-help}\n"
}

/// The command line's definition. Every option that takes numbers takes negative ones: clap alone takes `-1e-5` and
/// `-1,2` for options that do not exist.
pub fn command() -> clap::Command {
    let command = Cli::command();
    let template = help_template(&command);
    command.help_template(template).mut_subcommands(|command| {
        command.mut_args(|arg| {
            if takes_numbers(&arg) {
                arg.allow_hyphen_values(true)
            } else {
                arg
            }
        })
    })
}

/// Whether an option's values are numbers.
pub fn takes_numbers(arg: &Arg) -> bool {
    let of = arg.get_value_parser().type_id();
    [
        TypeId::of::<f64>(),
        TypeId::of::<usize>(),
        TypeId::of::<u64>(),
    ]
    .iter()
    .any(|number| of == *number)
}

/// What a command line asks for: a command, or a text to print (help, version).
pub enum Asked {
    /// A command.
    For(Box<Cli>),
    /// A text.
    Text(String),
}

/// Reads a command line, the program's name first.
///
/// # Errors
/// [`Error::Usage`], in one line.
pub fn parse(line: impl IntoIterator<Item = OsString>) -> Result<Asked, Error> {
    let parsed = command()
        .try_get_matches_from(line)
        .and_then(|matches| Cli::from_arg_matches(&matches));
    match parsed {
        Ok(cli) => Ok(Asked::For(Box::new(cli))),
        Err(error) if error.use_stderr() => Err(Error::Usage {
            problem: one_line(&error.render().to_string()),
        }),
        Err(text) => Ok(Asked::Text(text.render().to_string())),
    }
}

/// clap's message without the usage and the hint at the help behind it.
fn one_line(message: &str) -> String {
    let mut line = String::new();
    let parts = message
        .lines()
        .map(str::trim)
        .take_while(|part| !part.starts_with("Usage:") && !part.starts_with("For more"));
    for part in parts.filter(|part| !part.is_empty()) {
        if !line.is_empty() {
            line += if line.ends_with(':') { " " } else { "; " };
        }
        line += part.trim_start_matches("error: ");
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_stands_in_one_group_of_the_help() {
        let definition = command();
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|group| group.1).copied().collect();
        let mut all: Vec<&str> = definition.get_subcommands().map(|c| c.get_name()).collect();
        grouped.sort_unstable();
        all.sort_unstable();
        assert_eq!(grouped, all);
    }
}
