//! The FMU's documentation/index.html, from its own variables.

use crate::fmu::{Causality, ModelDescription};
use crate::report::{Cell, Page, Table};

/// The page of the beam.
pub fn index(description: &ModelDescription) -> String {
    page(
        description,
        "A friction-driven stick-slip beam as an FMI 2.0 FMU for co-simulation and model exchange.",
        &[
            "A cantilever whose tip rubs on a moving belt, in modal coordinates: \
             q_j'' + (2 D_j w_j + d_j) q_j' + w_j^2 q_j = phi_j(1) F / m_j, tip displacement w = sum of phi_j(1) q_j. \
             F is the friction force on the tip, positive along the belt's motion: in slip it follows the friction law, \
             in stick it is the force that keeps the tip on the belt. Transitions between stick and slip are located \
             inside a communication step, so results do not depend on the step.",
            "After M. Stelter, Nonlinear vibrations of structures induced by dry friction, Nonlinear Dynamics 3 (1992) 329-345.",
        ],
    )
}

/// A model's page: a summary, paragraphs, and its variables.
pub fn page(description: &ModelDescription, summary: &str, paragraphs: &[&str]) -> String {
    let mut page = Page::new(&description.model_identifier, summary);
    for paragraph in paragraphs {
        page = page.paragraph(paragraph);
    }
    let groups = [
        ("Inputs", Causality::Input),
        ("Outputs", Causality::Output),
        ("Parameters", Causality::Parameter),
        ("Local variables", Causality::Local),
    ];
    for (title, causality) in groups {
        let mut table = Table::new(&["name", "unit", "start", "meaning"]);
        for variable in description
            .variables
            .iter()
            .filter(|v| v.causality == causality)
        {
            table = table.row(vec![
                Cell::Text(variable.name.clone()),
                Cell::Text(variable.unit.clone().unwrap_or_default()),
                Cell::Number(variable.start.clone().unwrap_or_default()),
                Cell::Text(variable.description.clone()),
            ]);
        }
        page = page.section(title).table(&table);
    }
    page.html()
}
