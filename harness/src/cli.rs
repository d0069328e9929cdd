//! The command line.

use clap::{Parser, Subcommand};

use crate::command::{
    blind_test, compare, cross_check, demo, diagnose, dimension, effects, observe, pack, simulate,
    sweep, system, try_effects,
};

/// Exit codes, as the help shows them.
const EXIT_CODES: &str = "Exit codes:
  0  done
  1  a gate failed (--fail-above)
  2  bad input: option, campaign, CSV or FMU file
  3  the FMU failed while running
  4  a result could not be written
  5  stopped before the end; the same command goes on";

/// Compare a stick-slip beam's FMU with measurements.
///
/// Without a command: the demonstration.
#[derive(Debug, Parser)]
#[command(name = "stickslip", version, after_help = EXIT_CODES, term_width = 100)]
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
    /// Pack the FMU and compare it with the campaign that ships in reference-data/demo
    Demo(demo::Arguments),
    /// Find the physical effect that the model lacks, from a measured campaign
    Diagnose(diagnose::Arguments),
    /// Add effects to the calibrated model by hand, one step of the error ladder at a time
    Try(try_effects::Arguments),
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
