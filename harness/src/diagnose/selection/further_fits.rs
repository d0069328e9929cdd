//! Fits that go on: of the best hypotheses, from the optimum of another, to their end.

use crate::diagnose::estimation::fit_options::{FitOptions, STRIDE};
use crate::diagnose::estimation::graduation::SHARE;
use crate::diagnose::estimation::nesting::{narrowed, widen};
use crate::diagnose::initialisation::multistart;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::point::Point;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::lost_runs::LostRuns;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;

/// A model whose median error over the noise is below this is worth fitting further, ...
const PROMISING: f64 = 30.0;
/// ... and so is one that leaves less than this share of the calibrated model's: where the sensor is good, the right effect of two
/// is still far from the noise (a drive beside a lag of friction at 130 times the noise, the calibrated model at 1090).
const PROMISING_SHARE: f64 = 1.0 / 3.0;
/// ..., if it is also below this many times the best model's.
const NEAR_THE_BEST: f64 = 3.0;
/// A model whose median error over the noise is below this is worth fitting to its end.
const NEAR_THE_NOISE: f64 = 3.0;
/// Models that are fitted further.
const POLISHED: usize = 4;
/// Jacobians for that.
pub(crate) const POLISH: usize = 14;
/// Models found with the reference model held that are fitted freely, ...
const FREED: usize = 10;
/// ... with so many Jacobians.
const FREE: usize = 4;
/// Candidates from whose optimum the reference model is fitted again.
const RETRIES: usize = 2;
/// Jacobians for that.
pub(crate) const RETRY: usize = 8;

