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
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Hypotheses that are followed at a time: two for each of two cores. What was missing looked best of all in every campaign tried.
pub(crate) const BATCH: usize = 4;
/// Hypotheses that are followed at most.
pub(crate) const FOLLOWED: usize = 2 * BATCH;

/// A hypothesis, and first looks at it.
pub(crate) type Entrant = (Vec<Choice>, FirstLooks);

/// Hypotheses, each one and the same base with one effect more.
pub(crate) struct Race<'a> {
    screen: &'a Screen<'a>,
    base: FittedModel,
    search: SearchOptions,
    /// All that were looked at, the one that looks best first.
    pub entrants: Vec<Entrant>,
}

/// First looks at `jobs`, each `base` with one effect more, the one that looks best first; no more of them once the search is stopped.
/// They are told as the first of `steps` steps.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn first_looks(
    screen: &Screen,
    jobs: &[Vec<Choice>],
    base: &FittedModel,
    search: SearchOptions,
    steps: usize,
    watch: &dyn Watch,
) -> Result<Vec<Entrant>, Error> {
    let done = AtomicUsize::new(0);
    let looks = parallel(&screen.longest_first(jobs), |choices| {
        if watch.stop() {
            return Ok(None);
        }
        let (problem, base) = (screen.problem, &base.fitted);
        let looks = multistart::first_looks(problem, choices, &screen.segments, base, search)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        watch.step(&name(problem, choices), done, steps);
        Ok(Some((choices.to_vec(), looks)))
    })?;
    let mut entrants: Vec<Entrant> = looks.into_iter().flatten().collect();
    let objective = |(_, looks): &Entrant| {
        let best = looks.best_first().first().map(|fit| fit.trimmed);
        best.unwrap_or(f64::INFINITY)
    };
    entrants.sort_by(|a, b| objective(a).total_cmp(&objective(b)));
    Ok(entrants)
}

impl<'a> Race<'a> {
    /// First looks at all `jobs`.
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
        Ok(Self {
            screen,
            base: base.clone(),
            search,
            entrants: first_looks(screen, jobs, base, search, 2 * jobs.len(), watch)?,
        })
    }

    /// The hypotheses, best first: followed are those that look best, until one that imitates little has arrived at the noise, eight at
    /// most. The others stand where they were seen.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn run(&self, watch: &dyn Watch) -> Result<Vec<FittedModel>, Error> {
        let mut found = Vec::new();
        // Beside a base that meets most segments, most are met by whatever is added.
        let may_lose = !self.base.leaves_runs();
        let ends = |m: &FittedModel| m.is_answer() && (may_lose || !m.loses_segments());
        let is_open = |found: &[FittedModel]| !found.iter().any(ends);
        let most = self.entrants.len().min(FOLLOWED);
        // Those about to arrive at their first look need no rivals that are not.
        let arrived = |(_, looks): &&Entrant| looks.followed.is_some();
        let mut followed = self.entrants.iter().take_while(arrived).count().min(most);
        found.append(&mut self.follow(0..followed, watch)?);
        while followed < most && is_open(&found) && !watch.stop() {
            let next = followed..most.min(followed + BATCH);
            followed = next.end;
            found.append(&mut self.follow(next, watch)?);
        }
        let left = &self.entrants[followed..];
        found.append(&mut parallel(left, |entrant| self.as_seen(entrant))?);
        self.screen.sort(&mut found);
        Ok(found)
    }

    /// Follows those at these places.
    fn follow(&self, which: Range<usize>, watch: &dyn Watch) -> Result<Vec<FittedModel>, Error> {
        let steps = 2 * self.entrants.len();
        let done = AtomicUsize::new(self.entrants.len() + which.start);
        parallel(&self.entrants[which], |entrant| {
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
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            watch.step(&name(screen.problem, choices), done, steps);
            screen.model(choices.clone(), fitted)
        })
    }

    /// A hypothesis that is not followed.
    fn as_seen(&self, (choices, looks): &Entrant) -> Result<FittedModel, Error> {
        let screen = self.screen;
        let (problem, base) = (screen.problem, &self.base.fitted);
        let fitted = multistart::passed_over(problem, choices, &screen.segments, base, looks)?;
        Ok(FittedModel {
            is_passed_over: true,
            ..screen.model(choices.clone(), fitted)?
        })
    }
}
