//! figures.html.

use super::{PaperFigure, Verdict};
use crate::provenance::Provenance;
use crate::report::{Cell, Colour, Figure, Page, Table};

/// The finished document.
pub fn html(figures: &[PaperFigure], provenance: &Provenance) -> String {
    let mut summary = Table::new(&["figure", "what", "verdict"]);
    for figure in figures {
        for claim in &figure.claims {
            summary = summary.row(vec![
                Cell::Text(figure.number.into()),
                Cell::Text(figure.title.clone()),
                Cell::Text(claim.verdict.words().into()),
            ]);
        }
    }
    let claims = || figures.iter().flat_map(|f| &f.claims);
    let agreeing = claims().filter(|c| c.verdict == Verdict::Agrees).count();
    let headline = format!("{agreeing} of {} claims agree.", claims().count());
    let mut page = Page::new(
        "The paper's numerical figures",
        "P. Stelter, Nonlinear Vibrations of Structures Induced by Dry Friction (1992), beside what this model shows.",
    )
    .banner(Colour::Blue, &headline, "", &[])
    .table(&summary)
    .paragraph(
        "The paper gives neither the beam's dimensions nor start states nor the ranges of some axes; modal mass and ranges are this model's \
         own. Where several motions coexist, diagrams show those reached from a fixed start (stick, bent by 0.95 of the break-away \
         force) and by continuation upwards and downwards.",
    );
    for figure in figures {
        page = page.section(&format!("Figure {}: {}", figure.number, figure.title));
        for claim in &figure.claims {
            page = page.list(&[
                format!("Paper: {}", claim.paper),
                format!("This model: {}.", claim.model),
                format!("Verdict: {}.", claim.verdict.words()),
            ]);
        }
        let pictures: Vec<&dyn Figure> = figure.pictures.iter().map(|(_, p)| p.as_ref()).collect();
        page = match pictures.as_slice() {
            [only] => page.figure(*only),
            many => page.figures(many),
        };
    }
    page.foot(&provenance.lines()).html()
}
