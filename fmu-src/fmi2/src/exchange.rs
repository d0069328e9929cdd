//! Model exchange: what the master's integrator asks for (FMI 2.0.5, sections 3.2.1 and 3.2.2).

use crate::instance::Content;
use crate::lifecycle::{Function, Phase};
use crate::status::Fault;
use crate::types::EventInfo;
use beam_physics::error::PhysicsError;
use beam_physics::hybrid::{EVENT_FUNCTIONS, Hybrid};

/// Refuses a number of states or indicators that is not this FMU's.
fn check_count(
    function: Function,
    argument: &'static str,
    count: usize,
    expected: usize,
) -> Result<(), Fault> {
    if count == expected {
        return Ok(());
    }
    Err(Fault::WrongCount {
        function,
        argument,
        count,
        expected,
    })
}

impl Content {
    /// The present instant. During initialisation it is the start that the values set lead to.
    ///
    /// # Errors
    /// Values with which the equations can't be set up.
    pub fn instant(&mut self) -> Result<Hybrid, Fault> {
        self.catch_up()?;
        match (&self.hybrid, &self.run) {
            (Some(hybrid), _) => Ok(hybrid.clone()),
            (None, Some(run)) => Ok(Hybrid::start(run)),
            (None, None) => Err(Fault::Unsupported {
                function: Function::GetContinuousStates,
                what: "a look at a run that has not begun".into(),
            }),
        }
    }

    fn hybrid_mut(&mut self) -> &mut Hybrid {
        self.hybrid.as_mut().expect("these phases have one")
    }

    /// `fmi2SetTime`, in s.
    ///
    /// # Errors
    /// A time that is not finite.
    pub fn set_time(&mut self, time: f64) -> Result<(), Fault> {
        if !time.is_finite() {
            return Err(Fault::BadArgument {
                function: Function::SetTime,
                argument: "time",
                value: time,
                unit: "s",
                required: "finite".into(),
            });
        }
        self.hybrid_mut().set_time(time);
        if time != self.time {
            self.advance = (time - self.time).abs();
        }
        self.time = time;
        Ok(())
    }

    /// `fmi2SetContinuousStates`: all or none.
    ///
    /// # Errors
    /// A wrong number of states, a state that is not finite.
    pub fn set_states(&mut self, states: &[f64]) -> Result<(), Fault> {
        let function = Function::SetContinuousStates;
        let layout = self.layout;
        check_count(function, "nx", states.len(), layout.states().len())?;
        if let Some(value) = states.iter().find(|x| !x.is_finite()) {
            let fault = Fault::BadArgument {
                function,
                argument: "x",
                value: *value,
                unit: "SI",
                required: "finite".into(),
            };
            return Err(self.step_too_long().unwrap_or(fault));
        }
        let mut hybrid = self.hybrid.take().expect("this phase has one");
        for (&(index, _), &value) in layout.states().iter().zip(states) {
            match self.place(hybrid.model(), index) {
                Some(place) => place.set(&mut hybrid, value),
                None => self.values[index] = value,
            }
        }
        self.hybrid = Some(hybrid);
        Ok(())
    }

    /// A better explanation of states that have run away: a step that the master's integrator can't take. `None`
    /// where the last step was short enough even for the explicit Euler method.
    fn step_too_long(&self) -> Option<Fault> {
        let hybrid = self.hybrid.as_ref()?;
        let stiffness = hybrid.stiffness()?;
        (self.advance > stiffness.euler_limit).then_some(Fault::StepTooLong {
            time: hybrid.time(),
            step: self.advance,
            fastest: stiffness.fastest,
            limit: stiffness.euler_limit,
        })
    }

    /// The fault, or its cause in the master's steps.
    pub fn explained(&self, fault: Fault) -> Fault {
        match fault {
            Fault::NotEvaluable {
                cause: PhysicsError::NotFinite { .. },
                ..
            } => self.step_too_long().unwrap_or(fault),
            other => other,
        }
    }

