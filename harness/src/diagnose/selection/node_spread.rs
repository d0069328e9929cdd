//! How far the values of a friction profile along the belt spread, as the data tell it.
//!
//! Each value is believed to be normal about zero. Believed far wider than the values are, two hundred of them cost more evidence
//! than what they explain is worth, and what repeats along the belt hides among them at no price. The spread is no parameter of a
//! fit, since its likelihood grows without bound as values shrink with it, but of the evidence, all values integrated out:
//!
//! ```text
//! p(y | s) = integral of p(y | nodes) N(nodes; 0, s^2)
//! ```
//!
//! It is halved while that rises. Source: MacKay, Neural Computation 4 (1992) 415, sect. 4 (evidence for a regulariser).

use crate::diagnose::model::belt_profile::is_profile;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::screening::{RETRY, Screen, refitting};
use crate::error::Error;

impl Screen<'_> {
    /// A model with values along the belt, of the spread that has most evidence on these segments; as it is where it has none, and
    /// where break-aways tell the values.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn with_told_spread(&self, model: &FittedModel) -> Result<FittedModel, Error> {
        let problem = self.problem;
        let has_nodes = |c: &Choice| is_profile(&problem.catalogue[c.effect]);
        let mut best = model.clone();
        let Some(place) = best.choices.iter().position(has_nodes) else {
            return Ok(best);
        };
        if problem.place_is_told() {
            return Ok(best);
        }
        loop {
            let mut choices = best.choices.clone();
            choices[place].node_std *= 0.5;
            let start = best.fitted.fit.point.clone();
            let new = self.continued(&choices, start, refitting(RETRY))?;
            if !new.reaches_floor() || new.score() >= best.score() {
                return Ok(best);
            }
            best = new;
        }
    }
}
