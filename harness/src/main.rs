//! The command `stickslip`.

use std::io::Write as _;
use std::process::ExitCode;

use stickslip::cli::{Asked, Command, parse};
use stickslip::command::{
    blind_test, check, compare, cross_check, demo, diagnose, dimension, effects, import, new,
    observe, pack, simulate, studio, sweep, system, try_effects,
};
use stickslip::error::Error;
use stickslip::exit::Exit;
use stickslip::output::print;

fn main() -> ExitCode {
    let end = match run() {
        Ok(()) => Exit::Done,
        Err(error) => {
            let end = error.exit();
            if end != Exit::ReaderGone {
                say(&error);
            }
            end
        }
    };
    ExitCode::from(end.code())
}

/// Says in one line what went wrong. If even that can't be said, the exit code has to do.
fn say(error: &Error) {
    let mark = console::style("error:").red().bold().for_stderr();
    let _ = writeln!(std::io::stderr(), "{mark} {}", error.line());
}

fn run() -> Result<(), Error> {
    let cli = match parse(std::env::args_os())? {
        Asked::For(cli) => cli,
        Asked::Text(text) => return print(&text),
    };
    match cli.command {
        None => demo::run(&demo::Arguments::default()),
        Some(Command::Demo(arguments)) => demo::run(&arguments),
        Some(Command::Simulate(arguments)) => simulate::run(&arguments),
        Some(Command::Import(arguments)) => import::run(&arguments),
        Some(Command::New(arguments)) => new::run(&arguments),
        Some(Command::Check(arguments)) => check::run(&arguments),
        Some(Command::Compare(arguments)) => compare::run(&arguments),
        Some(Command::Diagnose(arguments)) => diagnose::run(&arguments),
        Some(Command::Try(arguments)) => try_effects::run(&arguments),
        Some(Command::Studio(arguments)) => studio::run(&arguments),
        Some(Command::BlindTest(arguments)) => blind_test::run(&arguments),
        Some(Command::Observe(arguments)) => observe::run(&arguments),
        Some(Command::Dimension(arguments)) => dimension::run(&arguments),
        Some(Command::Sweep(arguments)) => sweep::run(&arguments),
        Some(Command::Figures(arguments)) => sweep::figures::run(&arguments),
        Some(Command::Effects(arguments)) => effects::run(&arguments),
        Some(Command::Pack(arguments)) => pack::run(&arguments),
        Some(Command::System(arguments)) => system::run(&arguments),
        Some(Command::CrossCheck(arguments)) => cross_check::run(&arguments),
    }
}
