//! Forms of one effect, compared.

use crate::diagnose::initialisation::multistart::search;
use crate::diagnose::initialisation::search_options::BRIEF;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::parallel::parallel;

impl Screen<'_> {
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
}
