//! `stickslip figures`: the paper's figures from this model, beside what the paper says of them.

mod attractors;
mod bifurcations;
mod claim;
mod cycles;
mod identification;
mod map;
mod motions;
mod page;
mod second_frequency;
mod static_figures;

use std::path::{Path, PathBuf};

use beam_physics::sweep::{Chain, Motion, Rule, StartRule, Task, Values};
use clap::Args;

use self::claim::Claim;
use super::compute::compute;
use super::options::threads;
use super::plan::{self, Axis, Plan, StartKind};
use super::study::Study;
use crate::command::operating_point::{OperatingPoint, record};
use crate::command::progress::Progress;
use crate::error::Error;
use crate::fmu::Fmu;
use crate::output::{make_folder, print_line, write_file};
use crate::provenance::Provenance;
use crate::report::{Plot, svg_file};
use crate::watch::Watch;

/// Options of `figures`.
#[derive(Debug, Args)]
pub struct Arguments {
    /// FMU whose start values are used [default: this repository's StickSlipBeam, packed on the spot]
    #[arg(long, value_name = "FILE")]
    fmu: Option<PathBuf>,
    /// Threads [default: one per core]
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Coarse pictures in a tenth of the time
    #[arg(long)]
    quick: bool,
    /// Folder for figures.html, the pictures and their data
    #[arg(short, long, value_name = "DIR", default_value = "stickslip-figures")]
    output: PathBuf,
}

/// One figure.
pub struct PaperFigure {
    /// Its number in the paper.
    pub number: &'static str,
    /// What it shows.
    pub title: String,
    /// Claims.
    pub claims: Vec<Claim>,
    /// Pictures with their file names without suffix.
    pub pictures: Vec<(String, Plot)>,
}

/// What all figures are made with.
pub struct Workshop<'a> {
    base: Values,
    fmu: &'a Fmu,
    guid: String,
    folder: &'a Path,
    threads: usize,
    quick: bool,
    watch: &'a dyn Watch,
}

impl Workshop<'_> {
    /// The model with some values set.
    pub fn values(&self, set: &[(&str, f64)]) -> Values {
        let mut values = self.base.clone();
        for (name, value) in set {
            values.set(name, *value).expect("names of the model");
        }
        values
    }

    /// A number of points, fewer in quick pictures.
    pub fn points(&self, full: usize) -> usize {
        if self.quick {
            full.div_ceil(8).max(6)
        } else {
            full
        }
    }

    /// Writes a table.
    pub fn data(&self, name: &str, csv: &str) -> Result<(), Error> {
        write_file(&self.folder.join(name), csv.as_bytes())
    }

    /// A study into a folder of its own, and what to do with it.
    pub fn study<T>(
        &self,
        name: &str,
        axes: &[(&str, &str, f64, f64, usize)],
        set: &[(&str, f64)],
        starts: &[StartKind],
        look: impl FnOnce(&Study) -> T,
    ) -> Result<T, Error> {
        let plan = Plan {
            axes: axes
                .iter()
                .map(|(name, unit, from, to, points)| Axis {
                    name: (*name).into(),
                    unit: (*unit).into(),
                    values: plan::even(*from, *to, *points),
                })
                .collect(),
            settings: set.iter().map(|(n, v)| ((*n).into(), *v)).collect(),
            starts: starts.to_vec(),
            grid: (3, 2),
            rule: Rule {
                settle: if self.quick { 60 } else { 200 },
                cycles: if self.quick { 60 } else { 120 },
                ..Rule::default()
            },
            base: self.values(set),
            guid: self.guid.clone(),
        };
        let rows = plan.rows();
        let named = Named {
            watch: self.watch,
            name,
        };
        let store = compute(&plan, &rows, &self.folder.join(name), self.threads, &named)?;
        let section = store.section(&plan, &rows)?;
        let study = Study::new(&plan, &rows, store.done, section, Default::default());
        Ok(look(&study))
    }

    /// The motion with the largest amplitude that a grid of starts (and the fixed one) reaches.
    pub fn largest(&self, values: &Values) -> Option<Motion> {
        let mut starts = vec![StartRule::Fixed];
        for bend in [0.0, 0.95] {
            for velocity in [0.0, 1.0] {
                starts.push(StartRule::Grid { bend, velocity });
            }
        }
        let tasks = starts.into_iter().enumerate();
        let chains: Vec<Chain> = tasks
            .map(|(id, start)| Chain {
                carried: None,
                tasks: vec![Task {
                    id,
                    values: values.clone(),
                    start,
                }],
            })
            .collect();
        let mut all: Vec<(usize, Motion)> = Vec::new();
        let rule = Rule {
            settle: 100,
            cycles: 100,
            patience: 2,
            ..Rule::default()
        };
        beam_physics::sweep::run(&chains, &rule, self.threads, |outcome| {
            all.extend(outcome.motion.ok().map(|m| (outcome.id, m)));
            true
        });
        // In the order of the starts, so that of equal amplitudes always the same is taken.
        all.sort_by_key(|(id, _)| *id);
        let all = all.into_iter().map(|(_, m)| m);
        all.reduce(|a, b| {
            if b.amplitude > 1.001 * a.amplitude {
                b
            } else {
                a
            }
        })
    }

    /// Outputs of the FMU at an operating point: `count` samples every `interval` in s, after `settle` in s.
    pub fn record(
        &self,
        (force, velocity): (f64, f64),
        outputs: &[&str],
        interval: f64,
        settle: f64,
        count: usize,
    ) -> Result<Vec<Vec<f64>>, Error> {
        let point = OperatingPoint {
            belt_velocity: velocity,
            normal_force: force,
            ..OperatingPoint::default()
        };
        let before = (settle / interval).round() as usize;
        let mut instance = self.fmu.instantiate("figures")?;
        point.start(self.fmu, &mut instance)?;
        let steps = before + count - 1;
        let all = record(self.fmu, &mut instance, outputs, interval, steps)?;
        let after = all.values.into_iter().map(|mut v| v.split_off(before));
        Ok(after.collect())
    }

    /// The motion from the fixed start.
    pub fn fixed(&self, values: &Values) -> Option<Motion> {
        let subject = values.subject().ok()?;
        beam_physics::sweep::evaluate(&subject, &Rule::default(), &StartRule::Fixed, None).ok()
    }

    /// Says what is in work.
    pub fn begin(&self, what: &str) {
        self.watch.step(what, 0, 1);
    }
}

