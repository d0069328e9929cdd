//! What a handle of the master's refers to: a model, and the way to the master's logger.

use crate::lifecycle::Function;
use crate::log::Log;
use crate::model::Model;
use crate::status::Fault;

/// An instance.
pub struct Slave {
    /// Messages to the master.
    pub log: Log,
    /// The model.
    pub model: Box<dyn Model>,
}

impl Slave {
    /// Refuses a call that is not legal in the present phase.
    ///
    /// # Errors
    /// [`Fault::IllegalCall`].
    #[inline]
    pub fn admit(&self, function: Function) -> Result<(), Fault> {
        let legal = function.legal_phases();
        let (own, phase) = (self.model.interface(), self.model.phase());
        let belongs = function.interface().is_none_or(|needed| needed == own);
        if legal.contains(&phase) && belongs {
            return Ok(());
        }
        if !belongs {
            return Err(Fault::Unsupported {
                function,
                what: format!("a call to an instance made for {own}"),
            });
        }
        let allowed: Vec<_> = legal.iter().map(ToString::to_string).collect();
        Err(Fault::IllegalCall {
            function,
            phase,
            allowed: if allowed.is_empty() {
                "never".into()
            } else {
                allowed.join(", ")
            },
        })
    }
}
