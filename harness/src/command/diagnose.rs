//! `stickslip diagnose`: which physical effect the model lacks, from a measured campaign.

use std::cell::OnceCell;
use std::ops::Range;
use std::path::{Path, PathBuf};

use clap::Args;

use super::diagnose_page::{likely, with_interval};
use super::given_campaign::Forced;
use super::progress::Progress;
use super::{diagnose_page, given_campaign, pack, proposed_effect, repaired_model};
use crate::diagnose::data::hold_out::HoldOut;
use crate::diagnose::model::acting::leave_out;
use crate::diagnose::model::displacement_range::displacement_ranges;
use crate::diagnose::model::finished_work::FinishedWork;
use crate::diagnose::model::known_structure::structure;
use crate::diagnose::model::library;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::{lowest_frequency, unknown_functions};
use crate::diagnose::result::assemble::{conclude, shown};
use crate::diagnose::result::curve_formula;
use crate::diagnose::result::diagnosis::{Diagnosis, Rung};
use crate::diagnose::result::error_ladder::{Step, climb, contradiction};
use crate::diagnose::result::further_sensors::FoundSensor;
use crate::diagnose::result::run_sets::run_sets;
use crate::diagnose::selection::discrepancy::explain_most;
use crate::diagnose::selection::elimination::{Before, eliminate};
use crate::diagnose::selection::fitted_model::is_small;
use crate::diagnose::selection::select::{Selection, calibrate_threshold, gains_by_chance, select};
use crate::diagnose::stages;
use crate::diagnose::thresholds::TIE;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::Campaign;
use crate::output::{make_folder, print, print_line, tell, write_file};
use crate::provenance::Provenance;
use crate::watch::{OneStage, Watch};

/// Options of `diagnose`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder with campaign.toml and the CSV files, or the path of campaign.toml
    #[arg(value_name = "CAMPAIGN")]
    campaign: PathBuf,
    /// FMU to diagnose, one of another make with its <name>.effects.toml beside it [default: this repository's StickSlipBeam,
    /// packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Folder for diagnosis.json, report.html, model.toml, the .ssv and the repaired .fmu
    #[arg(short, long, value_name = "DIR", default_value = "diagnosis")]
    output: PathBuf,
    /// Which runs are kept out of every fit, to be forecast
    #[arg(long, value_enum, default_value_t)]
    hold_out: HoldOut,
    /// Folder of effects of your own (TOML, as for pack --effect) that take part
    #[arg(long, value_name = "DIR")]
    library: Option<PathBuf>,
    /// Campaigns without the effect to simulate and search in full, for the chance that the gain is chance; each takes about
    /// as long as the search itself
    #[arg(long, value_name = "COUNT", default_value_t = 0)]
    null: usize,
    /// Print diagnosis.json instead of the summary
    #[arg(long)]
    json: bool,
    /// Tell on standard error how long each stage took and what was computed
    #[arg(short, long)]
    verbose: bool,
    #[command(flatten)]
    forced: Forced,
}

impl Arguments {
    /// diagnosis.json, as it was written.
    ///
    /// # Errors
    /// A file that can't be read.
    pub fn written_json(&self) -> Result<String, Error> {
        written_json(&self.output)
    }
}

/// Campaigns that may be simulated for the chance of a gain by chance: enough for one in a thousand.
const MOST_NULL: usize = 10_000;

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let progress = Progress::new(Progress::STAGES);
    let diagnosis = perform(arguments, &progress);
    progress.finish();
    let diagnosis = diagnosis?;
    if arguments.verbose {
        tell(costs(&progress, &diagnosis).trim_end());
    }
    if progress.stop() {
        tell(format_args!(
            "Stopped before the end. What was fitted is kept in {}: the same command goes on from there.",
            arguments.output.join(UNFINISHED).display()
        ));
    }
    if arguments.json {
        print_line(arguments.written_json()?)
    } else {
        print(&terminal(&diagnosis))?;
        let report = arguments.output.join("report.html");
        print_line(format_args!("Report: {}", report.display()))
    }
}

