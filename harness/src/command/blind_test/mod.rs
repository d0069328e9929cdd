//! `stickslip blind-test`: diagnoses every campaign of a folder whose answers are known, and
//! counts.
//!
//! One campaign on each processor, each within one thread. What is finished is kept, so that a test
//! that was stopped goes on.

mod answer;
mod case;
mod finished;
mod power;
mod tally;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use clap::Args;
use cpu_time::ThreadTime;
use serde::Serialize;

use self::answer::Answer;
use self::case::BlindCase;
use self::finished::Finisher;
use self::tally::Tally;
use super::diagnose::{Search, UNFINISHED, diagnose};
use super::given_campaign::{self, Forced};
use super::progress::Progress;
use crate::error::Error;
use crate::exit::Exit;
use crate::fmu::Fmu;
use crate::measurement::Campaign;
use crate::output::{make_folder, print, print_line, write_file};
use crate::parallel::{on_this_thread, parallel};
use crate::provenance::{Provenance, on_behalf_of, stands_for};
use crate::watch::{Silent, Watch};

/// Options of `blind-test`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// Folder with numbered campaigns and a truth.json
    #[arg(value_name = "FOLDER")]
    folder: PathBuf,
    /// FMU to diagnose [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Folder for blind-test.json and the diagnosis of each campaign
    #[arg(short, long, value_name = "DIR", default_value = "blind-test")]
    output: PathBuf,
    /// Only these campaigns, by name
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<String>,
    #[command(flatten)]
    forced: Forced,
    /// Print tally and campaigns as JSON instead of the tables
    #[arg(long)]
    json: bool,
}

/// What `--json` prints.
#[derive(Serialize)]
struct Printed<'a> {
    #[serde(flatten)]
    tally: &'a Tally,
    campaigns: &'a [BlindCase],
}

/// What a blind test counts.
#[derive(Debug)]
pub struct Tested {
    /// Tally and campaigns as JSON.
    pub json: String,
    /// The tables.
    pub text: String,
    /// Campaigns finished.
    done: usize,
    /// Campaigns asked for.
    of: usize,
    folder: PathBuf,
}

impl Tested {
    /// Whether all campaigns asked for were diagnosed.
    ///
    /// # Errors
    /// [`Error::Stopped`] with how many were.
    pub fn whole(&self) -> Result<(), Error> {
        if self.done == self.of {
            return Ok(());
        }
        Err(Error::Stopped {
            what: "campaigns",
            done: self.done,
            of: self.of,
            folder: self.folder.clone(),
        })
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let progress = Progress::new(Progress::STEPS);
    let own = std::env::current_exe().map_err(Error::read(Path::new("the running program")))?;
    let tell = |line: &str| match arguments.json {
        true => Ok(()),
        false => progress.suspend(|| print_line(line)),
    };
    let found = perform(arguments, &own, &progress, &tell);
    progress.finish();
    let found = found?;
    if arguments.json {
        print_line(&found.json)?;
    } else {
        print(&format!("\n{}", found.text))?;
        let details = arguments.output.join(DETAILS);
        print_line(format_args!("Details: {}", details.display()))?;
    }
    found.whole()
}

/// The campaigns' results.
const DETAILS: &str = "blind-test.json";

/// Diagnoses and counts; `tell` hears a line for each campaign. Results in the folder are taken again where they are
/// of the same `program`, a file.
///
/// # Errors
/// A folder, campaign or FMU that can't be used; results that can't be written.
pub fn perform(
    arguments: &Arguments,
    program: &Path,
    watch: &dyn Watch,
    tell: &(dyn Fn(&str) -> Result<(), Error> + Sync),
) -> Result<Tested, Error> {
    let mut answers = answer::read(&arguments.folder)?;
    let is_wanted = |a: &Answer| arguments.only.is_empty() || arguments.only.contains(&a.campaign);
    answers.retain(is_wanted);
    make_folder(&arguments.output)?;
    let test = Test {
        arguments,
        fmu: super::open_fmu(arguments.fmu.as_deref())?,
        finisher: Finisher::new(program, arguments.fmu.as_deref())?,
        watch,
        tell,
        done: AtomicUsize::new(0),
        of: answers.len(),
    };
    let line = stands_for();
    let found = parallel(&answers, |answer| {
        on_behalf_of(line.clone(), || on_this_thread(|| test.campaign(answer)))
    });
    let cases: Vec<BlindCase> = found?.into_iter().flatten().collect();
    let text = serde_json::to_string_pretty(&cases).expect("plain data");
    write_file(&arguments.output.join(DETAILS), text.as_bytes())?;
    let tally = Tally::new(&cases);
    let printed = Printed {
        tally: &tally,
        campaigns: &cases,
    };
    let json = Provenance::of(&[&arguments.folder.join("truth.json")])?.json(&printed);
    write_file(&arguments.output.join("tally.json"), json.as_bytes())?;
    Ok(Tested {
        json,
        text: tally.text(),
        done: cases.len(),
        of: test.of,
        folder: arguments.output.clone(),
    })
}

/// A test in progress.
struct Test<'a> {
    arguments: &'a Arguments,
    fmu: Fmu,
    finisher: Finisher,
    watch: &'a dyn Watch,
    tell: &'a (dyn Fn(&str) -> Result<(), Error> + Sync),
    /// Campaigns finished.
    done: AtomicUsize,
    /// Campaigns asked for.
    of: usize,
}

