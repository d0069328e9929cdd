//! Energies of a run that the FMU integrates.
//!
//! Counting them costs about as much as the motion, and most masters never ask. So a run begins without, and counts
//! from the first look on. What has passed by then is followed once more: until inputs or parameters change, a run
//! is a function of its start alone, the same to the bit. The first change is the last moment for that, so
//! counting begins there at the latest.

use crate::instance::Content;
use crate::setup::PLACES;
use beam_physics::error::PhysicsError;

impl Content {
    /// Makes the run one whose energies are counted since its start. To be called before inputs or parameters of
    /// the run change.
    ///
    /// # Errors
    /// A run that can't be followed again to its present time.
    pub fn account_energy(&mut self) -> Result<(), PhysicsError> {
        let Some(run) = self.run.as_mut().filter(|run| !run.accounts_energy()) else {
            return Ok(());
        };
        let (start, now) = (self.experiment.start, run.time());
        if now == start {
            run.account_energy();
            return Ok(());
        }
        // Inputs and parameters may be set already and wait for the next step; the run has the old ones.
        let mut again = run.clone();
        again.account_energy();
        let begin = PLACES.start(self.layout, &self.values, run.model(), start);
        again.restart(run.inputs(), &begin, run.tolerance())?;
        match again.advance_to(now) {
            Ok(()) => {}
            // A run that has failed fails again, at the same time.
            Err(_) if again.time() == now => {}
            Err(cause) => return Err(cause),
        }
        self.run = Some(again);
        Ok(())
    }
}
