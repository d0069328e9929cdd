//! Parameters that change during a run (variability `tunable`, FMI 2.0.5, section 2.2.7): the model is built
//! anew and goes on from the present states.

use crate::instance::Content;
use crate::setup::{self, PLACES};
use beam_model_description::UserCard;
use beam_physics::error::PhysicsError;

impl Content {
    /// Takes over parameters set since the model was built.
    ///
    /// # Errors
    /// Values with which the equations can't be set up. The run stays as it was; the values can be
    /// corrected.
    pub fn retune(&mut self) -> Result<(), PhysicsError> {
        if !self.retuned {
            return Ok(());
        }
        if PLACES.same_model(self.layout, &self.values, &self.built) {
            self.retuned = false;
            return Ok(());
        }
        if let Some(hybrid) = &self.hybrid {
            let mut hybrid = hybrid.clone();
            let model = setup::model(
                self.layout,
                &self.values,
                hybrid.model().inputs,
                UserCard::effect,
            )?;
            let x = self.carried_over(hybrid.model(), hybrid.state(), &model);
            hybrid.set_model(model, x);
            self.hybrid = Some(hybrid);
        } else if self.run.is_some() {
            self.account_energy()?;
            let mut run = self.run.clone().expect("looked at above");
            let model = setup::model(self.layout, &self.values, run.inputs(), UserCard::effect)?;
            let x = self.carried_over(run.model(), &run.state(), &model);
            run.set_model(model, x)?;
            self.run = Some(run);
        }
        self.built.clone_from(&self.values);
        self.retuned = false;
        Ok(())
    }
}
