//! One live instance of an FMU.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::description::{Kind, ModelDescription, Variable};
use super::message_log::MessageLog;
use super::slave::Slave;
use super::status::Status;
use super::{Fmu, Loaded};
use crate::error::Error;

/// An instance, used by the thread that made it. Get and set take slices by value reference and allocate nothing.
///
/// ```text
/// instantiate -> set_* -> initialize -> { set_* inputs, do_step, get_* }* -> reset -> ...
/// ```
pub struct Instance {
    // Declared before `loaded`, so that the FMU is freed before its folder goes.
    slave: Box<dyn Slave>,
    loaded: Arc<Loaded>,
    log: Arc<MessageLog>,
    name: String,
    id: u64,
    released: Vec<usize>,
}

/// A saved state of one [`Instance`]. It keeps its memory until it is released or its instance goes.
#[derive(Debug)]
pub struct State {
    instance: u64,
    slot: usize,
}

static NEXT_ID: AtomicU64 = AtomicU64::new(0);

impl Instance {
    pub(super) fn new(
        fmu: &Fmu,
        slave: Box<dyn Slave>,
        log: Arc<MessageLog>,
        name: &str,
    ) -> Instance {
        let id = NEXT_ID.fetch_add(1, Ordering::Relaxed);
        Instance {
            slave,
            loaded: fmu.loaded.clone(),
            log,
            name: name.to_owned(),
            id,
            released: Vec::new(),
        }
    }

    /// The FMU's description.
    pub fn description(&self) -> &ModelDescription {
        &self.loaded.description
    }

    #[inline]
    fn check(&self, call: &'static str, status: Status) -> Result<(), Error> {
        if status.is_done() {
            Ok(())
        } else {
            Err(self.failure(call, status))
        }
    }

    #[cold]
    fn failure(&self, call: &'static str, status: Status) -> Error {
        Error::FmiCall {
            call,
            instance: self.name.clone(),
            status: status.name(),
            messages: self.log.take(),
        }
    }

