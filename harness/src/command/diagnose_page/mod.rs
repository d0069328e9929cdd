//! report.html of a diagnosis: what is missing, how sure that is, where the model fails, how the error falls.

mod break_aways;
mod evidence;
mod force_map;
mod forecast;
mod growth;
mod ladder;
mod overlay;
mod parameters;
mod profile;
mod samples;
mod statistics;
mod unknown;
mod verdict;
mod views;
mod where_it_fails;

pub use verdict::{likely, with_interval};

use std::path::Path;

use crate::command::data_quality;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::diagnosis::Diagnosis;
use crate::diagnose::result::error_ladder::Step;
use crate::diagnose::selection::outcome::Selection;
use crate::error::Error;
use crate::measurement::Campaign;
use crate::provenance::Provenance;
use crate::report::{Axis, Figure, Page};
use views::Views;

/// Sections in their order; the banner links to them.
const SECTIONS: [&str; 7] = [
    data_quality::TITLE,
    "Watch the error fall",
    "Where it fails",
    "Compare: before and after",
    "Learn which effect",
    "Contact force",
    "Add it: the calibrated model",
];

/// Everything that the pictures are drawn from.
struct Material<'a> {
    problem: &'a Problem<'a>,
    selection: &'a Selection,
    steps: &'a [Step],
    diagnosis: &'a Diagnosis,
    /// Folder of the calibrated FMU.
    output: &'a Path,
    views: Views,
}

/// The finished document, of a campaign as it was `stated`; `command` is the command line that makes it anew, with the provenance of what it shows.
///
/// # Errors
/// An FMU that can't be run.
pub fn html(
    problem: &Problem,
    selection: &Selection,
    steps: &[Step],
    diagnosis: &Diagnosis,
    (output, stated): (&Path, &Campaign),
    (command, provenance): (&str, &Provenance),
) -> Result<String, Error> {
    let views = Views::new(problem, selection, steps, diagnosis)?;
    let material = Material {
        problem,
        selection,
        steps,
        diagnosis,
        output,
        views,
    };
    let title = format!("Diagnosis of {}", problem.campaign.name);
    let page = Page::new(&title, &lead(problem));
    let page = verdict::banner(page, &material);
    let page = first_screen(page, &material);
    let page = verdict::words(page, &material);
    let page = data_quality::section(page, stated);
    let page = ladder::section(page, &material);
    let page = where_it_fails::section(page, &material);
    let page = forecast::section(page, &material);
    let page = unknown::section(page, &material);
    let page = overlay::section(page, &material);
    let page = evidence::section(page, &material);
    let page = force_map::section(page, &material);
    let page = break_aways::section(page, &material);
    let page = profile::section(page, &material);
    let page = parameters::section(page, &material);
    let page = page
        .section("Reproduce")
        .paragraph("This command makes this page anew, with the same numbers:")
        .code(command);
    Ok(page.foot(&provenance.lines()).html())
}

/// What one sees beside the verdict: the error falling, and the first forecast.
fn first_screen(page: Page, material: &Material) -> Page {
    let ladder = ladder::ladder(material);
    match forecast::first(material) {
        Some(forecast) => page.figures(&[&ladder, &forecast]),
        None => page.figure(&ladder),
    }
}

fn lead(problem: &Problem) -> String {
    let held = problem.held_out.iter().filter(|h| **h).count();
    let runs = problem.campaign.runs.len();
    let kept = match held {
        0 => "no run could be kept out of the fit, so every second piece was".to_owned(),
        n => format!("{n} of them kept out of every fit"),
    };
    format!(
        "{} against {runs} measured runs, {kept}. Errors are of predictions over {:.0} ms from estimated start states.",
        problem.fmu.description().model_name,
        1e3 * problem.horizon
    )
}

/// Adds figures of one type side by side.
fn side_by_side<F: Figure>(page: Page, figures: &[F]) -> Page {
    let list: Vec<&dyn Figure> = figures.iter().map(|f| f as &dyn Figure).collect();
    page.figures(&list)
}

/// `tip displacement` in mm, or what else was measured.
fn axis_of(campaign: &Campaign) -> Axis {
    let (place, measurand) = (campaign.beam.sensor.name(), campaign.measurand());
    Axis::linear(
        &format!("{place} {}", measurand.name()),
        measurand.milli_unit(),
    )
}

/// Values times a factor.
fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| v * factor).collect()
}
