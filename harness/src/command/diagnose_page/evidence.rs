//! Which effect: the candidates' ranking, what can't be told apart, and the cards of the effects found.

use super::Material;
use crate::diagnose::result::diagnosis::Verdict;
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::ties::others;
use crate::diagnose::thresholds::FLOOR_MEDIAN;
use crate::report::{Axis, Bars, Cell, Colour, Page, Plot, Table, number};

/// Candidates that the pictures show.
const SHOWN: usize = 24;

/// One row of the ranking.
struct Entry<'a> {
    name: String,
    gain: f64,
    model: &'a FittedModel,
    believed: bool,
}

/// The section.
pub fn section(page: Page, material: &Material) -> Page {
    let entries = ranking(material);
    let page = page.section(super::SECTIONS[4]).paragraph(&format!(
        "Every candidate is fitted together with all nuisances (frequencies, damping, mass, friction law, friction level and offset of each run, start states). \
         Its gain is that of the evidence (natural logarithm, nats) over the calibrated model: how much better the data fit, less the price of all that it may choose. \
         A first look ends after a few steps, since others came nearer to the data. \
         What is refuted gains on the segments compared, and fails on all of the runs fitted: a run is not met, what remains is far from white, or the structure is bent. \
         A gain of {:.1} makes up for the prior odds of one kind among all; a name is given only if the error also comes down to the noise.",
        material.selection.threshold
    ));
    if entries.is_empty() {
        return page.paragraph("No candidate was tried.");
    }
    let page = page.figures(&[
        &gains(&entries, material.selection.threshold),
        &adequacy(&entries),
    ]);
    let page = confusion(page, material)
        .subsection("All candidates")
        .table(&table(material, &entries));
    cards(page, material)
}

fn ranking<'a>(material: &'a Material) -> Vec<Entry<'a>> {
    let selection = material.selection;
    let base = selection.calibrated.score();
    let found = material.diagnosis.verdict == Verdict::EffectFound || selection.beyond.is_some();
    let on_path = selection.path.iter().map(|c| (c, true));
    let others = selection
        .singles
        .iter()
        .chain(selection.listed_pairs())
        .map(|c| (c, false));
    let mut all: Vec<Entry> = on_path
        .chain(others)
        .map(|(model, path)| Entry {
            name: label(material, model),
            gain: base - model.score(),
            model,
            believed: path && found,
        })
        .collect();
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    all.truncate(SHOWN);
    all
}

/// The hypothesis' name with the settings by which its forms differ, and whether it was fitted to its end.
fn label(material: &Material, model: &FittedModel) -> String {
    let settings: Vec<String> = model
        .choices
        .iter()
        .flat_map(|c| {
            let card = &material.problem.catalogue[c.effect];
            c.settings
                .iter()
                .map(|(i, v)| format!("{} {}", card.parameters[*i].name, number(*v, 3)))
        })
        .collect();
    let marks: Vec<String> = settings
        .into_iter()
        .chain(model.is_passed_over.then(|| "first look".to_owned()))
        .chain(model.is_refuted.then(|| "refuted".to_owned()))
        .collect();
    let name = name(material.problem, &model.choices);
    if marks.is_empty() {
        name
    } else {
        format!("{name} ({})", marks.join(", "))
    }
}

fn gains(entries: &[Entry], threshold: f64) -> Bars {
    let names: Vec<String> = entries.iter().map(|e| e.name.clone()).collect();
    let values: Vec<f64> = entries.iter().map(|e| e.gain).collect();
    let mut bars = Bars::new(Axis::symlog("gain", "1", 10.0), &names)
        .series("tried (blue: found)", Colour::Grey, &values)
        .threshold("what chance reaches", threshold);
    for i in (0..entries.len()).filter(|&i| entries[i].believed) {
        bars = bars.highlight(i, Colour::Blue);
    }
    bars.caption("How much each candidate gains over the calibrated model; left of the dashed line nothing can be concluded.")
}

