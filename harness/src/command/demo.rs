//! `stickslip demo`: pack the FMU, compare it with the campaign that ships with the repository.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{compare, pack};
use crate::error::Error;
use crate::output::{make_folder, print_line};

/// Options of `demo`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder for the FMU and the report
    #[arg(short, long, value_name = "DIR", default_value = "stickslip-demo")]
    output: PathBuf,
}

impl Default for Arguments {
    fn default() -> Self {
        Arguments {
            output: "stickslip-demo".into(),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    make_folder(&arguments.output)?;
    let fmu = arguments.output.join(pack::FILE_NAME);
    pack::pack(&fmu)?;
    print_line(format_args!("Packed {}", fmu.display()))?;
    compare::run(&compare::Arguments::of(
        campaign(),
        Some(fmu),
        arguments.output.clone(),
    ))?;
    print_line("See it live: `stickslip studio`")
}

/// The campaign below the current folder, or where this program was built.
pub fn campaign() -> PathBuf {
    let here = Path::new("reference-data/demo");
    if here.is_dir() {
        here.to_owned()
    } else {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo")
    }
}
