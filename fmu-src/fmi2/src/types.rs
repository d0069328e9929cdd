//! Types of the FMI 2.0 C interface (fmi2TypesPlatform.h, fmi2FunctionTypes.h), written by hand: the
//! interface has not changed since 2014 and a generated binding would need a C compiler's library.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// `fmi2Component`.
pub type Component = *mut c_void;
/// `fmi2FMUstate`.
pub type StateHandle = *mut c_void;
/// `fmi2ValueReference`.
pub type ValueReference = c_uint;
/// `fmi2String`.
pub type Text = *const c_char;
/// `fmi2Boolean`: 0 or 1.
pub type Boolean = c_int;

/// `fmi2CallbackLogger`: environment, instance name, status, category, printf format, its arguments.
pub type LoggerFunction = unsafe extern "C" fn(*mut c_void, Text, c_int, Text, Text, ...);

/// `fmi2CallbackFunctions`.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct CallbackFunctions {
    /// Receives messages; may be NULL.
    pub logger: Option<LoggerFunction>,
    /// Not used by this FMU.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used by this FMU.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used by this FMU: every step is synchronous.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, c_int)>,
    /// Handed through to the logger.
    pub environment: *mut c_void,
}

/// `fmi2EventInfo`.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default)]
pub struct EventInfo {
    /// Another call of `fmi2NewDiscreteStates` is needed.
    pub new_discrete_states_needed: Boolean,
    /// The simulation should end.
    pub terminate_simulation: Boolean,
    /// Nominal values of states have changed.
    pub nominals_of_continuous_states_changed: Boolean,
    /// States have jumped.
    pub values_of_continuous_states_changed: Boolean,
    /// The next time event is known.
    pub next_event_time_defined: Boolean,
    /// Its time in s.
    pub next_event_time: f64,
}

/// `fmi2ModelExchange` of `fmi2Type`.
pub const MODEL_EXCHANGE: c_int = 0;
/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: c_int = 1;
/// `fmi2DoStepStatus` of `fmi2StatusKind`.
pub const DO_STEP_STATUS: c_int = 0;
/// `fmi2PendingStatus` of `fmi2StatusKind`.
pub const PENDING_STATUS: c_int = 1;
/// `fmi2LastSuccessfulTime` of `fmi2StatusKind`.
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2Terminated` of `fmi2StatusKind`.
pub const TERMINATED: c_int = 3;
