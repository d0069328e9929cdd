//! The default backend: crate `fmi-rs`. Builds without libclang and reads every FMI 2.0 description.

use std::path::Path;
use std::ptr;
use std::sync::Arc;

use fmi_rs::fmi2::log::Logger;
use fmi_rs::fmi2::types::{fmi2FMUstate, fmi2Status, fmi2True};
use fmi_rs::fmi2::{CS, FMU2};

use super::description::ModelDescription;
use super::message_log::MessageLog;
use super::slave::Slave;
use super::status::Status;

impl Logger for MessageLog {
    fn log_call(&self, _: fmi2Status, _: &str) {}

    fn log_message(&self, _: fmi2Status, _: &str, message: &str) {
        self.push(message);
    }
}

pub(crate) struct FmiRsSlave {
    fmu: Arc<FMU2<CS>>,
    states: Vec<fmi2FMUstate>,
}

/// Loads the library (the system counts the loads, so only the first is slow) and instantiates.
pub(crate) fn instantiate(
    folder: &Path,
    description: &ModelDescription,
    name: &str,
    logging: bool,
    log: Arc<MessageLog>,
) -> Result<FmiRsSlave, String> {
    let memory_functions = !description
        .capabilities
        .can_not_use_memory_management_functions;
    let fmu = FMU2::<CS>::new(
        folder,
        &description.model_identifier,
        name,
        &description.guid,
        false,
        logging,
        false,
        log,
        memory_functions,
    )
    .map_err(|e| e.to_string())?;
    Ok(FmiRsSlave {
        fmu,
        states: Vec::new(),
    })
}

impl From<fmi2Status> for Status {
    #[inline]
    fn from(status: fmi2Status) -> Status {
        match status {
            fmi2Status::Ok => Status::Ok,
            fmi2Status::Warning => Status::Warning,
            fmi2Status::Discard => Status::Discard,
            fmi2Status::Error => Status::Error,
            fmi2Status::Fatal => Status::Fatal,
            fmi2Status::Pending => Status::Pending,
        }
    }
}

impl Slave for FmiRsSlave {
    fn set_real(&mut self, references: &[u32], values: &[f64]) -> Status {
        self.fmu.setReal(references, values).into()
    }

    fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Status {
        self.fmu.getReal(references, values).into()
    }

    fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Status {
        self.fmu.setInteger(references, values).into()
    }

    fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        self.fmu.getInteger(references, values).into()
    }

    fn set_boolean(&mut self, references: &[u32], values: &[i32]) -> Status {
        self.fmu.setBoolean(references, values).into()
    }

    fn get_boolean(&mut self, references: &[u32], values: &mut [i32]) -> Status {
        self.fmu.getBoolean(references, values).into()
    }

    fn set_string(&mut self, references: &[u32], values: &[&str]) -> Status {
        self.fmu.setString(references, values).into()
    }

    fn setup_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Status {
        self.fmu.setupExperiment(tolerance, start, stop).into()
    }

    fn enter_initialization(&mut self) -> Status {
        self.fmu.enterInitializationMode().into()
    }

    fn exit_initialization(&mut self) -> Status {
        self.fmu.exitInitializationMode().into()
    }

    fn do_step(&mut self, time: f64, step: f64) -> Status {
        self.fmu.doStep(time, step, fmi2True).into()
    }

    fn reset(&mut self) -> Status {
        self.fmu.reset().into()
    }

    fn terminate(&mut self) -> Status {
        self.fmu.terminate().into()
    }

    fn save_state(&mut self) -> Result<usize, Status> {
        let mut state = ptr::null_mut();
        match Status::from(self.fmu.getFMUstate(&mut state)) {
            status if status.is_done() && !state.is_null() => {
                self.states.push(state);
                Ok(self.states.len() - 1)
            }
            status => Err(status),
        }
    }

    fn overwrite_state(&mut self, slot: usize) -> Status {
        self.fmu.getFMUstate(&mut self.states[slot]).into()
    }

    fn restore_state(&mut self, slot: usize) -> Status {
        self.fmu.setFMUstate(self.states[slot]).into()
    }

    fn serialize_state(&mut self, slot: usize) -> Result<Vec<u8>, Status> {
        let mut size = 0;
        let status = Status::from(
            self.fmu
                .serializedFMUstateSize(self.states[slot], &mut size),
        );
        if !status.is_done() {
            return Err(status);
        }
        let mut bytes = vec![0; size];
        let status = Status::from(self.fmu.serializeFMUstate(self.states[slot], &mut bytes));
        if status.is_done() {
            Ok(bytes)
        } else {
            Err(status)
        }
    }

    fn deserialize_state(&mut self, bytes: &[u8]) -> Result<usize, Status> {
        let mut state = ptr::null_mut();
        match Status::from(self.fmu.deSerializeFMUstate(bytes, &mut state)) {
            status if status.is_done() && !state.is_null() => {
                self.states.push(state);
                Ok(self.states.len() - 1)
            }
            status => Err(status),
        }
    }
}

impl Drop for FmiRsSlave {
    /// The states belong to the component, so they go before it.
    fn drop(&mut self) {
        for state in &mut self.states {
            self.fmu.freeFMUstate(state);
        }
    }
}
