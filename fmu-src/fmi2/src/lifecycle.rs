//! Which call is legal when: one table, after the state machines of FMI 2.0.5, sections 3.2.3 (model
//! exchange) and 4.2.4 (co-simulation). Each entry names the section that defines its functions. An instance is in phases of its own interface only.

use std::fmt;

/// Phase of an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Phase {
    /// After `fmi2Instantiate` or `fmi2Reset`.
    Instantiated = 0,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    Initialization = 1,
    /// Ready for a step ("slaveInitialized", "stepComplete").
    StepComplete = 2,
    /// A step was not carried out in full ("stepFailed").
    StepFailed = 3,
    /// After `fmi2Terminate`.
    Terminated = 4,
    /// A step failed and can't be taken up again ("error").
    Error = 5,
    /// A mistake in this program was caught; the instance can only be freed ("fatal").
    Fatal = 6,
    /// Model exchange: at an event ("event mode").
    EventMode = 7,
    /// Model exchange: the master integrates ("continuous-time mode").
    ContinuousTime = 8,
}

impl Phase {
    /// The phase with a number, for restoring states.
    pub fn from_number(number: u8) -> Option<Self> {
        [
            Self::Instantiated,
            Self::Initialization,
            Self::StepComplete,
            Self::StepFailed,
            Self::Terminated,
            Self::Error,
            Self::EventMode,
            Self::ContinuousTime,
        ]
        .into_iter()
        .find(|phase| *phase as u8 == number)
    }
}

impl fmt::Display for Phase {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Instantiated => "instantiated",
            Self::Initialization => "initialization mode",
            Self::StepComplete => "step complete",
            Self::StepFailed => "step failed",
            Self::Terminated => "terminated",
            Self::Error => "error",
            Self::Fatal => "fatal",
            Self::EventMode => "event mode",
            Self::ContinuousTime => "continuous-time mode",
        })
    }
}

/// A function of the interface that acts on an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Function {
    SetDebugLogging,
    SetupExperiment,
    EnterInitializationMode,
    ExitInitializationMode,
    Terminate,
    Reset,
    GetReal,
    GetInteger,
    GetBoolean,
    GetString,
    SetReal,
    SetInteger,
    SetBoolean,
    SetString,
    GetFmuState,
    SetFmuState,
    FreeFmuState,
    SerializedFmuStateSize,
    SerializeFmuState,
    DeSerializeFmuState,
    GetDirectionalDerivative,
    SetRealInputDerivatives,
    GetRealOutputDerivatives,
    DoStep,
    CancelStep,
    GetStatus,
    GetRealStatus,
    GetIntegerStatus,
    GetBooleanStatus,
    GetStringStatus,
    EnterEventMode,
    NewDiscreteStates,
    EnterContinuousTimeMode,
    CompletedIntegratorStep,
    SetTime,
    SetContinuousStates,
    GetDerivatives,
    GetEventIndicators,
    GetContinuousStates,
    GetNominalsOfContinuousStates,
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::GetFmuState => f.write_str("fmi2GetFMUstate"),
            Self::SetFmuState => f.write_str("fmi2SetFMUstate"),
            Self::FreeFmuState => f.write_str("fmi2FreeFMUstate"),
            Self::SerializedFmuStateSize => f.write_str("fmi2SerializedFMUstateSize"),
            Self::SerializeFmuState => f.write_str("fmi2SerializeFMUstate"),
            Self::DeSerializeFmuState => f.write_str("fmi2DeSerializeFMUstate"),
            other => write!(f, "fmi2{other:?}"),
        }
    }
}

use Phase::{
    ContinuousTime, Error, EventMode, Initialization, Instantiated, StepComplete, StepFailed,
    Terminated,
};

/// Every phase but the fatal one.
const ANY: &[Phase] = &[
    Instantiated,
    Initialization,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
    EventMode,
    ContinuousTime,
];
/// Phases in which results can be read (2.1.7, 3.2.3, 4.2.4).
const READ: &[Phase] = &[
    Initialization,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
    EventMode,
    ContinuousTime,
];
/// Phases in which Real variables can be set (2.1.7, 3.2.3, 4.2.4); which variables, see `values`.
const WRITE: &[Phase] = &[
    Instantiated,
    Initialization,
    StepComplete,
    EventMode,
    ContinuousTime,
];
/// The same for other types, which change at events only.
const WRITE_DISCRETE: &[Phase] = &[Instantiated, Initialization, StepComplete, EventMode];
/// Phases in which steps are answered for (4.2.4).
const STEPPED: &[Phase] = &[StepComplete, StepFailed, Terminated, Error];

