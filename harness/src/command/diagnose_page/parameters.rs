//! The calibrated values with their confidence, and how far they move when the effect is added.

use super::Material;
use super::verdict::with_interval;
use super::views::COLOURS;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::validation::estimate::estimate;
use crate::report::{Axis, Cell, Colour, Page, Plot, Table, number};

/// The section.
pub fn section(page: Page, material: &Material) -> Page {
    let page = page
        .section(super::SECTIONS[6])
        .paragraph("± is half the width of the 95 % interval (1.96 standard deviations), as far as the model is right. The same folder holds these values as model.toml, as an SSP parameter file (.ssv) and as the start values of an FMU. What differs from run to run, one FMU has but once; so it also holds a parameter set and start states for each run (the folder runs, and resources/runs in the FMU). `compare` finds them there and shows, as NRMSE from start states, the last error of each run again:")
        .code(&compare_again(material));
    let page = page.table(&values(material)).figure(&shift(material));
    page.subsection("Run-specific parameters")
        .table(&per_run(material))
}

/// The command that compares with the calibrated FMU.
fn compare_again(material: &Material) -> String {
    format!(
        "stickslip compare {} --fmu {}",
        material.problem.campaign.folder.display(),
        material
            .output
            .join(crate::command::repaired_model::file_name(
                material.problem.fmu
            ))
            .display()
    )
}

/// Models whose values are shown: calibrated, and the last rung if an effect was added.
fn all_fitted<'a>(material: &'a Material) -> Vec<(String, &'a FittedHypothesis)> {
    let steps = material.steps;
    let mut out = vec![("calibrated".to_owned(), &steps[0].fitted)];
    if steps.len() > 1
        && material.diagnosis.verdict
            != crate::diagnose::result::diagnosis::Verdict::NoMissingEffect
    {
        out.push((
            material.views.pair[1].name.clone(),
            &steps[steps.len() - 1].fitted,
        ));
    }
    out
}

fn values(material: &Material) -> Table {
    let all_fitted = all_fitted(material);
    let longest = all_fitted[all_fitted.len() - 1].1;
    let header: Vec<&str> = ["parameter", "given"]
        .into_iter()
        .chain(all_fitted.iter().map(|t| t.0.as_str()))
        .collect();
    longest
        .hypothesis
        .shared
        .iter()
        .fold(Table::new(&header), |table, parameter| {
            let known = all_fitted[0]
                .1
                .hypothesis
                .shared_index(&parameter.name)
                .is_some();
            let unit = if parameter.unit == "1" {
                String::new()
            } else {
                format!(" {}", parameter.unit)
            };
            let mut cells = vec![
                Cell::Text(parameter.name.clone()),
                Cell::Number(if known {
                    format!("{}{unit}", number(parameter.prior, 4))
                } else {
                    "–".into()
                }),
            ];
            for (_, fitted) in &all_fitted {
                cells.push(match fitted.hypothesis.shared_index(&parameter.name) {
                    None => Cell::Number("–".into()),
                    Some(i) => {
                        let found = estimate(&fitted.hypothesis, &fitted.fit, i);
                        let text = with_interval(&found);
                        if found.at_bound {
                            Cell::Alert(text)
                        } else {
                            Cell::Number(text)
                        }
                    }
                });
            }
            table.row(cells)
        })
}

fn shift(material: &Material) -> Plot {
    let all_fitted = all_fitted(material);
    let base = &all_fitted[0].1.hypothesis.shared;
    // A share of nothing says nothing: how late a sensor is stands in the table.
    let shown: Vec<usize> = (0..base.len()).filter(|&i| base[i].prior != 0.0).collect();
    let names: Vec<String> = shown.iter().map(|&i| base[i].name.clone()).collect();
    let height = 90.0 + 26.0 * names.len() as f64;
    let mut plot = Plot::new(
        Axis::symlog("change from the value given", "%", 1.0),
        Axis::rows(&names),
    )
    .size(1000.0, height)
    .upright("as given", Colour::Grey, 0.0);
    for (n, (name, fitted)) in all_fitted.iter().enumerate() {
        let offset = if all_fitted.len() == 1 {
            0.0
        } else {
            0.36 * n as f64 - 0.18
        };
        let (mut row, mut middle, mut low, mut high) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for (place, &i) in shown.iter().enumerate() {
            let found = estimate(&fitted.hypothesis, &fitted.fit, i);
            let percent = |v: f64| 100.0 * (v / base[i].prior - 1.0);
            row.push(place as f64 + offset);
            middle.push(percent(found.value));
            let half = found.half_width().unwrap_or(f64::NAN);
            low.push(percent(found.value - half));
            high.push(percent(found.value + half));
        }
        plot = plot.intervals(name, COLOURS[n], &row, &middle, &low, &high);
    }
    plot.caption("How far calibration moved each parameter, with 95 % intervals: a model that lacks an effect bends its parameters to make up for it, and they come back when the effect is added.")
}

/// How the names of further sensors' constants begin.
const OF_FURTHER_SENSORS: &str = "further_sensor.";

fn per_run(material: &Material) -> Table {
    let runs = &material.diagnosis.runs;
    // Profiles have dozens of nodes per run; they are in diagnosis.json.
    let names: Vec<&String> = runs.first().map_or(Vec::new(), |r| {
        r.per_run
            .keys()
            .filter(|k| {
                k.starts_with(OF_FURTHER_SENSORS) || !(k.contains("node") || k.contains('['))
            })
            .collect()
    });
    let header: Vec<&str> = std::iter::once("run")
        .chain(names.iter().map(|n| n.as_str()))
        .collect();
    runs.iter().fold(Table::new(&header), |table, run| {
        let cells = names
            .iter()
            .map(|n| Cell::Number(run.per_run.get(*n).map_or("–".into(), |v| number(*v, 4))));
        table.row(
            std::iter::once(Cell::Text(run.name.clone()))
                .chain(cells)
                .collect(),
        )
    })
}