/// Diagnoses and writes everything into the folder of the options. A stop ends it early, with what was
/// found until then.
///
/// # Errors
/// Options, a campaign or an FMU that can't be used; a folder that can't be written.
pub fn perform(arguments: &Arguments, watch: &dyn Watch) -> Result<Diagnosis, Error> {
    perform_with(arguments, Null::Simulate(arguments.null), watch)
}

/// The same with gains by chance found in this way, whatever the options say of them.
///
/// # Errors
/// As [`perform`].
pub fn perform_with(
    arguments: &Arguments,
    null: Null,
    watch: &dyn Watch,
) -> Result<Diagnosis, Error> {
    let (fmu, campaign, search) = given(arguments, null)?;
    diagnose(&fmu, &campaign, &search, &arguments.output, watch)
}

/// For each step of the diagnosis, the largest gains by chance in those of the simulated campaigns that `which`
/// numbers. The search goes before; fits that lie in the folder of the options are not made again.
///
/// # Errors
/// As [`perform`].
pub fn perform_null(
    arguments: &Arguments,
    which: Range<usize>,
    watch: &dyn Watch,
) -> Result<Vec<Vec<f64>>, Error> {
    let (fmu, campaign, search) = given(arguments, Null::Later)?;
    searched(
        &fmu,
        &campaign,
        &search,
        &arguments.output,
        watch,
        |problem, selection| gains_by_chance(problem, selection, which, watch),
    )
}

