//! A race of hypotheses: first looks at all of them, and those that look best followed to their end until one explains the data.
//!
//! What is missing looks better than what is not from a few Jacobians on: of eight campaigns with one effect it had arrived at the
//! noise by then in six and looked best of all in the others. What looks worse ends far from the noise however long it is followed.
//! Source of the method: Jamieson and Talwalkar, Proc. AISTATS 2016, sect. 3 (successive halving).

use crate::diagnose::initialisation::multistart::{self, FirstLooks};
use crate::diagnose::initialisation::search_options::SearchOptions;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Hypotheses that are followed at a time: twice as many as looked better than what was missing in any campaign tried, with it.
const BATCH: usize = 4;

/// A hypothesis, and first looks at it.
type Entrant = (Vec<Choice>, FirstLooks);

/// Hypotheses, each one and the same base with one effect more.
pub(crate) struct Race<'a> {
    screen: &'a Screen<'a>,
    base: FittedModel,
    search: SearchOptions,
    /// Those that were only looked at, the one that looks best last.
    waiting: Vec<Entrant>,
    /// How many were looked at or followed.
    done: AtomicUsize,
    /// How many of these there can be.
    most: usize,
}

impl<'a> Race<'a> {
    /// First looks at all `jobs`. None of them once the search is stopped.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn new(
        screen: &'a Screen<'a>,
        jobs: &[Vec<Choice>],
        base: &FittedModel,
        search: SearchOptions,
        watch: &dyn Watch,
    ) -> Result<Self, Error> {
        let mut race = Self {
            screen,
            base: base.clone(),
            search,
            waiting: Vec::new(),
            done: AtomicUsize::new(0),
            most: 2 * jobs.len(),
        };
        let jobs = screen.longest_first(jobs);
        let looks = parallel(&jobs, |choices| {
            if watch.stop() {
                return Ok(None);
            }
            let looks = multistart::first_looks(
                screen.problem,
                choices,
                &screen.segments,
                &base.fitted,
                search,
            )?;
            race.step(choices, watch);
            Ok(Some((choices.to_vec(), looks)))
        })?;
        race.waiting = looks.into_iter().flatten().collect();
        let objective = |(_, looks): &Entrant| {
            let all = looks.followed.iter().chain(&looks.seen);
            all.map(|fit| fit.trimmed).fold(f64::INFINITY, f64::min)
        };
        race.waiting
            .sort_by(|a, b| objective(b).total_cmp(&objective(a)));
        Ok(race)
    }

    fn step(&self, choices: &[Choice], watch: &dyn Watch) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        watch.step(&name(self.screen.problem, choices), done, self.most);
    }

    /// The hypotheses, best first: followed are those that look best, until one that imitates little has arrived at the noise.
    /// The others stand where they were seen.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn run(&mut self, watch: &dyn Watch) -> Result<Vec<FittedModel>, Error> {
        let mut found = Vec::new();
        let has_won = |model: &FittedModel| !model.is_local() && model.reaches_floor();
        while !(self.waiting.is_empty() || found.iter().any(has_won) || watch.stop()) {
            found.append(&mut self.follow(BATCH, watch)?);
        }
        let mut left = parallel(&self.waiting, |entrant| self.as_seen(entrant))?;
        found.append(&mut left);
        self.screen.sort(&mut found);
        Ok(found)
    }

    /// What was not followed yet, followed too.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn run_on(&mut self, watch: &dyn Watch) -> Result<Vec<FittedModel>, Error> {
        self.follow(self.waiting.len(), watch)
    }

    /// Follows so many of those that look best.
    fn follow(&mut self, most: usize, watch: &dyn Watch) -> Result<Vec<FittedModel>, Error> {
        let left = self.waiting.len().saturating_sub(most);
        let batch = self.waiting.split_off(left);
        let screen = self.screen;
        parallel(&batch, |entrant| {
            if watch.stop() {
                return self.as_seen(entrant);
            }
            let (choices, looks) = entrant;
            let fitted = multistart::followed(
                screen.problem,
                choices,
                &screen.segments,
                &self.base.fitted,
                self.search,
                looks.clone(),
            )?;
            self.step(choices, watch);
            screen.model(choices.clone(), fitted)
        })
    }

    /// A hypothesis that is not followed.
    fn as_seen(&self, (choices, looks): &Entrant) -> Result<FittedModel, Error> {
        let screen = self.screen;
        let (problem, base) = (screen.problem, &self.base.fitted);
        let fitted = multistart::passed_over(problem, choices, &screen.segments, base, looks)?;
        screen.model(choices.clone(), fitted)
    }
}
