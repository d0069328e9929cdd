//! The engine behind the page: opens campaigns, answers questions, does the work that is ordered. It never ends by an error: what
//! goes wrong is told on the page.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use serde::Serialize;

use super::controls::{Controls, controls};
use super::curves::{Curves, Measured, curves, measured};
use super::desk::{Ask, Desk, Order, closed};
use super::dropped::CAMPAIGNS;
use super::ladder::{Ladder, Origin, Rung};
use super::model::{Draft, hypothesis, point};
use super::preview::{Base, Errors, careful, careful_to_its_end, quick};
use super::work::{Bench, as_fitted, forecast_error, work};
use crate::command::{given_campaign, pack};
use crate::diagnose::model::library;
use crate::diagnose::model::problem::Problem;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::measurement::Campaign;
use crate::output::make_folder;
use crate::provenance::Provenance;

/// How often the engine looks whether files have changed, and whether it is to end.
const PAUSE: Duration = Duration::from_millis(500);
/// Bases that are kept: more than pages that are open at once, usually.
const BASES: usize = 6;

/// A campaign as the page shows it.
#[derive(Serialize)]
struct Opened<'a> {
    name: &'a str,
    folder: String,
    output: String,
    fmu: String,
    horizon_s: f64,
    segments: usize,
    quantity: Quantity,
    remarks: &'a [String],
    runs: Vec<RunView<'a>>,
    controls: Controls,
}

/// What the sensor reads.
#[derive(Serialize)]
struct Quantity {
    name: &'static str,
    unit: &'static str,
}

#[derive(Serialize)]
struct RunView<'a> {
    name: &'a str,
    belt_velocity: f64,
    normal_force: f64,
    kept_out: bool,
    duration_s: f64,
    samples: usize,
    /// In the unit of what the sensor reads.
    noise: f64,
    measured: Measured,
}

/// What a question is answered with.
#[derive(Serialize)]
struct Answer<'a> {
    errors: &'a Errors,
    curves: Curves,
    run: usize,
    careful: bool,
    milliseconds: f64,
}

/// Opens a campaign and all that are asked for after it, until `closing` is set.
pub fn run(desk: &Desk, fmu: &Fmu, campaign: Campaign, given: PathBuf, closing: &AtomicBool) {
    let (mut given, mut campaign) = (given, Some(campaign));
    while !closing.load(Ordering::Relaxed) {
        let is_open = match campaign.take() {
            Some(campaign) => guarded(|| open(desk, fmu, &campaign, &given, closing)),
            None => Ok(None),
        };
        let next = match is_open {
            Ok(Some(next)) => Some(next),
            Ok(None) => wait_closed(desk, closing),
            Err(error) => {
                desk.post(|board| {
                    board.campaign = None;
                    board.ladder = None;
                    board.opened += 1;
                    board.trouble = Some(error.to_string());
                });
                wait_closed(desk, closing)
            }
        };
        let path = match next {
            Some(Order::Open(path)) => path,
            Some(_) => given.clone(),
            None => continue,
        };
        match given_campaign::load(&path, given_campaign::Forced::default()) {
            Ok(read) => {
                (given, campaign) = (path, Some(read));
                desk.post(|board| board.trouble = None);
            }
            Err(error) => desk.post(|board| board.trouble = Some(error.to_string())),
        }
    }
}

/// Without a campaign: refuses work until one is to be opened.
fn wait_closed(desk: &Desk, closing: &AtomicBool) -> Option<Order> {
    while !closing.load(Ordering::Relaxed) {
        if let Some(waiting) = desk.next_ask(Duration::ZERO) {
            let why = desk.read(|board| closed(board.trouble.as_deref()));
            let _ = waiting.reply.send(Some(Err(why)));
        }
        match desk.next_order(PAUSE / 5) {
            Some(Order::Work(_)) => {
                let why = desk.read(|board| closed(board.trouble.as_deref()));
                desk.end(Err(why));
            }
            Some(order) => return Some(order),
            None => {}
        }
    }
    None
}

/// A panic of the numerics ends one answer, not the server.
fn guarded<R>(work: impl FnOnce() -> Result<R, Error>) -> Result<R, Error> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied());
        Err(Error::Internal {
            problem: text.unwrap_or("no reason given").to_owned(),
        })
    })
}

