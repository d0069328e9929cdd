//! `stickslip try`: adds effects to the calibrated model by hand, one step of the error ladder at a time.

use std::path::PathBuf;

use clap::Args;

use super::diagnose::{report, terminal, written_json};
use super::given_campaign::{self, Forced};
use super::pack::widened::with_effects;
use super::progress::Progress;
use crate::diagnose::model::acting::leave_out;
use crate::diagnose::model::library::{self, is_library_effect};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::result::diagnosis::Diagnosis;
use crate::diagnose::result::error_ladder::climb;
use crate::diagnose::selection::follow::follow;
use crate::diagnose::stages;
use crate::error::Error;
use crate::measurement::Measurand;
use crate::output::{make_folder, print, print_line};
use crate::watch::Watch;

/// Options of `try`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder with campaign.toml and the CSV files, or the path of campaign.toml
    #[arg(value_name = "CAMPAIGN")]
    campaign: PathBuf,
    /// Effect to add; give it again for a further one (`stickslip effects` and `effects --library` list them)
    #[arg(long = "add", value_name = "ID", required = true)]
    add: Vec<String>,
    /// FMU to try [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Folder for diagnosis.json, report.html, model.toml, the .ssv and the repaired .fmu
    #[arg(short, long, value_name = "DIR", default_value = "try")]
    output: PathBuf,
    /// Print diagnosis.json instead of the summary
    #[arg(long)]
    json: bool,
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

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let progress = Progress::new(Progress::STAGES);
    let diagnosis = perform(arguments, &progress);
    progress.finish();
    let diagnosis = diagnosis?;
    if arguments.json {
        print_line(arguments.written_json()?)
    } else {
        print(&terminal(&diagnosis))?;
        let report = arguments.output.join("report.html");
        print_line(format_args!("Report: {}", report.display()))
    }
}

/// Of a campaign of velocities or accelerations, refuses effects that a sensor of displacements alone shows.
fn leave_out_blind(problem: &mut Problem, effects: &[usize]) -> Result<(), Error> {
    if problem.campaign.measurand() == Measurand::Displacement {
        return Ok(());
    }
    leave_out(problem)?;
    match effects.iter().find(|effect| !problem.acts[**effect]) {
        None => Ok(()),
        Some(&effect) => Err(Error::Option {
            option: "--add",
            value: problem.catalogue[effect].id.clone(),
            rule: format!(
                "can't act in this campaign: it does not move the tip, and what was measured is the tip's {}; leave it out",
                problem.campaign.measurand().name()
            ),
        }),
    }
}

/// Tries the effects and writes everything into the folder of the options.
///
/// # Errors
/// Options, a campaign, an effect or an FMU that can't be used; a folder that can't be written.
pub fn perform(arguments: &Arguments, watch: &dyn Watch) -> Result<Diagnosis, Error> {
    let campaign = given_campaign::load(&arguments.campaign, arguments.forced)?;
    let fmu = super::open_fmu(arguments.fmu.as_deref())?;
    let widened = match arguments.add.iter().any(|id| is_library_effect(id)) {
        true => with_effects(&fmu, &library::FILES)?,
        false => None,
    };
    let mut problem = Problem::new(widened.as_ref().unwrap_or(&fmu), &campaign)?;
    let mut effects = Vec::new();
    for id in &arguments.add {
        let index = super::effects::find(&problem.catalogue, id, fmu.path())?;
        if !effects.contains(&index) {
            effects.push(index);
        }
    }
    leave_out_blind(&mut problem, &effects)?;
    make_folder(&arguments.output)?;
    let selection = follow(&problem, &effects, watch)?;
    let command = format!("try --add {}", arguments.add.join(" --add "));
    if selection.explained {
        problem.trust_sensor();
    }
    watch.stage(stages::KEPT_OUT);
    let steps = climb(&problem, &selection)?;
    report(
        &fmu,
        &problem,
        &selection,
        &steps,
        (&command, &campaign),
        &arguments.output,
        watch,
    )
}
