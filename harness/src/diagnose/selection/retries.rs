//! Models that are near the noise, tried again from elsewhere: from other shapes, from each other's lines.

use crate::diagnose::initialisation::multistart;
use crate::diagnose::initialisation::multistart::search;
use crate::diagnose::initialisation::search_options::{BRIEF, HIDDEN};
use crate::diagnose::model::effect_card::Role;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::periodic;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::screening::{POLISH, Screen};
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;

/// Models that are searched for again from their own optima are fitted further if that brings the objective below
/// this share.
const GAINS: f64 = 0.8;
/// Models at whose lines the others are tried, ...
const LENDERS: usize = 2;
/// ... if theirs differ by more than this.
const SAME_LINE: f64 = 2e-3;

impl Screen<'_> {
    /// Searches for the last effects of the best models, `most` at most, again from their own optima, barely on and with
    /// other shapes: a shape fitted beside wrong nuisances may have wandered into a valley (a drift of friction to one
    /// fifteen times as slow) from which only another start leads out once the nuisances are right.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn restart(
        &self,
        models: &mut Vec<FittedModel>,
        most: usize,
        watch: &dyn Watch,
    ) -> Result<(), Error> {
        let catalogue = &self.problem.catalogue;
        let has_shape = |c: &FittedModel| {
            let effect = c.choices.last().map(|l| &catalogue[l.effect]);
            effect.is_some_and(|e| e.find_role(Role::Shape).is_some() && !e.repeats())
        };
        let wanted: Vec<usize> = (0..models.len())
            .filter(|&i| {
                let c = &models[i];
                self.is_promising(c) && !c.reaches_floor() && has_shape(c)
            })
            .take(most)
            .collect();
        if wanted.is_empty() || watch.stop() {
            return Ok(());
        }
        watch.step("trying the best candidates from other starts", 0, 1);
        let again = parallel(&wanted, |&i| {
            let old = &models[i];
            let fitted = search(
                self.problem,
                &old.choices,
                &self.segments,
                &old.fitted,
                HIDDEN,
            )?;
            let new = self.model(old.choices.clone(), fitted)?;
            let is_worth_more = new.fit.trimmed < GAINS * old.fit.trimmed && !new.reaches_floor();
            if is_worth_more {
                return self.further(&new, POLISH);
            }
            Ok(new)
        })?;
        self.keep_better(models, again);
        Ok(())
    }

    /// Fits the best model and those with the same effects in other forms to their end: of two forms that both come down
    /// to the noise, the one that happens to be fitted further would else be reported.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn compare_forms(&self, models: &mut Vec<FittedModel>) -> Result<(), Error> {
        let Some(best) = models.first().map(FittedModel::effects) else {
            return Ok(());
        };
        let forms: Vec<usize> = (0..models.len())
            .filter(|&i| models[i].effects() == best)
            .collect();
        if forms.len() > 1 {
            let again = parallel(&forms, |&i| self.to_its_end(&models[i]))?;
            // The others also from where the best stands: of its parameters, those of the same name mean much the same.
            let best = &models[0].fitted;
            let from_the_best = parallel(&forms[1..], |&i| {
                let choices = &models[i].choices;
                let fitted = search(self.problem, choices, &self.segments, best, BRIEF)?;
                self.to_its_end(&self.model(choices.clone(), fitted)?)
            })?;
            self.keep_better(models, again);
            self.keep_better(models, from_the_best);
        }
        Ok(())
    }

    /// Lets effects that repeat with the same argument, time or place, try each other's lines: what repeats shows itself at
    /// the same frequency whichever way it acts, but a wrong effect may find it and the right one miss it.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn lend_lines(&self, models: &mut Vec<FittedModel>, list: &[Choice]) -> Result<(), Error> {
        let catalogue = &self.problem.catalogue;
        let mut jobs: Vec<(usize, Vec<Choice>, f64)> = Vec::new();
        let promising = (0..models.len()).filter(|&i| self.is_promising(&models[i]));
        let lenders = promising.filter_map(|i| Some((i, models[i].line(self.problem)?)));
        for (i, (argument, value)) in lenders.take(LENDERS) {
            let (last, others) = models[i].choices.split_last().expect("it has a line");
            let borrowers = list.iter().filter(|c| {
                periodic::argument(&catalogue[c.effect]) == Some(argument)
                    && c.effect != last.effect
                    && others.iter().all(|o| o.effect != c.effect)
            });
            for borrower in borrowers {
                let choices = [others, std::slice::from_ref(borrower)].concat();
                let per_run = models.iter().find(|c| c.choices == choices);
                let per_run = per_run.and_then(|c| c.line(self.problem));
                if per_run.is_none_or(|(_, per_run)| (per_run / value - 1.0).abs() > SAME_LINE) {
                    jobs.push((i, choices, value));
                }
            }
        }
        let tried = parallel(&jobs, |(i, choices, value)| {
            let lender = &models[*i].fitted;
            let fitted =
                multistart::at_line(self.problem, choices, &self.segments, lender, *value)?;
            fitted.map(|t| self.model(choices.clone(), t)).transpose()
        })?;
        self.keep_better(models, tried.into_iter().flatten().collect());
        Ok(())
    }
}
