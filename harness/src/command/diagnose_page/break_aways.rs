//! What the force at break-away depends on: each event predicted from the others of its run.

use super::{Material, side_by_side};
use crate::diagnose::data::break_away::BreakAways;
use crate::diagnose::model::profile_values::values_along;
use crate::report::{Axis, Cell, Colour, Page, Plot, Table, number};

/// Points of the line along the belt.
const POINTS: usize = 400;

/// The part of the section on break-aways; nothing where no run has enough of them.
pub fn section(page: Page, material: &Material) -> Page {
    let told: Vec<(usize, &BreakAways)> = material
        .problem
        .break_aways
        .iter()
        .enumerate()
        .filter(|(_, b)| b.fall_by_place.is_finite())
        .collect();
    if told.is_empty() {
        return page;
    }
    let page = page.subsection("Break-away along the belt").paragraph(
        "Each break-away after a whole stick is predicted from the others of its run: by their mean, by those near it on the belt, and by the force with which the stick began, \
         which is known before the threshold is met. What the place takes away of the error speaks for friction that depends on the place (or on time, where each place is passed once); \
         what the beginning takes away speaks for ageing. Where modes ring, the force just before a transition is known roughly only, and single runs show a fall where nothing depends on the place.",
    );
    let header = [
        "run",
        "break-aways",
        "mean force over normal force",
        "error of the mean of the others",
        "taken away by the place",
        "by chance",
        "taken away by the beginning of the stick",
    ];
    let percent = |share: f64| Cell::Number(format!("{:.0} %", 100.0 * share));
    let table = told.iter().fold(Table::new(&header), |table, (_, b)| {
        table.row(vec![
            Cell::Text(b.file.clone()),
            Cell::Number(b.events.to_string()),
            Cell::Number(number(b.mean, 3)),
            Cell::Number(number(b.scatter, 2)),
            percent(b.fall_by_place),
            Cell::Number(number(b.fall_by_place_by_chance, 1)),
            percent(b.fall_by_dwell_foretold),
        ])
    });
    let plots: Vec<Plot> = told
        .iter()
        .filter_map(|(run, b)| along(material, *run, b))
        .collect();
    side_by_side(page.table(&table), &plots)
}

fn along(material: &Material, run: usize, found: &BreakAways) -> Option<Plot> {
    let map = material.problem.tracks[run].map.as_ref()?;
    let (x, y): (Vec<f64>, Vec<f64>) = map
        .events()
        .iter()
        .map(|e| (1e3 * e.place, e.force))
        .unzip();
    let from = x.iter().copied().fold(f64::INFINITY, f64::min);
    let to = x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let places: Vec<f64> = (0..POINTS)
        .map(|i| from + (to - from) * i as f64 / (POINTS - 1) as f64)
        .collect();
    let near: Vec<f64> = places
        .iter()
        .map(|s| found.mean * (1.0 + map.at(1e-3 * s)))
        .collect();
    let mut plot = Plot::new(
        Axis::linear("belt travel", "mm"),
        Axis::linear("break-away force over normal force", "1"),
    )
    .size(620.0, 260.0)
    .level("mean", Colour::Grey, found.mean)
    .scatter("break-aways", Colour::Ink, &x, &y)
    .line("weighted mean near the place", Colour::Blue, &places, &near);
    if let Some((s, mu)) = profile(material, run) {
        plot = plot.line("profile found, level mu_0 (1 + g)", Colour::Red, &s, &mu);
    }
    Some(plot.caption(&format!(
        "{}: forces at break-away along the belt; knowing the place takes away {:.0} % of the error of predicting each from the others (width {} mm).",
        found.file,
        100.0 * found.fall_by_place,
        number(1e3 * found.place_width_m, 2)
    )))
}

/// Places in mm and static friction there by the nodes of the last step's profile; `None` if it has none.
fn profile(material: &Material, run: usize) -> Option<(Vec<f64>, Vec<f64>)> {
    let step = material.steps.last()?;
    let h = &step.fitted.hypothesis;
    let point = step.point(material.problem, run);
    let per_run = |name: &str| {
        let i = h.per_run[run].iter().position(|k| k.name == name)?;
        Some(h.per_run[run][i].value(point.per_run[run][i]))
    };
    let mu_0 = h.shared_index("friction.mu_0")?;
    let scale = h.shared[mu_0].value(point.shared[mu_0]) * per_run("friction.level")?;
    let nodes: (Vec<f64>, Vec<f64>) = values_along(&h.per_run[run], &point.per_run[run])
        .into_iter()
        .map(|(s, g)| (1e3 * s, scale * (1.0 + g)))
        .unzip();
    (!nodes.0.is_empty()).then_some(nodes)
}
