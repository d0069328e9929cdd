//! Sequential replacement on short windows: each effect of the best pair gives way to what explains most beside the other one.
//!
//! Pairs are ranked beside the reference model, far from the data, where an effect with states of its own imitates what others do, and one
//! that is strong hides another. The best pair fitted is near the data, and so is each of its effects where the pair has it: beside it
//! the right partner of the right effect explains most. An exchange that leads to a better pair is followed by another, until none does.
//! Source: Miller, Subset Selection in Regression, 2nd ed., 2002, chapter 3.

use crate::diagnose::model::belt_profile::is_profile;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::further_fits::refitting;
use crate::diagnose::selection::subset_search::{FIRST, SECOND, Search, Start, possible};
use crate::error::Error;

/// Exchanges of each effect of a pair that are fitted, of those that explain most.
const EXCHANGED: usize = 2;

impl Search<'_, '_> {
    /// Models on the windows, best first, with the pairs that exchanges bring.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(super) fn with_replaced(
        &self,
        mut best: Vec<FittedModel>,
    ) -> Result<Vec<FittedModel>, Error> {
        let mut exchanged: Vec<Vec<usize>> = Vec::new();
        while !self.watch.stop() {
            let is_open = |pair: &&FittedModel| !exchanged.contains(&pair.effects());
            let mut pairs = best.iter().filter(|model| model.choices.len() == 2);
            let is_explained = best.first().is_some_and(FittedModel::meets_all);
            let Some(pair) = pairs.next().filter(|p| is_open(p) && !is_explained) else {
                break;
            };
            exchanged.push(pair.effects());
            let starts = self.exchanges(pair)?;
            best.extend(self.round(&starts, |(choices, start)| {
                self.fitted(choices, start, refitting(FIRST + SECOND))
            })?);
            best = self.windows.by_evidence(best);
        }
        Ok(best)
    }

    /// Where to fit from with one effect of a pair exchanged: of each the exchanges that explain most, also for pairs fitted before, as
    /// these points are nearer.
    fn exchanges(&self, pair: &FittedModel) -> Result<Vec<Start>, Error> {
        let mut found = Vec::new();
        for (kept, removed) in [(0, 1), (1, 0)] {
            let [kept, removed] = [kept, removed].map(|i| &pair.choices[i]);
            // Values along the belt stay, at the price of the belief in them: an effect that takes their place lets them go. All others
            // make room.
            let stays = is_profile(&self.windows.screen.problem.catalogue[removed.effect]);
            let base = match stays {
                true => pair.clone(),
                false => self.without_other(pair, kept)?,
            };
            let is_other = |c: &&Choice| c.effect != kept.effect && c.effect != removed.effect;
            let others: Vec<Choice> = self.list.iter().filter(is_other).cloned().collect();
            let beside = self.responses(&base, &others)?;
            let least = match stays {
                true => beside.explained_by(&[]).map_or(f64::INFINITY, |n| n.score),
                false => f64::INFINITY,
            };
            let ranked = possible(self.alone(&beside)?, &beside);
            // What stays is free in one list and has its price in the other, so that they do not compare.
            let gaining = ranked
                .iter()
                .filter(|(_, explained)| explained.score < least);
            for (set, explained) in gaining.take(EXCHANGED) {
                found.push(beside.start(set, explained, Some(removed.effect))?);
            }
        }
        Ok(found)
    }

    /// One effect of a pair where the pair has it, not fitted again: it would be bent in the place of the other.
    fn without_other(&self, pair: &FittedModel, kept: &Choice) -> Result<FittedModel, Error> {
        let alone = std::slice::from_ref(kept);
        let start = self.windows.screen.point_like(pair, alone)?;
        self.fitted(alone, &start, refitting(0))
    }
}
