//! The curve of an unknown function, with its band, over where the data lie; and its hysteresis loop.

use super::Material;
use crate::diagnose::result::beyond_catalogue::{argument_in_words, place_in_words};
use crate::diagnose::result::hysteresis::Loop;
use crate::diagnose::result::unknown::Unknown;
use crate::metric::half_width;
use crate::report::{Axis, Colour, Figure, Page, Plot, number};

/// Share of the picture's height that the tallest bar of the histogram takes.
const TALLEST: f64 = 0.3;

/// Adds the section where something unknown was fitted.
pub fn section(page: Page, material: &Material) -> Page {
    let Some(unknown) = &material.diagnosis.unknown else {
        return page;
    };
    let page = page.section("Where the unknown physics acts");
    let page = match (&unknown.curve[..], &unknown.hysteresis) {
        ([], _) => page,
        (_, Some(found)) => {
            let figures: [&dyn Figure; 2] = [&curve(unknown), &hysteresis(unknown, found)];
            page.figures(&figures)
        }
        (_, None) => page.figure(&curve(unknown)),
    };
    let page = match &unknown.file {
        Some(_) => page.paragraph(
            "unknown.toml is this curve as an effect: stickslip pack --effect unknown.toml -o own.fmu puts it into an FMU.",
        ),
        None => page,
    };
    let page = page.paragraph(&unknown.words);
    let mut others: Vec<String> = unknown
        .alternatives
        .iter()
        .map(|a| {
            let place = a.target.replace('_', " ");
            let argument = a.argument.replace('_', " ");
            match a.is_same_motion {
                true => format!("The same motion of the tip: {place} over {argument}."),
                false => format!(
                    "Not distinguished by these data: {place} over {argument} ({:.0} %).",
                    100.0 * a.probability
                ),
            }
        })
        .collect();
    if !unknown.nearest_library_effects.is_empty() {
        others.push(format!(
            "Nearest effects of the library: {} (stickslip effects ID explains one).",
            unknown.nearest_library_effects.join(", ")
        ));
    }
    page.list(&others)
}

fn value_axis(unknown: &Unknown) -> Axis {
    let relative = if unknown.value_unit == "1" {
        "relative "
    } else {
        ""
    };
    Axis::linear(
        &format!("{relative}change of {}", unknown.target.replace('_', " ")),
        &unknown.value_unit,
    )
}

fn curve(unknown: &Unknown) -> Plot {
    let column = |i: usize| -> Vec<f64> { unknown.curve.iter().map(|c| c[i]).collect() };
    let (x, y) = (column(0), column(1));
    let half: Vec<f64> = column(2).iter().map(|std| half_width(*std)).collect();
    let edge = |sign: f64| -> Vec<f64> { y.iter().zip(&half).map(|(y, h)| y + sign * h).collect() };
    let (low, high) = (edge(-1.0), edge(1.0));
    let finite = || {
        low.iter()
            .chain(&high)
            .chain(&y)
            .copied()
            .filter(|v| v.is_finite())
    };
    let top = finite().fold(f64::NEG_INFINITY, f64::max);
    let least = finite().fold(f64::INFINITY, f64::min);
    let span = (top - least).max(1e-12);
    // The histogram stands below the curve, so that neither hides the other.
    let bottom = least - TALLEST * span;
    let tallest = unknown.samples.iter().map(|s| s[2]).fold(0.0, f64::max);
    let bars: Vec<(f64, f64)> = unknown
        .samples
        .iter()
        .flat_map(|[from, to, share]| {
            let height = bottom + TALLEST * span * share / tallest.max(1e-12);
            [(*from, height), (*to, height)]
        })
        .collect();
    let (bar_x, bar_y): (Vec<f64>, Vec<f64>) = bars.into_iter().unzip();
    let floor = vec![bottom; bar_x.len()];
    let past = if unknown.memory_s.is_some() {
        " of earlier times"
    } else {
        ""
    };
    let argument = argument_in_words(&unknown.argument).trim_start_matches("the ");
    Plot::new(
        Axis::linear(&format!("{argument}{past}"), &unknown.argument_unit)
            .from_to(x[0], x[x.len() - 1]),
        value_axis(unknown).from_to(bottom, top + 0.05 * span),
    )
    .band(
        &format!("samples (tallest: {} %)", number(100.0 * tallest, 2)),
        Colour::Grey,
        &bar_x,
        &floor,
        &bar_y,
    )
    .band("95 % interval", Colour::Purple, &x, &low, &high)
    .line("most probable", Colour::Purple, &x, &y)
    .caption(&format!(
        "The curve that explains the data best, as an unknown function of one quantity acting in one place: it {}. \
         The grey bars show where the samples of the runs fitted lie; beyond them the curve is what was believed before.",
        unknown.shape
    ))
}

fn hysteresis(unknown: &Unknown, found: &Loop) -> Plot {
    let place = place_in_words(&unknown.target);
    let argument = argument_in_words(&unknown.argument);
    let mut points = found.points.clone();
    points.extend(found.points.first().copied());
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().map(|p| (p[0], p[1])).unzip();
    Plot::new(
        Axis::linear(argument.trim_start_matches("the "), &unknown.argument_unit),
        value_axis(unknown),
    )
    .line(
        &format!("typical cycle of {}", found.cycles),
        Colour::Purple,
        &x,
        &y,
    )
    .caption(&found.words(place, argument))
}
