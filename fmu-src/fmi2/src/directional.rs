//! Directional derivatives (FMI 2.0.5, section 2.1.9): `d unknown = sum of (d unknown / d known) seed`, at fixed
//! time and in the present mode of the contact.
//!
//! By central differences of fourth order along the seed, whose longest component is `STEP` of the known's
//! usual magnitude. Of the derivatives' own magnitude they are good to 1e-7 or better, through every effect and
//! a user's formula alike.

use crate::instance::Content;
use crate::lifecycle::{Function, Phase};
use crate::setup::PLACES;
use crate::states::place;
use crate::status::Fault;
use crate::values::{Access, View, find};
use beam_model_description::{Causality, Quantity};
use beam_physics::contact::ContactMode;
use beam_physics::error::PhysicsError;
use beam_physics::hybrid::Hybrid;

/// Step over the usual magnitude of a known.
const STEP: f64 = 1e-4;

impl Content {
    /// Writes the derivative of each unknown along `seed`.
    ///
    /// # Errors
    /// Variables that are not unknowns or knowns in this phase, seeds that are not finite, equations that
    /// can't be evaluated.
    pub fn directional(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Fault> {
        let unknowns = self.unknowns(unknowns)?;
        let knowns = self.knowns(knowns)?;
        if let Some(value) = seed.iter().find(|s| !s.is_finite()) {
            return Err(Fault::BadArgument {
                function: Function::GetDirectionalDerivative,
                argument: "dvKnown",
                value: *value,
                unit: "SI",
                required: "finite".into(),
            });
        }
        self.catch_up()?;
        let longest = knowns
            .iter()
            .zip(seed)
            .map(|(&known, s)| s.abs() / self.magnitude(known))
            .fold(0.0, f64::max);
        if longest == 0.0 {
            (0..unknowns.len()).for_each(|position| write(position, 0.0));
            return Ok(());
        }
        let step = STEP / longest;
        let at = |times: f64| -> Result<Vec<f64>, Fault> {
            let moves = knowns.iter().zip(seed).map(|(&k, s)| (k, times * step * s));
            if self.phase == Phase::Initialization {
                self.moved_start(moves, &unknowns)
            } else {
                self.moved(moves, &unknowns)
            }
        };
        let central = || -> Result<Vec<f64>, Fault> {
            let [a, b, c, d] = [at(-2.0)?, at(-1.0)?, at(1.0)?, at(2.0)?];
            let slope = |i: usize| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
            Ok((0..unknowns.len()).map(slope).collect())
        };
        // At the end of a range (a normal force of zero) there is only one side to look at.
        let forward = || -> Result<Vec<f64>, Fault> {
            let [a, b, c] = [at(0.0)?, at(1.0)?, at(2.0)?];
            let slope = |i: usize| (4.0 * b[i] - 3.0 * a[i] - c[i]) / (2.0 * step);
            Ok((0..unknowns.len()).map(slope).collect())
        };
        let slopes = central().or_else(|_| forward())?;
        if !slopes.iter().all(|s| s.is_finite()) {
            let time = self.time;
            let cause = PhysicsError::NotFinite { time };
            return Err(Fault::NotEvaluable { time, cause });
        }
        slopes
            .into_iter()
            .enumerate()
            .for_each(|(i, s)| write(i, s));
        Ok(())
    }

    fn unknowns(&self, references: &[u32]) -> Result<Vec<usize>, Fault> {
        let one = |&reference: &u32| {
            let index = find(self.layout, reference, Access::Real)?;
            let variable = &self.layout.variables()[index];
            let fits = variable.causality == Causality::Output
                || matches!(variable.quantity, Quantity::Rate(_));
            fits.then_some(index).ok_or_else(|| Fault::Unsupported {
                function: Function::GetDirectionalDerivative,
                what: format!("the unknown '{}', neither output nor rate,", variable.name),
            })
        };
        references.iter().map(one).collect()
    }

    fn knowns(&self, references: &[u32]) -> Result<Vec<usize>, Fault> {
        let one = |&reference: &u32| {
            let index = find(self.layout, reference, Access::Real)?;
            let variable = &self.layout.variables()[index];
            let is_state = self.layout.states().iter().any(|(s, _)| *s == index);
            let fits = if self.phase == Phase::Initialization {
                variable.is_settable()
            } else {
                variable.causality == Causality::Input || is_state
            };
            fits.then_some(index).ok_or_else(|| Fault::Unsupported {
                function: Function::GetDirectionalDerivative,
                what: format!(
                    "the known '{}' in the phase '{}'",
                    variable.name, self.phase
                ),
            })
        };
        references.iter().map(one).collect()
    }

    /// Usual magnitude of a variable.
    fn magnitude(&self, index: usize) -> f64 {
        let variable = &self.layout.variables()[index];
        variable.nominal.unwrap_or_else(|| {
            let usual = [self.values[index], variable.start.unwrap_or(0.0)];
            usual
                .into_iter()
                .map(f64::abs)
                .find(|v| *v > 0.0)
                .unwrap_or(1e-3)
        })
    }

    /// Unknowns during a run, with inputs and states moved.
    fn moved(
        &self,
        moves: impl Iterator<Item = (usize, f64)>,
        unknowns: &[usize],
    ) -> Result<Vec<f64>, Fault> {
        let mut hybrid = match (&self.hybrid, &self.run) {
            (Some(hybrid), _) => hybrid.clone(),
            (None, Some(run)) => Hybrid::of(run),
            (None, None) => {
                return Err(Fault::Unsupported {
                    function: Function::GetDirectionalDerivative,
                    what: "a derivative before the run has begun".into(),
                });
            }
        };
        let inputs = hybrid.model().inputs;
        let (mut velocity, mut force) = (inputs.belt_velocity, inputs.normal_force);
        let mut external = inputs.external_force;
        let mut clamp = inputs.clamp_acceleration;
        for (index, by) in moves {
            let quantity = self.layout.variables()[index].quantity;
            match quantity {
                Quantity::BeltVelocity => velocity += by,
                Quantity::NormalForce => force += by,
                Quantity::ExternalForce => external += by,
                Quantity::ClampAcceleration => clamp += by,
                _ => {
                    if let Some(place) = place(self.layout, hybrid.model(), self.modes(), quantity)
                    {
                        let value = place.value(&hybrid) + by;
                        place.set(&mut hybrid, value);
                    }
                }
            }
        }
        hybrid.set_inputs([velocity, force, external, clamp], false)?;
        let mut view = View::of_hybrid(self, &hybrid);
        self.read(&mut view, unknowns)
    }

    /// Unknowns during initialisation, with values moved and the contact in the mode in which it is.
    fn moved_start(
        &self,
        moves: impl Iterator<Item = (usize, f64)>,
        unknowns: &[usize],
    ) -> Result<Vec<f64>, Fault> {
        let mut content = self.clone();
        let sticks = content.run.as_ref().map(|run| run.contact_mode()) == Some(ContactMode::Stuck);
        content.values[PLACES.start_contact] = if sticks { 1.0 } else { 2.0 };
        for (index, by) in moves {
            content.values[index] += by;
        }
        content.stale = true;
        content.refresh()?;
        let run = content.run.as_ref().expect("just made");
        let mut view = View::of_run(&content, run);
        content.read(&mut view, unknowns)
    }

    fn read(&self, view: &mut View, unknowns: &[usize]) -> Result<Vec<f64>, Fault> {
        let one = |&index: &usize| {
            let quantity = self.layout.variables()[index].quantity;
            Ok(view.value(quantity, self.values[index])?.unwrap_or(0.0))
        };
        unknowns.iter().map(one).collect()
    }
}
