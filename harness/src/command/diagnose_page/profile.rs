//! The friction profile along the belt that was found.

use super::{Material, scaled, side_by_side};
use crate::diagnose::model::belt_profile::is_profile;
use crate::diagnose::model::profile_values::values_along;
use crate::report::{Axis, Colour, Page, Plot, number};

/// The part of the section on friction along the belt; nothing where no profile was found, or where break-aways map it and show it.
pub fn section(page: Page, material: &Material) -> Page {
    let Some(step) = material.steps.last() else {
        return page;
    };
    let h = &step.fitted.hypothesis;
    let catalogue = &material.problem.catalogue;
    let mut choices = h.choices.iter();
    let profile = choices.find(|c| is_profile(&catalogue[c.effect]));
    let Some(choice) = profile.filter(|_| !material.problem.place_is_told()) else {
        return page;
    };
    let runs = material.problem.campaign.runs.iter().enumerate();
    let plots: Vec<Plot> = runs
        .map(|(r, run)| {
            let point = step.point(material.problem, r);
            let (places, values): (Vec<f64>, Vec<f64>) =
                values_along(&h.per_run[r], &point.per_run[r])
                    .into_iter()
                    .unzip();
            Plot::new(
                Axis::linear("belt travel", "mm"),
                Axis::linear("friction relative to the run's level", "%"),
            )
            .size(620.0, 260.0)
            .level("level of the run", Colour::Grey, 0.0)
            .line(
                "profile found",
                Colour::Red,
                &scaled(&places, 1e3),
                &scaled(&values, 1e2),
            )
            .caption(&format!(
                "{}: friction along the stretch of belt that this run passes.",
                run.name
            ))
        })
        .collect();
    let page = page.subsection("Friction along the belt").paragraph(&format!(
        "Each run passes its own stretch of the belt, and its profile is found from its motion alone. \
         The evidence is largest where profiles spread by {} % and change within {} mm (correlation length).",
        number(1e2 * choice.roughness.std, 2),
        number(1e3 * choice.roughness.length, 2)
    ));
    side_by_side(page, &plots)
}
