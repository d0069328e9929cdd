//! What a model must be able to do to stand behind the C interface.

use crate::experiment::Experiment;
use crate::instance::Content;
use crate::lifecycle::{Function, Interface, Phase};
use crate::status::{Fault, Status};
use crate::tangent::{Answer, Request};
use crate::types::EventInfo;
use crate::values::Access;
use std::any::Any;

/// A state that `fmi2GetFMUstate` has copied; each model knows its own type.
pub type SavedState = Box<dyn Any>;
/// What a function of model exchange or of directional derivatives answers where a model lacks it.
fn lacks<T>(function: Function) -> Result<T, Fault> {
    Err(Fault::Unsupported {
        function,
        what: "this function".into(),
    })
}

/// A model, one instance of it. Every method is called in phases only in which its function is legal.
#[allow(clippy::missing_errors_doc)]
pub trait Model {
    /// Interface for which the instance was made.
    fn interface(&self) -> Interface;
    /// Phase of the calling sequence.
    fn phase(&self) -> Phase;
    /// Enters a phase.
    fn set_phase(&mut self, phase: Phase);

    /// `fmi2SetupExperiment`.
    fn setup_experiment(&mut self, experiment: Experiment) -> Result<(), Fault>;
    /// `fmi2EnterInitializationMode`.
    fn enter_initialization(&mut self);
    /// `fmi2ExitInitializationMode`.
    fn exit_initialization(&mut self) -> Result<(), Fault>;
    /// `fmi2Reset`.
    fn reset(&mut self);

    /// Reads variables into `write(position, value)`.
    fn get(
        &mut self,
        references: &[u32],
        access: Access,
        write: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault>;
    /// Sets variables to the values that `read(position)` gives: all of them, or none.
    fn set(
        &mut self,
        references: &[u32],
        access: Access,
        read: &dyn Fn(usize) -> f64,
    ) -> Result<(), Fault>;
    /// `fmi2GetDirectionalDerivative`.
    fn directional(
        &mut self,
        _unknowns: &[u32],
        _knowns: &[u32],
        _seed: &[f64],
        _write: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault> {
        lacks(Function::GetDirectionalDerivative)
    }

    /// What parameter studies evaluate, where the model is one that they are made for.
    fn content(&self) -> Option<&Content> {
        None
    }

    /// A motion with its derivatives, where the model offers that.
    fn tangents(&mut self, _request: &Request, _answer: Answer) -> Result<(), Fault> {
        Err(Fault::Unsupported {
            function: Function::SetReal,
            what: "a motion with its derivatives".into(),
        })
    }

    /// A copy of the state, in the memory of `old` where that is one of this model's.
    fn save(&self, old: Option<SavedState>) -> SavedState;
    /// Takes a copy over.
    fn restore(&mut self, state: &dyn Any) -> Result<(), Fault>;
    /// Bytes of a copy.
    fn serialize(&self, state: &dyn Any) -> Result<Vec<u8>, Fault>;
    /// The copy in `bytes`.
    fn deserialize(&self, bytes: &[u8]) -> Result<SavedState, Fault>;

    /// `fmi2DoStep` from `point` in s over `step` in s.
    fn do_step(&mut self, point: f64, step: f64) -> Result<(), Fault>;
    /// `fmi2SetRealInputDerivatives`.
    fn set_input_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        rates: &[f64],
    ) -> Result<(), Fault>;
    /// `fmi2GetRealOutputDerivatives`.
    fn output_rates(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: &mut dyn FnMut(usize, f64),
    ) -> Result<(), Fault>;
    /// Status of the last step.
    fn last_step(&self) -> Status;
    /// The present communication point in s.
    fn time(&self) -> f64;

    /// `fmi2SetTime`, in s.
    fn set_time(&mut self, _time: f64) -> Result<(), Fault> {
        lacks(Function::SetTime)
    }
    /// `fmi2SetContinuousStates`.
    fn set_states(&mut self, _states: &[f64]) -> Result<(), Fault> {
        lacks(Function::SetContinuousStates)
    }
    /// `fmi2GetContinuousStates`.
    fn get_states(&mut self, _states: &mut [f64]) -> Result<(), Fault> {
        lacks(Function::GetContinuousStates)
    }
    /// `fmi2GetNominalsOfContinuousStates`.
    fn get_nominals(&mut self, _nominals: &mut [f64]) -> Result<(), Fault> {
        lacks(Function::GetNominalsOfContinuousStates)
    }
    /// `fmi2GetDerivatives`.
    fn get_derivatives(&mut self, _rates: &mut [f64]) -> Result<(), Fault> {
        lacks(Function::GetDerivatives)
    }
    /// `fmi2GetEventIndicators`.
    fn get_indicators(&mut self, _indicators: &mut [f64]) -> Result<(), Fault> {
        lacks(Function::GetEventIndicators)
    }
    /// `fmi2NewDiscreteStates`.
    fn new_discrete_states(&mut self) -> Result<EventInfo, Fault> {
        lacks(Function::NewDiscreteStates)
    }
}

/// A copy as the type of the model that is asked to take it.
///
/// # Errors
/// [`Fault::BrokenState`] for a copy of the other model of this binary.
pub fn own<T: 'static>(state: &dyn Any) -> Result<&T, Fault> {
    state.downcast_ref().ok_or_else(|| Fault::BrokenState {
        problem: "it belongs to another model".into(),
    })
}

/// A copy in the memory of an old one where that is of the same type.
pub fn copied<T: Clone + 'static>(content: &T, old: Option<SavedState>) -> SavedState {
    match old.map(SavedState::downcast::<T>) {
        Some(Ok(mut own)) => {
            (*own).clone_from(content);
            own
        }
        _ => Box::new(content.clone()),
    }
}
