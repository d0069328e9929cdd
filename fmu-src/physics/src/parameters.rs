//! Everything that can be set of a model, as plain values.

use crate::beam::{Beam, MAX_MODES};
use crate::effects::user_expression::UserEffect;
use crate::effects::{CATALOGUE, find_parameter};
use crate::error::PhysicsError;
use crate::friction::FrictionLaw;
use crate::real::{Real, ZERO, real};

/// Parameters of a model: structure, friction and the effects' values.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelParameters {
    /// The elastic structure.
    pub beam: Beam,
    /// The friction characteristic.
    pub friction: FrictionLaw,
    /// Factor on friction as a whole; 1 unless calibrated for one run.
    pub friction_level: Real,
    /// Offset of the displacement sensor in m.
    pub sensor_offset: Real,
    /// Mode shapes where the sensor looks over those at the contact, phi_j(s) / phi_j(1); all 1 for a sensor at the contact. Modes
    /// that effects add follow the beam's own.
    pub sensor_ratios: [Real; MAX_MODES],
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
            friction_level: real(1.0),
            sensor_offset: ZERO,
            sensor_ratios: [real(1.0); MAX_MODES],
            effects: EffectValues::default(),
            user_effects: Vec::new(),
        }
    }
}

/// The values of all effects' parameters; at the start all effects are off.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectValues {
    values: Vec<Real>,
}

impl Default for EffectValues {
    fn default() -> Self {
        let values = CATALOGUE
            .iter()
            .flat_map(|card| card.parameters.iter().map(|p| real(p.start)))
            .collect();
        Self { values }
    }
}

impl EffectValues {
    fn first(card: usize) -> usize {
        CATALOGUE[..card].iter().map(|c| c.parameters.len()).sum()
    }

    /// Values of the effect with index `card` in the catalogue, in the order of its card.
    pub fn of(&self, card: usize) -> &[Real] {
        let first = Self::first(card);
        &self.values[first..first + CATALOGUE[card].parameters.len()]
    }

    /// Sets one value by the indices of effect and parameter.
    pub fn set(&mut self, card: usize, parameter: usize, value: Real) {
        self.values[Self::first(card) + parameter] = value;
    }

    /// Sets one value by name, e.g. `third_mode.frequency`.
    ///
    /// # Errors
    /// [`PhysicsError::UnknownParameter`].
    pub fn set_named(&mut self, name: &str, value: Real) -> Result<(), PhysicsError> {
        let (card, parameter) = find_parameter(name)?;
        self.set(card, parameter, value);
        Ok(())
    }

    /// All values, effect after effect in the catalogue's order.
    pub fn as_slice(&self) -> &[Real] {
        &self.values
    }

    /// All values, to be changed in place.
    pub fn as_mut_slice(&mut self) -> &mut [Real] {
        &mut self.values
    }
}
