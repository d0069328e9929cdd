//! The belt drive as a [`Model`] behind the C interface, for co-simulation.

use crate::experiment::Experiment;
use crate::fmu_state::{misfit, open, optional, seal};
use crate::lifecycle::{Function, Interface, Phase};
use crate::model::{Model, SavedState, copied, own};
use crate::status::{Fault, Status};
use crate::values::{Access, finite_rate, first_order};
use beam_model_description::Causality;
use beam_model_description::belt_drive::{Item, VARIABLES, Variable, index_of_reference};
use beam_physics::belt_drive::{BeltDrive, DriveState, Load};
use beam_physics::error::PhysicsError;
use beam_physics::simulate::snapshot::{Codec, Reader, Writer};
use std::any::Any;

const MAGIC: [u8; 8] = *b"SSDRIVE\n";
const VERSION: u32 = 1;

/// Everything of an instance; also what `fmi2GetFMUstate` copies.
#[derive(Debug, Clone)]
pub struct Drive {
    phase: Phase,
    /// Values set, or start values, in the order of the table.
    values: [f64; VARIABLES.len()],
    experiment: Experiment,
    /// The present communication point in s.
    time: f64,
    state: DriveState,
    /// Rates of the inputs (N/s, m/s^2) for the next step.
    input_rates: [f64; 2],
    last_step: Status,
}

/// The variable with a value reference if it is read or set as `access`.
fn find(reference: u32, access: Access) -> Result<&'static Variable, Fault> {
    let index = index_of_reference(reference).ok_or(Fault::UnknownReference { reference })?;
    let variable = &VARIABLES[index];
    if access == Access::Real {
        return Ok(variable);
    }
    Err(Fault::WrongType {
        name: variable.name,
        actual: Access::Real.name(),
        asked: access.name(),
    })
}

impl Drive {
    /// A fresh instance.
    ///
    /// # Errors
    /// An interface that this model does not offer.
    pub fn new(interface: Interface) -> Result<Self, String> {
        if interface != Interface::CoSimulation {
            return Err("the belt drive offers co-simulation only: pass fmuType 1".into());
        }
        Ok(Self::fresh())
    }

    fn fresh() -> Self {
        Self {
            phase: Phase::Instantiated,
            values: std::array::from_fn(|i| VARIABLES[i].start.unwrap_or(0.0)),
            experiment: Experiment::default(),
            time: 0.0,
            state: DriveState::default(),
            input_rates: [0.0; 2],
            last_step: Status::Ok,
        }
    }

    fn value(&self, item: Item) -> f64 {
        self.values[item as usize]
    }

    fn constants(&self) -> BeltDrive {
        BeltDrive {
            mass: self.value(Item::Mass),
            stiffness: self.value(Item::Stiffness),
            damping: self.value(Item::Damping),
        }
    }

    fn load(&self) -> Load {
        let [force_rate, motor_rate] = self.input_rates;
        Load {
            friction_force: [self.value(Item::FrictionForce), force_rate],
            motor_velocity: [self.value(Item::MotorVelocity), motor_rate],
        }
    }

    /// The state at present; before the run that to which the values set lead.
    fn present(&self) -> DriveState {
        if matches!(self.phase, Phase::Instantiated | Phase::Initialization) {
            return DriveState {
                stretch: self.value(Item::StretchStart),
                velocity: self.value(Item::MotorVelocity) + self.value(Item::StretchRateStart),
            };
        }
        self.state
    }

    fn read(&self, item: Item) -> f64 {
        let (state, load) = (self.present(), self.load());
        match item {
            Item::BeltVelocity => state.velocity,
            Item::BeltAcceleration => self.constants().acceleration(&state, &load),
            Item::Stretch => state.stretch,
            Item::MotorForce => self.constants().pull(&state, load.motor_velocity[0]),
            _ => self.value(item),
        }
    }

    /// Rate of an output, per s, with the inputs and their rates as set.
    fn rate(&self, item: Item) -> Option<f64> {
        let (state, load, constants) = (self.present(), self.load(), self.constants());
        let acceleration = constants.acceleration(&state, &load);
        let stretch_rate = state.velocity - load.motor_velocity[0];
        let pull_rate = -constants.stiffness * stretch_rate
            - constants.damping * (acceleration - load.motor_velocity[1]);
        Some(match item {
            Item::BeltVelocity => acceleration,
            Item::BeltAcceleration => (pull_rate - load.friction_force[1]) / constants.mass,
            Item::Stretch => stretch_rate,
            Item::MotorForce => pull_rate,
            _ => return None,
        })
    }

    fn check(&self, variable: &'static Variable, value: f64) -> Result<(), Fault> {
        let refused = |reason| {
            Err(Fault::NotSettable {
                name: variable.name,
                phase: self.phase,
                reason,
            })
        };
        match variable.causality {
            Causality::Input => {}
            Causality::Parameter if self.phase == Phase::StepComplete => {
                return refused("fixed once the run has begun");
            }
            Causality::Parameter => {}
            _ => return refused("a result"),
        }
        let required = match variable.min {
            _ if !value.is_finite() => "finite".to_owned(),
            Some(min) if value < min => format!("at least {min}"),
            _ => return Ok(()),
        };
        Err(Fault::BadValue {
            name: variable.name,
            value,
            unit: variable.unit.symbol,
            required,
        })
    }

