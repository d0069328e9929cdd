//! The command `stickslip`.

use std::process::ExitCode;

use clap::Parser as _;
use stickslip::cli::{Cli, Command};
use stickslip::command::{
    blind_test, compare, cross_check, demo, diagnose, dimension, effects, observe, pack, simulate,
    sweep, system, try_effects,
};

fn main() -> ExitCode {
    let result = match Cli::parse().command {
        None => demo::run(&demo::Arguments::default()),
        Some(Command::Demo(arguments)) => demo::run(&arguments),
        Some(Command::Simulate(arguments)) => simulate::run(&arguments),
        Some(Command::Compare(arguments)) => compare::run(&arguments),
        Some(Command::Diagnose(arguments)) => diagnose::run(&arguments),
        Some(Command::Try(arguments)) => try_effects::run(&arguments),
        Some(Command::BlindTest(arguments)) => blind_test::run(&arguments),
        Some(Command::Observe(arguments)) => observe::run(&arguments),
        Some(Command::Dimension(arguments)) => dimension::run(&arguments),
        Some(Command::Sweep(arguments)) => sweep::run(&arguments),
        Some(Command::Figures(arguments)) => sweep::figures::run(&arguments),
        Some(Command::Effects(arguments)) => effects::run(&arguments),
        Some(Command::Pack(arguments)) => pack::run(&arguments),
        Some(Command::System(arguments)) => system::run(&arguments),
        Some(Command::CrossCheck(arguments)) => cross_check::run(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!(
                "{} {error}",
                console::style("error:").red().bold().for_stderr()
            );
            ExitCode::from(error.exit_code())
        }
    }
}
