//! Contenders that are near the noise, tried again from elsewhere: from other shapes, from each other's lines.

use super::candidate::{Candidate, Role};
use super::contender::Contender;
use super::hypothesis::Choice;
use super::scan;
use super::screen::{POLISH, Screen};
use super::search::{self, BRIEF, HIDDEN, search};
use super::session::parallel;
use crate::error::Error;
use crate::watch::Watch;

/// Contenders that are searched for again from their own optima are fitted further if that brings the objective below
/// this share.
const GAINS: f64 = 0.8;
/// Contenders at whose lines the others are tried, ...
const LENDERS: usize = 2;
/// ... if theirs differ by more than this.
const SAME_LINE: f64 = 2e-3;

impl Screen<'_> {
    /// Searches for the last effects of the best contenders, `most` at most, again from their own optima, barely on and with
    /// other shapes: a shape fitted beside wrong nuisances may have wandered into a valley (a drift of friction to one
    /// fifteen times as slow) from which only another start leads out once the nuisances are right.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn restart(
        &self,
        contenders: &mut Vec<Contender>,
        most: usize,
        watch: &dyn Watch,
    ) -> Result<(), Error> {
        let catalogue = &self.session.catalogue;
        let has_shape = |c: &Contender| {
            let effect = c.choices.last().map(|l| &catalogue[l.effect]);
            let is_periodic = |e: &Candidate| e.find_role(Role::Phase).is_some();
            effect.is_some_and(|e| e.find_role(Role::Shape).is_some() && !is_periodic(e))
        };
        let wanted: Vec<usize> = (0..contenders.len())
            .filter(|&i| {
                let c = &contenders[i];
                self.is_promising(c) && !c.reaches_floor() && has_shape(c)
            })
            .take(most)
            .collect();
        if wanted.is_empty() || watch.stop() {
            return Ok(());
        }
        watch.step("trying the best candidates from other starts", 0, 1);
        let again = parallel(&wanted, |&i| {
            let old = &contenders[i];
            let trial = search(self.session, &old.choices, &self.shots, &old.trial, HIDDEN)?;
            let new = self.contender(old.choices.clone(), trial)?;
            let is_worth_more = new.fit.trimmed < GAINS * old.fit.trimmed && !new.reaches_floor();
            if is_worth_more {
                return self.further(&new, POLISH);
            }
            Ok(new)
        })?;
        self.keep_better(contenders, again);
        Ok(())
    }

    /// Fits the best contender and those with the same effects in other forms to their end: of two forms that both come down
    /// to the noise, the one that happens to be fitted further would else be reported.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn compare_forms(&self, contenders: &mut Vec<Contender>) -> Result<(), Error> {
        let Some(best) = contenders.first().map(Contender::effects) else {
            return Ok(());
        };
        let forms: Vec<usize> = (0..contenders.len())
            .filter(|&i| contenders[i].effects() == best)
            .collect();
        if forms.len() > 1 {
            let again = parallel(&forms, |&i| self.to_its_end(&contenders[i]))?;
            // The others also from where the best stands: of its parameters, those of the same name mean much the same.
            let best = &contenders[0].trial;
            let from_the_best = parallel(&forms[1..], |&i| {
                let choices = &contenders[i].choices;
                let trial = search(self.session, choices, &self.shots, best, BRIEF)?;
                self.to_its_end(&self.contender(choices.clone(), trial)?)
            })?;
            self.keep_better(contenders, again);
            self.keep_better(contenders, from_the_best);
        }
        Ok(())
    }

    /// Lets effects that repeat with the same argument, time or place, try each other's lines: what repeats shows itself at
    /// the same frequency whichever way it acts, but a wrong effect may find it and the right one miss it.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn lend_lines(
        &self,
        contenders: &mut Vec<Contender>,
        list: &[Choice],
    ) -> Result<(), Error> {
        let catalogue = &self.session.catalogue;
        let mut jobs: Vec<(usize, Vec<Choice>, f64)> = Vec::new();
        let promising = (0..contenders.len()).filter(|&i| self.is_promising(&contenders[i]));
        let lenders = promising.filter_map(|i| Some((i, contenders[i].line(self.session)?)));
        for (i, (argument, value)) in lenders.take(LENDERS) {
            let (last, others) = contenders[i].choices.split_last().expect("it has a line");
            let borrowers = list.iter().filter(|c| {
                scan::argument(&catalogue[c.effect]) == Some(argument)
                    && c.effect != last.effect
                    && others.iter().all(|o| o.effect != c.effect)
            });
            for borrower in borrowers {
                let choices = [others, std::slice::from_ref(borrower)].concat();
                let own = contenders.iter().find(|c| c.choices == choices);
                let own = own.and_then(|c| c.line(self.session));
                if own.is_none_or(|(_, own)| (own / value - 1.0).abs() > SAME_LINE) {
                    jobs.push((i, choices, value));
                }
            }
        }
        let tried = parallel(&jobs, |(i, choices, value)| {
            let lender = &contenders[*i].trial;
            let trial = search::at_line(self.session, choices, &self.shots, lender, *value)?;
            trial
                .map(|t| self.contender(choices.clone(), t))
                .transpose()
        })?;
        self.keep_better(contenders, tried.into_iter().flatten().collect());
        Ok(())
    }
}