    /// Names every field once, for writing and for reading.
    fn exchange(&mut self, codec: &mut impl Codec) -> Option<()> {
        let mut phase = self.phase as u8;
        codec.byte(&mut phase)?;
        self.phase = Phase::from_number(phase)?;
        self.values.iter_mut().try_for_each(|v| codec.number(v))?;
        codec.number(&mut self.experiment.start)?;
        optional(&mut self.experiment.stop, codec)?;
        optional(&mut self.experiment.tolerance, codec)?;
        codec.number(&mut self.time)?;
        codec.number(&mut self.state.stretch)?;
        codec.number(&mut self.state.velocity)?;
        self.input_rates
            .iter_mut()
            .try_for_each(|v| codec.number(v))?;
        let mut status = self.last_step.code() as u8;
        codec.byte(&mut status)?;
        self.last_step = match status {
            0 => Status::Ok,
            3 => Status::Error,
            _ => return None,
        };
        Some(())
    }
}

impl Model for Drive {
    fn interface(&self) -> Interface {
        Interface::CoSimulation
    }
    fn phase(&self) -> Phase {
        self.phase
    }
    fn set_phase(&mut self, phase: Phase) {
        self.phase = phase;
    }

    fn setup_experiment(&mut self, experiment: Experiment) -> Result<(), Fault> {
        experiment.check()?;
        self.experiment = experiment;
        self.time = experiment.start;
        Ok(())
    }
    fn enter_initialization(&mut self) {
        self.phase = Phase::Initialization;
    }
    fn exit_initialization(&mut self) -> Result<(), Fault> {
        self.constants().check()?;
        self.state = self.present();
        self.phase = Phase::StepComplete;
        Ok(())
    }
    fn reset(&mut self) {
        *self = Self::fresh();
    }

    fn get(
        &mut self,
        references: &[u32],
        access: Access,
        write: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault> {
        for (position, &reference) in references.iter().enumerate() {
            let value = self.read(find(reference, access)?.item);
            if !value.is_finite() {
                let time = self.time;
                let cause = PhysicsError::NotFinite { time };
                return Err(Fault::NotEvaluable { time, cause });
            }
            write(position, value);
        }
        Ok(())
    }
    fn set(
        &mut self,
        references: &[u32],
        access: Access,
        read: &dyn Fn(usize) -> f64,
    ) -> Result<(), Fault> {
        for (position, &reference) in references.iter().enumerate() {
            self.check(find(reference, access)?, read(position))?;
        }
        for (position, &reference) in references.iter().enumerate() {
            self.values[find(reference, access)?.item as usize] = read(position);
        }
        Ok(())
    }

    fn save(&self, old: Option<SavedState>) -> SavedState {
        copied(self, old)
    }
    fn restore(&mut self, state: &dyn Any) -> Result<(), Fault> {
        self.clone_from(own(state)?);
        Ok(())
    }
    fn serialize(&self, state: &dyn Any) -> Result<Vec<u8>, Fault> {
        let mut content: Self = own::<Self>(state)?.clone();
        let mut writer = Writer::default();
        content
            .exchange(&mut writer)
            .expect("writing does not fail");
        Ok(seal(MAGIC, VERSION, &writer.bytes))
    }
    fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, Fault> {
        let mut reader = Reader::new(open(MAGIC, VERSION, bytes)?);
        let mut content = Self::fresh();
        content
            .exchange(&mut reader)
            .filter(|()| reader.is_empty())
            .ok_or_else(misfit)?;
        Ok(Box::new(content))
    }

    fn do_step(&mut self, point: f64, step: f64) -> Result<(), Fault> {
        self.experiment.check_step(self.time, point, step)?;
        let load = self.load();
        let end = self.constants().after(&self.state, &load, step);
        let time = point + step;
        if !(end.stretch.is_finite() && end.velocity.is_finite()) {
            self.phase = Phase::Error;
            self.last_step = Status::Error;
            let cause = PhysicsError::NotFinite { time };
            return Err(Fault::StepStopped {
                time: self.time,
                cause,
            });
        }
        self.state = end;
        self.time = time;
        self.input_rates = [0.0; 2];
        self.last_step = Status::Ok;
        Ok(())
    }
    fn set_input_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        rates: &[f64],
    ) -> Result<(), Fault> {
        let function = Function::SetRealInputDerivatives;
        let mut wanted = self.input_rates;
        for ((&reference, &order), &rate) in references.iter().zip(orders).zip(rates) {
            let variable = find(reference, Access::Real)?;
            let place = match variable.item {
                Item::FrictionForce => 0,
                Item::MotorVelocity => 1,
                _ => {
                    return Err(Fault::NotSettable {
                        name: variable.name,
                        phase: self.phase,
                        reason: "not an input, so it has no input derivative",
                    });
                }
            };
            first_order(function, order)?;
            finite_rate(rate)?;
            wanted[place] = rate;
        }
        self.input_rates = wanted;
        Ok(())
    }
    fn output_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault> {
        let function = Function::GetRealOutputDerivatives;
        for (position, (&reference, &order)) in references.iter().zip(orders).enumerate() {
            let variable = find(reference, Access::Real)?;
            first_order(function, order)?;
            let rate = self.rate(variable.item).ok_or_else(|| Fault::Unsupported {
                function,
                what: format!("'{}', which is no output,", variable.name),
            })?;
            write(position, rate);
        }
        Ok(())
    }
    fn last_step(&self) -> Status {
        self.last_step
    }
    fn time(&self) -> f64 {
        self.time
    }
}
