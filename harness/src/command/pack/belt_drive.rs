//! BeltDrive.fmu: the second model of the FMU's binary, packed under its own name.

use std::path::Path;

use beam_model_description::belt_drive;

use super::platforms::Binaries;
use super::{DESCRIPTION, contents, documentation, write_fmu};
use crate::error::Error;
use crate::fmu::ModelDescription;

/// Name of the file.
pub const FILE_NAME: &str = "BeltDrive.fmu";

/// Writes the FMU.
///
/// # Errors
/// No library beside this program, or a file that can't be written.
pub fn pack(path: &Path) -> Result<(), Error> {
    let xml = belt_drive::xml();
    let description = ModelDescription::parse(xml).map_err(|problem| Error::FmuDescription {
        path: path.to_owned(),
        problem,
    })?;
    let page = documentation::page(
        &description,
        "A belt drive as an FMI 2.0 FMU for co-simulation, made to be coupled with StickSlipBeam.",
        &[
            "A motor that keeps its speed v_m pulls a belt, elastic with stiffness k and damping c, whose mass M the \
             friction force F brakes: M u' = -F - k x - c (u - v_m), x' = u - v_m. Connect friction_force with that \
             of the beam, and belt_velocity with the beam's input.",
            "Each step is exact for inputs that are linear in time (fmi2SetRealInputDerivatives), otherwise for inputs \
             that are constant.",
            "With a constant motor velocity, and the beam, this is the two-mass system of Popp and Stelter, \
             Phil. Trans. R. Soc. A 332 (1990) 89.",
        ],
    );
    let mut files = vec![(DESCRIPTION.to_owned(), xml.as_bytes().to_vec())];
    files.extend(Binaries::of_this_build()?.entries(belt_drive::IDENTIFIER));
    files.push((contents::DOCUMENTATION.to_owned(), page.into_bytes()));
    files.extend(contents::licenses());
    write_fmu(path, &files)
}
