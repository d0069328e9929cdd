//! A race of hypotheses: first looks at all of them, and those that look best followed to their end until one explains the data.
//!
//! What is missing looks better than what is not from a few Jacobians on: of eight campaigns with one effect it had arrived at the
//! noise by then in seven and looked best of all in the eighth. What looks worse ends far from the noise however long it is followed.
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

/// Hypotheses that are followed at a time: two for each of two cores. What was missing looked best of all in every campaign tried.
pub(crate) const BATCH: usize = 4;

/// A hypothesis, and first looks at it.
pub(crate) type Entrant = (Vec<Choice>, FirstLooks);

/// Hypotheses, each one and the same base with one effect more.
pub(crate) struct Race<'a> {
    screen: &'a Screen<'a>,
    base: FittedModel,
    search: SearchOptions,
    /// All that were looked at, the one that looks best first.
    pub entrants: Vec<Entrant>,
    /// How many of these were followed.
    followed: usize,
    /// How many were looked at or followed, as it is told.
    done: AtomicUsize,
    /// How many of these there can be.
    most: usize,
}

impl<'a> Race<'a> {
    /// First looks at all `jobs`. No more of them once the search is stopped.
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
            entrants: Vec::new(),
            followed: 0,
            done: AtomicUsize::new(0),
            most: 2 * jobs.len(),
        };
        let mut jobs: Vec<&Vec<Choice>> = jobs.iter().collect();
        jobs.sort_by_key(|choices| std::cmp::Reverse(screen.weight(choices)));
        let looks = parallel(&jobs, |choices| {
            if watch.stop() {
                return Ok(None);
            }
            let (problem, base) = (screen.problem, &base.fitted);
            let looks = multistart::first_looks(problem, choices, &screen.segments, base, search)?;
            race.step(choices, watch);
            Ok(Some((choices.to_vec(), looks)))
        })?;
        race.entrants = looks.into_iter().flatten().collect();
        let objective = |(_, looks): &Entrant| {
            let best = looks.best_first().first().map(|fit| fit.trimmed);
            best.unwrap_or(f64::INFINITY)
        };
        race.entrants
            .sort_by(|a, b| objective(a).total_cmp(&objective(b)));
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
        while self.followed < self.entrants.len() && !found.iter().any(has_won) && !watch.stop() {
            found.append(&mut self.follow(BATCH, watch)?);
        }
        let left = &self.entrants[self.followed..];
        found.append(&mut parallel(left, |entrant| self.as_seen(entrant))?);
        self.screen.sort(&mut found);
        Ok(found)
    }

    /// What was not followed yet, followed too.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn run_on(&mut self, watch: &dyn Watch) -> Result<Vec<FittedModel>, Error> {
        self.follow(self.entrants.len(), watch)
    }

    /// Follows the next so many of those that look best.
    fn follow(&mut self, most: usize, watch: &dyn Watch) -> Result<Vec<FittedModel>, Error> {
        let from = self.followed;
        self.followed = self.entrants.len().min(from + most);
        parallel(&self.entrants[from..self.followed], |entrant| {
            if watch.stop() {
                return self.as_seen(entrant);
            }
            let (screen, (choices, looks)) = (self.screen, entrant);
            let fitted = multistart::followed(
                screen.problem,
                choices,
                &screen.segments,
                &self.base.fitted,
                self.search,
                looks,
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
