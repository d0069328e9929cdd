//! dimension.html.

use super::series::Series;
use super::{pictures, terminal};
use crate::dimension::{Analysis, Verdict};
use crate::metric::half_width;
use crate::provenance::Provenance;
use crate::report::{Cell, Colour, Figure, Page, Table, number};

/// The finished document.
pub fn html(series: &Series, a: &Analysis, provenance: &Provenance) -> String {
    let table = terminal::rows(series, a).into_iter().fold(
        Table::new(&["quantity", "value"]),
        |table, (name, value)| table.row(vec![Cell::Text(name), Cell::Number(value)]),
    );
    let colour = match a.verdict {
        Verdict::Dimension => Colour::Green,
        Verdict::Periodic => Colour::Blue,
        _ => Colour::Orange,
    };
    let headline = match a.dimension() {
        Some(d) => {
            let half = half_width(a.std.unwrap_or(f64::NAN));
            format!("D = {d:.2} ± {} (95 %)", number(half, 2))
        }
        None => a.verdict.title().to_owned(),
    };
    let mut page = Page::new("Correlation dimension", &format!("{}.", series.name))
        .banner(colour, &headline, a.verdict.meaning(), &[])
        .figure(&pictures::slopes(series, a))
        .table(&table)
        .list(&a.remarks)
        .section("Embedding and correlation sum")
        .figures(&[&pictures::embedding(series, a), &pictures::sums(series, a)])
        .section("Is there a dimension?")
        .figures(&[&pictures::surrogates(series, a)]);
    if a.region.is_some() {
        page = page
            .figures(&[&pictures::over_dimensions(a)])
            .table(&per_dimension(a));
    }
    let (delay, separation) = (pictures::delay(series, a), pictures::separation(series, a));
    let divergence = pictures::divergence(series, a);
    let mut grounds: Vec<&dyn Figure> = vec![&delay, &separation];
    grounds.extend(divergence.iter().map(|d| d as &dyn Figure));
    page = page.section("What the choices rest on").figures(&grounds);
    let bound = format!(
        "With N = {} samples no dimension above 2 log10 N = {:.1} can be measured (Eckmann and Ruelle 1992). The bound is necessary, by far not \
         sufficient. The paper's D_C = 5.1 for its irregular motion rests on about 15 000 samples, where the bound is 8.4: it is not excluded. But with as \
         many samples a torus of five frequencies, a flow of dimension 5.1 and linear narrow-band noise all pass through slopes of 5 to 5.6 at m = 6, and \
         none is told from its surrogates: such a number says that the motion is not of low dimension, not how high it is.",
        a.samples - a.missing,
        a.eckmann_ruelle_bound()
    );
    page.section("What so many samples can show")
        .paragraph(&bound)
        .foot(&provenance.lines())
        .html()
}

fn per_dimension(a: &Analysis) -> Table {
    let header = ["m", "slope in the region", "pairs"];
    (1..=a.sum.counts.len()).fold(Table::new(&header), |table, m| {
        table.row(vec![
            Cell::Number(m.to_string()),
            Cell::Number(number(a.over_dimensions[m - 1], 4)),
            Cell::Number(a.sum.pairs(m).to_string()),
        ])
    })
}
