//! What runs by collocation need to know of a model.

use super::Model;
use crate::integrate::collocation::Characteristic;
use crate::real::ZERO;

impl Model {
    /// Whether no effect is on: beam, belt and friction law are all there is.
    pub fn is_bare(&self) -> bool {
        self.effects.is_empty()
    }

    /// Friction force in N over the sliding speed under the present normal force, without effects; `None` for laws that are
    /// not made of exponentials.
    pub fn characteristic(&self) -> Option<Characteristic> {
        let load = self.level * self.inputs.normal_force.max(ZERO);
        self.friction.characteristic(load)
    }
}
