//! What no term of the catalogue explains: effects of the library and unknown functions as hypotheses.

use super::Exploration;
use crate::diagnose::initialisation::search_options::{BRIEF, CURVE};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::{File, is_library_effect};
use crate::diagnose::model::variants::{library, unknown};
use crate::diagnose::selection::decision::log_posterior;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::screening::Promised;
use crate::diagnose::stages;
use crate::error::Error;
use crate::parallel::parallel;

/// Effects of the library that are fitted before it is asked whether one is adequate.
pub(super) const LIBRARY_BATCH: usize = 10;

/// Unknown functions that are fitted where the catalogue has no answer: of each place where one may act about one.
pub(super) const UNKNOWN_FITTED: usize = 6;

impl Exploration<'_> {
    /// Whether the catalogue has no answer: nothing of it is adequate but with values along each run, which imitate much, or with these
    /// it is more probable than without.
    pub(super) fn needs_unknown_functions(&self) -> bool {
        let is_of_catalogue = |c: &&FittedModel| {
            let mut effects = c.choices.iter();
            effects.all(|e| !is_library_effect(&self.problem.catalogue[e.effect].id))
        };
        let has_answer = self
            .all()
            .filter(is_of_catalogue)
            .any(FittedModel::is_answer);
        (!has_answer || self.leader_is_local()) && !self.problem.place_is_told()
    }

    /// Whether the most probable of what is adequate has values of its own along each run.
    pub(super) fn leader_is_local(&self) -> bool {
        let posterior = |model: &FittedModel| log_posterior(self.problem, model);
        let adequate = self.all().filter(|m| m.reaches_floor());
        let leader = adequate.max_by(|a, b| posterior(a).total_cmp(&posterior(b)));
        leader.is_some_and(FittedModel::is_local)
    }

    /// Lets unknown functions compete where the catalogue has no answer, once.
    pub(super) fn try_unknown_functions(&mut self) -> Result<(), Error> {
        if self.has_tried_unknown || !self.needs_unknown_functions() {
            return Ok(());
        }
        self.has_tried_unknown = true;
        self.watch.stage(stages::UNKNOWN);
        self.add_unknown_functions()
    }

    /// Unknown functions as the only thing that the calibrated model lacks: hypotheses like the others.
    pub(super) fn add_unknown_functions(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let alone = self.held_alone()?;
        let ranked = self.by_promise(&alone, unknown(self.problem))?;
        let acting = self.adequate_of_library();
        let is_wanted = |(place, (choices, _)): &(usize, Promised)| {
            *place < UNKNOWN_FITTED || self.acts_like(choices, &acting)
        };
        let best = ranked.into_iter().enumerate().filter(is_wanted);
        let jobs: Vec<Vec<Choice>> = best.map(|(_, (choices, _))| choices).collect();
        let held = screen.compete(&jobs, &alone, CURVE, watch)?;
        let mut found = screen.freed(&held)?;
        screen.finish(&mut found, watch)?;
        // A brief fit tells only what may be the most probable of all.
        let posterior = |model: &FittedModel| log_posterior(self.problem, model);
        let adequate = self.all().filter(|m| m.reaches_floor());
        let best = adequate.map(posterior).fold(f64::NEG_INFINITY, f64::max);
        let found = parallel(&found, |model: &FittedModel| {
            let is_open = model.reaches_floor() && posterior(model) + model.most_gain() > best;
            let ended = match is_open {
                true => screen.to_its_end(model)?,
                false => model.clone(),
            };
            screen.with_told_smoothness(ended)
        })?;
        screen.keep_better(&mut self.singles, held);
        screen.keep_better(&mut self.singles, found);
        Ok(())
    }

    /// The effects of the library that are adequate, each alone.
    pub(super) fn adequate_of_library(&self) -> Vec<File> {
        let adequate = self.singles.iter().filter(|m| m.reaches_floor());
        let id = |m: &FittedModel| &self.problem.catalogue[m.choices[0].effect].id;
        adequate.filter_map(|m| File::of_library(id(m))).collect()
    }

    /// Whether a hypothesis is an unknown function with the place and the argument of one of these effects, whose curve it shows.
    pub(super) fn acts_like(&self, choices: &[Choice], effects: &[File]) -> bool {
        let id = &self.problem.catalogue[choices[0].effect].id;
        let mut functions = self.problem.unknown_functions.iter();
        functions.any(|f| {
            let is_its = |e: &File| e.place() == f.place && e.argument == f.argument;
            f.id == *id && effects.iter().any(is_its)
        })
    }

    /// The effects of the library, best first by what a score test beside the calibrated model promises of them.
    pub(super) fn ordered_library(&self) -> Result<Vec<Promised>, Error> {
        self.by_promise(&self.calibrated, library(self.problem))
    }

    /// Whether an effect of the library may explain the data as well as the best single effect does, which is adequate and fitted to its
    /// end: it leaves segments unmet, or a score test at the calibrated model promises no less of another. Where nothing is named but the
    /// calibrated model, beside which they are tested anyway, only if that loses segments, of which no score test can tell.
    pub(super) fn library_may_explain(&self) -> Result<bool, Error> {
        let Some(best) = self.named() else {
            return Ok(self.calibrated.loses_segments());
        };
        if best.leaves_segments() {
            return Ok(true);
        }
        let jobs = [best.choices.clone()];
        let gained = self.calibrated.score() - best.score();
        let promised = self.screen.promises(&jobs, &self.calibrated, self.watch)?;
        let least = promised[0].as_ref().map_or(gained, |p| p.gain);
        let of_library = self.ordered_library()?;
        let first = of_library.first().and_then(|(_, p)| p.as_ref());
        Ok(first.is_some_and(|p| p.gain >= least))
    }

    /// Effects of the library as the only thing that the calibrated model lacks, hypotheses like the others, until one is adequate and
    /// meets all segments. A score test orders them. Far from the noise it can't tell more.
    pub(super) fn add_library_effects(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let alone = self.calibrated.clone();
        let ordered = self.ordered_library()?;
        let jobs: Vec<Vec<Choice>> = ordered.into_iter().map(|(choices, _)| choices).collect();
        let mut found: Vec<FittedModel> = Vec::new();
        for batch in jobs.chunks(LIBRARY_BATCH) {
            let new = screen.compete(batch, &alone, BRIEF, watch)?;
            screen.keep_better(&mut found, new);
            // What a brief fit leaves unmet, the same fit to its end may meet.
            let best = found.first().filter(|m| m.reaches_floor());
            if let Some(ended) = best.map(|m| screen.to_its_end(m)).transpose()? {
                screen.keep_better(&mut found, vec![ended]);
            }
            if watch.stop() || found.first().is_some_and(FittedModel::meets_all) {
                break;
            }
        }
        screen.polish(&mut found, watch)?;
        screen.finish(&mut found, watch)?;
        screen.keep_better(&mut self.singles, found);
        Ok(())
    }
}
