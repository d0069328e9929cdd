//! figures.html.

use super::PaperFigure;
use super::claim::Verdict;
use crate::provenance::Provenance;
use crate::report::{Axis, Bars, Cell, Colour, Figure, Page, Table};

fn verdict(verdict: Verdict) -> Cell {
    let words = verdict.words().into();
    match verdict {
        Verdict::Agrees => Cell::Number(words),
        Verdict::InPart | Verdict::Differs => Cell::Alert(words),
    }
}

/// How many of the numbers behind the claims of each figure keep their bounds.
fn kept(figures: &[PaperFigure]) -> Bars {
    let judged: Vec<&PaperFigure> = figures.iter().filter(|f| !f.claims.is_empty()).collect();
    let names: Vec<String> = judged
        .iter()
        .map(|f| format!("Figure {}", f.number))
        .collect();
    let count = |wanted: bool| -> Vec<f64> {
        let of = |f: &&PaperFigure| {
            f.claims
                .iter()
                .flat_map(|c| &c.findings)
                .filter(|f| f.holds() == wanted)
                .count()
        };
        judged.iter().map(|f| of(f) as f64).collect()
    };
    Bars::new(Axis::linear("numbers of the model", "1"), &names)
        .series("within the bound", Colour::Blue, &count(true))
        .series("beyond it", Colour::Orange, &count(false))
        .caption("For each figure of the paper, how many numbers of the model keep the bound that the paper's claim asks for.")
}

/// The finished document.
pub fn html(figures: &[PaperFigure], provenance: &Provenance) -> String {
    let mut summary = Table::new(&["figure", "the paper's claim", "verdict"]);
    for figure in figures {
        for claim in &figure.claims {
            summary = summary.row(vec![
                Cell::Text(figure.number.into()),
                Cell::Text(claim.paper.clone()),
                verdict(claim.verdict()),
            ]);
        }
    }
    let claims = || figures.iter().flat_map(|f| &f.claims);
    let agreeing = claims().filter(|c| c.verdict() == Verdict::Agrees).count();
    let headline = format!("{agreeing} of {} claims agree.", claims().count());
    let mut page = Page::new(
        "The paper's figures",
        "P. Stelter, Nonlinear Vibrations of Structures Induced by Dry Friction (1992): each figure from this model, and each claim held against \
         numbers with bounds.",
    )
    .banner(Colour::Blue, &headline, "", &[])
    .figure(&kept(figures))
    .table(&summary)
    .paragraph(
        "A claim agrees if all its numbers keep their bounds, agrees in part if some do, differs if none does. The paper's measurements are not at \
         hand: of measured figures the panels show what the model has in their place.",
    )
    .paragraph(
        "The paper gives neither the beam's dimensions nor start states nor the ranges of some axes; modal mass and ranges are this model's \
         own. Where several motions coexist, diagrams show those reached from a fixed start (stick, bent by 0.95 of the break-away \
         force) and by continuation upwards and downwards.",
    );
    for figure in figures {
        page = page.section(&format!("Figure {}: {}", figure.number, figure.title));
        for claim in &figure.claims {
            let mut findings =
                Table::new(&["this model", "number", "bound", "kept", "why this bound"]);
            for f in &claim.findings {
                let kept = f.holds();
                findings = findings.row(vec![
                    Cell::Text(f.what.clone()),
                    Cell::Number(f.value_words()),
                    Cell::Number(f.bound_words()),
                    if kept {
                        Cell::Number("yes".into())
                    } else {
                        Cell::Alert("no".into())
                    },
                    Cell::Text(f.reason.clone()),
                ]);
            }
            page = page
                .subsection(&format!(
                    "{} The model {}.",
                    claim.paper,
                    claim.verdict().words()
                ))
                .table(&findings);
            if !claim.model.is_empty() {
                page = page.paragraph(&format!("{}.", claim.model));
            }
        }
        let pictures: Vec<&dyn Figure> = figure
            .pictures
            .iter()
            .map(|(_, p)| p as &dyn Figure)
            .collect();
        page = match pictures.as_slice() {
            [only] => page.figure(*only),
            many => page.figures(many),
        };
    }
    page.foot(&provenance.lines()).html()
}