/// Opens a campaign, serves it, and returns the order that ends it.
fn open(
    desk: &Desk,
    fmu: &Fmu,
    campaign: &Campaign,
    given: &Path,
    closing: &AtomicBool,
) -> Result<Option<Order>, Error> {
    // Before the page hears of it: what is written from then on is a change.
    let read_at = stamps(campaign, given);
    let widened = pack::widened::with_effects(fmu, &library::FILES)?;
    let problem = Problem::new(widened.as_ref().unwrap_or(fmu), campaign)?;
    let inputs = Provenance::of_campaign(campaign, Some(fmu))?;
    let inputs = format!("{} {}", inputs.version, inputs.inputs_sha256);
    let home = home(desk, given);
    make_folder(&home)?;
    let (ladder, told) = history(&home, &problem, &inputs)?;
    let opened = Opened {
        name: &problem.campaign.name,
        folder: given.display().to_string(),
        output: desk.output.display().to_string(),
        fmu: fmu.path().display().to_string(),
        horizon_s: problem.horizon,
        segments: problem.segments.len(),
        quantity: Quantity {
            name: campaign.measurand().name(),
            unit: campaign.measurand().unit(),
        },
        remarks: &problem.remarks,
        runs: (0..problem.campaign.runs.len())
            .map(|r| run_view(&problem, r))
            .collect(),
        controls: controls(&problem)?,
    };
    let json = serde_json::to_string(&opened).expect("numbers and texts have a JSON form");
    desk.post(|board| {
        board.campaign = Some(json.into());
        board.ladder = Some(ladder);
        board.home = home;
        board.opened += 1;
        board.trouble = told;
    });
    let bench = Bench {
        desk,
        problem: &problem,
        campaign,
        fmu,
        given,
    };
    let leaving = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| answers(&bench, &leaving, closing));
        let next = orders(&bench, &read_at, closing);
        leaving.store(true, Ordering::Relaxed);
        Ok(next)
    })
}

/// Where the history of a campaign lives: in the output folder, or, of one that was imported into it, in a folder beside that.
fn home(desk: &Desk, given: &Path) -> PathBuf {
    let is_imported = given.starts_with(desk.output.join(CAMPAIGNS));
    match given.file_name() {
        Some(name) if is_imported => {
            let name = format!("{}.studio", name.to_string_lossy());
            given.with_file_name(name)
        }
        _ => desk.output.clone(),
    }
}

fn run_view<'a>(problem: &'a Problem, r: usize) -> RunView<'a> {
    let run = &problem.campaign.runs[r];
    RunView {
        name: &run.name,
        belt_velocity: problem.stated_belt_velocity(r),
        normal_force: run.normal_force,
        kept_out: problem.held_out[r],
        duration_s: run.time[run.time.len() - 1] - run.time[0],
        samples: run.time.len(),
        noise: problem.noise[r],
        measured: measured(problem, r),
    }
}

/// The history of the output folder, or a new one that begins with the model as given; and what must be said of it.
fn history(
    home: &Path,
    problem: &Problem,
    inputs: &str,
) -> Result<(Ladder, Option<String>), Error> {
    let (read, told) = match Ladder::read(home) {
        Ok(read) => (read, None),
        Err(error) => {
            // It is kept under another name, so that nothing is lost by going on.
            let path = home.join(super::ladder::FILE);
            let aside = path.with_extension("unread.json");
            let moved = std::fs::rename(&path, &aside).is_ok();
            let where_to = if moved {
                format!("; it is kept as {}", aside.display())
            } else {
                String::new()
            };
            (None, Some(format!("{error}{where_to}")))
        }
    };
    if let Some(mut ladder) = read {
        let fits = |draft: &Draft| hypothesis(problem, draft).is_ok();
        if ladder.inputs == inputs {
            return Ok((ladder, told));
        }
        // The values still stand, but not where segments start, nor the errors.
        ladder.inputs = inputs.to_owned();
        for rung in &mut ladder.rungs {
            rung.starts = None;
        }
        if ladder.rungs.iter().all(|rung| fits(&rung.draft)) && fits(&ladder.draft) {
            let changed = "The campaign or the program has changed since the tries below were made: their errors are \
                           those of then. Keep a model again to see its error now.";
            return Ok((ladder, Some(changed.into())));
        }
    }
    let draft = Draft::default();
    let given = careful_to_its_end(problem, &draft, None)?;
    let first = Rung {
        id: 0,
        name: "as given".into(),
        origin: Origin::Given,
        before: None,
        draft,
        forecast: forecast_error(problem, &as_fitted(&given))?,
        starts: Some(given.starts()),
        errors: given.errors,
    };
    let ladder = Ladder::new(inputs.to_owned(), first);
    let written = ladder.write(home).err().map(|e| e.to_string());
    Ok((ladder, told.or(written)))
}

/// Answers questions until the campaign is left.
fn answers(bench: &Bench, leaving: &AtomicBool, closing: &AtomicBool) {
    let mut bases: Vec<(u64, Draft, Arc<Base>)> = Vec::new();
    while !leaving.load(Ordering::Relaxed) && !closing.load(Ordering::Relaxed) {
        let Some(waiting) = bench.desk.next_ask(PAUSE / 5) else {
            continue;
        };
        let answer = guarded(|| answer(bench, &mut bases, &waiting.ask, &waiting.superseded));
        let _ = waiting.reply.send(answer.transpose());
    }
}

