//! `stickslip sweep`: the motions of the model over one or two parameters.

mod compute;
pub mod figures;
mod json;
mod options;
mod orbits;
mod page;
mod pictures;
pub mod plan;
mod store;
mod study;
pub mod table;
mod terminal;

use std::path::Path;

use super::progress::Progress;
use crate::error::Error;
use crate::output::{print, print_line, write_file};
use crate::provenance::Provenance;
use crate::report::svg_file;
use crate::watch::Watch;
use compute::{compute, compute_chains};
pub use options::Arguments;
use options::{plan_of, threads};
use orbits::Branches;
use store::Store;
use study::Study;

/// What a study finds.
#[derive(Debug)]
pub struct Swept {
    /// The table and the coexisting motions.
    pub json: String,
    /// The summary.
    pub text: String,
    /// Displacements in m at the section points, row by row.
    pub section: Vec<Vec<f64>>,
}

/// Runs the command.
///
/// # Errors
/// As [`perform`].
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    if arguments.plan {
        return print_line(planned(arguments)?);
    }
    let progress = Progress::new(Progress::STEPS);
    let found = perform(arguments, &progress);
    progress.finish();
    let found = found?;
    if arguments.json {
        print_line(&found.json)
    } else {
        print(&found.text)?;
        let report = arguments.output.join("sweep.html");
        print_line(format_args!("Report: {}", report.display()))
    }
}

/// The points still to be computed, as JSON, and a folder prepared for them.
///
/// # Errors
/// Names, ranges or folders that can't be used.
pub fn planned(arguments: &Arguments) -> Result<String, Error> {
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let plan = plan_of(arguments, &fmu)?;
    let rows = plan.rows();
    Store::open(&arguments.output, &plan, &rows)?;
    Ok(json::tasks(&plan, &rows, &arguments.output))
}

/// Computes the points of one chain only, on one thread, into the folder of the options: no tables are
/// sorted, nothing is drawn. For clusters, whose workers have folders of their own.
///
/// # Errors
/// As [`perform`]; a chain that the study does not have.
pub fn perform_chain(arguments: &Arguments, chain: usize, watch: &dyn Watch) -> Result<(), Error> {
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let plan = plan_of(arguments, &fmu)?;
    let rows = plan.rows();
    let mut chains = plan.chains(&rows);
    if chain >= chains.len() {
        return Err(Error::Option {
            option: "--plan",
            value: format!("chain {chain}"),
            rule: format!("is not among the {} of this study", chains.len()),
        });
    }
    let mut store = Store::open(&arguments.output, &plan, &rows)?;
    compute_chains(
        &plan,
        &rows,
        vec![chains.swap_remove(chain)],
        &mut store,
        (1, &arguments.output),
        watch,
    )
}

/// Computes the study and writes its files.
///
/// # Errors
/// Names, ranges or folders that can't be used; a disk that is full; a stop by the user. Points that fail are no error:
/// they are in the table with their reasons.
pub fn perform(arguments: &Arguments, watch: &dyn Watch) -> Result<Swept, Error> {
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let plan = plan_of(arguments, &fmu)?;
    let rows = plan.rows();
    let threads = threads(arguments.threads)?;
    let into = |name: &str| arguments.output.join(name);
    let store = compute(&plan, &rows, &arguments.output, threads, watch)?;
    let branches = if arguments.orbits {
        orbits::find(&plan, &rows, &store.done, &store.carried, watch)
    } else {
        Branches::default()
    };
    if arguments.orbits {
        write_file(
            &into("orbits.csv"),
            orbits::orbits_csv(&plan, &branches).as_bytes(),
        )?;
        let bifurcations = orbits::bifurcations_csv(&plan, &branches);
        write_file(&into("bifurcations.csv"), bifurcations.as_bytes())?;
    }
    let section = store.section(&plan, &rows)?;
    let study = Study::new(&plan, &rows, store.done, section, branches);
    let picture = pictures::main(&study);
    write_file(&into("sweep.svg"), svg_file(&picture).as_bytes())?;
    let files: Vec<&Path> = arguments.fmu.as_deref().into_iter().collect();
    let provenance = Provenance::of(&files)?;
    let html = page::html(&study, &provenance);
    write_file(&into("sweep.html"), html.as_bytes())?;
    Ok(Swept {
        json: json::results(&study, &provenance),
        text: terminal::summary(&study),
        section: study.section,
    })
}
