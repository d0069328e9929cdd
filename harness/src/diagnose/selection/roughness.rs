//! How rough a friction profile along the belt is, as the data tell it.
//!
//! Spread and correlation length of the process ([`crate::diagnose::model::belt_profile`]) are no parameters of a fit, since its
//! likelihood grows without bound as values shrink with the spread, but of the evidence, all values integrated out:
//!
//! ```text
//! p(y | sigma, l) = integral of p(y | g) GP(g; sigma, l)
//! ```
//!
//! Believed rougher than it is, a profile costs evidence for what it does not explain, and what repeats along the belt hides in it at no
//! price; one believed too smooth leaves to waves what is its own. Each is changed by steps while the evidence rises.
//! Source: MacKay, Neural Computation 4 (1992) 415, sect. 4 (evidence for a regulariser).

use crate::diagnose::model::belt_profile::{Roughness, is_profile, longest_track, resolved_length};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::further_fits::{RETRY, refitting};
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use std::f64::consts::SQRT_2;

/// How often the spread is doubled, and the correlation length made longer by the root of 2. The data tell a spread from n values to
/// a share of 1/sqrt(2 n), and a correlation length likewise.
type Step = (i32, i32);

/// Steps, the last tried first: smoother is cheaper.
const STEPS: [Step; 4] = [(1, 0), (0, -1), (-1, 0), (0, 1)];

/// Least rise of the evidence for which a step is kept, nats: less tells nothing.
pub(super) const LEAST_RISE: f64 = 1.0;
/// Share of a bound that counts as it: steps there and back round.
const ROUNDED: f64 = 0.999;

impl Screen<'_> {
    /// An adequate model with values along the belt, as rough as has most evidence on these segments; as it is where it has none, where
    /// their roughness is told already, and where break-aways tell the values.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn with_told_roughness(&self, model: FittedModel) -> Result<FittedModel, Error> {
        let problem = self.problem;
        let is_open = |c: &Choice| is_profile(&problem.catalogue[c.effect]) && !c.roughness.is_told;
        let place = model.choices.iter().position(is_open);
        let Some(place) = place.filter(|_| model.reaches_floor() && !problem.place_is_told())
        else {
            return Ok(model);
        };
        let card = &problem.catalogue[model.choices[place].effect];
        let least = resolved_length(card, &problem.tracks);
        let longest = longest_track(&problem.tracks);
        let mut best = model;
        let mut open = STEPS.to_vec();
        while let Some(step) = open.pop() {
            let mut roughness = best.choices[place].roughness;
            roughness.std *= 2.0_f64.powi(step.0);
            roughness.length = roughness.length.max(least) * SQRT_2.powi(step.1);
            if roughness.length < ROUNDED * least || roughness.length > longest {
                continue;
            }
            let new = self.as_rough(&best, place, roughness)?;
            if new.reaches_floor() && new.score() < best.score() - LEAST_RISE {
                best = new;
                // On this way first; the way back was not worth it.
                let back = (-step.0, -step.1);
                open = STEPS.to_vec();
                open.retain(|&s| s != step && s != back);
                open.push(step);
            }
        }
        for choices in [&mut best.choices, &mut best.fitted.hypothesis.choices] {
            choices[place].roughness.is_told = true;
        }
        Ok(best)
    }

    /// A model fitted on from where it stands, with its values along the belt believed otherwise. What it loses by that is looked for
    /// again: a profile carried over to another length is another one by what noise had left in it, and segments that grazed a
    /// transition fall from their basin.
    fn as_rough(
        &self,
        model: &FittedModel,
        place: usize,
        roughness: Roughness,
    ) -> Result<FittedModel, Error> {
        let mut choices = model.choices.clone();
        choices[place].roughness = roughness;
        let start = self.point_like(model, &choices)?;
        let new = self.continued(&choices, start, refitting(RETRY))?;
        if new.lost <= model.lost {
            return Ok(new);
        }
        let again = self.further(&new, RETRY)?;
        Ok(if again.is_before(&new) { again } else { new })
    }
}