    /// `fmi2GetContinuousStates`.
    ///
    /// # Errors
    /// A wrong number of states.
    pub fn get_states(&mut self, states: &mut [f64]) -> Result<(), Fault> {
        let function = Function::GetContinuousStates;
        let layout = self.layout;
        check_count(function, "nx", states.len(), layout.states().len())?;
        let hybrid = self.instant()?;
        for (&(index, _), out) in layout.states().iter().zip(states) {
            *out = match self.place(hybrid.model(), index) {
                Some(place) => place.value(&hybrid),
                None => self.values[index],
            };
        }
        Ok(())
    }

    /// `fmi2GetNominalsOfContinuousStates`.
    ///
    /// # Errors
    /// A wrong number of states.
    pub fn get_nominals(&self, nominals: &mut [f64]) -> Result<(), Fault> {
        let function = Function::GetNominalsOfContinuousStates;
        check_count(function, "nx", nominals.len(), self.layout.states().len())?;
        for (&(index, _), out) in self.layout.states().iter().zip(nominals) {
            *out = self.layout.variables()[index].nominal.unwrap_or(1.0);
        }
        Ok(())
    }

    /// `fmi2GetDerivatives`.
    ///
    /// # Errors
    /// A wrong number of states, or equations that can't be evaluated here.
    pub fn get_derivatives(&mut self, rates: &mut [f64]) -> Result<(), Fault> {
        let function = Function::GetDerivatives;
        let layout = self.layout;
        check_count(function, "nx", rates.len(), layout.states().len())?;
        self.catch_up()?;
        let Some(hybrid) = &self.hybrid else {
            return Err(Fault::Unsupported {
                function,
                what: "a derivative before the run has begun".into(),
            });
        };
        let time = hybrid.time();
        let all = hybrid
            .rates()
            .map_err(|cause| self.explained(Fault::NotEvaluable { time, cause }))?;
        for (&(index, _), out) in layout.states().iter().zip(rates) {
            *out = self
                .place(hybrid.model(), index)
                .map_or(0.0, |place| place.rate(&all));
        }
        Ok(())
    }

    /// `fmi2GetEventIndicators`.
    ///
    /// # Errors
    /// A wrong number of indicators, or equations that can't be evaluated here.
    pub fn get_indicators(&mut self, indicators: &mut [f64]) -> Result<(), Fault> {
        let function = Function::GetEventIndicators;
        check_count(function, "ni", indicators.len(), EVENT_FUNCTIONS)?;
        self.catch_up()?;
        let start;
        let hybrid = match &self.hybrid {
            Some(hybrid) => hybrid,
            None => {
                start = self.instant()?;
                &start
            }
        };
        let (time, model) = (hybrid.time(), hybrid.model());
        if let Some(cause) = model.fault(time, hybrid.state(), hybrid.mode()) {
            return Err(Fault::NotEvaluable { time, cause });
        }
        indicators.copy_from_slice(&hybrid.event_functions());
        Ok(())
    }

    /// `fmi2NewDiscreteStates`.
    ///
    /// # Errors
    /// Tunable parameters with which the equations can't be set up; states that lead nowhere, which stay
    /// as they were.
    pub fn new_discrete_states(&mut self) -> Result<EventInfo, Fault> {
        self.catch_up()?;
        let mut hybrid = self.hybrid_mut().clone();
        let jumped = hybrid.update();
        let (time, state) = (hybrid.time(), hybrid.state());
        if !state.iter().all(|x| x.is_finite()) {
            let cause = PhysicsError::NotFinite { time };
            return Err(self.explained(Fault::NotEvaluable { time, cause }));
        }
        self.hybrid = Some(hybrid);
        Ok(EventInfo {
            values_of_continuous_states_changed: jumped.into(),
            ..EventInfo::default()
        })
    }

    /// Hands inputs to the instant; at an event they may jump.
    ///
    /// # Errors
    /// Inputs outside the range in which the equations hold.
    pub fn hand_inputs(&mut self) -> Result<(), Fault> {
        let inputs = self.input_values();
        let jump = self.phase == Phase::EventMode;
        self.hybrid_mut().set_inputs(inputs, jump)?;
        Ok(())
    }
}
