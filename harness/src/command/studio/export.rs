//! The files of a rung: FMU, parameter set, model.toml, campaign with roles, report, and the command lines that do the same.

use std::path::{Path, PathBuf};

use super::model::{Values, hypothesis};
use super::work::{Bench, Finding, as_fitted, settled};
use crate::command::{compare, pack, repaired_model};
use crate::diagnose::result::error_ladder::Step;
use crate::diagnose::result::run_sets::run_sets;
use crate::diagnose::validation::segment_errors::{SegmentErrors, of_fit};
use crate::error::Error;
use crate::fmu::Fmu;
use crate::output::{make_folder, write_file};

/// Variables that belong to a run and not to the model.
const OF_RUNS: [&str; 6] = [
    "belt_velocity",
    "normal_force",
    "external_force",
    "clamp_acceleration",
    "friction.level",
    "sensor.offset",
];

/// Writes a rung's files into a folder `export/NUMBER`.
///
/// # Errors
/// A rung that is not there, a folder that can't be written.
pub fn export(bench: &Bench, id: u64) -> Result<Finding, Error> {
    let (desk, problem) = (bench.desk, bench.problem);
    let draft = desk.read(|board| {
        let ladder = board.ladder.as_ref();
        let ladder = ladder.ok_or_else(|| super::desk::closed(None))?;
        ladder.rung(id).map(|rung| rung.draft.clone())
    })?;
    let (folder, inside) = desk.folder(&format!("export/{id}"));
    make_folder(&folder)?;
    desk.progress(|p| p.words = "start states of every segment".into());
    let fitted = as_fitted(&settled(bench, &draft, id)?);
    let all: Vec<usize> = (0..problem.segments.len()).collect();
    let errors = of_fit(problem, &all, &fitted.fit);
    // Nothing was judged apart: every segment belongs to what is written.
    let holdout = SegmentErrors {
        by_run: vec![f64::NAN; problem.campaign.runs.len()],
        ..errors.clone()
    };
    let step = Step {
        fitted,
        fit: errors,
        holdout,
        spectral_ratio: f64::NAN,
    };
    let sets = run_sets(problem, &step);
    let side = problem.fmu.side_file();
    let own = side.map_or(&[][..], |side| &side.constants);
    let is_per_run = |name: &str| own.iter().any(|c| c.per_run && c.variable == name);
    let is_of_run = |name: &str| OF_RUNS.iter().any(|of| problem.fmu.own_name(of) == name);
    let of_model = |(name, _): &&(String, f64)| !is_of_run(name) && !is_per_run(name);
    let values: Vec<(String, f64)> = sets[0]
        .parameters
        .iter()
        .filter(of_model)
        .cloned()
        .collect();
    let h = hypothesis(problem, &draft)?;
    let chosen = h
        .choices
        .iter()
        .map(|c| problem.catalogue[c.effect].id.as_str());
    let ids: Vec<&str> = chosen.collect();
    let widened = pack::widened::with_effects_of(bench.fmu, problem.fmu, &ids)?;
    let fmu = widened.as_ref().unwrap_or(bench.fmu);
    desk.progress(|p| p.words = "FMU and parameter sets".into());
    repaired_model::write_values(fmu, &values, &sets, &folder)?;
    write_campaign(bench, &folder.join("campaign"))?;
    desk.progress(|p| p.words = "report".into());
    let fmu_file = repaired_model::file_name(fmu);
    let written = Fmu::load(&folder.join(&fmu_file))?;
    compare::into_folder(&written, bench.campaign, &folder)?;
    let commands = commands(bench, &draft.effects, &folder);
    write_file(
        &folder.join("commands.txt"),
        (commands.join("\n") + "\n").as_bytes(),
    )?;
    let names = [
        "report.html",
        &fmu_file,
        &fmu_file.replace(".fmu", ".ssv"),
        "model.toml",
        "campaign/campaign.toml",
        "commands.txt",
    ];
    Ok(Finding::Files {
        files: names.map(|name| format!("{inside}/{name}")).to_vec(),
        commands,
    })
}

/// The command lines that do the same: the report of the files written, and the fit by hand of the same effects.
fn commands(
    bench: &Bench,
    effects: &std::collections::BTreeMap<String, Values>,
    folder: &Path,
) -> Vec<String> {
    let campaign = bench.given.display();
    let own = bench.desk.folder("").0;
    let own = own.display();
    let mut lines = vec![format!(
        "stickslip compare {campaign} --fmu {} -o {}",
        folder.join(repaired_model::file_name(bench.fmu)).display(),
        folder.display()
    )];
    let of_fmu = match bench.fmu.side_file() {
        Some(_) => format!(" --fmu {}", bench.fmu.path().display()),
        None => String::new(),
    };
    if !effects.is_empty() {
        let added: String = effects.keys().map(|id| format!(" --add {id}")).collect();
        lines.push(format!("stickslip try {campaign}{of_fmu}{added} -o try"));
    }
    lines.push(format!("stickslip studio {campaign}{of_fmu} -o {own}"));
    lines
}

/// Writes the campaign with the role that each run has: fitted, or kept out.
fn write_campaign(bench: &Bench, folder: &Path) -> Result<(), Error> {
    let path: PathBuf = match bench.given.is_dir() {
        true => bench.given.join("campaign.toml"),
        false => bench.given.to_owned(),
    };
    let text = std::fs::read_to_string(&path).map_err(Error::read(&path))?;
    let changed = |problem: String| Error::StudioState {
        path: path.clone(),
        problem,
    };
    let mut table: toml::Table = text.parse().map_err(|_| changed(CHANGED.into()))?;
    let runs = table.get_mut("run").and_then(toml::Value::as_array_mut);
    let runs = runs.ok_or_else(|| changed(CHANGED.into()))?;
    if runs.len() != bench.campaign.runs.len() {
        return Err(changed(CHANGED.into()));
    }
    make_folder(folder)?;
    for (r, (entry, run)) in runs.iter_mut().zip(&bench.campaign.runs).enumerate() {
        let name = run.file.file_name().unwrap_or(run.file.as_os_str());
        let name = format!("{:02}_{}", r + 1, name.to_string_lossy());
        let bytes = std::fs::read(&run.file).map_err(Error::read(&run.file))?;
        write_file(&folder.join(&name), &bytes)?;
        let role = match bench.problem.held_out[r] {
            true => "holdout",
            false => "fit",
        };
        let entry = entry
            .as_table_mut()
            .ok_or_else(|| changed(CHANGED.into()))?;
        // A run's name is its file's where none is given.
        entry
            .entry("name")
            .or_insert_with(|| run.name.clone().into());
        entry.insert("file".into(), name.into());
        entry.insert("role".into(), role.into());
    }
    let text = toml::to_string(&table).map_err(|e| changed(e.to_string()))?;
    write_file(&folder.join("campaign.toml"), text.as_bytes())
}

const CHANGED: &str = "the campaign has changed since it was read; reload it";
