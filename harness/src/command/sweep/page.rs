//! sweep.html.

use super::orbits;
use super::pictures;
use super::study::Study;
use super::terminal::{coexisting, exponent, kinds, name};
use crate::provenance::Provenance;
use crate::report::{Cell, Colour, Figure, Page, Table, number, with_unit};

/// Rows of a table on the page; sweep.csv has all.
const ROWS: usize = 400;

/// The finished document.
pub fn html(study: &Study, provenance: &Provenance) -> String {
    let plan = study.plan;
    let parameters: Vec<String> = plan
        .axes
        .iter()
        .map(|a| format!("{} ({} values)", a.name, a.values.len()))
        .collect();
    let set: Vec<String> = plan
        .settings
        .iter()
        .map(|(name, value)| format!("{name} = {value}"))
        .collect();
    let lead = format!(
        "{}{}; {} rows.",
        parameters.join(" and "),
        if set.is_empty() {
            String::new()
        } else {
            format!("; {}", set.join(", "))
        },
        study.rows.len()
    );
    let counted = kinds(study)
        .into_iter()
        .map(|(kind, count)| format!("{kind}: {count}"));
    let counted = counted.collect::<Vec<_>>().join(", ");
    let mut page = Page::new("Parameter study", &lead)
        .banner(Colour::Blue, &format!("{counted}."), "", &[])
        .figure(&pictures::main(study));
    if plan.axes.len() == 2 {
        for kind in &plan.starts[1..] {
            page = page.figure(&pictures::map(study, *kind));
        }
    }
    let counts = kinds(study)
        .into_iter()
        .map(|(kind, count)| format!("{kind}: {count} of {}", study.rows.len()));
    page = page.list(&counts.collect::<Vec<_>>());
    if plan.axes.len() == 1 {
        let exponents = pictures::quantity(
            study,
            "largest exponent",
            "1/s",
            "Largest Lyapunov exponent, the trivial one left out: below zero nearby motions come together, above zero they part.",
            |r| r.lyapunov,
        )
        .level("", Colour::Grey, 0.0);
        let frequency = pictures::quantity(
            study,
            "main frequency",
            "Hz",
            "Frequency of the strongest spectral line of the tip's displacement.",
            |r| r.main_frequency,
        );
        let amplitude = pictures::quantity(
            study,
            "amplitude",
            "mm",
            "Half the distance from the lowest trough to the highest peak.",
            |r| r.amplitude.map(|a| 1e3 * a),
        );
        let stick = pictures::quantity(
            study,
            "share of time in stick",
            "1",
            "Share of time that the tip sticks to the belt.",
            |r| r.stick_fraction,
        );
        let all: [&dyn Figure; 4] = [&exponents, &frequency, &amplitude, &stick];
        page = page.section("Numbers").figures(&all);
    }
    let starts = study.rows.iter().filter(|r| r.at == study.rows[0].at);
    if starts.count() > 1 {
        page = page
            .section("Coexisting motions")
            .paragraph("Motions that the starts at one point end in, and the share of the starts. Motions count as the same if \
                        period, main frequency and amplitude agree (1 %; 20 % for irregular ones).")
            .table(&coexisting_table(study));
    }
    page = branches(page, study);
    let rule = &plan.rule;
    page = page.section("All points").table(&rows(study));
    if study.rows.len() > ROWS {
        page = page.paragraph(&format!("The first {ROWS} rows; sweep.csv has all."));
    }
    page.section("How it was computed")
        .list(&[
            format!(
                "Transients: the first {} peaks are discarded, the next {} measured; while a motion does not repeat although its exponent \
                 is not positive by more than two standard errors, the next {} are measured instead, at most {} times. If small differences to it have died out then \
                 by e^2, it is settling; if it is shown neither to settle nor to be irregular, unresolved: quasi-periodic, or a long transient.",
                rule.settle, rule.cycles, rule.cycles, rule.patience
            ),
            "Period: the least number of section points after which all modal states come back within 1e-5 of the amplitude, fifty times \
             better than after fewer.".into(),
            "Exponent: growth of the distance (1e-6 of the amplitude) to a second motion through its own transitions, put back at every \
             peak; a mere shift in time does not count. -inf: the distance vanishes, as stick makes it.".into(),
            "Section points are located on the integrator's polynomials.".into(),
        ])
        .foot(&provenance.lines())
        .html()
}

