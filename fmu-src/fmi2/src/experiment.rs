//! What `fmi2SetupExperiment` fixes, and the checks of times and steps that all models share.

use crate::lifecycle::Function;
use crate::status::Fault;

/// What `fmi2SetupExperiment` fixes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Experiment {
    /// Start time in s.
    pub start: f64,
    /// Stop time in s, if any.
    pub stop: Option<f64>,
    /// Relative tolerance that the master asks for, if any.
    pub tolerance: Option<f64>,
}

impl Experiment {
    /// Checks times and tolerance.
    ///
    /// # Errors
    /// Times or a tolerance that make no sense.
    pub fn check(&self) -> Result<(), Fault> {
        let bad = |argument, value, unit, required: &str| Fault::BadArgument {
            function: Function::SetupExperiment,
            argument,
            value,
            unit,
            required: required.into(),
        };
        if !self.start.is_finite() {
            return Err(bad("startTime", self.start, "s", "finite"));
        }
        if let Some(stop) = self.stop
            && !(stop.is_finite() && stop >= self.start)
        {
            return Err(bad(
                "stopTime",
                stop,
                "s",
                "finite and not before startTime",
            ));
        }
        if let Some(tolerance) = self.tolerance
            && !(tolerance.is_finite() && tolerance > 0.0)
        {
            return Err(bad("tolerance", tolerance, "1", "finite and positive"));
        }
        Ok(())
    }

    /// Checks the arguments of a step: masters' clocks jitter in the last digits and may drift, so
    /// small differences are taken as they come; a wrong point is an error. `time` is that of the last step's end.
    ///
    /// # Errors
    /// [`Fault::BadArgument`].
    pub fn check_step(&self, time: f64, point: f64, step: f64) -> Result<(), Fault> {
        let bad = |argument, value, required: String| {
            Err(Fault::BadArgument {
                function: Function::DoStep,
                argument,
                value,
                unit: "s",
                required,
            })
        };
        if !(step.is_finite() && step > 0.0) {
            return bad("communicationStepSize", step, "finite and positive".into());
        }
        let slack = 1e-3 * step + 1e-9 * time.abs().max(1.0);
        if !point.is_finite() || (point - time).abs() > slack {
            return bad(
                "currentCommunicationPoint",
                point,
                format!(
                    "the end of the last step, {} s (to go back, restore a state)",
                    time
                ),
            );
        }
        match self.stop {
            Some(stop) if point + step > stop + 1e-6 * step + 1e-9 * stop.abs().max(1.0) => bad(
                "communicationStepSize",
                step,
                format!("such that the step ends at the stop time, {stop} s"),
            ),
            _ => Ok(()),
        }
    }
}