/// The interface for which an instance was made (`fmi2Type`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Interface {
    /// The master integrates.
    ModelExchange = 0,
    /// The FMU integrates.
    CoSimulation = 1,
}

impl Interface {
    /// The interface with the number of the standard.
    pub fn from_number(number: i32) -> Option<Self> {
        [Self::ModelExchange, Self::CoSimulation]
            .into_iter()
            .find(|kind| *kind as i32 == number)
    }
}

impl fmt::Display for Interface {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::ModelExchange => "model exchange",
            Self::CoSimulation => "co-simulation",
        })
    }
}

impl Function {
    /// The interface to which the function belongs; `None` for common ones (2.1, 3.2, 4.2).
    pub fn interface(self) -> Option<Interface> {
        match self {
            Self::EnterEventMode
            | Self::NewDiscreteStates
            | Self::EnterContinuousTimeMode
            | Self::CompletedIntegratorStep
            | Self::SetTime
            | Self::SetContinuousStates
            | Self::GetDerivatives
            | Self::GetEventIndicators
            | Self::GetContinuousStates
            | Self::GetNominalsOfContinuousStates => Some(Interface::ModelExchange),
            Self::SetRealInputDerivatives
            | Self::GetRealOutputDerivatives
            | Self::DoStep
            | Self::CancelStep
            | Self::GetStatus
            | Self::GetRealStatus
            | Self::GetIntegerStatus
            | Self::GetBooleanStatus
            | Self::GetStringStatus => Some(Interface::CoSimulation),
            _ => None,
        }
    }

    /// Phases in which the call is legal.
    pub fn legal_phases(self) -> &'static [Phase] {
        match self {
            // 2.1.5 (logging), 2.1.6 (reset): in every phase.
            Self::SetDebugLogging | Self::Reset => ANY,
            // 2.1.6: once, before initialization mode.
            Self::SetupExperiment | Self::EnterInitializationMode => &[Instantiated],
            Self::ExitInitializationMode => &[Initialization],
            // 2.1.6: ends a run that has begun.
            Self::Terminate => &[StepComplete, StepFailed, EventMode, ContinuousTime],
            // 2.1.7
            Self::GetReal | Self::GetInteger | Self::GetBoolean | Self::GetString => READ,
            Self::SetReal => WRITE,
            Self::SetInteger | Self::SetBoolean | Self::SetString => WRITE_DISCRETE,
            // 2.1.8: in every phase; a state also takes an instance out of "error".
            Self::GetFmuState
            | Self::SetFmuState
            | Self::FreeFmuState
            | Self::SerializedFmuStateSize
            | Self::SerializeFmuState
            | Self::DeSerializeFmuState => ANY,
            // 2.1.9
            Self::GetDirectionalDerivative => READ,
            // 4.2.1
            Self::SetRealInputDerivatives => &[Instantiated, Initialization, StepComplete],
            Self::GetRealOutputDerivatives => STEPPED,
            // 4.2.2; steps are synchronous, so there is never one to cancel.
            Self::DoStep => &[StepComplete],
            Self::CancelStep => &[],
            // 4.2.3
            Self::GetStatus
            | Self::GetRealStatus
            | Self::GetIntegerStatus
            | Self::GetBooleanStatus
            | Self::GetStringStatus => STEPPED,
            // 3.2.2
            Self::EnterEventMode => &[EventMode, ContinuousTime],
            Self::NewDiscreteStates | Self::EnterContinuousTimeMode => &[EventMode],
            Self::CompletedIntegratorStep => &[ContinuousTime],
            // 3.2.1
            Self::SetTime => &[EventMode, ContinuousTime],
            Self::SetContinuousStates => &[ContinuousTime],
            // 3.2.2
            Self::GetDerivatives => &[EventMode, ContinuousTime, Terminated, Error],
            Self::GetEventIndicators | Self::GetContinuousStates => {
                &[Initialization, EventMode, ContinuousTime, Terminated, Error]
            }
            Self::GetNominalsOfContinuousStates => &[
                Instantiated,
                Initialization,
                EventMode,
                ContinuousTime,
                Terminated,
                Error,
            ],
        }
    }
}
