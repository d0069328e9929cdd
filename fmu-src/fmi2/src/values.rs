//! Reading and setting variables by value reference.

use crate::instance::Content;
use crate::lifecycle::{Function, Phase};
use crate::setup::PLACES;
use crate::status::Fault;
use beam_model_description::{Causality, Kind, Layout, ModeItem, Quantity, Variable};
use beam_physics::contact::ContactMode;
use beam_physics::energy::Energy;
use beam_physics::integrate::State;
use beam_physics::simulate::{Outputs, Simulation};

/// Data type of an access.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// `fmi2GetReal`, `fmi2SetReal`.
    Real,
    /// `fmi2GetInteger`, `fmi2SetInteger` (counts and enumerations).
    Integer,
    /// `fmi2GetBoolean`, `fmi2SetBoolean`; no variable has this type.
    Boolean,
    /// `fmi2GetString`, `fmi2SetString`; no variable has this type.
    Text,
}

impl Access {
    fn name(self) -> &'static str {
        match self {
            Self::Real => "Real",
            Self::Integer => "Integer or Enumeration",
            Self::Boolean => "Boolean",
            Self::Text => "String",
        }
    }
}

/// Index of the variable with a value reference if it has the type asked for.
///
/// # Errors
/// Unknown value reference, another type.
#[inline]
pub fn find(layout: &'static Layout, reference: u32, access: Access) -> Result<usize, Fault> {
    let unknown = Fault::UnknownReference { reference };
    let index = layout.index_of_reference(reference).ok_or(unknown)?;
    let variable = &layout.variables()[index];
    let integer = variable.kind.is_integer();
    if access
        == (if integer {
            Access::Integer
        } else {
            Access::Real
        })
    {
        return Ok(index);
    }
    Err(Fault::WrongType {
        name: &variable.name,
        actual: match variable.kind {
            Kind::Real(_) => "Real",
            Kind::Integer => "Integer",
            Kind::Enumeration(_) => "Enumeration",
        },
        asked: access.name(),
    })
}

fn unit(variable: &Variable) -> &'static str {
    match variable.kind {
        Kind::Real(unit) => unit.symbol,
        _ => "1",
    }
}

/// The run as results look at it; what several results need is worked out once.
struct View<'a> {
    run: &'a Simulation,
    state: Option<State>,
    outputs: Option<Outputs>,
    energy: Option<Energy>,
}

impl<'a> View<'a> {
    fn new(run: &'a Simulation) -> Self {
        Self {
            run,
            state: None,
            outputs: None,
            energy: None,
        }
    }
    fn state(&mut self) -> &State {
        self.state.get_or_insert_with(|| self.run.state())
    }
    fn outputs(&mut self) -> &Outputs {
        self.outputs.get_or_insert_with(|| self.run.outputs())
    }
    /// Energies since the start; `None` while they are not accounted for.
    fn energy(&mut self) -> Option<&Energy> {
        if self.energy.is_none() {
            self.energy = self.run.energy();
        }
        self.energy.as_ref()
    }