/// The branches of periodic motions, where they were asked for.
fn branches(page: Page, study: &Study) -> Page {
    let found = &study.branches;
    if found.all.is_empty() && found.problems.is_empty() {
        return page;
    }
    let name = &study.plan.axes[0].name;
    let heads = ["branch", name, "within", "what happens"];
    let mut table = Table::new(&heads);
    let mut list = Vec::new();
    for (k, branch) in found.all.iter().enumerate() {
        for b in &branch.bifurcations {
            table = table.row(vec![
                Cell::Number((k + 1).to_string()),
                Cell::Number(number(b.parameter, 6)),
                Cell::Number(number(b.within, 2)),
                Cell::Text(orbits::words(&b.kind)),
            ]);
        }
        list.push(format!(
            "Branch {}: {} orbits; begins: {}; ends: {}.",
            k + 1,
            branch.points.len(),
            orbits::end(&branch.ends.0),
            orbits::end(&branch.ends.1)
        ));
    }
    list.extend(found.problems.iter().cloned());
    page.section("Branches of period one")
        .paragraph("Period-one motions found by Newton's method on the return map and followed in the parameter; stable where all Floquet \
                    multipliers lie within the unit circle. Bifurcations lie between two orbits of the branch.")
        .list(&list)
        .table(&table)
}

fn dash(v: Option<f64>, show: impl Fn(f64) -> String) -> String {
    v.map_or("–".into(), show)
}

fn heads<'a>(study: &'a Study, rest: &[&'a str]) -> Vec<String> {
    let names = study.plan.axes.iter().map(|a| {
        if a.unit.is_empty() {
            a.name.clone()
        } else {
            format!("{} [{}]", a.name, a.unit)
        }
    });
    names.chain(rest.iter().map(|r| (*r).to_owned())).collect()
}

fn table(heads: &[String]) -> Table {
    Table::new(&heads.iter().map(String::as_str).collect::<Vec<_>>())
}

fn coexisting_table(study: &Study) -> Table {
    let heads = heads(study, &["motion", "share", "main frequency", "amplitude"]);
    coexisting(study)
        .into_iter()
        .take(ROWS)
        .fold(table(&heads), |table, g| {
            let mut cells: Vec<Cell> = g.at.iter().map(|v| Cell::Number(v.to_string())).collect();
            cells.extend([
                Cell::Text(g.name),
                Cell::Number(format!("{:.0} %", 100.0 * g.share)),
                Cell::Number(dash(g.frequency, |v| with_unit(v, "Hz"))),
                Cell::Number(dash(g.amplitude, |v| with_unit(v, "m"))),
            ]);
            table.row(cells)
        })
}

fn rows(study: &Study) -> Table {
    let heads = heads(
        study,
        &[
            "start",
            "motion",
            "main frequency",
            "amplitude",
            "stick",
            "exponent",
        ],
    );
    let all = study.rows.iter().zip(&study.results);
    all.take(ROWS).fold(table(&heads), |table, (row, r)| {
        let mut cells: Vec<Cell> = row.at.iter().map(|v| Cell::Number(v.to_string())).collect();
        let motion = if r.is_failed() {
            Cell::Alert(r.status.clone())
        } else {
            Cell::Text(name(r))
        };
        cells.extend([
            Cell::Text(row.start.clone()),
            motion,
            Cell::Number(dash(r.main_frequency, |v| with_unit(v, "Hz"))),
            Cell::Number(dash(r.amplitude, |v| with_unit(v, "m"))),
            Cell::Number(dash(r.stick_fraction, |v| number(v, 3))),
            Cell::Number(dash(r.lyapunov, exponent)),
        ]);
        table.row(cells)
    })
}
