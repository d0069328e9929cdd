//! Bifurcation diagram or map, and the numbers beside it.

use beam_physics::sweep::{Section, sliding_deflection, static_amplitude};

use super::orbits::stretches;
use super::plan::{Axis as Parameter, Row, StartKind};
use super::study::Study;
use super::table::Result;
use super::terminal::name;
use crate::report::{Axis, Colour, Plot};

/// Points of a cloud in one picture: more would only make the page heavy.
const POINTS: usize = 60_000;

/// Metres as millimetres.
const MM: f64 = 1e3;

fn colour(kind: StartKind) -> Colour {
    match kind {
        StartKind::Fixed => Colour::Blue,
        StartKind::Up => Colour::Orange,
        StartKind::Down => Colour::Green,
        StartKind::Grid => Colour::Purple,
    }
}

fn legend(kind: StartKind) -> &'static str {
    match kind {
        StartKind::Fixed => "fixed start",
        StartKind::Up => "upwards",
        StartKind::Down => "downwards",
        StartKind::Grid => "grid of starts",
    }
}

fn over(parameter: &Parameter) -> Axis {
    let unit = if parameter.unit.is_empty() {
        "1"
    } else {
        &parameter.unit
    };
    let words = parameter.name.replace('_', " ");
    let axis = Axis::linear(&words, unit);
    let low = parameter
        .values
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min);
    let high = parameter
        .values
        .iter()
        .copied()
        .fold(f64::NEG_INFINITY, f64::max);
    let margin = if high > low {
        0.02 * (high - low)
    } else {
        0.05 * high.abs().max(1e-6)
    };
    axis.from_to(low - margin, high + margin)
}

/// What the section shows, in words.
fn section(study: &Study) -> &'static str {
    match study.plan.rule.section {
        Section::Peak => "tip displacement at w' = 0, falling",
        Section::Release => "tip displacement at the end of stick",
        Section::Stroboscopic { .. } => "tip displacement, stroboscopic",
    }
}

/// The picture of sweep.svg.
pub fn main(study: &Study) -> Plot {
    if study.plan.axes.len() == 2 {
        map(study, study.plan.starts[0])
    } else {
        bifurcation(study)
    }
}

/// The section points over the parameter, with eq. (8).
pub fn bifurcation(study: &Study) -> Plot {
    let parameter = &study.plan.axes[0];
    let caption = format!(
        "{} over {}, counted from the position of steady sliding: one point per return, so period one is one line and a cloud is irregular; dashed in \
         black: static amplitude w_A of eq. (8).",
        capital(section(study)),
        parameter.name
    );
    let total: usize = study.section.iter().map(Vec::len).sum();
    let every = total.div_ceil(POINTS).max(1);
    let mut plot = Plot::new(
        over(parameter),
        Axis::linear("w at the section, from steady sliding", "mm"),
    )
    .size(900.0, 460.0)
    .caption(&caption);
    for kind in &study.plan.starts {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        let rows = study.rows.iter().zip(&study.section);
        for (row, points) in rows.filter(|(row, _)| row.kind == *kind) {
            let zero = steady(study, row.at[0]);
            for w in points.iter().step_by(every) {
                x.push(row.at[0]);
                y.push(MM * (w - zero));
            }
        }
        plot = plot.cloud(legend(*kind), colour(*kind), &x, &y);
    }
    let all = &study.branches.all;
    for (stable, name) in [(true, "orbit, stable"), (false, "orbit, unstable")] {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for branch in all {
            let (bx, by) = stretches(branch, stable);
            y.extend(bx.iter().zip(by).map(|(at, w)| w - MM * steady(study, *at)));
            x.extend(bx);
            x.push(f64::NAN);
            y.push(f64::NAN);
        }
        if x.iter().any(|v| v.is_finite()) {
            plot = match stable {
                true => plot.thin_line(name, Colour::Red, &x, &y),
                false => plot.dashed_line(name, Colour::Red, &x, &y),
            };
        }
    }
    let (x, y) = static_line(study);
    plot.dashed_line("static amplitude w_A, eq. (8)", Colour::Ink, &x, &y)
}

