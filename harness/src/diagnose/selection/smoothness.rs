//! How smooth the curve of an unknown function is, as the data tell it.
//!
//! Strength and decay of a curve's coefficients ([`crate::diagnose::model::unknown_function::Smoothness`]) are no parameters of a fit
//! but of the evidence, as the roughness of a profile along the belt is ([`super::roughness`]). Linear theory says where the evidence
//! is largest; the curve is fitted there, and what the fit finds counts, since a curve that the data hardly bind is not linear over the
//! way that a weak belief leaves it.

use crate::diagnose::estimation::curve_estimate::curve_estimate;
use crate::diagnose::model::unknown_function::Smoothness;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::further_fits::{RETRY, refitting};
use crate::diagnose::selection::roughness::LEAST_RISE;
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;

/// Smoothnesses fitted: linear theory is right about the next one from near.
const STEPS: usize = 3;

impl Screen<'_> {
    /// An adequate unknown function, as smooth as has most evidence on these segments; any other model as it is.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn with_told_smoothness(&self, model: FittedModel) -> Result<FittedModel, Error> {
        let problem = self.problem;
        let [choice] = &model.choices[..] else {
            return Ok(model);
        };
        let id = &problem.catalogue[choice.effect].id;
        let function = problem.unknown_functions.iter().find(|f| f.id == *id);
        let Some(function) = function.filter(|_| model.reaches_floor()) else {
            return Ok(model);
        };
        let mut best = model;
        for _ in 0..STEPS {
            let believed = best.choices[0].smoothness;
            let estimate = curve_estimate(problem, function, &best.fitted);
            let Some(next) = estimate.map(|e| e.most_probable) else {
                break;
            };
            if next.std(0) == believed.std(0) && next.std(2) == believed.std(2) {
                break;
            }
            let new = self.as_smooth(&best, next)?;
            if !(new.reaches_floor() && new.score() < best.score() - LEAST_RISE) {
                break;
            }
            best = new;
        }
        for choices in [&mut best.choices, &mut best.fitted.hypothesis.choices] {
            choices[0].smoothness.is_told = true;
        }
        Ok(best)
    }

    /// A model fitted on from where it stands, with its curve believed otherwise.
    fn as_smooth(&self, model: &FittedModel, smoothness: Smoothness) -> Result<FittedModel, Error> {
        let mut choices = model.choices.clone();
        choices[0].smoothness = smoothness;
        let start = self.point_like(model, &choices)?;
        self.continued(&choices, start, refitting(RETRY))
    }
}
