//! FMI 2.0 status codes, the same for both backends.

/// What an FMI function returned (FMI 2.0.5, section 2.1.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// All well.
    Ok,
    /// Done, with a message.
    Warning,
    /// Not done, the step may be tried differently.
    Discard,
    /// Not done, this instance must be reset.
    Error,
    /// All instances are lost.
    Fatal,
    /// Asynchronous work has started; the harness never asks for it.
    Pending,
}

impl Status {
    /// Whether the call did what it should.
    #[inline]
    pub fn is_done(self) -> bool {
        matches!(self, Status::Ok | Status::Warning)
    }

    /// The standard's name.
    pub fn name(self) -> &'static str {
        match self {
            Status::Ok => "fmi2OK",
            Status::Warning => "fmi2Warning",
            Status::Discard => "fmi2Discard",
            Status::Error => "fmi2Error",
            Status::Fatal => "fmi2Fatal",
            Status::Pending => "fmi2Pending",
        }
    }
}
