//! The curve of an unknown function, with its band.

use super::Material;
use crate::metric::half_width;
use crate::report::{Axis, Colour, Page, Plot};

/// Adds the section where something unknown was fitted.
pub fn section(page: Page, material: &Material) -> Page {
    let Some(unknown) = &material.diagnosis.unknown else {
        return page;
    };
    let column = |i: usize| -> Vec<f64> { unknown.curve.iter().map(|c| c[i]).collect() };
    let (x, y) = (column(0), column(1));
    let half: Vec<f64> = column(2).iter().map(|std| half_width(*std)).collect();
    let edge = |sign: f64| -> Vec<f64> { y.iter().zip(&half).map(|(y, h)| y + sign * h).collect() };
    let plot = Plot::new(
        Axis::linear(&unknown.argument.replace('_', " "), &unknown.argument_unit),
        Axis::linear(
            &format!("change of {}", unknown.target.replace('_', " ")),
            &unknown.value_unit,
        ),
    )
    .band("95 % interval", Colour::Purple, &x, &edge(-1.0), &edge(1.0))
    .line("most probable", Colour::Purple, &x, &y)
    .caption(&format!(
        "The curve that explains the data best, as an unknown function of one quantity acting in one place. {}",
        unknown.words
    ));
    let page = page
        .section("The unknown physics as a curve")
        .figure(&plot)
        .paragraph(
            "unknown.toml is this curve as an effect: stickslip pack --effect unknown.toml -o own.fmu puts it into an FMU.",
        );
    let mut others: Vec<String> = unknown
        .alternatives
        .iter()
        .map(|a| {
            format!(
                "Not told apart by these data: {} over {} ({:.0} %).",
                a.target.replace('_', " "),
                a.argument.replace('_', " "),
                100.0 * a.probability
            )
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
