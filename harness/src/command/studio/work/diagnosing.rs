//! The whole diagnosis from the page, with stages and progress.

use super::{Bench, Finding, keep};
use crate::command::diagnose::{self, Search};
use crate::command::repaired_model::file_name;
use crate::command::studio::desk::Desk;
use crate::command::studio::ladder::Origin;
use crate::command::studio::model::{Draft, bounds, hypothesis};
use crate::command::studio::preview::careful_to_its_end;
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::result::diagnosis::Diagnosis;
use crate::error::Error;
use crate::output::make_folder;
use crate::watch::{Stage, Watch};

/// Folder of its files.
const FOLDER: &str = "diagnosis";
/// Its files that are worth showing, besides those of the model.
const FILES: [&str; 3] = ["report.html", "diagnosis.json", "model.toml"];

/// Passes progress on to the board.
struct Reporter<'a>(&'a Desk);

impl Watch for Reporter<'_> {
    fn stage(&self, stage: Stage) {
        self.0.progress(|p| {
            p.words = stage.name.to_owned();
            // A stage says where it ends; it begins where the one before ended.
            p.share = Some(p.stage_end);
            p.stage_end = stage.until.max(p.stage_end);
        });
    }
    fn step(&self, what: &str, done: usize, of: usize) {
        self.0.progress(|p| {
            let stage = p.words.split(':').next().unwrap_or_default().to_owned();
            p.words = format!("{stage}: {done} of {of}: {what}");
        });
    }
    fn stop(&self) -> bool {
        self.0.is_cancelled()
    }
}

/// Diagnoses the campaign and adds what was found as a rung.
///
/// # Errors
/// Whatever a diagnosis fails with.
pub fn diagnose(bench: &Bench) -> Result<Finding, Error> {
    let (folder, inside) = bench.desk.folder(FOLDER);
    make_folder(&folder)?;
    let reporter = Reporter(bench.desk);
    let search = Search::default();
    let found = diagnose::diagnose(bench.fmu, bench.campaign, &search, &folder, &reporter)?;
    let draft = draft(bench, &found)?;
    let first = bench.desk.read(|board| {
        let ladder = board.ladder.as_ref();
        ladder.map_or(0, |ladder| ladder.rungs[0].id)
    });
    let name = match found.effects.as_slice() {
        [] => "diagnosis: calibrated".to_owned(),
        effects => {
            let ids: Vec<&str> = effects.iter().map(|e| e.id.as_str()).collect();
            format!("diagnosis: {}", ids.join(" + "))
        }
    };
    // It may be far from the model given, from which its segments would start.
    let reached = careful_to_its_end(bench.problem, &draft, None)?;
    let kept = keep(
        bench,
        &draft,
        first,
        (Origin::Diagnosis, name),
        Some(&reached),
    )?;
    let Finding::Rung { id, .. } = kept else {
        return Ok(kept);
    };
    let stopped = if bench.desk.is_cancelled() {
        "Stopped before its end; it goes on from there when it is begun again. "
    } else {
        ""
    };
    let fmu = file_name(bench.fmu);
    let model = [fmu.replace(".fmu", ".ssv"), fmu];
    let files = FILES.map(str::to_owned).into_iter().chain(model);
    let files = files.filter(|file| folder.join(file).is_file());
    Ok(Finding::Diagnosis {
        summary: format!("{stopped}{}", found.summary),
        rung: id,
        files: files.map(|file| format!("{inside}/{file}")).collect(),
        command: format!(
            "stickslip diagnose {} -o {}",
            bench.given.display(),
            folder.display()
        ),
    })
}

/// What a diagnosis found, as a model of the page. Effects that only the diagnosis has (curves of unknown functions) are left out.
fn draft(bench: &Bench, found: &Diagnosis) -> Result<Draft, Error> {
    let problem = bench.problem;
    let mut draft = Draft::default();
    for effect in &found.effects {
        if problem.catalogue.iter().any(|card| card.id == effect.id) {
            draft.effects.insert(effect.id.clone(), Default::default());
        }
    }
    let h = hypothesis(problem, &draft)?;
    let clamped = |p: &Parameter, value: f64| {
        let (min, max) = bounds(p);
        value.clamp(min, max)
    };
    for parameter in &h.shared {
        let of_effects = found.effects.iter().find_map(|effect| {
            let name = parameter.name.strip_prefix(&format!("{}.", effect.id))?;
            effect.parameters.get(name)
        });
        let value = of_effects
            .or_else(|| found.calibrated.get(&parameter.name))
            .or_else(|| found.inputs.get(&parameter.name));
        if let Some(estimate) = value {
            let value = clamped(parameter, estimate.value);
            draft.shared.insert(parameter.name.clone(), value);
        }
    }
    for (r, run) in problem.campaign.runs.iter().enumerate() {
        let Some(own) = found.runs.iter().find(|of| of.name == run.name) else {
            continue;
        };
        let values = draft.own.entry(run.name.clone()).or_default();
        for parameter in h.per_run[r].iter().filter(|p| p.support.is_none()) {
            if let Some(&value) = own.per_run.get(&parameter.name) {
                let turn = std::f64::consts::TAU;
                let value = match parameter.is_phase() {
                    true => value - turn * (value / turn).round(),
                    false => value,
                };
                values.insert(parameter.name.clone(), clamped(parameter, value));
            }
        }
    }
    Ok(draft)
}