/// The answer to a question; `None` once it is superseded.
fn answer(
    bench: &Bench,
    bases: &mut Vec<(u64, Draft, Arc<Base>)>,
    ask: &Ask,
    superseded: &AtomicBool,
) -> Result<Option<String>, Error> {
    let (desk, problem) = (bench.desk, bench.problem);
    if ask.run >= problem.campaign.runs.len() {
        return Err(Error::Option {
            option: "run",
            value: ask.run.to_string(),
            rule: format!(
                "is none; the campaign has {} runs",
                problem.campaign.runs.len()
            ),
        });
    }
    let base = base_of(bench, bases, ask.base)?;
    let begun = Instant::now();
    let before = on_the_page(desk);
    let predicted = match ask.careful {
        true => careful(problem, &ask.draft, Some(base.starts()), superseded)?,
        false => quick(problem, &ask.draft, &base, superseded)?,
    };
    let Some(predicted) = predicted else {
        return Ok(None);
    };
    let curves = curves(problem, &predicted, ask.run)?;
    if ask.shown {
        remember(desk, ask, &before)?;
    }
    let answer = Answer {
        errors: &predicted.errors,
        curves,
        run: ask.run,
        careful: ask.careful,
        milliseconds: 1e3 * begun.elapsed().as_secs_f64(),
    };
    let text = serde_json::to_string(&answer).expect("numbers and texts have a JSON form");
    Ok(Some(text))
}

/// The model on the page and the rung that it starts from.
fn on_the_page(desk: &Desk) -> Option<(Draft, u64)> {
    desk.read(|board| board.ladder.as_ref().map(|l| (l.draft.clone(), l.base)))
}

/// Notes the model on the page; writes it once a slider rests. A model that came onto the page while this one was predicted, that of
/// a fit that has ended, stays.
fn remember(desk: &Desk, ask: &Ask, before: &Option<(Draft, u64)>) -> Result<(), Error> {
    let now = on_the_page(desk);
    let same = now
        .as_ref()
        .is_some_and(|(draft, base)| *draft == ask.draft && *base == ask.base);
    if now != *before && !same || same && !ask.careful {
        return Ok(());
    }
    if !same {
        desk.post(|board| {
            board.shown.client.clone_from(&ask.client);
            board.shown.turn += 1;
            if let Some(ladder) = &mut board.ladder {
                ladder.draft.clone_from(&ask.draft);
                ladder.base = ask.base;
            }
        });
    }
    if ask.careful {
        desk.change_ladder(|_| Ok(()))?;
    }
    Ok(())
}

/// The base that a rung is, made when it is first asked for.
fn base_of(
    bench: &Bench,
    bases: &mut Vec<(u64, Draft, Arc<Base>)>,
    id: u64,
) -> Result<Arc<Base>, Error> {
    let rung = bench.desk.read(|board| {
        let ladder = board.ladder.as_ref();
        let ladder = ladder.ok_or_else(|| closed(board.trouble.as_deref()))?;
        ladder.rung(id).cloned()
    })?;
    if let Some(i) = bases.iter().position(|b| b.0 == id && b.1 == rung.draft) {
        return Ok(bases[i].2.clone());
    }
    let h = hypothesis(bench.problem, &rung.draft)?;
    let base = match &rung.starts {
        Some(starts) => {
            let there = point(bench.problem, &h, &rung.draft, Some((&h, starts)))?;
            Base::at(bench.problem, h, &there)?
        }
        None => {
            let there = careful_to_its_end(bench.problem, &rung.draft, None)?;
            Base::at(bench.problem, there.hypothesis, &there.point)?
        }
    };
    let base = Arc::new(base);
    if bases.len() >= BASES {
        bases.remove(0);
    }
    bases.push((id, rung.draft, base.clone()));
    Ok(base)
}

/// Does what is ordered until another campaign is to be opened.
fn orders(bench: &Bench, read_at: &[Stamp], closing: &AtomicBool) -> Option<Order> {
    let desk = bench.desk;
    let mut has_changed = false;
    while !closing.load(Ordering::Relaxed) {
        match desk.next_order(PAUSE) {
            Some(Order::Work(job)) => {
                let result = guarded(|| work(bench, job));
                desk.end(result);
            }
            // One that can't be read leaves the page with what it has.
            Some(order @ (Order::Reload | Order::Open(_))) => {
                let path = match &order {
                    Order::Open(path) => path,
                    _ => bench.given,
                };
                match given_campaign::load(path, given_campaign::Forced::default()) {
                    Ok(_) => return Some(order),
                    Err(error) => desk.post(|board| {
                        board.trouble = Some(format!(
                            "{error}. The page goes on with what was read before."
                        ));
                    }),
                }
            }
            None => {
                if !has_changed && stamps(bench.campaign, bench.given) != read_at {
                    has_changed = true;
                    desk.post(|board| {
                        board.trouble = Some(
                            "The campaign's files have changed since they were read. The page goes on with what was \
                             read; reload the campaign to see them."
                                .into(),
                        );
                    });
                }
            }
        }
    }
    None
}

/// When a file was written, and how long it is; `None` of one that is not there.
type Stamp = Option<(SystemTime, u64)>;

/// Those of the campaign's files.
fn stamps(campaign: &Campaign, given: &Path) -> Vec<Stamp> {
    let toml = match given.is_dir() {
        true => given.join("campaign.toml"),
        false => given.to_owned(),
    };
    let runs = campaign.runs.iter().map(|run| run.file.clone());
    let stamp = |path: PathBuf| {
        let about = std::fs::metadata(path).ok()?;
        Some((about.modified().ok()?, about.len()))
    };
    std::iter::once(toml).chain(runs).map(stamp).collect()
}
