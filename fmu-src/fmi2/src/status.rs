//! Status codes, and everything that can be wrong with a call.

use crate::lifecycle::{Function, Phase};
use beam_physics::error::PhysicsError;
use std::ffi::c_int;

/// `fmi2Status`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Done, with a remark.
    Warning = 1,
    /// Not done in full.
    Discard = 2,
    /// Refused; the instance is as it was before the call.
    Error = 3,
    /// The instance is unusable.
    Fatal = 4,
}

impl Status {
    /// The value that crosses the C interface.
    pub fn code(self) -> c_int {
        self as c_int
    }

    /// Log category of messages with this status (FMI 2.0.5, section 2.2.4).
    pub fn category(self) -> &'static std::ffi::CStr {
        match self {
            Self::Ok => c"logEvents",
            Self::Warning => c"logStatusWarning",
            Self::Discard => c"logStatusDiscard",
            Self::Error => c"logStatusError",
            Self::Fatal => c"logStatusFatal",
        }
    }
}

/// Why a call was refused or failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The function must not be called in this phase.
    #[error("{function} must not be called in the phase '{phase}'; allowed: {allowed}")]
    IllegalCall {
        /// Function called.
        function: Function,
        /// Phase of the instance.
        phase: Phase,
        /// Phases in which the call is legal.
        allowed: String,
    },
    /// A pointer argument is NULL.
    #[error("{function}: argument '{argument}' is NULL; pass a valid pointer")]
    NullArgument {
        /// Function called.
        function: Function,
        /// Name of the argument in the standard.
        argument: &'static str,
    },
    /// No variable has this value reference.
    #[error(
        "no variable has the value reference {reference}; use the value references of modelDescription.xml"
    )]
    UnknownReference {
        /// The value reference.
        reference: u32,
    },
    /// The variable has another data type.
    #[error("variable '{name}' is of type {actual}: it can't be accessed as {asked}")]
    WrongType {
        /// Name of the variable.
        name: &'static str,
        /// Its type.
        actual: &'static str,
        /// The type of the function called.
        asked: &'static str,
    },
    /// The variable can't be set in this phase, or never.
    #[error("variable '{name}' can't be set in the phase '{phase}': it is {reason}")]
    NotSettable {
        /// Name of the variable.
        name: &'static str,
        /// Phase of the instance.
        phase: Phase,
        /// Why.
        reason: &'static str,
    },
    /// A value that a variable must not have.
    #[error("{name} = {value} {unit} is not allowed: it must be {required}")]
    BadValue {
        /// Name of the variable.
        name: &'static str,
        /// The value.
        value: f64,
        /// Unit of the variable.
        unit: &'static str,
        /// The condition in words.
        required: String,
    },
    /// An argument that is not a variable is out of range.
    #[error("{function}: {argument} = {value} {unit} is not allowed: it must be {required}")]
    BadArgument {
        /// Function called.
        function: Function,
        /// Name of the argument in the standard.
        argument: &'static str,
        /// The value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// The condition in words.
        required: String,
    },
    /// The FMU does not offer this function or this choice.
    #[error("{function}: {what} is not supported by this FMU")]
    Unsupported {
        /// Function called.
        function: Function,
        /// What was asked for.
        what: String,
    },
    /// A state that can't be restored.
    #[error("the FMU state can't be restored: {problem}; nothing was changed")]
    BrokenState {
        /// What is wrong with it.
        problem: String,
    },
    /// Unknown log category.
    #[error("log category '{category}' is unknown; use those of modelDescription.xml")]
    UnknownCategory {
        /// The category asked for.
        category: String,
    },
    /// The equations can't be set up with these values, or can't be integrated.
    #[error(transparent)]
    Physics(#[from] PhysicsError),
    /// A step was not carried out in full.
    #[error("step stopped at t = {time} s: {cause}")]
    StepStopped {
        /// Last time reached in s.
        time: f64,
        /// Why.
        cause: PhysicsError,
    },
    /// The equations can't be evaluated at the instant that the master's integrator asks for.
    #[error("can't be evaluated at t = {time} s with the states set: {cause}")]
    NotEvaluable {
        /// Time in s.
        time: f64,
        /// Why.
        cause: PhysicsError,
    },
    /// The states that the master's integrator has set have run away, and its step explains it.
    #[error(
        "the integrator has diverged at t = {time} s: its last step, {step:.3e} s, is too long for this model, whose fastest rate is {fastest:.4e} 1/s ({:.4e} Hz); the explicit Euler method is sure to be stable only with steps below {limit:.2e} s; use an integrator with step control such as CVode, or co-simulation",
        fastest / std::f64::consts::TAU
    )]
    StepTooLong {
        /// Time in s.
        time: f64,
        /// The last step in s.
        step: f64,
        /// Largest eigenvalue of the model at rest, by magnitude, in 1/s.
        fastest: f64,
        /// Largest step in s at which the explicit Euler method is stable.
        limit: f64,
    },
    /// A motion can't be followed with its derivatives.
    #[error("can't be followed with derivatives from t = {time} s: {cause}")]
    NotFollowed {
        /// Start of the motion in s.
        time: f64,
        /// Why.
        cause: beam_tangent::error::PhysicsError,
    },
    /// An array of the wrong length.
    #[error(
        "{function}: {argument} = {count}, but this FMU has {expected}; use that of modelDescription.xml"
    )]
    WrongCount {
        /// Function called.
        function: Function,
        /// Name of the argument in the standard.
        argument: &'static str,
        /// The number given.
        count: usize,
        /// The right one.
        expected: usize,
    },
    /// A mistake in this program.
    #[error("internal failure: {message}; the instance is unusable, free it")]
    Panic {
        /// Message of the panic.
        message: String,
    },
}

impl Fault {
    /// Status that the call returns.
    pub fn status(&self) -> Status {
        match self {
            Self::StepStopped {
                cause: PhysicsError::Stalled { .. },
                ..
            }
            | Self::NotEvaluable { .. }
            | Self::StepTooLong { .. }
            | Self::NotFollowed { .. } => Status::Discard,
            Self::Panic { .. } => Status::Fatal,
            _ => Status::Error,
        }
    }
}
