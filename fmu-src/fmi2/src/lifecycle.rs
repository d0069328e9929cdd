//! Which call is legal when: one table, after FMI 2.0.5, section 4.2.4 (state machine of calling
//! sequence, table of allowed calls in co-simulation).

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

use Phase::{Error, Initialization, Instantiated, StepComplete, StepFailed, Terminated};

/// Every phase but the fatal one.
const ANY: &[Phase] = &[
    Instantiated,
    Initialization,
    StepComplete,
    StepFailed,
    Terminated,
    Error,
];
/// Phases in which results can be read (2.1.7, 4.2.4).
const READ: &[Phase] = &[Initialization, StepComplete, StepFailed, Terminated, Error];
/// Phases in which values can be set (2.1.7, 4.2.4); which variables, see `values`.
const WRITE: &[Phase] = &[Instantiated, Initialization, StepComplete];

impl Function {
    /// Phases in which the call is legal.
    pub fn legal_phases(self) -> &'static [Phase] {
        match self {
            // 2.1.5, 2.1.6: in every phase.
            Self::SetDebugLogging | Self::Reset => ANY,
            // 2.1.6: once, before initialization mode.
            Self::SetupExperiment | Self::EnterInitializationMode => &[Instantiated],
            Self::ExitInitializationMode => &[Initialization],
            // 2.1.6: ends a run that has begun.
            Self::Terminate => &[StepComplete, StepFailed],
            // 2.1.7
            Self::GetReal | Self::GetInteger | Self::GetBoolean | Self::GetString => READ,
            Self::SetReal | Self::SetInteger | Self::SetBoolean | Self::SetString => WRITE,
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
            Self::SetRealInputDerivatives => WRITE,
            Self::GetRealOutputDerivatives => &[StepComplete, StepFailed, Terminated, Error],
            // 4.2.2; steps are synchronous, so there is never one to cancel.
            Self::DoStep => &[StepComplete],
            Self::CancelStep => &[],
            // 4.2.3
            Self::GetStatus
            | Self::GetRealStatus
            | Self::GetIntegerStatus
            | Self::GetBooleanStatus
            | Self::GetStringStatus => &[StepComplete, StepFailed, Terminated, Error],
        }
    }
}