    /// `fmi2SetReal`. Panics if the lengths differ.
    #[inline]
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "one value per reference");
        let status = self.slave.set_real(references, values);
        self.check("fmi2SetReal", status)
    }

    /// `fmi2GetReal`. Panics if the lengths differ.
    #[inline]
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "one value per reference");
        let status = self.slave.get_real(references, values);
        self.check("fmi2GetReal", status)
    }

    /// `fmi2SetInteger`, also for enumerations. Panics if the lengths differ.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "one value per reference");
        let status = self.slave.set_integer(references, values);
        self.check("fmi2SetInteger", status)
    }

    /// `fmi2GetInteger`, also for enumerations. Panics if the lengths differ.
    #[inline]
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "one value per reference");
        let status = self.slave.get_integer(references, values);
        self.check("fmi2GetInteger", status)
    }

    /// `fmi2SetBoolean`, 0 is false. Panics if the lengths differ.
    pub fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "one value per reference");
        let status = self.slave.set_boolean(references, values);
        self.check("fmi2SetBoolean", status)
    }

    /// `fmi2GetBoolean`, 0 is false. Panics if the lengths differ.
    pub fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "one value per reference");
        let status = self.slave.get_boolean(references, values);
        self.check("fmi2GetBoolean", status)
    }

    /// `fmi2SetString`. Panics if the lengths differ.
    pub fn set_string(&mut self, references: &[u32], values: &[&str]) -> Result<(), Error> {
        assert_eq!(references.len(), values.len(), "one value per reference");
        let status = self.slave.set_string(references, values);
        self.check("fmi2SetString", status)
    }

    /// `fmi2SetRealInputDerivatives` of order 1, per s, for the next step; of an instance made by
    /// [`Fmu::instantiate_driven`]. Panics if the lengths differ.
    pub fn set_input_rates(&mut self, references: &[u32], rates: &[f64]) -> Result<(), Error> {
        assert_eq!(references.len(), rates.len(), "one rate per reference");
        let status = self.slave.set_input_rates(references, rates);
        self.check("fmi2SetRealInputDerivatives", status)
    }

    /// Sets any variable but a string from a number: integers and enumerations must be whole, booleans 0 or 1.
    pub fn set_number(&mut self, variable: &Variable, value: f64) -> Result<(), Error> {
        let refuse = |kind, rule| Error::VariableValue {
            name: variable.name.clone(),
            kind,
            value: value.to_string(),
            rule,
        };
        let whole = value.fract() == 0.0 && value.abs() <= f64::from(i32::MAX);
        match variable.kind {
            Kind::Real => self.set_real(&[variable.reference], &[value]),
            Kind::Integer | Kind::Enumeration if whole => {
                self.set_integer(&[variable.reference], &[value as i32])
            }
            Kind::Integer | Kind::Enumeration => Err(refuse("an integer", "give a whole number")),
            Kind::Boolean if value == 0.0 || value == 1.0 => {
                self.set_boolean(&[variable.reference], &[value as i32])
            }
            Kind::Boolean => Err(refuse("a boolean", "give 0 or 1")),
            Kind::String => Err(refuse("a text", "leave it at its start value")),
        }
    }

    /// `fmi2SetupExperiment`; times in s, relative tolerance.
    pub fn setup_experiment(
        &mut self,
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    ) -> Result<(), Error> {
        let status = self.slave.setup_experiment(tolerance, start, stop);
        self.check("fmi2SetupExperiment", status)
    }

    /// `fmi2EnterInitializationMode`.
    pub fn enter_initialization(&mut self) -> Result<(), Error> {
        let status = self.slave.enter_initialization();
        self.check("fmi2EnterInitializationMode", status)
    }

    /// `fmi2ExitInitializationMode`.
    pub fn exit_initialization(&mut self) -> Result<(), Error> {
        let status = self.slave.exit_initialization();
        self.check("fmi2ExitInitializationMode", status)
    }

    /// Setup, enter and exit in one; times in s.
    pub fn initialize(
        &mut self,
        start: f64,
        stop: Option<f64>,
        tolerance: Option<f64>,
    ) -> Result<(), Error> {
        self.setup_experiment(start, stop, tolerance)?;
        self.enter_initialization()?;
        self.exit_initialization()
    }

    /// `fmi2DoStep` from `time` by `step`, in s.
    #[inline]
    pub fn do_step(&mut self, time: f64, step: f64) -> Result<(), Error> {
        let status = self.slave.do_step(time, step);
        self.check("fmi2DoStep", status)
    }

    /// `fmi2Reset`: as new, also after an error.
    pub fn reset(&mut self) -> Result<(), Error> {
        let status = self.slave.reset();
        self.check("fmi2Reset", status)
    }

    /// `fmi2Terminate`.
    pub fn terminate(&mut self) -> Result<(), Error> {
        let status = self.slave.terminate();
        self.check("fmi2Terminate", status)
    }

    /// `fmi2GetFMUstate`, into a released slot if there is one.
    pub fn save_state(&mut self) -> Result<State, Error> {
        let slot = match self.released.pop() {
            Some(slot) => {
                let status = self.slave.overwrite_state(slot);
                self.check("fmi2GetFMUstate", status)?;
                slot
            }
            None => self
                .slave
                .save_state()
                .map_err(|s| self.failure("fmi2GetFMUstate", s))?,
        };
        Ok(State {
            instance: self.id,
            slot,
        })
    }

    /// `fmi2GetFMUstate` into a state that exists.
    pub fn overwrite_state(&mut self, state: &State) -> Result<(), Error> {
        self.own(state)?;
        let status = self.slave.overwrite_state(state.slot);
        self.check("fmi2GetFMUstate", status)
    }

    /// `fmi2SetFMUstate`.
    pub fn restore_state(&mut self, state: &State) -> Result<(), Error> {
        self.own(state)?;
        let status = self.slave.restore_state(state.slot);
        self.check("fmi2SetFMUstate", status)
    }

    /// Gives the state's memory back for the next [`Instance::save_state`].
    pub fn release_state(&mut self, state: State) -> Result<(), Error> {
        self.own(&state)?;
        self.released.push(state.slot);
        Ok(())
    }

    /// `fmi2SerializeFMUstate`.
    pub fn serialize_state(&mut self, state: &State) -> Result<Vec<u8>, Error> {
        self.own(state)?;
        self.slave
            .serialize_state(state.slot)
            .map_err(|s| self.failure("fmi2SerializeFMUstate", s))
    }

    /// `fmi2DeSerializeFMUstate`: a state that any instance of the same FMU serialised.
    pub fn deserialize_state(&mut self, bytes: &[u8]) -> Result<State, Error> {
        let slot = self
            .slave
            .deserialize_state(bytes)
            .map_err(|s| self.failure("fmi2DeSerializeFMUstate", s))?;
        Ok(State {
            instance: self.id,
            slot,
        })
    }

    fn own(&self, state: &State) -> Result<(), Error> {
        if state.instance == self.id {
            Ok(())
        } else {
            Err(Error::ForeignState {
                instance: self.name.clone(),
            })
        }
    }
}