/// A watch that says which figure is in work.
struct Named<'a> {
    watch: &'a dyn Watch,
    name: &'a str,
}

impl Watch for Named<'_> {
    fn step(&self, _: &str, done: usize, of: usize) {
        self.watch.step(self.name, done, of);
    }
    fn stop(&self) -> bool {
        self.watch.stop()
    }
}

/// Runs the command.
///
/// # Errors
/// A folder that can't be written or holds something else; a stop by the user.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let fmu = crate::command::open_fmu(arguments.fmu.as_deref())?;
    make_folder(&arguments.output)?;
    let progress = Progress::new(Progress::STEPS);
    let workshop = Workshop {
        base: plan::base(&fmu)?,
        fmu: &fmu,
        guid: fmu.description().guid.clone(),
        folder: &arguments.output,
        threads: threads(arguments.threads)?,
        quick: arguments.quick,
        watch: &progress,
    };
    let figures = all(&workshop);
    progress.finish();
    let figures = figures?;
    for figure in &figures {
        for (name, picture) in &figure.pictures {
            let path = arguments.output.join(format!("{name}.svg"));
            write_file(&path, svg_file(picture).as_bytes())?;
        }
    }
    let files: Vec<&Path> = arguments.fmu.as_deref().into_iter().collect();
    let provenance = Provenance::of(&files)?;
    let report = arguments.output.join("figures.html");
    write_file(&report, page::html(&figures, &provenance).as_bytes())?;
    for figure in &figures {
        for claim in &figure.claims {
            print_line(format_args!(
                "Figure {:<3} {}: {}",
                figure.number,
                claim.verdict().words(),
                claim.paper
            ))?;
            for f in &claim.findings {
                print_line(format_args!(
                    "           {} {}: {} ({})",
                    if f.holds() { "+" } else { "-" },
                    f.what,
                    f.value_words(),
                    f.bound_words()
                ))?;
            }
        }
    }
    print_line(format_args!("Report: {}", report.display()))
}

fn all(workshop: &Workshop) -> Result<Vec<PaperFigure>, Error> {
    let mut all = vec![
        static_figures::cantilever(workshop)?,
        static_figures::mode_shapes(workshop)?,
        cycles::figure(workshop)?,
        static_figures::friction(workshop)?,
    ];
    all.extend(bifurcations::figures(workshop)?);
    let [set_up, diagram, characteristic] = identification::figures(workshop)?;
    all.push(set_up);
    all.extend(motions::figures(workshop)?);
    all.push(map::figure(workshop)?);
    all.extend([diagram, characteristic]);
    all.extend(attractors::figures(workshop)?);
    Ok(all)
}
