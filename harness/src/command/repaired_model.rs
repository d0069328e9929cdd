//! The model that a diagnosis ends with, in the forms in which others take it: model.toml, an SSP
//! parameter file (.ssv) and an FMU with these start values.

use std::path::Path;

use super::pack;
use crate::diagnose::outcome::Diagnosis;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::output::write_file;

/// Calibrated values by FMU variable: those of the structure, the friction law and the effects.
pub fn values(diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let mut out = Vec::new();
    for (name, estimate) in &diagnosis.calibrated {
        if name == "mass" {
            let modes = diagnosis
                .calibrated
                .keys()
                .filter(|k| k.ends_with("].frequency"))
                .count();
            out.extend((1..=modes).map(|j| (format!("mode[{j}].mass"), estimate.value)));
        } else {
            out.push((name.clone(), estimate.value));
        }
    }
    for effect in &diagnosis.effects {
        for (name, estimate) in &effect.parameters {
            out.push((format!("{}.{name}", effect.id), estimate.value));
        }
        for (name, own) in &effect.own_parameters {
            // A phase belongs to a run; the first run's stands for all.
            out.push((format!("{}.{name}", effect.id), own[0]));
        }
    }
    out
}

/// Writes model.toml, StickSlipBeam.ssv and StickSlipBeam.fmu into `folder`.
///
/// # Errors
/// A folder that can't be written, or values that the FMU does not take.
pub fn write(fmu: &Fmu, diagnosis: &Diagnosis, folder: &Path) -> Result<(), Error> {
    let values = values(diagnosis);
    write_file(&folder.join("model.toml"), model_toml(&values).as_bytes())?;
    write_file(
        &folder.join("StickSlipBeam.ssv"),
        ssv(fmu, &values).as_bytes(),
    )?;
    let list: Vec<(&str, f64)> = values.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    let refused = |e: beam_model_description::StartValueError| Error::StartValues {
        problem: e.to_string(),
    };
    let (xml, guid) = beam_model_description::xml_with_starts(&list).map_err(refused)?;
    let starts = beam_model_description::start_values_toml(&list, &guid).map_err(refused)?;
    let resource = format!("resources/{}", beam_model_description::START_VALUES_FILE);
    pack::write_fmu(
        &folder.join(pack::FILE_NAME),
        &xml,
        &[(&resource, starts.as_bytes())],
    )
}

fn model_toml(values: &[(String, f64)]) -> String {
    let mut out = String::from(
        "# Calibrated model: FMU variable = value in SI units; `stickslip simulate --set NAME=VALUE` takes them.\n[parameters]\n",
    );
    for (name, value) in values {
        out += &format!("\"{name}\" = {value:?}\n");
    }
    out
}

/// System Structure Parameter Values 1.0 (SSP standard, section 6).
fn ssv(fmu: &Fmu, values: &[(String, f64)]) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<ssv:ParameterSet version=\"1.0\" name=\"calibrated\" xmlns:ssv=\"http://ssp-standard.org/SSP1/SystemStructureParameterValues\">\n  <ssv:Parameters>\n",
    );
    for (name, value) in values {
        let unit = fmu
            .variable(name)
            .ok()
            .and_then(|v| v.unit.clone())
            .map_or(String::new(), |u| format!(" unit=\"{u}\""));
        out += &format!(
            "    <ssv:Parameter name=\"{name}\"><ssv:Real value=\"{value:?}\"{unit}/></ssv:Parameter>\n"
        );
    }
    out + "  </ssv:Parameters>\n</ssv:ParameterSet>\n"
}