/// What the options say, and the folder of results.
fn given(arguments: &Arguments, null: Null) -> Result<(Fmu, Campaign, Search), Error> {
    if arguments.null > MOST_NULL {
        return Err(Error::Option {
            option: "--null",
            value: arguments.null.to_string(),
            rule: format!("campaigns would take months; give {MOST_NULL} or less"),
        });
    }
    let campaign = given_campaign::load(&arguments.campaign, arguments.forced)?;
    make_folder(&arguments.output)?;
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let search = Search {
        null,
        hold_out: arguments.hold_out,
        library: match &arguments.library {
            Some(folder) => pack::own_effects::of_folder(folder)?,
            None => Vec::new(),
        },
    };
    Ok((fmu, campaign, search))
}

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
fn searched<R>(
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
            "{} {} {hold_out:?} {:?}",
            inputs.version, inputs.inputs_sha256, search.library
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

/// Writes what a selection found into `output`; with the command, and the campaign as it was stated.
pub fn report(
    fmu: &Fmu,
    problem: &Problem,
    selection: &Selection,
    steps: &[Step],
    (command, stated): (&str, &Campaign),
    output: &Path,
    watch: &dyn Watch,
) -> Result<Diagnosis, Error> {
    let campaign = &problem.campaign;
    let diagnosis = conclude(problem, selection, steps)?;
    let provenance = Provenance::of_campaign(campaign, Some(fmu))?;
    let json = provenance.json(&diagnosis);
    write_file(&output.join(JSON), json.as_bytes())?;
    let written = &steps[shown(problem, selection, diagnosis.verdict, steps)];
    let choices = written.fitted.hypothesis.choices.iter();
    let ids: Vec<&str> = choices
        .map(|c| problem.catalogue[c.effect].id.as_str())
        .collect();
    let widened = pack::widened::with_effects_of(fmu, problem.fmu, &ids)?;
    let fmu = widened.as_ref().unwrap_or(fmu);
    repaired_model::write(fmu, &diagnosis, &run_sets(problem, written), output)?;
    proposed_effect::write(&diagnosis.proposed_terms, output)?;
    if let Some(curve) = diagnosis.unknown.as_ref().and_then(|u| u.file.as_ref()) {
        write_file(&output.join("unknown.toml"), curve.as_bytes())?;
    }
    watch.stage(stages::REPORT);
    let command = format!(
        "stickslip {command} {} -o {}",
        campaign.folder.display(),
        output.display()
    );
    let page = diagnose_page::html(
        problem,
        selection,
        steps,
        &diagnosis,
        (output, stated),
        (&command, &provenance),
    )?;
    write_file(&output.join("report.html"), page.as_bytes())?;
    Ok(diagnosis)
}

/// How long each stage took, and what was computed.
fn costs(progress: &Progress, diagnosis: &Diagnosis) -> String {
    use std::fmt::Write as _;
    let mut out = String::new();
    for (stage, time) in progress.times() {
        let _ = writeln!(out, "{stage:<28} {:>8.1} s", time.as_secs_f64());
    }
    let work = diagnosis.counters;
    let _ = writeln!(
        out,
        "{} fits, {} motions of a segment, {} derivatives of one, {:.1} s of processor time",
        work.fits, work.motions, work.sensitivities, work.processor_s
    );
    out
}

/// Fits of a diagnosis that has not come to its end.
pub const UNFINISHED: &str = "unfinished.fits";
/// The diagnosis as a file.
const JSON: &str = "diagnosis.json";

/// The JSON text that [`report`] has written into `output`.
///
/// # Errors
/// A file that can't be read.
pub fn written_json(output: &Path) -> Result<String, Error> {
    let path = output.join(JSON);
    std::fs::read_to_string(&path).map_err(Error::read(&path))
}

/// How far the readings of further sensor `i` are met along the ladder, and by which factor they are off.
fn of_sensor(i: usize, sensor: &FoundSensor, ladder: &[Rung]) -> String {
    let over_noise = ladder
        .iter()
        .filter_map(|rung| rung.further_over_noise.get(i));
    let over_noise: Vec<String> = over_noise.map(|r| format!("{r:.2}")).collect();
    let gain = sensor.gain.as_ref().map_or(String::new(), |gain| {
        format!("; factor {}", with_interval(gain))
    });
    format!(
        "{}: error over noise, step by step, {}{gain}",
        sensor.name,
        over_noise.join(", ")
    )
}

/// The summary for the terminal.
pub fn terminal(diagnosis: &Diagnosis) -> String {
    use std::fmt::Write as _;
    let mut out = String::new();
    let _ = writeln!(out, "{}\n", diagnosis.summary);
    if let Some(probability) = diagnosis.verdict_probability {
        let _ = writeln!(
            out,
            "Probability of this verdict among all that was compared: {}\n",
            likely(probability)
        );
    }
    let _ = writeln!(
        out,
        "{:<32} {:>10} {:>10} {:>14}",
        "error ladder (NRMSE)", "fit", "held out", "held out/noise"
    );
    for rung in &diagnosis.error_ladder {
        let _ = writeln!(
            out,
            "{:<32} {:>9.3} % {:>9.3} % {:>14.2}",
            rung.step,
            100.0 * rung.fit_nrmse,
            100.0 * rung.holdout_nrmse,
            rung.holdout_over_noise
        );
    }
    for (i, sensor) in diagnosis.further_sensors.iter().enumerate() {
        let _ = writeln!(out, "{}", of_sensor(i, sensor, &diagnosis.error_ladder));
    }
    let _ = writeln!(
        out,
        "\n{:<48} {:>10} {:>12} {:>10}",
        "candidates, best first", "gain", "probability", "fit/noise"
    );
    for candidate in diagnosis.candidates.iter().take(8) {
        let fitted = match candidate.passed_over {
            true => format!("{} (first look)", candidate.id),
            false => candidate.id.clone(),
        };
        let _ = writeln!(
            out,
            "{:<48} {:>10.1} {:>12} {:>10.2}",
            fitted,
            candidate.score,
            likely(candidate.probability),
            candidate.fit_over_noise
        );
    }
    if let Some(next) = &diagnosis.next_measurement {
        let _ = writeln!(
            out,
            "\nTo tell {} apart, measure at {} m/s and {} N (those that are wrong should then fall behind by {:.0} in gain; {TIE} is a tie).",
            next.separates.join(", "),
            next.belt_velocity_m_per_s,
            next.normal_force_n,
            next.expected_gain
        );
    }
    for (i, term) in diagnosis.proposed_terms.iter().enumerate() {
        let _ = writeln!(
            out,
            "proposed term (proposed_{}.toml): {} = {}, {}",
            i + 1,
            term.target,
            term.expression,
            term.worth()
        );
    }
    for remark in &diagnosis.remarks {
        let _ = writeln!(out, "note: {remark}");
    }
    out
}
