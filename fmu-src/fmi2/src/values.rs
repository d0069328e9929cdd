//! Reading and setting variables by value reference.

use crate::instance::Content;
use crate::lifecycle::{Function, Phase};
use crate::setup::{INPUTS, PLACES};
use crate::states::{Place, place};
use crate::status::Fault;
use beam_model_description::{Causality, Kind, Layout, ModeItem, Quantity, Variable};
use beam_physics::contact::ContactMode;
use beam_physics::energy::Energy;
use beam_physics::error::PhysicsError;
use beam_physics::hybrid::{Hybrid, Rates};
use beam_physics::integrate::State;
use beam_physics::model::Model;
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
    /// Name of the type for messages.
    pub fn name(self) -> &'static str {
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

/// What results are read from.
#[derive(Clone, Copy)]
enum Source<'a> {
    /// A run that this FMU integrates.
    Run(&'a Simulation),
    /// An instant of a run that the master integrates.
    Instant(&'a Hybrid),
}

/// The run as results look at it; what several results need is worked out once.
pub struct View<'a> {
    source: Source<'a>,
    layout: &'static Layout,
    modes: usize,
    state: Option<State>,
    outputs: Option<Outputs>,
    energy: Option<Energy>,
    rates: Option<Rates>,
}

impl<'a> View<'a> {
    /// Results of a run.
    pub fn of_run(content: &Content, run: &'a Simulation) -> Self {
        Self::new(content, Source::Run(run))
    }
    /// Results at an instant.
    pub fn of_hybrid(content: &Content, hybrid: &'a Hybrid) -> Self {
        Self::new(content, Source::Instant(hybrid))
    }
    fn new(content: &Content, source: Source<'a>) -> Self {
        Self {
            source,
            layout: content.layout,
            modes: content.modes(),
            state: None,
            outputs: None,
            energy: None,
            rates: None,
        }
    }
    #[inline]
    fn model(&self) -> &'a Model {
        match self.source {
            Source::Run(run) => run.model(),
            Source::Instant(hybrid) => hybrid.model(),
        }
    }
    fn time(&self) -> f64 {
        match self.source {
            Source::Run(run) => run.time(),
            Source::Instant(hybrid) => hybrid.time(),
        }
    }
    fn contact_mode(&self) -> ContactMode {
        match self.source {
            Source::Run(run) => run.contact_mode(),
            Source::Instant(hybrid) => hybrid.mode(),
        }
    }
    fn state(&mut self) -> &State {
        let source = self.source;
        self.state.get_or_insert_with(|| match source {
            Source::Run(run) => run.state(),
            Source::Instant(hybrid) => *hybrid.state(),
        })
    }
    fn outputs(&mut self) -> &Outputs {
        let source = self.source;
        self.outputs.get_or_insert_with(|| match source {
            Source::Run(run) => run.outputs(),
            Source::Instant(hybrid) => hybrid.outputs(),
        })
    }
    /// Energies since the start; `None` while they are not accounted for.
    fn energy(&mut self) -> Option<&Energy> {
        if self.energy.is_none() {
            self.energy = match self.source {
                Source::Run(run) => run.energy(),
                Source::Instant(hybrid) => {
                    let [belt_work, contact_heat, structural_heat, external_work] = hybrid.energy();
                    Some(Energy {
                        stored: 0.0,
                        belt_work,
                        external_work,
                        contact_dissipation: contact_heat,
                        structural_dissipation: structural_heat,
                    })
                }
            };
        }
        self.energy.as_ref()
    }
    /// Rate of the state with a value reference.
    fn rate(&mut self, state: u32) -> Result<f64, Fault> {
        let rates = match self.rates {
            Some(rates) => rates,
            None => {
                let rates = match self.source {
                    Source::Run(run) => Hybrid::of(run).rates(),
                    Source::Instant(hybrid) => hybrid.rates(),
                };
                let time = self.time();
                let rates = rates.map_err(|cause| Fault::NotEvaluable { time, cause })?;
                *self.rates.insert(rates)
            }
        };
        let place = self.layout.index_of_reference(state).and_then(|index| {
            let quantity = self.layout.variables()[index].quantity;
            place(self.layout, self.model(), self.modes, quantity)
        });
        Ok(place.map_or(0.0, |place| place.rate(&rates)))
    }

    /// Value of a quantity; `set` is the value set before the run. `None` for energies that are not
    /// accounted for yet.
    ///
    /// # Errors
    /// Rates that can't be evaluated.
    #[inline]
    pub fn value(&mut self, quantity: Quantity, set: f64) -> Result<Option<f64>, Fault> {
        if let Quantity::Rate(state) = quantity {
            return self.rate(state).map(Some);
        }
        Ok(self.quantity(quantity, set))
    }

    #[inline]
    fn quantity(&mut self, quantity: Quantity, set: f64) -> Option<f64> {
        let model = self.model();
        Some(match quantity {
            // Fits read it at every sample, and nothing else: it needs no forces.
            Quantity::MeasuredDisplacement => {
                let (t, mode) = (self.time(), self.contact_mode());
                model.measured_displacement(t, self.state(), mode)
            }
            Quantity::MeasuredVelocity => {
                let x = self.state();
                model.sensor(x, model.tip(x)).1
            }
            Quantity::MeasuredAcceleration => self.outputs().measured_acceleration,
            Quantity::TipDisplacement => model.tip(self.state()).0,
            Quantity::TipVelocity => model.tip(self.state()).1,
            Quantity::TipAcceleration => self.outputs().acceleration,
            Quantity::FrictionForce => self.outputs().friction_force,
            Quantity::RelativeVelocity => self.outputs().relative_velocity,
            Quantity::PowerIntoBeam => {
                let outputs = self.outputs();
                outputs.friction_force * outputs.velocity
            }
            Quantity::ContactMode => {
                if model.has_memory() {
                    return Some(2.0);
                }
                match self.contact_mode() {
                    ContactMode::Backward => -1.0,
                    ContactMode::Stuck => 0.0,
                    ContactMode::Forward => 1.0,
                }
            }
            Quantity::TransitionCount => match self.source {
                Source::Run(run) => run.transition_count() as f64,
                Source::Instant(hybrid) => hybrid.transition_count() as f64,
            },
            Quantity::LastTransitionTime => match self.source {
                Source::Run(run) => run.last_transition_time(),
                Source::Instant(hybrid) => hybrid.last_transition_time(),
            },
            Quantity::BeltTravel => self.outputs().belt_travel,
            Quantity::DwellTime => self.outputs().dwell,
            Quantity::EnergyStored => model.stored_energy(self.state()),
            Quantity::EnergyBeltWork => self.energy()?.belt_work,
            Quantity::EnergyContactDissipation => self.energy()?.contact_dissipation,
            Quantity::EnergyStructuralDissipation => self.energy()?.structural_dissipation,
            Quantity::EnergyExternalWork => self.energy()?.external_work,
            Quantity::BeltDistance => match self.source {
                Source::Run(run) => Hybrid::of(run).belt_distance(),
                Source::Instant(hybrid) => hybrid.belt_distance(),
            },
            Quantity::Mode(_, ModeItem::Displacement | ModeItem::Velocity)
            | Quantity::EffectState(..)
            | Quantity::UserState(..) => match place(self.layout, model, self.modes, quantity) {
                Some(Place::Model(i)) => self.state()[i],
                _ => set,
            },
            _ => set,
        })
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
        self.catch_up()?;
        let (run, hybrid) = (self.run.as_ref(), self.hybrid.as_ref());
        let mut view = match (run, hybrid) {
            (Some(run), _) => View::of_run(self, run),
            (None, Some(hybrid)) => View::of_hybrid(self, hybrid),
            (None, None) => {
                // A run that never began (an error before) has nothing but the values set.
                for (position, &reference) in references.iter().enumerate() {
                    write(position, self.values[find(self.layout, reference, access)?]);
                }
                return Ok(());
            }
        };
        for (position, &reference) in references.iter().enumerate() {
            let index = find(self.layout, reference, access)?;
            let quantity = self.layout.variables()[index].quantity;
            let value = view.value(quantity, self.values[index]);
            let value = match value.map_err(|fault| self.explained(fault))? {
                Some(value) => value,
                None => {
                    self.account_energy()?;
                    view = View::of_run(self, self.run.as_ref().expect("there was one"));
                    view.value(quantity, self.values[index])?.unwrap_or(0.0)
                }
            };
            // An integrator from outside can go where nothing can be computed any more.
            if !value.is_finite() {
                let time = view.time();
                let cause = PhysicsError::NotFinite { time };
                return Err(self.explained(Fault::NotEvaluable { time, cause }));
            }
            write(position, value);
        }
        Ok(())
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
        let (mut inputs, mut tuned) = (false, false);
        for (position, &reference) in references.iter().enumerate() {
            let index = find(self.layout, reference, access)?;
            self.values[index] = read(position);
            let is_input = self.layout.variables()[index].causality == Causality::Input;
            inputs |= is_input;
            tuned |= !is_input;
        }
        match self.phase {
            Phase::StepComplete => {
                self.inputs_touched |= inputs;
                self.retuned |= tuned;
            }
            Phase::EventMode | Phase::ContinuousTime => {
                self.retuned |= tuned;
                if inputs {
                    self.hand_inputs()?;
                }
            }
            _ => self.stale |= !references.is_empty(),
        }
        Ok(())
    }

    /// Belt velocity in m/s, normal force in N, external force in N and acceleration of the clamp in m/s^2 as set.
    pub fn input_values(&self) -> [f64; INPUTS] {
        PLACES.input_indices().map(|i| self.values[i])
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
        match self.phase {
            Phase::StepComplete | Phase::EventMode if !variable.is_settable_in_a_run() => {
                return refused("fixed once the run has begun");
            }
            Phase::ContinuousTime if variable.causality != Causality::Input => {
                return refused("settable at events only");
            }
            _ => {}
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
            let place = PLACES
                .input_indices()
                .iter()
                .position(|&input| input == index)
                .ok_or(Fault::NotSettable {
                    name: &variable.name,
                    phase: self.phase,
                    reason: "not an input, so it has no input derivative",
                })?;
            first_order(Function::SetRealInputDerivatives, order)?;
            finite_rate(rate)?;
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
        self.catch_up()?;
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
            first_order(function, order)?;
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
                Quantity::MeasuredVelocity => rates.measured_velocity,
                Quantity::MeasuredAcceleration => rates.measured_acceleration,
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

/// Refuses derivatives of any order but the first.
pub(crate) fn first_order(function: Function, order: i32) -> Result<(), Fault> {
    if order == 1 {
        return Ok(());
    }
    Err(Fault::BadArgument {
        function,
        argument: "order",
        value: f64::from(order),
        unit: "1",
        required: "1".into(),
    })
}

/// The derivative of an input must be a number.
pub(crate) fn finite_rate(rate: f64) -> Result<(), Fault> {
    if rate.is_finite() {
        return Ok(());
    }
    Err(Fault::BadArgument {
        function: Function::SetRealInputDerivatives,
        argument: "value",
        value: rate,
        unit: "1/s of the input's unit",
        required: "finite".into(),
    })
}
