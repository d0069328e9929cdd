//! What can be wrong with a model or a run, said with value, unit, place and remedy.

/// Errors of the beam physics.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PhysicsError {
    /// A quantity lies outside the range in which the equations hold.
    #[error(
        "{name} = {value} {unit} is not allowed: it must be {required}; set {name} accordingly"
    )]
    OutOfRange {
        /// Name of the quantity as the user knows it.
        name: String,
        /// The offending value.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// The condition in words.
        required: &'static str,
    },
    /// The number of modes is not supported.
    #[error(
        "{count} modes asked for: a model needs 1 to {max} modes; set mode_count in that range"
    )]
    ModeCount {
        /// The number asked for.
        count: usize,
        /// The largest number supported.
        max: usize,
    },
    /// Too many states.
    #[error("{count} states; at most {max} are possible: leave out modes or effects")]
    StateCount {
        /// The number asked for.
        count: usize,
        /// The largest number supported.
        max: usize,
    },
    /// A tabulated friction law is unusable.
    #[error(
        "friction table, row {row}: {problem}; give at least 2 rows with rising velocities (m/s) and coefficients >= 0"
    )]
    Table {
        /// Row, counted from 1.
        row: usize,
        /// What is wrong with it.
        problem: String,
    },
    /// No effect of that name.
    #[error("no parameter '{name}' in the catalogue of effects; `stickslip effects` lists them")]
    UnknownParameter {
        /// The name asked for.
        name: String,
    },
    /// The state or a rate became infinite or not a number.
    #[error(
        "the motion is no longer finite at t = {time} s; a parameter is extreme: check the effects' strengths"
    )]
    NotFinite {
        /// Time of the failure in s.
        time: f64,
    },
    /// The integrator can't go on.
    #[error(
        "no progress at t = {time} s: {transitions} transitions or steps of {step} s within one advance; loosen tolerance or check the parameters"
    )]
    Stalled {
        /// Time of the failure in s.
        time: f64,
        /// Last step in s.
        step: f64,
        /// Transitions counted in this advance.
        transitions: u64,
    },
    /// A user-defined effect can't be read or evaluated.
    #[error("user effect '{name}': {problem}; correct the expression")]
    Expression {
        /// Name of the effect.
        name: String,
        /// What is wrong.
        problem: String,
    },
}

pub(crate) fn require(
    ok: bool,
    name: &str,
    value: impl Into<f64>,
    unit: &'static str,
    required: &'static str,
) -> Result<(), PhysicsError> {
    let value = value.into();
    if ok && value.is_finite() {
        Ok(())
    } else {
        Err(PhysicsError::OutOfRange {
            name: name.to_owned(),
            value,
            unit,
            required,
        })
    }
}