    /// Value of a quantity; `set` is the value set before the run. `None` for energies that are not
    /// accounted for yet.
    #[inline]
    fn value(&mut self, quantity: Quantity, set: f64) -> Option<f64> {
        Some(match quantity {
            Quantity::MeasuredDisplacement => {
                let run = self.run;
                run.model().measured_displacement(self.state())
            }
            Quantity::TipDisplacement => {
                let run = self.run;
                run.model().tip(self.state()).0
            }
            Quantity::TipVelocity => {
                let run = self.run;
                run.model().tip(self.state()).1
            }
            Quantity::TipAcceleration => self.outputs().acceleration,
            Quantity::FrictionForce => self.outputs().friction_force,
            Quantity::RelativeVelocity => self.outputs().relative_velocity,
            Quantity::PowerIntoBeam => {
                let outputs = self.outputs();
                outputs.friction_force * outputs.velocity
            }
            Quantity::ContactMode => {
                if self.run.model().has_memory() {
                    return Some(2.0);
                }
                match self.run.contact_mode() {
                    ContactMode::Backward => -1.0,
                    ContactMode::Stuck => 0.0,
                    ContactMode::Forward => 1.0,
                }
            }
            Quantity::TransitionCount => self.run.transition_count() as f64,
            Quantity::LastTransitionTime => self.run.last_transition_time(),
            Quantity::BeltTravel => self.outputs().belt_travel,
            Quantity::DwellTime => self.outputs().dwell,
            Quantity::EnergyStored => {
                let run = self.run;
                run.model().stored_energy(self.state())
            }
            Quantity::EnergyBeltWork => self.energy()?.belt_work,
            Quantity::EnergyContactDissipation => self.energy()?.contact_dissipation,
            Quantity::EnergyStructuralDissipation => self.energy()?.structural_dissipation,
            Quantity::Mode(j, ModeItem::Displacement) => self.state_or(2 * j, j, set),
            Quantity::Mode(j, ModeItem::Velocity) => self.state_or(2 * j + 1, j, set),
            Quantity::EffectState(card, i) => match self.run.model().effect_states(card) {
                Some((first, _)) => self.state()[first + i],
                None => set,
            },
            _ => set,
        })
    }

    /// A modal coordinate; those of modes that are not in use keep the value set.
    fn state_or(&mut self, index: usize, mode: usize, set: f64) -> f64 {
        if mode < self.run.model().beam().modes().len() {
            self.state()[index]
        } else {
            set
        }
    }
}

impl Content {
    /// Reads variables into `write(position, value)`.
    ///
    /// # Errors
    /// Unknown value references, wrong types, values with which the equations can't be set up.
    #[inline]
    pub fn get(
        &mut self,
        references: &[u32],
        access: Access,
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Fault> {
        if self.phase == Phase::Initialization {
            self.refresh()?;
        } else if self.inputs_touched && self.phase == Phase::StepComplete {
            self.apply_inputs()?;
        }
        let Some(run) = &self.run else {
            // A run that never began (an error before) has nothing but the values set.
            for (position, &reference) in references.iter().enumerate() {
                write(position, self.values[find(self.layout, reference, access)?]);
            }
            return Ok(());
        };
        let mut view = View::new(run);
        for (position, &reference) in references.iter().enumerate() {
            let index = find(self.layout, reference, access)?;
            let quantity = self.layout.variables()[index].quantity;
            let value = match view.value(quantity, self.values[index]) {
                Some(value) => value,
                None => {
                    self.begin_energy(index)?;
                    view = View::new(self.run.as_ref().expect("there was one"));
                    view.value(quantity, self.values[index]).unwrap_or(0.0)
                }
            };
            write(position, value);
        }
        Ok(())
    }

    /// Energies cost about as much as the motion, so they are accounted for only in runs whose master
    /// reads one before the first step, as every master does that records it.
    fn begin_energy(&mut self, index: usize) -> Result<(), Fault> {
        match &mut self.run {
            Some(run) if self.time == self.experiment.start => {
                run.account_energy();
                Ok(())
            }
            _ => Err(Fault::EnergyNotAccounted {
                name: &self.layout.variables()[index].name,
            }),
        }
    }

    /// Sets variables to the values that `read(position)` gives: all of them, or none.
    ///
    /// # Errors
    /// Unknown value references, wrong types, variables that can't be set now, values out of range.
    pub fn set(
        &mut self,
        references: &[u32],
        access: Access,
        read: impl Fn(usize) -> f64,
    ) -> Result<(), Fault> {
        for (position, &reference) in references.iter().enumerate() {
            let index = find(self.layout, reference, access)?;
            self.check(&self.layout.variables()[index], read(position))?;
        }
        for (position, &reference) in references.iter().enumerate() {
            let index = find(self.layout, reference, access)?;
            self.values[index] = read(position);
        }
        if self.phase == Phase::StepComplete {
            self.inputs_touched |= !references.is_empty();
        } else {
            self.stale |= !references.is_empty();
        }
        Ok(())
    }

    fn check(&self, variable: &'static Variable, value: f64) -> Result<(), Fault> {
        let refused = |reason| {
            Err(Fault::NotSettable {
                name: &variable.name,
                phase: self.phase,
                reason,
            })
        };
        if !variable.is_settable() {
            return refused("a result");
        }
        if self.phase == Phase::StepComplete && variable.causality != Causality::Input {
            return refused("fixed once the run has begun");
        }
        let required = match (variable.min, variable.max) {
            _ if !value.is_finite() => "finite".to_owned(),
            (Some(min), _) if value < min => format!("at least {min}"),
            (_, Some(max)) if value > max => format!("at most {max}"),
            _ => return Ok(()),
        };
        Err(Fault::BadValue {
            name: &variable.name,
            value,
            unit: unit(variable),
            required,
        })
    }

    /// Sets the first derivative (per s) of inputs for the next step.
    ///
    /// # Errors
    /// Variables that are no inputs, orders other than 1, rates that are not finite.
    pub fn set_input_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        rates: &[f64],
    ) -> Result<(), Fault> {
        let mut wanted = self.input_rates;
        for ((&reference, &order), &rate) in references.iter().zip(orders).zip(rates) {
            let index = find(self.layout, reference, Access::Real)?;
            let variable = &self.layout.variables()[index];
            let place = [PLACES.belt_velocity, PLACES.normal_force]
                .iter()
                .position(|&input| input == index)
                .ok_or(Fault::NotSettable {
                    name: &variable.name,
                    phase: self.phase,
                    reason: "not an input, so it has no input derivative",
                })?;
            if order != 1 {
                return Err(Fault::BadArgument {
                    function: Function::SetRealInputDerivatives,
                    argument: "order",
                    value: f64::from(order),
                    unit: "1",
                    required: "1".into(),
                });
            }
            if !rate.is_finite() {
                return Err(Fault::BadArgument {
                    function: Function::SetRealInputDerivatives,
                    argument: "value",
                    value: rate,
                    unit: "1/s of the input's unit",
                    required: "finite".into(),
                });
            }
            wanted[place] = rate;
        }
        self.input_rates = wanted;
        if self.phase == Phase::StepComplete {
            self.inputs_touched = true;
        } else {
            self.stale = true;
        }
        Ok(())
    }