fn adequacy(entries: &[Entry]) -> Plot {
    let names: Vec<String> = entries.iter().map(|e| e.name.clone()).collect();
    let height = 90.0 + 22.0 * entries.len() as f64;
    let plot =
        Plot::new(Axis::log("error over noise", "1"), Axis::rows(&names)).size(620.0, height);
    let series = [
        (false, "tried", Colour::Grey),
        (true, "found", Colour::Blue),
    ];
    series
        .iter()
        .fold(plot, |plot, (believed, name, colour)| {
            let of: Vec<usize> = (0..entries.len()).filter(|&i| entries[i].believed == *believed).collect();
            if of.is_empty() {
                return plot;
            }
            let row: Vec<f64> = of.iter().map(|&i| i as f64).collect();
            let q = |share: f64| of.iter().map(|&i| entries[i].model.fit.quantile(share)).collect::<Vec<f64>>();
            plot.intervals(name, *colour, &row, &q(0.5), &q(0.25), &q(0.75))
        })
        .upright("noise level", Colour::Green, FLOOR_MEDIAN)
        .caption("What each candidate leaves unexplained on the runs fitted: median over the pieces, with the middle half; only at the dashed line is a model complete.")
}

fn confusion(page: Page, material: &Material) -> Page {
    let ties: Vec<String> = material
        .diagnosis
        .effects
        .iter()
        .filter(|e| !e.confounded_with.is_empty())
        .map(|e| {
            format!(
                "{} can't be distinguished from {}",
                e.id,
                e.confounded_with.join(", ")
            )
        })
        .collect();
    let page = page.subsection("Candidates that can't be distinguished");
    match (ties.is_empty(), material.diagnosis.verdict) {
        (false, _) => page.list(&ties),
        (true, Verdict::EffectFound) if material.selection.by_break_aways => page.paragraph(
            "Not compared: the effect is named by the break-aways, and no predicted motion reaches the noise level.",
        ),
        (true, Verdict::EffectFound) => {
            let others = others(material.problem, material.selection);
            page.paragraph(&format!("None. {others}"))
        }
        (true, _) => page.paragraph("No effect is named, so there is none to be confused."),
    }
}

fn table(material: &Material, entries: &[Entry]) -> Table {
    let header = [
        "candidate",
        "gain",
        "error over noise (fit, median)",
        "three in four below",
        "values found",
    ];
    entries.iter().fold(Table::new(&header), |table, entry| {
        table.row(vec![
            Cell::Text(entry.name.clone()),
            Cell::Number(number(entry.gain, 3)),
            Cell::Number(number(entry.model.fit.quantile(0.5), 3)),
            Cell::Number(number(entry.model.fit.quantile(0.75), 3)),
            Cell::Text(values(material, entry.model)),
        ])
    })
}

/// The effects' own parameters of a candidate.
fn values(material: &Material, model: &FittedModel) -> String {
    let problem = material.problem;
    let is_effect = |name: &str| {
        model
            .choices
            .iter()
            .any(|c| name.starts_with(&format!("{}.", problem.catalogue[c.effect].id)))
    };
    let fitted = &model.fitted;
    let list: Vec<String> = fitted
        .hypothesis
        .shared
        .iter()
        .zip(&fitted.fit.point.shared)
        .filter(|(parameter, _)| is_effect(&parameter.name))
        .map(|(parameter, at)| {
            let short = parameter
                .name
                .split_once('.')
                .map_or(parameter.name.as_str(), |n| n.1);
            let unit = if parameter.unit == "1" {
                String::new()
            } else {
                format!(" {}", parameter.unit)
            };
            let bound = if parameter.is_at_bound(*at) {
                " (bound)"
            } else {
                ""
            };
            format!("{short} {}{unit}{bound}", number(parameter.value(*at), 3))
        })
        .collect();
    list.join(", ")
}

fn cards(mut page: Page, material: &Material) -> Page {
    for effect in &material.diagnosis.effects {
        let Some(card) = material
            .problem
            .catalogue
            .iter()
            .find(|c| c.id == effect.id)
        else {
            continue;
        };
        page = page
            .subsection(&format!("{}: {}", card.id, card.title))
            .paragraph(&card.description)
            .list(&[
                format!("Equation: {}", card.equation),
                format!("How it shows: {}", card.signature),
                format!("What looks alike: {}", card.confounders),
                format!("Source: {}", card.source),
            ]);
    }
    page
}