/// Position of steady sliding in m.
fn steady(study: &Study, value: f64) -> f64 {
    let model = study.plan.values(&[value]).model();
    model.map_or(f64::NAN, |m| sliding_deflection(&m))
}

/// w_A in mm over the first parameter.
fn static_line(study: &Study) -> (Vec<f64>, Vec<f64>) {
    let mut x = study.plan.axes[0].values.clone();
    x.sort_by(f64::total_cmp);
    let y = x
        .iter()
        .map(|value| {
            let model = study.plan.values(&[*value]).model();
            model.map_or(f64::NAN, |m| MM * static_amplitude(&m))
        })
        .collect();
    (x, y)
}

/// A number of the table over the parameter.
pub fn quantity(
    study: &Study,
    title: &str,
    unit: &str,
    caption: &str,
    value: impl Fn(&Result) -> Option<f64>,
) -> Plot {
    let mut plot = Plot::new(over(&study.plan.axes[0]), Axis::linear(title, unit)).caption(caption);
    for kind in &study.plan.starts {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        let rows = study.rows.iter().zip(&study.results);
        for (row, r) in rows.filter(|(row, _)| row.kind == *kind) {
            if let Some(v) = value(r).filter(|v| v.is_finite()) {
                x.push(row.at[0]);
                y.push(v);
            }
        }
        plot = if x.len() <= 200 {
            plot.scatter(legend(*kind), colour(*kind), &x, &y)
        } else {
            plot.cloud(legend(*kind), colour(*kind), &x, &y)
        };
    }
    plot
}

/// The rows that stand for their points: those of a kind of start, of a grid the ones with the largest amplitude.
pub fn representative<'a>(study: &'a Study, kind: StartKind) -> Vec<(&'a Row, &'a Result)> {
    let mut found: Vec<(&Row, &Result)> = Vec::new();
    let rows = study.rows.iter().zip(&study.results);
    for (row, r) in rows.filter(|(row, _)| row.kind == kind) {
        match found.last_mut() {
            Some(last) if last.0.at == row.at => {
                if r.amplitude > last.1.amplitude {
                    *last = (row, r);
                }
            }
            _ => found.push((row, r)),
        }
    }
    found
}

/// The kinds of motion over two parameters, from one kind of start.
pub fn map(study: &Study, kind: StartKind) -> Plot {
    let from = match kind {
        StartKind::Grid => "the largest of a grid of starts",
        other => legend(other),
    };
    let caption = format!(
        "Kind of motion over {} and {} ({from}): Figure 12 of the paper for any two parameters.",
        study.plan.axes[0].name, study.plan.axes[1].name,
    );
    let first = study
        .plan
        .base
        .get("mode[1].frequency")
        .unwrap_or(f64::INFINITY);
    let class = |r: &Result| match (name(r).as_str(), r.period) {
        ("period 1", _) if r.main_frequency.is_some_and(|f| f > first) => 1,
        ("period 1", _) => 0,
        (_, Some(2..=4)) if r.status == "ok" => 2,
        (_, Some(p)) if r.status == "ok" && p > 4 => 3,
        ("irregular", _) => 4,
        ("settling" | "unresolved", _) => 5,
        ("no vibration", _) => 6,
        _ => 7,
    };
    let classes = [
        ("period one", Colour::Blue),
        ("period one, above the first natural frequency", Colour::Sky),
        ("period two to four", Colour::Green),
        ("longer periods", Colour::Purple),
        ("irregular", Colour::Orange),
        ("unresolved or still settling", Colour::Ink),
        ("no vibration", Colour::Grey),
        ("failed or without section", Colour::Red),
    ];
    let mut plot = Plot::new(over(&study.plan.axes[0]), over(&study.plan.axes[1]))
        .size(900.0, 560.0)
        .caption(&caption);
    let rows = representative(study, kind);
    for (i, (title, colour)) in classes.into_iter().enumerate() {
        let here = rows.iter().filter(|(_, r)| class(r) == i);
        let (x, y): (Vec<f64>, Vec<f64>) = here.map(|(row, _)| (row.at[0], row.at[1])).unzip();
        if !x.is_empty() {
            plot = plot.scatter(title, colour, &x, &y);
        }
    }
    plot
}

/// A sentence's first letter as a capital.
pub fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}