impl Test<'_> {
    /// One campaign's result; `None` where the test was stopped before its end.
    fn campaign(&self, answer: &Answer) -> Result<Option<BlindCase>, Error> {
        if self.watch.stop() {
            return Ok(None);
        }
        let name = &answer.campaign;
        let campaign = given_campaign::load_plain(
            &self.arguments.folder.join(name),
            self.arguments.forced,
            "blind-test",
        )?;
        let provenance = Provenance::of_campaign(&campaign, Some(&self.fmu))?;
        let folder = self.arguments.output.join(name);
        make_folder(&folder)?;
        let case = match self.finisher.recall(&folder, answer, &provenance) {
            Some(case) => case,
            None => {
                let case = self.diagnosed(answer, (&campaign, provenance), &folder)?;
                let Some(case) = case else { return Ok(None) };
                self.finisher.keep(&folder, answer, &case)?;
                case
            }
        };
        let done = 1 + self.done.fetch_add(1, Ordering::Relaxed);
        self.watch.step(name, done, self.of);
        (self.tell)(&case.line())?;
        Ok(Some(case))
    }

    fn diagnosed(
        &self,
        answer: &Answer,
        (campaign, provenance): (&Campaign, Provenance),
        folder: &Path,
    ) -> Result<Option<BlindCase>, Error> {
        let silent = Silent(self.watch);
        // The time of what is left to do is not that of a diagnosis.
        let is_new = !folder.join(UNFINISHED).exists();
        let (start, thread) = (Instant::now(), ThreadTime::now());
        let ended = diagnose(&self.fmu, campaign, &Search::default(), folder, &silent);
        let processor = thread.elapsed().as_secs_f64();
        let cost = (start.elapsed().as_secs_f64(), is_new.then_some(processor));
        // What can't be written ends the test; what a diagnosis can't do counts against it.
        let ended = match ended {
            Err(error) if error.exit() == Exit::NotWritten => return Err(error),
            ended => ended,
        };
        if self.watch.stop() {
            return Ok(None);
        }
        // A diagnosis counts as what it is even where its power can't be told.
        let power = power::power(&self.fmu, campaign, answer).unwrap_or(None);
        if self.watch.stop() {
            return Ok(None);
        }
        Ok(Some(BlindCase::new(
            answer, &ended, power, cost, provenance,
        )))
    }
}
