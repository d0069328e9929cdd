//! What scripts read: the results, or the points still to be computed.

use std::path::Path;

use beam_physics::sweep::Section;
use serde_json::{Value, json};

use super::plan::{Plan, Row};
use super::study::Study;
use super::terminal::{Group, coexisting};
use crate::provenance::Provenance;

/// The table and the coexisting motions.
pub fn results(study: &Study, provenance: &Provenance) -> String {
    let rows: Vec<Value> = study
        .rows
        .iter()
        .zip(&study.results)
        .map(|(row, r)| {
            json!({
                "at": at(study.plan, &row.at),
                "start": row.start,
                "period": r.period,
                "main_frequency_hz": r.main_frequency,
                "amplitude_m": r.amplitude,
                "stick_fraction": r.stick_fraction,
                // Minus infinity has no JSON form; the difference of motions has died out altogether.
                "lyapunov_per_s": r.lyapunov.map(|l| if l.is_finite() { json!(l) } else { json!(l.to_string()) }),
                "status": r.status,
            })
        })
        .collect();
    let groups: Vec<Value> = coexisting(study)
        .iter()
        .map(|g: &Group| {
            json!({
                "at": at(study.plan, &g.at), "share": g.share, "motion": g.name, "period": g.period,
                "main_frequency_hz": g.frequency, "amplitude_m": g.amplitude,
            })
        })
        .collect();
    let all = json!({ "plan": study.plan.identity(), "rows": rows, "coexisting": groups });
    provenance.json(&all)
}

fn at(plan: &Plan, values: &[f64]) -> Value {
    let pairs = plan.axes.iter().zip(values);
    pairs
        .map(|(axis, value)| (axis.name.clone(), json!(value)))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

/// The points as tasks for a cluster: what to set in the FMU, how to start, and the row's key.
pub fn tasks(plan: &Plan, rows: &[Row], folder: &Path) -> String {
    let rule = &plan.rule;
    let (section, period) = match rule.section {
        Section::Peak => (0, 0.0),
        Section::Release => (1, 0.0),
        Section::Stroboscopic { period } => (2, period),
    };
    let set: serde_json::Map<String, Value> = plan
        .settings
        .iter()
        .map(|(name, value)| (name.clone(), json!(value)))
        .collect();
    let chains: Vec<Value> = plan
        .chains(rows)
        .iter()
        .map(|chain| {
            let tasks = chain.tasks.iter().map(|task| {
                let row = &rows[task.id];
                json!({ "id": task.id, "key": row.key(), "set": at(plan, &row.at), "start": row.rule_numbers() })
            });
            tasks.collect::<Vec<_>>().into()
        })
        .collect();
    let all = json!({
        "set": set, "start_is_given": plan.settings.iter().any(|(name, _)| super::plan::is_start(name)),
        "rule": { "settle": rule.settle, "cycles": rule.cycles, "patience": rule.patience, "section": section, "strobe_period": period },
        "fmu_guid": plan.guid, "chains": chains, "folder": folder, "keys": plan.axes.len() + 1,
    });
    serde_json::to_string(&all).expect("plain values")
}
