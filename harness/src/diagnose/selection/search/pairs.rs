//! Pairs of effects: from regressions on windows, on beginnings of segments, from their halves and beside the nearest single effect.

use super::Exploration;
use crate::diagnose::initialisation::search_options::{BRIEF, THOROUGH};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::variants::{library, variants};
use crate::diagnose::selection::extension::one_further;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::further_fits::{RETRY, is_near_noise};
use crate::diagnose::selection::{full_refit, lengthening, subset_search};
use crate::diagnose::stages;
use crate::error::Error;
use crate::parallel::parallel;

impl Exploration<'_> {
    /// Sets of effects, from where a regression on windows points.
    pub(super) fn search_sets(&mut self) -> Result<(), Error> {
        self.untried = Some(Vec::new());
        // Where the break-aways tell of the place, friction scatters: no effect brings the motion down to the noise.
        if self.problem.place_is_told() || self.watch.stop() {
            return Ok(());
        }
        self.watch.stage(stages::SETS);
        let list = self.list.clone();
        self.untried = Some(self.search_on_windows(&list)?);
        Ok(())
    }

    /// Pairs of a list and effects of the library, as short windows tell them; the pairs that were not tried. Without a list the library
    /// rivals the best single effect.
    pub(super) fn search_on_windows(&mut self, list: &[Choice]) -> Result<Vec<Vec<Choice>>, Error> {
        let held = self.held_alone()?;
        let library = library(self.problem);
        let may_rival = |named: &&FittedModel| list.is_empty() && !named.is_local();
        let rival = self.named().filter(may_rival);
        let effects = (list, &library[..]);
        let found = subset_search::search(self.screen, &held, effects, rival, self.watch)?;
        let (singles, pairs) = found.models.into_iter().partition(|m| m.choices.len() == 1);
        self.screen.keep_better(&mut self.singles, singles);
        self.screen.keep_better(&mut self.pairs, pairs);
        Ok(found.untried)
    }

    /// Pairs on beginnings of the segments that lengthen, from the single effects that look best there.
    pub(super) fn pair_on_beginnings(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let found = lengthening::search(screen, &self.list, &self.race, watch)?;
        let (singles, pairs): (Vec<_>, Vec<_>) =
            found.into_iter().partition(|m| m.choices.len() == 1);
        screen.keep_better(&mut self.singles, singles);
        screen.keep_better(&mut self.pairs, pairs);
        let has = |model: &FittedModel, pair: &[Choice]| {
            pair.iter().all(|c| model.effects().contains(&c.effect))
        };
        let is_tried = |pair: &Vec<Choice>| self.pairs.iter().any(|model| has(model, pair));
        if let Some(untried) = &mut self.untried {
            untried.retain(|pair| !is_tried(pair));
        }
        Ok(())
    }

    /// Whether a pair explains the data: one is adequate, and stays so on all segments.
    pub(super) fn pair_explains(&mut self) -> Result<bool, Error> {
        self.refute_what_is_lost();
        while !self.watch.stop() {
            self.screen.sort(&mut self.pairs);
            match self.pairs.first_mut() {
                Some(best) if best.reaches_floor() => {
                    if full_refit::stands(self.problem, best)? {
                        return Ok(true);
                    }
                }
                _ => return Ok(false),
            }
        }
        Ok(false)
    }

    /// An effect of a pair by itself, from where the pair stands.
    pub(super) fn half(&self, pair: &FittedModel, choice: &Choice) -> Result<FittedModel, Error> {
        let alone = std::slice::from_ref(choice);
        let start = self.screen.point_like(pair, alone)?;
        self.screen.fitted_from(alone, start)
    }

    /// The best pair again from each of its effects alone, where it is near the noise and not down to it: what short windows tell of
    /// strengths and start states may lie beside the valley that ends there, and one effect alone is in it where it explains most.
    pub(super) fn pair_from_halves(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let is_open = |p: &&FittedModel| {
            p.choices.len() == 2 && is_near_noise(p) && !p.reaches_floor() && !watch.stop()
        };
        let Some(pair) = self.pairs.first().filter(is_open) else {
            return Ok(());
        };
        let found = parallel(&[0, 1], |&first| {
            let [base, added] = [first, 1 - first].map(|i| pair.choices[i].clone());
            let half = self.half(pair, &base)?;
            let found = screen.compete(&[vec![base, added]], &half, THOROUGH, watch)?;
            let Some(found) = found.first() else {
                return Ok(None);
            };
            let found = screen.reordered(found, &pair.choices)?;
            Ok(Some(screen.to_its_end(&found)?))
        })?;
        let found = found.into_iter().flatten().collect();
        screen.keep_better(&mut self.pairs, found);
        Ok(())
    }

    /// Pairs of the best single effect near the noise and what a score test beside it promises most of: there first order holds on whole
    /// segments, where windows leave states of effects free.
    pub(super) fn pair_beside_nearest(&mut self) -> Result<(), Error> {
        let is_near = |s: &&FittedModel| is_near_noise(s) && !s.is_local();
        let Some(nearest) = self.singles.iter().find(is_near).cloned() else {
            return Ok(());
        };
        let mut found = one_further(self.screen, &nearest, RETRY, self.watch)?;
        self.screen.sort(&mut found);
        self.end_adequate(&mut found, &nearest)?;
        self.screen.keep_better(&mut self.pairs, found);
        Ok(())
    }

    /// Fits the effects of the best pair by themselves again from its optimum: where one of them is enough, it may have come
    /// down to the noise only beside the other.
    pub(super) fn refit_halves(&mut self) -> Result<(), Error> {
        let Some(pair) = self.pairs.first().filter(|p| p.reaches_floor()) else {
            return Ok(());
        };
        // As far as the pair was fitted: where the other effect does nothing both end in one place.
        let halves = parallel(&pair.choices, |choice| {
            self.screen.to_its_end(&self.half(pair, choice)?)
        })?;
        self.screen.keep_better(&mut self.singles, halves);
        Ok(())
    }

    /// A pair that is believed again with the other forms of its effects, from where it stands: of a leader, the form was
    /// chosen before its partner was known.
    pub(super) fn other_forms_of_pair(&mut self) -> Result<(), Error> {
        let Some(pair) = self.pairs.iter().find(|p| !p.is_refuted) else {
            return Ok(());
        };
        let singles = self.singles.iter().filter(|s| s.reaches_floor());
        let alone = singles
            .map(FittedModel::score)
            .fold(f64::INFINITY, f64::min);
        if !pair.reaches_floor() || pair.score() > alone {
            return Ok(());
        }
        let mut others = Vec::new();
        for (place, choice) in pair.choices.iter().enumerate() {
            for form in variants(self.problem, choice.effect) {
                if form == *choice {
                    continue;
                }
                // A search adds the last effect of its list.
                let mut job = pair.choices.clone();
                job.remove(place);
                job.push(form.clone());
                for found in self.screen.compete(&[job], pair, BRIEF, self.watch)? {
                    let mut choices = pair.choices.clone();
                    choices[place] = form.clone();
                    others.push(self.screen.reordered(&found, &choices)?);
                }
            }
        }
        self.screen.keep_better(&mut self.pairs, others);
        Ok(())
    }
}