    /// Reads the first derivative (per s) of continuous outputs.
    ///
    /// # Errors
    /// Variables that are no outputs, orders other than 1.
    pub fn output_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Fault> {
        if self.inputs_touched && self.phase == Phase::StepComplete {
            self.apply_inputs()?;
        }
        let function = Function::GetRealOutputDerivatives;
        let Some(run) = &mut self.run else {
            return Err(Fault::Unsupported {
                function,
                what: "a derivative before the run has begun".into(),
            });
        };
        let rates = run.output_rates()?;
        for (position, (&reference, &order)) in references.iter().zip(orders).enumerate() {
            let variable = &self.layout.variables()[find(self.layout, reference, Access::Real)?];
            if order != 1 {
                return Err(Fault::BadArgument {
                    function,
                    argument: "order",
                    value: f64::from(order),
                    unit: "1",
                    required: "1".into(),
                });
            }
            let outputs = run.outputs();
            let rate = match variable.quantity {
                Quantity::TipDisplacement => rates.displacement,
                Quantity::TipVelocity => rates.velocity,
                Quantity::TipAcceleration => rates.acceleration,
                Quantity::FrictionForce => rates.friction_force,
                Quantity::RelativeVelocity => rates.relative_velocity,
                Quantity::PowerIntoBeam => {
                    rates.friction_force * outputs.velocity
                        + outputs.friction_force * rates.velocity
                }
                Quantity::MeasuredDisplacement => rates.measured_displacement,
                Quantity::BeltTravel => rates.belt_travel,
                Quantity::DwellTime => rates.dwell,
                Quantity::LastTransitionTime => 0.0,
                _ => {
                    return Err(Fault::Unsupported {
                        function,
                        what: format!("'{}', which is no output,", variable.name),
                    });
                }
            };
            write(position, rate);
        }
        Ok(())
    }
}