impl Screen<'_> {
    /// Whether a model is near enough to the noise, or far enough from the calibrated model, to be worth fitting further.
    fn is_promising(&self, model: &FittedModel) -> bool {
        let calibrated = self.calibrated_error.get().copied().unwrap_or(0.0);
        model.fit.quantile(0.5) < PROMISING.max(PROMISING_SHARE * calibrated)
    }

    /// Fits models further that are near the noise but not down to it: the best ones, and where the best is down
    /// to it already and leaves no segment, only those that need fewer parameters than it does.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn polish(&self, models: &mut [FittedModel], watch: &dyn Watch) -> Result<(), Error> {
        let enough = match models.first() {
            Some(best) if best.meets_all() => best.size(),
            _ => usize::MAX,
        };
        let near = match models.first() {
            // Values of its own along each run imitate much: what is simpler gets its chance from afar.
            Some(best) if best.is_local() => f64::INFINITY,
            Some(best) => NEAR_THE_BEST * best.fit.quantile(0.5),
            None => f64::NAN,
        };
        let wanted: Vec<usize> = (0..models.len())
            .filter(|&i| {
                let c = &models[i];
                self.is_promising(c)
                    && c.fit.quantile(0.5) < near
                    && !c.reaches_floor()
                    && c.size() < enough
            })
            .take(POLISHED)
            .collect();
        if wanted.is_empty() || watch.stop() {
            return Ok(());
        }
        watch.step("fitting the best candidates further", 0, 1);
        let polished = parallel(&wanted, |&i| self.further(&models[i], POLISH))?;
        for (i, new) in wanted.into_iter().zip(polished) {
            if new.is_before(&models[i]) {
                models[i] = new;
            }
        }
        self.sort(models);
        Ok(())
    }

    /// Models found with the reference model held: the best ones fitted freely from there, best first.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn freed(&self, held: &[FittedModel]) -> Result<Vec<FittedModel>, Error> {
        let best = &held[..held.len().min(FREED)];
        let mut freed = parallel(best, |old| self.further(old, FREE))?;
        self.sort(&mut freed);
        Ok(freed)
    }

    /// Fits a model again from the optima of the best that extend it, with what they add switched off, so that it
    /// is not left behind in a worse minimum than they.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn recalibrate(
        &self,
        base: FittedModel,
        extended: &[FittedModel],
    ) -> Result<FittedModel, Error> {
        let leaders: Vec<&FittedModel> = extended.iter().take(RETRIES).collect();
        let retried = parallel(&leaders, |single| {
            let h = self.problem.hypothesis(&base.choices)?;
            let start = narrowed(&h, &single.fitted.fit.point, &self.segments);
            self.fitted(&base.choices, start, refitting(RETRY))
        })?;
        let mut best = base;
        for retry in retried {
            // One that was refuted stands behind whatever was not, however it fits.
            let is_better = match best.is_refuted {
                true => retry.fitted.fit.misfit < best.fitted.fit.misfit,
                false => retry.is_before(&best),
            };
            if is_better {
                best = retry;
            }
        }
        Ok(best)
    }

    /// Fits those candidates again that ended above the model that they extend, which is one of their own
    /// points: from there.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn nest(&self, models: &mut [FittedModel], base: &FittedModel) -> Result<(), Error> {
        let above: Vec<usize> = (0..models.len())
            .filter(|&i| models[i].fitted.fit.misfit > base.fitted.fit.misfit)
            .collect();
        let again = parallel(&above, |&i| {
            let choices = &models[i].choices;
            let fitted =
                multistart::from_nested(self.problem, choices, &self.segments, &base.fitted)?;
            Ok(FittedModel {
                is_passed_over: models[i].is_passed_over,
                ..self.model(choices.clone(), fitted)?
            })
        })?;
        for (i, new) in above.into_iter().zip(again) {
            if new.fitted.fit.misfit < models[i].fitted.fit.misfit {
                models[i] = new;
            }
        }
        self.sort(models);
        Ok(())
    }

    /// A model's hypothesis fitted again from where it stands.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn refit_of(&self, model: &FittedModel) -> Result<FittedModel, Error> {
        self.further(model, RETRY)
    }

    /// A model fitted further from where it stands, and if that loses runs, again with what the others found.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn further(
        &self,
        old: &FittedModel,
        iterations: usize,
    ) -> Result<FittedModel, Error> {
        self.further_by(old, refitting(iterations))
    }

    fn further_by(&self, old: &FittedModel, options: FitOptions) -> Result<FittedModel, Error> {
        let options = FitOptions {
            trims: options.trims && !old.leaves_runs(),
            ..options
        };
        let start = old.fitted.fit.point.clone();
        let mut further = self.continued(&old.choices, start, options)?;
        if gives_up(&further) {
            let graduated = FitOptions {
                graduated: true,
                ..refitting(POLISH)
            };
            let start = further.fitted.fit.point.clone();
            let again = self.continued(&old.choices, start, graduated)?;
            if again.fitted.fit.misfit < further.fitted.fit.misfit {
                further = again;
            }
        }
        let lost = LostRuns::of(self.problem, &further.fitted, &self.segments);
        if !(lost.may_be_found() && lost.are_few()) {
            return Ok(further);
        }
        let start = lost.start(self.problem, &further.fitted, &self.segments)?;
        let again = self.fitted(&old.choices, start, options)?;
        let is_better = again.fit.trimmed < further.fit.trimmed;
        Ok(if is_better { again } else { further })
    }

    /// Fits the best model to its end if it is near the noise but not down to it: what lies along a narrow valley takes more
    /// steps than a comparison affords.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn finish(
        &self,
        models: &mut [FittedModel],
        watch: &dyn Watch,
    ) -> Result<(), Error> {
        let Some(best) = models.first_mut() else {
            return Ok(());
        };
        if best.reaches_floor() || !is_near_noise(best) || watch.stop() {
            return Ok(());
        }
        watch.step("fitting the best candidate to its end", 0, 1);
        *best = self.to_its_end(best)?;
        Ok(())
    }

    /// A model fitted from where it stands until nothing moves any more, values along the belt as rough as the data tell.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn to_its_end(&self, model: &FittedModel) -> Result<FittedModel, Error> {
        let further = self.further_by(model, last_options())?;
        let is_better = further.is_before(model);
        let best = if is_better { further } else { model.clone() };
        self.with_told_roughness(best)
    }

    /// Where a hypothesis agrees with a model in all that they have in common.
    ///
    /// # Errors
    /// Effects that the FMU does not have.
    pub(crate) fn point_like(
        &self,
        model: &FittedModel,
        choices: &[Choice],
    ) -> Result<Point, Error> {
        let h = self.problem.hypothesis(choices)?;
        let centre = Point::centre(&h, &self.segments);
        Ok(widen(&model.fitted, &h, &centre))
    }

    /// A model fitted further with its effects in another order.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn reordered(&self, found: &FittedModel, choices: &[Choice]) -> Result<FittedModel, Error> {
        let start = self.point_like(found, choices)?;
        self.fitted(choices, start, refitting(POLISH))
    }

    /// The path to a model, one effect more each time, in its order; empty for the reference model.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn path_to(&self, best: FittedModel) -> Result<Vec<FittedModel>, Error> {
        let before = 1..best.choices.len();
        let path = before.map(|count| self.reordered(&best, &best.choices[..count]));
        let mut path = path.collect::<Result<Vec<FittedModel>, Error>>()?;
        if !best.choices.is_empty() {
            path.push(best);
        }
        Ok(path)
    }

    /// A hypothesis fitted from a point of its own.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(crate) fn fitted_from(
        &self,
        choices: &[Choice],
        start: Point,
    ) -> Result<FittedModel, Error> {
        self.fitted(choices, start, refitting(RETRY))
    }
}

/// Whether a model may still come down to the noise when it is fitted to its end.
pub(crate) fn is_near_noise(model: &FittedModel) -> bool {
    model.fit.quantile(0.5) <= NEAR_THE_NOISE
}

/// Whether a model meets most segments and has given others up, which may be due to the way to where it stands.
fn gives_up(model: &FittedModel) -> bool {
    let middle = model.fit.quantile(0.5);
    middle < NEAR_THE_NOISE && model.fit.quantile(SHARE) > NEAR_THE_NOISE * middle
}

/// The options of a last fit to the segments compared.
pub(crate) fn last_options() -> FitOptions {
    FitOptions {
        stride: STRIDE,
        ..full_refit::last_options()
    }
}

/// The options of a fit that goes on from where another ended.
pub(crate) fn refitting(iterations: usize) -> FitOptions {
    FitOptions {
        patience: 2,
        ..FitOptions::search(iterations)
    }
}
