//! The model that a diagnosis ends with, in the forms in which others take it: model.toml, an SSP
//! parameter file (.ssv) and an FMU with these start values.

use std::path::Path;

use super::parameter_set::ssv;
use super::{pack, run_sets};
use crate::diagnose::result::diagnosis::Diagnosis;
use crate::diagnose::result::run_sets::RunSet;
use crate::error::Error;
use crate::fmu::{Fmu, SideFile, with_guid, with_starts};
use crate::output::write_file;

/// Calibrated values by FMU variable: those of the structure, the friction law and the effects.
pub fn values(diagnosis: &Diagnosis) -> Vec<(String, f64)> {
    let mut out: Vec<(String, f64)> = diagnosis
        .structure
        .iter()
        .map(|(name, value)| (name.clone(), *value))
        .collect();
    // "mass" is the first mode's under its earlier name, where there are modes.
    let is_alias = |name: &str| name == "mass" && diagnosis.calibrated.contains_key("mode[1].mass");
    let calibrated = diagnosis.calibrated.iter().filter(|(n, _)| !is_alias(n));
    out.extend(calibrated.map(|(name, estimate)| (name.clone(), estimate.value)));
    for effect in &diagnosis.effects {
        for (name, estimate) in &effect.parameters {
            out.push((format!("{}.{name}", effect.id), estimate.value));
        }
        // A phase belongs to a run; the first run's stands for all.
        let of_first = effect
            .own_parameters
            .iter()
            .filter(|(_, v)| v[0].is_finite());
        for (name, per_run) in of_first {
            out.push((format!("{}.{name}", effect.id), per_run[0]));
        }
    }
    out.extend(diagnosis.unnamed_effects.iter().cloned());
    out
}

/// Name of the calibrated FMU's file: that of this project's FMU, or the model identifier of one of another make.
pub fn file_name(fmu: &Fmu) -> String {
    match fmu.side_file() {
        Some(_) => format!("{}.fmu", fmu.description().model_identifier),
        None => pack::FILE_NAME.to_owned(),
    }
}

/// Writes model.toml, StickSlipBeam.ssv and StickSlipBeam.fmu, or those under the name of an FMU of another make, into `folder`, and
/// into its folder `runs`, as into the FMU, what each run has of its own.
///
/// The FMU is the one that was diagnosed, its binaries and resources included, with other start values. One of
/// this project takes them from its resources too, under a GUID of their own; in any other they stand in
/// modelDescription.xml alone, from where masters send them.
///
/// # Errors
/// A folder that can't be written, or values that the FMU does not take.
pub fn write(
    fmu: &Fmu,
    diagnosis: &Diagnosis,
    sets: &[RunSet],
    folder: &Path,
) -> Result<(), Error> {
    write_values(fmu, &values(diagnosis), sets, folder)
}

/// Writes the same files for values that come from elsewhere.
///
/// # Errors
/// As [`write`].
pub fn write_values(
    fmu: &Fmu,
    values: &[(String, f64)],
    sets: &[RunSet],
    folder: &Path,
) -> Result<(), Error> {
    let values: Vec<(String, f64)> = values
        .iter()
        .map(|(name, value)| (fmu.own_name(name).to_owned(), *value))
        .collect();
    write_file(&folder.join("model.toml"), model_toml(&values).as_bytes())?;
    let path = folder.join(file_name(fmu));
    if let Some(side) = fmu.side_file() {
        write_file(&SideFile::place(&path), side.text().as_bytes())?;
    }
    write_file(
        &path.with_extension("ssv"),
        ssv(fmu.description(), "calibrated", &values).as_bytes(),
    )?;
    let runs = run_sets::files(fmu.description(), sets);
    run_sets::write_beside(&runs, folder)?;
    write_with_runs(fmu, &values, &runs, &path)
}

/// Writes the FMU with these start values to `path`; what it held for single runs is left out, as it belongs to other values.
///
/// # Errors
/// As [`write`].
pub fn write_fmu(fmu: &Fmu, values: &[(String, f64)], path: &Path) -> Result<(), Error> {
    write_with_runs(fmu, values, &[], path)
}

/// The same with these files for single runs.
fn write_with_runs(
    fmu: &Fmu,
    values: &[(String, f64)],
    runs: &[(String, Vec<u8>)],
    path: &Path,
) -> Result<(), Error> {
    let refused = |problem: String| Error::StartValues { problem };
    let unfit = |error| match error {
        Error::FmuInstantiate { reason, .. } => refused(reason),
        other => other,
    };
    let mut files = fmu.files()?;
    files.retain(|(name, _)| !name.starts_with(run_sets::FOLDER));
    let inside = |(name, content): &(String, Vec<u8>)| {
        (format!("{}{name}", run_sets::FOLDER), content.clone())
    };
    files.extend(runs.iter().map(inside));
    let place = |files: &[(String, Vec<u8>)], name: &str| files.iter().position(|f| f.0 == name);
    let text = |files: &[(String, Vec<u8>)], at: usize| {
        String::from_utf8(files[at].1.clone())
            .map_err(|_| refused(format!("{} is not UTF-8 text", files[at].0)))
    };
    let description = place(&files, pack::DESCRIPTION)
        .ok_or_else(|| refused(format!("{} is missing", pack::DESCRIPTION)))?;
    let mut xml = with_starts(&text(&files, description)?, values).map_err(refused)?;
    if let Some(starts) = place(&files, pack::START_VALUES) {
        let guid = beam_model_description::guid_of(&xml);
        xml = with_guid(&xml, &guid).map_err(refused)?;
        let old = text(&files, starts)?;
        files[starts].1 = start_values(&old, &guid, values)
            .map_err(|problem| refused(format!("{}: {problem}", pack::START_VALUES)))?
            .into_bytes();
        files[description].1 = xml.clone().into_bytes();
        return pack::write_changed(path, &xml, files).map_err(unfit);
    }
    files[description].1 = xml.into_bytes();
    pack::write_fmu(path, &files).map_err(unfit)
}

/// The start values' file with these values and this GUID; what else stands in it (the users' effects) stays.
fn start_values(old: &str, guid: &str, values: &[(String, f64)]) -> Result<String, String> {
    let mut table: toml::Table = old.parse().map_err(|e| format!("not valid TOML: {e}"))?;
    table.insert("guid".into(), guid.into());
    let start = table
        .entry("start")
        .or_insert_with(|| toml::Table::new().into());
    let start = start.as_table_mut().ok_or("[start] is not a table")?;
    for (name, value) in values {
        start.insert(name.clone(), (*value).into());
    }
    toml::to_string(&table).map_err(|e| e.to_string())
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
