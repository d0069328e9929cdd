//! The commands of `stickslip`, one file each.

pub mod blind_test;
pub mod check;
pub mod compare;
pub mod cross_check;
mod data_quality;
pub mod demo;
pub mod diagnose;
mod diagnose_page;
pub mod dimension;
pub mod effects;
mod given_campaign;
pub mod import;
pub mod new;
mod new_folder;
pub mod observe;
pub mod operating_options;
pub mod operating_point;
pub mod pack;
mod parameter_set;
pub mod progress;
mod proposed_effect;
pub mod repaired_model;
mod run_sets;
pub mod simulate;
pub mod studio;
pub mod sweep;
pub mod system;
pub mod try_effects;

use std::path::Path;

use crate::error::Error;
use crate::fmu::Fmu;

/// The FMU at `path`, or without one the FMU of this repository, packed on the spot.
pub fn open_fmu(path: Option<&Path>) -> Result<Fmu, Error> {
    match path {
        Some(path) => Fmu::load(path),
        None => {
            let folder = tempfile::tempdir().map_err(Error::write(&std::env::temp_dir()))?;
            let path = folder.path().join(pack::FILE_NAME);
            pack::pack(&path)?;
            Fmu::load(&path)
        }
    }
}
