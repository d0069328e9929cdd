//! The files of a diagnosis.

use crate::command::{diagnose_page, pack, proposed_effect, repaired_model};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::assemble::{conclude, shown};
use crate::diagnose::result::diagnosis::Diagnosis;
use crate::diagnose::result::error_ladder::Step;
use crate::diagnose::result::run_sets::run_sets;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::stages;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::Campaign;
use crate::output::write_file;
use crate::provenance::Provenance;
use crate::watch::Watch;
use std::path::Path;

/// The diagnosis as a file.
const JSON: &str = "diagnosis.json";

/// The JSON text that [`report`] has written into `output`.
///
/// # Errors
/// A file that can't be read.
pub fn written_json(output: &Path) -> Result<String, Error> {
    let path = output.join(JSON);
    std::fs::read_to_string(&path).map_err(Error::read(&path))
}

/// Writes what a selection found into `output`; with the command, and the campaign as it was stated.
pub fn report(
    fmu: &Fmu,
    problem: &Problem,
    selection: &Selection,
    steps: &[Step],
    (command, stated): (&str, &Campaign),
    output: &Path,
    watch: &dyn Watch,
) -> Result<Diagnosis, Error> {
    let campaign = &problem.campaign;
    let diagnosis = conclude(problem, selection, steps)?;
    let provenance = Provenance::of_campaign(campaign, Some(fmu))?;
    let json = provenance.json(&diagnosis);
    write_file(&output.join(JSON), json.as_bytes())?;
    let written = &steps[shown(problem, selection, diagnosis.verdict, steps)];
    let choices = written.fitted.hypothesis.choices.iter();
    let ids: Vec<&str> = choices
        .map(|c| problem.catalogue[c.effect].id.as_str())
        .collect();
    let widened = pack::widened::with_effects_of(fmu, problem.fmu, &ids)?;
    let fmu = widened.as_ref().unwrap_or(fmu);
    repaired_model::write(fmu, &diagnosis, &run_sets(problem, written), output)?;
    proposed_effect::write(&diagnosis.proposed_terms, output)?;
    if let Some(curve) = diagnosis.unknown.as_ref().and_then(|u| u.file.as_ref()) {
        write_file(&output.join("unknown.toml"), curve.as_bytes())?;
    }
    watch.stage(stages::REPORT);
    let command = format!(
        "stickslip {command} {} -o {}",
        campaign.folder.display(),
        output.display()
    );
    let page = diagnose_page::html(
        problem,
        selection,
        steps,
        &diagnosis,
        (output, stated),
        (&command, &provenance),
    )?;
    write_file(&output.join("report.html"), page.as_bytes())?;
    Ok(diagnosis)
}
