//! Packs the FMU that a wheel carries: `stickslip-wheel-fmu FILE`. The build backend runs it; it is built with the extension
//! module, so that both are of the same sources.
#![forbid(unsafe_code)]

use std::path::Path;
use std::process::ExitCode;

fn main() -> ExitCode {
    let packed = match std::env::args().nth(1) {
        Some(file) => stickslip::command::pack::pack(Path::new(&file)).map_err(|e| e.line()),
        None => Err("the file to write is missing: stickslip-wheel-fmu FILE".to_owned()),
    };
    match packed {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            stickslip::output::tell(problem);
            ExitCode::FAILURE
        }
    }
}
