//! Everything that can be set of a model, as plain values.

use crate::beam::Beam;
use crate::effects::user_expression::UserEffect;
use crate::effects::{CATALOGUE, find_parameter};
use crate::error::PhysicsError;
use crate::friction::FrictionLaw;

/// Parameters of a model: structure, friction and the effects' values.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelParameters {
    /// The elastic structure.
    pub beam: Beam,
    /// The friction characteristic.
    pub friction: FrictionLaw,
    /// Factor on friction as a whole; 1 unless calibrated for one run.
    pub friction_level: f64,
    /// Offset of the displacement sensor in m.
    pub sensor_offset: f64,
    /// Values of the catalogue's parameters.
    pub effects: EffectValues,
    /// Effects that the user has written; all of them are on.
    pub user_effects: Vec<UserEffect>,
}

impl Default for ModelParameters {
    fn default() -> Self {
        Self {
            beam: Beam::default(),
            friction: FrictionLaw::default(),
            friction_level: 1.0,
            sensor_offset: 0.0,
            effects: EffectValues::default(),
            user_effects: Vec::new(),
        }
    }
}

/// The values of all effects' parameters; at the start all effects are off.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectValues {
    values: Vec<f64>,
}

impl Default for EffectValues {
    fn default() -> Self {
        let values = CATALOGUE
            .iter()
            .flat_map(|card| card.parameters.iter().map(|p| p.start))
            .collect();
        Self { values }
    }
}

impl EffectValues {
    fn first(card: usize) -> usize {
        CATALOGUE[..card].iter().map(|c| c.parameters.len()).sum()
    }

    /// Values of the effect with index `card` in the catalogue, in the order of its card.
    pub fn of(&self, card: usize) -> &[f64] {
        let first = Self::first(card);
        &self.values[first..first + CATALOGUE[card].parameters.len()]
    }

    /// Sets one value by the indices of effect and parameter.
    pub fn set(&mut self, card: usize, parameter: usize, value: f64) {
        self.values[Self::first(card) + parameter] = value;
    }

    /// Sets one value by name, e.g. `third_mode.frequency`.
    ///
    /// # Errors
    /// [`PhysicsError::UnknownParameter`].
    pub fn set_named(&mut self, name: &str, value: f64) -> Result<(), PhysicsError> {
        let (card, parameter) = find_parameter(name)?;
        self.set(card, parameter, value);
        Ok(())
    }

    /// All values, effect after effect in the catalogue's order.
    pub fn as_slice(&self) -> &[f64] {
        &self.values
    }

    /// All values, to be changed in place.
    pub fn as_mut_slice(&mut self) -> &mut [f64] {
        &mut self.values
    }
}
