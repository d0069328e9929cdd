//! The error ladder and the errors at each operating point.

use super::Material;
use super::verdict::percent;
use super::views::COLOURS;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::diagnosis::Verdict;
use crate::report::{Axis, Cell, Colour, Page, Plot, Table, number};

/// The section: the errors run by run, and how they grow while predictions run on.
pub fn section(page: Page, material: &Material) -> Page {
    let quantity = material.problem.campaign.measurand().name();
    page.section(super::SECTIONS[1])
        .paragraph(&format!(
            "The error of each run, rung by rung, and over the time of a prediction. It is the root mean square of measured \
             less predicted {quantity} over the standard deviation of the {quantity}."
        ))
        .table(&table(material))
        .figures(&[&by_run(material), &super::growth::by_horizon(material)])
}

/// Error that the sensor's noise alone makes, over the runs kept out (over all if none is).
pub fn floor(problem: &Problem) -> f64 {
    let any = problem.held_out.iter().any(|h| *h);
    let shares: Vec<f64> = (0..problem.noise.len())
        .filter(|&r| !any || problem.held_out[r])
        .map(|r| (problem.noise[r] / problem.spread[r]).powi(2))
        .collect();
    (shares.iter().sum::<f64>() / shares.len() as f64).sqrt()
}

/// The error of prediction, rung by rung.
pub fn ladder(material: &Material) -> Plot {
    let rungs = &material.diagnosis.error_ladder;
    let believed =
        material.diagnosis.verdict != Verdict::UnknownEffect || material.selection.beyond.is_some();
    let names: Vec<String> = rungs
        .iter()
        .map(|r| {
            if believed || !r.step.starts_with('+') {
                r.step.clone()
            } else {
                format!("({}, not believed)", r.step)
            }
        })
        .collect();
    let place: Vec<f64> = (0..rungs.len()).map(|i| i as f64).collect();
    let of = |f: fn(&crate::diagnose::result::diagnosis::Rung) -> f64| {
        rungs.iter().map(f).collect::<Vec<f64>>()
    };
    let (fit, holdout) = (of(|r| 100.0 * r.fit_nrmse), of(|r| 100.0 * r.holdout_nrmse));
    let mut plot = Plot::new(
        Axis::places("model", &names),
        Axis::log("error (NRMSE)", "%"),
    )
    .level(
        "sensor noise alone",
        Colour::Grey,
        100.0 * floor(material.problem),
    );
    // Single effects that were tried but do not stand on the ladder.
    if rungs.len() > 2 {
        let others: Vec<f64> = material
            .selection
            .singles
            .iter()
            .map(|c| 100.0 * c.fit.nrmse)
            .collect();
        let x = vec![1.82; others.len()];
        plot = plot.scatter(
            "other candidates, one at a time (fit)",
            Colour::Grey,
            &x,
            &others,
        );
    }
    for (held, mark) in [(false, "each run fitted"), (true, "each run kept out")] {
        let (mut x, mut y) = (Vec::new(), Vec::new());
        for (i, rung) in rungs.iter().enumerate() {
            for (r, value) in rung.by_run.iter().enumerate() {
                if material.problem.held_out[r] == held {
                    x.push(i as f64 + if held { 0.08 } else { -0.08 });
                    y.push(100.0 * value);
                }
            }
        }
        let colour = if held { Colour::Sky } else { Colour::Purple };
        if !x.is_empty() {
            plot = plot.cloud(mark, colour, &x, &y);
        }
    }
    let texts: Vec<String> = rungs.iter().map(|r| percent(r.holdout_nrmse)).collect();
    plot.dashed_line("fit", Colour::Orange, &place, &fit)
        .scatter("", Colour::Orange, &place, &fit)
        .line("kept out of the fit", Colour::Blue, &place, &holdout)
        .scatter("", Colour::Blue, &place, &holdout)
        .notes(Colour::Blue, &place, &holdout, &texts)
        .caption(
            "The error of prediction, rung by rung: as given, with the nuisances calibrated, and with each effect added; \
             it falls to the noise when nothing is missing any more.",
        )
}

fn table(material: &Material) -> Table {
    let problem = material.problem;
    let rungs = &material.diagnosis.error_ladder;
    let mut header = vec!["run", "belt velocity", "normal force", "used for"];
    header.extend(rungs.iter().map(|r| r.step.as_str()));
    header.extend(["noise alone", "last over noise"]);
    let last = rungs.last();
    problem
        .campaign
        .runs
        .iter()
        .enumerate()
        .fold(Table::new(&header), |table, (r, run)| {
            let floor = problem.noise[r] / problem.spread[r];
            let mut cells = vec![
                Cell::Text(run.name.clone()),
                Cell::Number(format!("{} m/s", number(run.belt_velocity, 3))),
                Cell::Number(format!("{} N", number(run.normal_force, 3))),
                Cell::Text(if problem.held_out[r] {
                    "kept out".into()
                } else {
                    "fit".into()
                }),
            ];
            cells.extend(
                rungs
                    .iter()
                    .map(|rung| Cell::Number(percent(rung.by_run[r]))),
            );
            let end = last.map_or(f64::NAN, |l| l.by_run[r] / floor);
            cells.push(Cell::Number(percent(floor)));
            let text = number(end, 3);
            cells.push(if end > 3.0 {
                Cell::Alert(text)
            } else {
                Cell::Number(text)
            });
            table.row(cells)
        })
}

fn label(material: &Material, r: usize) -> String {
    let held = if material.problem.held_out[r] {
        ", kept out"
    } else {
        ""
    };
    format!("{}{held}", material.problem.campaign.runs[r].name)
}

fn by_run(material: &Material) -> Plot {
    let problem = material.problem;
    let count = problem.campaign.runs.len();
    let names: Vec<String> = (0..count).map(|r| label(material, r)).collect();
    let row: Vec<f64> = (0..count).map(|r| r as f64).collect();
    let floor: Vec<f64> = (0..count)
        .map(|r| 100.0 * problem.noise[r] / problem.spread[r])
        .collect();
    let pair = &material.views.pair;
    let values = pair.each_ref().map(|v| super::scaled(&v.by_run, 100.0));
    dumbbells(Axis::log("error (NRMSE)", "%"), &names, &values, [&pair[0].name, &pair[1].name])
        .scatter("sensor noise alone", Colour::Grey, &floor, &row)
        .caption("How far the error of each run falls, and how far it could: the grey points are what the noise alone makes.")
}

/// Two values per row, before and after, with a line between.
pub fn dumbbells(axis: Axis, names: &[String], values: &[Vec<f64>; 2], legend: [&str; 2]) -> Plot {
    let row: Vec<f64> = (0..names.len()).map(|r| r as f64).collect();
    let mut plot = Plot::new(axis, Axis::rows(names));
    for r in 0..names.len() {
        plot = plot.thin_line(
            "",
            Colour::Grey,
            &[values[0][r], values[1][r]],
            &[row[r], row[r]],
        );
    }
    plot.scatter(legend[0], COLOURS[0], &values[0], &row)
        .scatter(legend[1], COLOURS[1], &values[1], &row)
}
