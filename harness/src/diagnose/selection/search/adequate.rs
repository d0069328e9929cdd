//! Among what is adequate: rivals close to the best are fitted to their end, and effects that may hide beside the leader are looked for.

use super::Exploration;
use crate::diagnose::initialisation::search_options::{HIDDEN, THOROUGH};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::selection::decision::{
    log_posterior, log_posterior_on_all, log_prior, share_starts,
};
use crate::diagnose::selection::extension::{Beside, extend};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::further_fits::last_options;
use crate::diagnose::stages;
use crate::diagnose::thresholds::{CLOSE, FINALISTS};
use crate::error::Error;
use crate::parallel::parallel;

/// Hypotheses close to the best that are fitted to their end.
pub(super) const FINISHED: usize = 6;

impl Exploration<'_> {
    /// Compares what is adequate, and what may hide behind it.
    pub(super) fn compare_adequate(&mut self) -> Result<(), Error> {
        self.refute_what_is_lost();
        if self.is_adequate() {
            self.watch.stage(stages::CLOSE);
            self.finish_close()?;
            self.refute_what_is_lost();
            self.watch.stage(stages::EXTENSIONS);
            self.extend_leader()?;
        }
        Ok(())
    }

    /// Fits the hypotheses whose evidence is close to the best to their end, so that they compare, and the forms of the best
    /// from each other.
    pub(super) fn finish_close(&mut self) -> Result<(), Error> {
        if self.watch.stop() {
            return Ok(());
        }
        self.screen.compare_forms(&mut self.singles)?;
        let smaller = &self.calibrated;
        let jobs: Vec<Vec<Choice>> = self.singles.iter().map(|c| c.choices.clone()).collect();
        let expected = match smaller.reaches_floor() {
            true => self.screen.promises(&jobs, smaller, self.watch)?,
            false => jobs.iter().map(|_| None).collect(),
        };
        // What a search has not reached yet, a score test may promise.
        let within_reach = |i: usize| {
            let promised = expected[i].as_ref().map(|p| p.gain - smaller.score());
            promised
                .unwrap_or(f64::NEG_INFINITY)
                .max(-self.singles[i].score())
                + log_prior(self.problem, 1)
        };
        let best = (0..self.singles.len())
            .map(within_reach)
            .fold(log_posterior(self.problem, smaller), f64::max);
        let mut close: Vec<usize> = (0..self.singles.len())
            .filter(|&i| within_reach(i) > best - CLOSE)
            .collect();
        close.sort_by(|&a, &b| within_reach(b).total_cmp(&within_reach(a)));
        close.truncate(FINISHED);
        let ended = parallel(&close, |&i| {
            let now = &self.singles[i];
            match &expected[i] {
                Some(p) if p.gain - smaller.score() > -now.score() => {
                    let start = p.start.clone();
                    let there = self.screen.fitted_from(&p.choices(&now.choices), start)?;
                    self.screen.to_its_end(&there)
                }
                _ => self.screen.to_its_end(now),
            }
        })?;
        for (i, new) in close.into_iter().zip(ended) {
            if !self.singles[i].is_before(&new) {
                self.singles[i] = new;
            }
        }
        self.screen.sort(&mut self.singles);
        let calibrated = self
            .screen
            .recalibrate(self.calibrated.clone(), &self.singles)?;
        self.calibrated = self.screen.to_its_end(&calibrated)?;
        Ok(())
    }

    /// Fits what is adequate and close to the best to all segments, until one of it stands there: what leads on those compared may leave
    /// others unmet.
    pub(super) fn close_on_all(&mut self) -> Result<(), Error> {
        loop {
            let all = std::iter::once(&mut self.calibrated).chain(&mut self.singles);
            let mut close: Vec<&mut FittedModel> = all.filter(|m| m.reaches_floor()).collect();
            let posterior = |model: &FittedModel| log_posterior(self.problem, model);
            close.sort_by(|a, b| posterior(b).total_cmp(&posterior(a)));
            let Some(best) = close.first().map(|m| posterior(m)) else {
                return Ok(());
            };
            close.retain(|m| posterior(m) >= best - CLOSE);
            close.truncate(FINALISTS);
            let judged = parallel(&close, |model| {
                let mut model = (**model).clone();
                full_refit::stands(self.problem, &mut model)?;
                Ok(model)
            })?;
            for (model, judged) in close.iter_mut().zip(judged) {
                **model = judged;
            }
            let standing = (0..close.len()).filter(|&i| close[i].reaches_floor());
            let standing: Vec<usize> = standing.collect();
            share_starts(self.problem, &mut close, &standing, &standing)?;
            // What replaces a fit is judged again.
            if close.iter().any(|m| m.reaches_floor()) || self.watch.stop() {
                return Ok(());
            }
        }
    }

    /// A further effect may hide behind what is adequate, also behind the calibrated model itself, and then another behind that.
    pub(super) fn extend_leader(&mut self) -> Result<(), Error> {
        let mut extended: Option<Vec<Choice>> = None;
        let mut searched: Option<Beside> = None;
        while !self.watch.stop() && !self.problem.place_is_told() {
            // What imitates much takes longest to extend, and what extends it imitates more: its rivals come first.
            if self.leader_is_local() {
                self.try_unknown_functions()?;
            }
            self.close_on_all()?;
            let posterior = |c: &FittedModel| {
                log_posterior_on_all(self.problem, c).unwrap_or(f64::NEG_INFINITY)
            };
            let leader = std::iter::once(&mut self.calibrated)
                .chain(&mut self.singles)
                .filter(|c| c.reaches_floor())
                .max_by(|a, b| posterior(a).total_cmp(&posterior(b)))
                .filter(|c| extended.as_ref() != Some(&c.choices));
            let Some(leader) = leader else {
                return Ok(());
            };
            let known = searched.take().filter(|b| b.leader == leader.choices);
            let is_known = known.is_some();
            let beside = match known {
                Some(beside) => beside,
                None => Beside::new(self.screen, leader, self.watch)?,
            };
            if extended.is_none() && !is_known {
                let leader = leader.clone();
                if self.search_beside(&leader, &beside)? {
                    return Ok(());
                }
                searched = Some(beside);
                continue;
            }
            // A leader that falls when it is fitted to all segments is marked, so that the next one is looked at.
            let Some(found) = extend(self.screen, leader, beside)? else {
                continue;
            };
            let leader = leader.clone();
            self.tested = found.tested;
            let hidden = self.hidden(found.untested, &leader)?;
            let beside_partners = self.beside_partners(&found.fitted, &leader)?;
            if !leader.choices.is_empty() {
                self.screen.keep_better(&mut self.pairs, found.fitted);
                self.screen.keep_better(&mut self.pairs, hidden);
                self.screen.keep_better(&mut self.pairs, beside_partners);
                return Ok(());
            }
            self.screen.keep_better(&mut self.singles, found.fitted);
            self.screen.keep_better(&mut self.singles, hidden);
            extended = Some(leader.choices);
        }
        Ok(())
    }

    /// Pairs beside a leader with values along the belt, again from where the other effect is alone. The values have taken its place,
    /// and the way back is a valley so narrow and bent that no fit gets along it; beside the other effect they find theirs.
    pub(super) fn beside_partners(
        &self,
        pairs: &[FittedModel],
        leader: &FittedModel,
    ) -> Result<Vec<FittedModel>, Error> {
        if !leader.is_local() {
            return Ok(Vec::new());
        }
        let found = parallel(pairs, |pair| {
            let (new, old) = pair.choices.split_last().expect("two effects");
            let mut singles = self.singles.iter();
            let Some(partner) = singles.find(|s| s.choices.first() == Some(new)) else {
                return Ok(None);
            };
            let job: Vec<Choice> = std::iter::once(new).chain(old).cloned().collect();
            let found = self.screen.compete(&[job], partner, THOROUGH, self.watch)?;
            let Some(found) = found.first() else {
                return Ok(None);
            };
            let found = self.screen.reordered(found, &pair.choices)?;
            let mut found = self.screen.to_its_end(&found)?;
            full_refit::stands(self.problem, &mut found)?;
            Ok(Some(found))
        })?;
        Ok(found.into_iter().flatten().collect())
    }

    /// Searches near a leader that looks adequate for effects more that were not found yet.
    pub(super) fn hidden(
        &self,
        mut jobs: Vec<Vec<Choice>>,
        leader: &FittedModel,
    ) -> Result<Vec<FittedModel>, Error> {
        let is_new = |choices: &Vec<Choice>| {
            let mut known = self.singles.iter().chain(&self.pairs);
            known.all(|model| model.choices != *choices)
        };
        jobs.retain(is_new);
        let mut found = self.screen.compete(&jobs, leader, HIDDEN, self.watch)?;
        self.end_adequate(&mut found, leader)?;
        Ok(found)
    }

    /// Fits the best of what is adequate to its end: the leader beside which it was found stands there, and what does not would lose by
    /// that alone. What is too far behind the leader for all that its derivatives promise stays where it is.
    pub(super) fn end_adequate(
        &self,
        found: &mut Vec<FittedModel>,
        leader: &FittedModel,
    ) -> Result<(), Error> {
        let close = log_posterior(self.problem, leader) - CLOSE;
        let within_reach = |model: &FittedModel| {
            let fall = model.most_gain();
            let is_weighed = model.score().is_finite() && fall.is_finite();
            // Of values along the belt the roughness may not be told yet.
            !is_weighed || model.is_local() || log_posterior(self.problem, model) + fall > close
        };
        let adequate = found
            .iter()
            .filter(|model| model.reaches_floor() && within_reach(model));
        let adequate: Vec<&FittedModel> = adequate.take(FINISHED).collect();
        let ended = parallel(&adequate, |model| self.screen.to_its_end(model))?;
        self.screen.keep_better(found, ended);
        Ok(())
    }

    /// Searches beside a leader that looks adequate for the further effects that a score test on the segments compared promises a claim
    /// of. Whether a pair was found that is more probable than the leader.
    pub(super) fn search_beside(
        &mut self,
        leader: &FittedModel,
        beside: &Beside,
    ) -> Result<bool, Error> {
        let visible = beside.visible(self.problem);
        if visible.is_empty() {
            return Ok(false);
        }
        let mut found = parallel(&visible, |(choices, promise)| {
            let start = promise.start.clone();
            self.screen
                .continued(&promise.choices(choices), start, last_options())
        })?;
        self.screen.sort(&mut found);
        if leader.choices.is_empty() {
            self.screen.keep_better(&mut self.singles, found);
            return Ok(false);
        }
        self.end_adequate(&mut found, leader)?;
        let is_more_probable = |pair: &FittedModel| {
            let posterior = log_posterior(self.problem, pair);
            pair.reaches_floor() && posterior > log_posterior(self.problem, leader)
        };
        let is_any = found.iter().any(is_more_probable);
        self.screen.keep_better(&mut self.pairs, found);
        Ok(is_any)
    }
}
