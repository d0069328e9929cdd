//! The second backend: crate `fmi` (feature `fmi-crate`, needs libclang to build). It runs the same tests with equal numbers.

use std::ffi::CString;

use fmi::fmi2::import::Fmi2Import;
use fmi::fmi2::instance::{CoSimulation, Common, FmuState, InstanceCS};
use fmi::fmi2::{Fmi2Error, Fmi2Res, Fmi2Status};
use fmi::traits::FmiStatus;

use super::slave::Slave;
use super::status::Status;

pub(crate) struct FmiCrateSlave {
    instance: InstanceCS,
    states: Vec<FmuState>,
}

/// Instantiates from an import that the caller keeps alive as long as the instance: its folder holds the resources.
pub(crate) fn instantiate(
    import: &Fmi2Import,
    name: &str,
    logging: bool,
) -> Result<FmiCrateSlave, String> {
    let instance = import
        .instantiate_cs(name, false, logging)
        .map_err(|e| e.to_string())?;
    Ok(FmiCrateSlave {
        instance,
        states: Vec::new(),
    })
}

fn status(result: Result<Fmi2Res, Fmi2Error>) -> Status {
    match result {
        Ok(Fmi2Res::OK) => Status::Ok,
        Ok(Fmi2Res::Warning) => Status::Warning,
        Ok(Fmi2Res::Pending) => Status::Pending,
        Err(error) => failure(&error),
    }
}

fn failure(error: &Fmi2Error) -> Status {
    match error {
        Fmi2Error::Discard => Status::Discard,
        Fmi2Error::Fatal => Status::Fatal,
        Fmi2Error::Error | Fmi2Error::TypesPlatformMismatch(_) => Status::Error,
    }
}

fn of(value: Fmi2Status) -> Status {
    status(value.ok())
}

impl FmiCrateSlave {
    fn keep(&mut self, state: Result<FmuState, Fmi2Error>) -> Result<usize, Status> {
        self.states.push(state.map_err(|e| failure(&e))?);
        Ok(self.states.len() - 1)
    }
}

impl Slave for FmiCrateSlave {
    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        status(self.instance.set_real(references, values))
    }

    fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Status {
        status(self.instance.get_real(references, values))
    }

    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status {
        status(self.instance.set_integer(references, values))
    }

    fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        status(self.instance.get_integer(references, values))
    }

    fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Status {
        status(self.instance.set_boolean(references, values))
    }

    fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        status(self.instance.get_boolean(references, values))
    }

    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Status {
        let Ok(values) = values
            .iter()
            .map(|v| CString::new(*v))
            .collect::<Result<Vec<_>, _>>()
        else {
            return Status::Error;
        };
        status(
            self.instance
                .set_string(references, &values)
                .map(|()| Fmi2Res::OK),
        )
    }

    fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Status {
        status(Common::setup_experiment(
            &mut self.instance,
            tolerance,
            start,
            stop,
        ))
    }

    fn enter_initialization(&mut self) -> Status {
        status(Common::enter_initialization_mode(&mut self.instance))
    }

    fn exit_initialization(&mut self) -> Status {
        status(Common::exit_initialization_mode(&mut self.instance))
    }

    fn do_step(&mut self, time: f64, step: f64) -> Status {
        status(self.instance.do_step(time, step, true))
    }

    fn reset(&mut self) -> Status {
        status(Common::reset(&mut self.instance))
    }

    fn terminate(&mut self) -> Status {
        status(Common::terminate(&mut self.instance))
    }

    fn save_state(&mut self) -> Result<usize, Status> {
        let state = self.instance.get_fmu_state();
        self.keep(state)
    }

    fn overwrite_state(&mut self, slot: usize) -> Status {
        of(self.instance.update_fmu_state(&self.states[slot]))
    }

    fn restore_state(&mut self, slot: usize) -> Status {
        of(self.instance.set_fmu_state(&self.states[slot]))
    }

    fn serialize_state(&mut self, slot: usize) -> Result<Vec<u8>, Status> {
        self.instance
            .serialize_fmu_state(&self.states[slot])
            .map_err(|e| failure(&e))
    }

    fn deserialize_state(&mut self, bytes: &[u8]) -> Result<usize, Status> {
        let state = self.instance.deserialize_fmu_state(bytes);
        self.keep(state)
    }
}
