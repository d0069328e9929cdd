//! The search for what a model lacks, and what is done with its outcome.

use super::report::report;
use crate::command::pack;
use crate::diagnose::data::hold_out::HoldOut;
use crate::diagnose::model::acting::leave_out;
use crate::diagnose::model::displacement_range::displacement_ranges;
use crate::diagnose::model::finished_work::FinishedWork;
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::library;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{lowest_frequency, unknown_functions};
use crate::diagnose::result::curve_formula;
use crate::diagnose::result::diagnosis::Diagnosis;
use crate::diagnose::result::error_ladder::{climb, contradiction};
use crate::diagnose::selection::by_chance::calibrate_threshold;
use crate::diagnose::selection::discrepancy::explain_most;
use crate::diagnose::selection::elimination::{Before, eliminate};
use crate::diagnose::selection::fitted_model::is_small;
use crate::diagnose::selection::outcome::Selection;
use crate::diagnose::selection::select::select;
use crate::diagnose::stages;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::Campaign;
use crate::provenance::Provenance;
use crate::watch::{OneStage, Watch};
use std::cell::OnceCell;
use std::path::Path;

/// Fits of a diagnosis that has not come to its end.
pub const UNFINISHED: &str = "unfinished.fits";
/// How it is found what chance alone would gain.
#[derive(Debug, Clone)]
pub enum Null {
    /// So many campaigns without the effect are simulated and searched for each step.
    Simulate(usize),
    /// Elsewhere, by [`perform_null`]; the fits are kept for that.
    Later,
    /// It is known: the largest gain in each campaign simulated, for each step.
    Known(Vec<Vec<f64>>),
}

impl Default for Null {
    fn default() -> Self {
        Null::Simulate(0)
    }
}

/// How a diagnosis searches.
#[derive(Debug, Default)]
pub struct Search {
    /// How it is found what chance alone would gain.
    pub null: Null,
    /// Which runs are kept out.
    pub hold_out: HoldOut,
    /// Files of the user's effects that take part.
    pub library: Vec<String>,
}

/// Diagnoses a campaign and writes everything into `output`.
pub fn diagnose(
    fmu: &Fmu,
    campaign: &Campaign,
    search: &Search,
    output: &Path,
    watch: &dyn Watch,
) -> Result<Diagnosis, Error> {
    searched(
        fmu,
        campaign,
        search,
        output,
        watch,
        |problem, selection| {
            let by_chance = |problem: &Problem, selection: &mut Selection| match search.null {
                Null::Simulate(0) | Null::Later | Null::Known(_) => Ok(()),
                Null::Simulate(count) => calibrate_threshold(problem, selection, count, watch),
            };
            by_chance(problem, selection)?;
            if let Null::Known(gains) = &search.null {
                selection.judge_by_chance(gains.clone());
            }
            if watch.stop() && watch.discards() {
                return Err(Error::Discarded);
            }
            if selection.explained {
                problem.trust_sensor();
            } else if !problem.place_is_told() && !watch.stop() {
                watch.stage(stages::INCOMPLETE);
                let (sensors, before) = (problem.segments.clone(), Before::of(selection));
                let (noise, of_further) = explain_most(problem, selection, watch)?;
                if selection.path.last().is_some_and(|m| is_small(&m.fit)) {
                    problem.segments = sensors;
                    problem.trust_sensor();
                    match eliminate(problem, selection, before, watch)? {
                        false => problem.count_with(noise, &of_further),
                        true => by_chance(problem, selection)?,
                    }
                }
            }
            watch.stage(stages::KEPT_OUT);
            let steps = climb(problem, selection)?;
            let diagnosis = report(
                fmu,
                problem,
                selection,
                &steps,
                ("diagnose", campaign),
                output,
                watch,
            )?;
            if !watch.stop() && !matches!(search.null, Null::Later) {
                problem.finished.remove()?;
            }
            Ok(diagnosis)
        },
    )
}

/// Searches, and then does what is asked with what was found.
pub(super) fn searched<R>(
    fmu: &Fmu,
    campaign: &Campaign,
    search: &Search,
    output: &Path,
    watch: &dyn Watch,
    then: impl FnOnce(&mut Problem, &mut Selection) -> Result<R, Error>,
) -> Result<R, Error> {
    let structure = structure(fmu, &campaign.beam)?;
    let ranges = displacement_ranges(fmu, campaign, &structure)?;
    let lowest = lowest_frequency(campaign, &structure, &ranges);
    let mass = 1.0 / structure.inverse_tip_mass();
    let unknown = unknown_functions(campaign, lowest, mass, &ranges);
    let files: Vec<&str> = search
        .library
        .iter()
        .map(String::as_str)
        .chain(library::FILES)
        .chain(unknown.iter().map(|f| f.file.as_str()))
        .collect();
    let widened = pack::widened::with_effects(fmu, &files)?;
    // One with formulas for a curve that was found, made when that is known.
    let further = OnceCell::new();
    let inputs = Provenance::of_campaign(campaign, Some(fmu))?;
    let problem_with = |hold_out: HoldOut| -> Result<Problem, Error> {
        let fmu = widened.as_ref().unwrap_or(fmu);
        let mut problem = Problem::holding_out(fmu, campaign, hold_out)?;
        if widened.is_some() {
            problem.unknown_functions.clone_from(&unknown);
        }
        leave_out(&mut problem)?;
        let inputs = format!(
            "{} {} {} {hold_out:?} {:?}",
            inputs.version,
            env!("STICKSLIP_SOURCES"),
            inputs.inputs_sha256,
            search.library
        );
        problem.finished = FinishedWork::open(&output.join(UNFINISHED), &inputs)?;
        Ok(problem)
    };
    watch.stage(stages::REFERENCE);
    let first = problem_with(search.hold_out)?;
    let mut selection = select(&first, watch)?;
    let may_change = search.hold_out == HoldOut::Middle && !watch.stop();
    let contradicted = match may_change {
        true => contradiction(&first, &selection)?,
        false => None,
    };
    let mut problem = first;
    if contradicted.is_some() {
        // A run may be too short to judge anything on it.
        let others = match problem_with(HoldOut::Others) {
            Ok(others) => Some(others).filter(|o| o.held_out != problem.held_out),
            Err(Error::NothingToFit { .. } | Error::RunsTooShort { .. }) => None,
            Err(error) => return Err(error),
        };
        if let Some(others) = others {
            watch.stage(stages::AGAIN);
            let again = select(&others, &OneStage(watch))?;
            if again.stopped {
                selection.stopped = true;
            } else {
                selection = again;
                selection.contradicted = contradicted;
                problem = others;
            }
        }
    }
    let formulas = curve_formula::formulas(&problem, &selection);
    let texts: Vec<&str> = formulas.iter().map(|f| f.file.as_str()).collect();
    if !texts.is_empty()
        && !watch.stop()
        // A formula that is no effect (a constant of zero) is left out: the curve stands without it.
        && let Ok(Some(with_formulas)) = pack::widened::with_effects(problem.fmu, &texts)
    {
        let fmu = further.get_or_init(|| with_formulas);
        problem.widen(fmu, texts.into_iter().map(str::to_owned).collect())?;
        curve_formula::fit(&problem, &mut selection, &formulas)?;
    }
    then(&mut problem, &mut selection)
}
