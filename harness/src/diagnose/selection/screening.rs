//! The segments on which hypotheses are compared, and the fits of many hypotheses to them.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::initialisation::multistart;
use crate::diagnose::initialisation::multistart::baseline;
use crate::diagnose::initialisation::score_test::{At, Lead, Promise, look};
use crate::diagnose::initialisation::search_options::SearchOptions;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Every how many-th group of segments is used at most while candidates are compared, ...
const SCREEN_EVERY: usize = 3;
/// ... fewer left out where so many segments would not be reached: what a poor campaign has is needed.
const ENOUGH: usize = 24;
/// A hypothesis with what a score test promises of its last effect; `None` where it can't speak of it.
pub(crate) type Promised = (Vec<Choice>, Option<Promise>);

/// Segments on which hypotheses are compared.
pub struct Screen<'a> {
    pub(crate) problem: &'a Problem<'a>,
    /// Their indices.
    pub indices: Vec<usize>,
    /// The segments themselves.
    pub segments: Vec<Segment>,
    /// Median error over the noise of the calibrated model on them, once it was fitted.
    pub(super) calibrated_error: OnceLock<f64>,
}

impl<'a> Screen<'a> {
    /// Some of the segments of every run that is fitted.
    pub fn new(problem: &'a Problem<'a>) -> Self {
        let every = (problem.fit_segments(1).len() / ENOUGH).clamp(1, SCREEN_EVERY);
        let indices = problem.fit_segments(every);
        let segments = problem.copies(&indices);
        Self::of_segments(problem, indices, segments)
    }

    /// Segments at the places `indices` of the problem's, their measurements perhaps replaced.
    pub fn of_segments(
        problem: &'a Problem<'a>,
        indices: Vec<usize>,
        segments: Vec<Segment>,
    ) -> Self {
        Self {
            problem,
            indices,
            segments,
            calibrated_error: OnceLock::new(),
        }
    }

    pub(crate) fn model(
        &self,
        choices: Vec<Choice>,
        fitted: FittedHypothesis,
    ) -> Result<FittedModel, Error> {
        FittedModel::new(self.problem, choices, fitted, &self.indices, &self.segments)
    }

    /// A model where it stands on these segments.
    ///
    /// # Errors
    /// An FMU that can't be instantiated.
    pub(crate) fn at<'b>(&'b self, model: &'b FittedModel) -> Result<At<'b>, Error> {
        At::new(self.problem, &self.segments, &model.fitted)
    }

    /// What a score test finds of the last effect of each of `jobs` beside a model that lacks it; `None` where it can't speak of it,
    /// and once the search is stopped.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn leads(
        &self,
        jobs: &[Vec<Choice>],
        base: &FittedModel,
        watch: &dyn Watch,
    ) -> Result<Vec<Option<Lead>>, Error> {
        let at = self.at(base)?;
        parallel(jobs, |choices| match watch.stop() {
            true => Ok(None),
            false => look(self.problem, choices, &at),
        })
    }

    /// What a score test promises of each of them.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn promises(
        &self,
        jobs: &[Vec<Choice>],
        base: &FittedModel,
        watch: &dyn Watch,
    ) -> Result<Vec<Option<Promise>>, Error> {
        let leads = self.leads(jobs, base, watch)?;
        Ok(leads.into_iter().map(|lead| lead?.promise).collect())
    }

    /// `jobs`, each `base` with one effect more, with what a score test promises of them, best first. What the test does not speak of
    /// counts as gaining nothing.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn by_promise(
        &self,
        jobs: Vec<Vec<Choice>>,
        base: &FittedModel,
        watch: &dyn Watch,
    ) -> Result<Vec<Promised>, Error> {
        let promises = self.promises(&jobs, base, watch)?;
        let gain = |promise: &Option<Promise>| promise.as_ref().map_or(0.0, |p| p.gain);
        let mut all: Vec<Promised> = jobs.into_iter().zip(promises).collect();
        all.sort_by(|(_, a), (_, b)| gain(b).total_cmp(&gain(a)));
        Ok(all)
    }

    /// Best first.
    pub fn sort(&self, models: &mut [FittedModel]) {
        models.sort_by(FittedModel::compare);
    }

    /// The reference model, fitted; `belief` is how firmly it is held to what is believed of it.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn calibrate(&self, belief: f64) -> Result<FittedModel, Error> {
        let fitted = baseline(self.problem, &self.segments, belief)?;
        let model = self.model(Vec::new(), fitted)?;
        self.calibrated_error
            .get_or_init(|| model.fit.quantile(0.5));
        Ok(model)
    }

    /// Hypotheses that take long to fit first, so that no thread waits for the last one.
    pub(crate) fn longest_first<'j>(&self, jobs: &'j [Vec<Choice>]) -> Vec<&'j Vec<Choice>> {
        let weight = |choices: &Vec<Choice>| -> usize {
            let of = |c: &Choice| self.problem.catalogue[c.effect].weight();
            choices.iter().map(of).sum()
        };
        let mut jobs: Vec<&Vec<Choice>> = jobs.iter().collect();
        jobs.sort_by_key(|choices| std::cmp::Reverse(weight(choices)));
        jobs
    }

    /// Fits many hypotheses in parallel, each the base with one effect more; best first.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn compete(
        &self,
        jobs: &[Vec<Choice>],
        base: &FittedModel,
        search: SearchOptions,
        watch: &dyn Watch,
    ) -> Result<Vec<FittedModel>, Error> {
        let done = AtomicUsize::new(0);
        let jobs = self.longest_first(jobs);
        let results = parallel(&jobs, |choices| {
            if watch.stop() {
                return Ok(None);
            }
            let fitted =
                multistart::search(self.problem, choices, &self.segments, &base.fitted, search)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            watch.step(&name(self.problem, choices), done, jobs.len());
            Ok(Some(self.model(choices.to_vec(), fitted)?))
        })?;
        let mut models: Vec<FittedModel> = results.into_iter().flatten().collect();
        self.sort(&mut models);
        Ok(models)
    }

    /// Keeps for each hypothesis the better of two fits.
    pub fn keep_better(&self, models: &mut Vec<FittedModel>, others: Vec<FittedModel>) {
        for other in others {
            match models.iter_mut().find(|c| c.choices == other.choices) {
                Some(mine) if other.is_better_fit(mine) => *mine = other,
                Some(mine) => mine.is_passed_over &= other.is_passed_over,
                None => models.push(other),
            }
        }
        self.sort(models);
    }

    /// A hypothesis fitted further from a point that a fit has reached.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn continued(
        &self,
        choices: &[Choice],
        start: Point,
        options: FitOptions,
    ) -> Result<FittedModel, Error> {
        let h = self.problem.hypothesis(choices)?;
        let fitted = multistart::continued(self.problem, h, &self.segments, start, options)?;
        self.model(choices.to_vec(), fitted)
    }

    /// A hypothesis fitted from a point of its own: its start states first, then all.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn fitted(
        &self,
        choices: &[Choice],
        start: Point,
        options: FitOptions,
    ) -> Result<FittedModel, Error> {
        let h = self.problem.hypothesis(choices)?;
        let fitted = multistart::settled(self.problem, h, &self.segments, start, options)?;
        self.model(choices.to_vec(), fitted)
    }
}
