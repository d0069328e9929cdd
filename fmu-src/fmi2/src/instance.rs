//! One instance: values of the variables, the run, and the steps from one communication point to the next.

use crate::experiment::Experiment;
use crate::lifecycle::{Interface, Phase};
use crate::resource::Starts;
use crate::setup::{self, INPUTS, PLACES};
use crate::status::{Fault, Status};
use crate::tangent::Room;
use beam_model_description::{Layout, UserCard};
use beam_physics::error::PhysicsError;
use beam_physics::hybrid::Hybrid;
use beam_physics::simulate::Simulation;

/// Everything of an instance that changes; what `fmi2GetFMUstate` copies.
#[derive(Clone)]
pub struct Content {
    /// The FMU's variables.
    pub layout: &'static Layout,
    /// Interface for which the instance was made.
    pub interface: Interface,
    /// Phase of the calling sequence.
    pub phase: Phase,
    /// Values set (or start values) in the order of the layout.
    pub values: Vec<f64>,
    /// The experiment.
    pub experiment: Experiment,
    /// The present communication point in s.
    pub time: f64,
    /// How far the master has last moved the time on, in s; model exchange only.
    pub advance: f64,
    /// Rates of the inputs (m/s^2, N/s, N/s) for the next step.
    pub input_rates: [f64; INPUTS],
    /// An input was set since the last step.
    pub inputs_touched: bool,
    /// A tunable parameter was set since the last step.
    pub retuned: bool,
    /// The run, once there is one; in model exchange during initialisation only.
    pub run: Option<Simulation>,
    /// The present instant of a run that the master integrates.
    pub hybrid: Option<Hybrid>,
    /// Values from which the run's model was built.
    pub built: Vec<f64>,
    /// The run does not reflect the values any more.
    pub stale: bool,
    /// Status of the last step.
    pub last_step: Status,
}

/// An instance of the beam.
pub struct Instance {
    /// Start values of this FMU.
    pub starts: Starts,
    /// What changes.
    pub content: Content,
    /// Where motions with derivatives are followed.
    pub tangents: Room,
}

impl Instance {
    /// A fresh instance.
    pub fn new(starts: Starts, interface: Interface) -> Self {
        let mut content = Content::blank(starts.layout, interface);
        content.values.copy_from_slice(&starts.values);
        Self {
            starts,
            content,
            tangents: Room::default(),
        }
    }

    /// `fmi2ExitInitializationMode`.
    ///
    /// # Errors
    /// Values with which the equations can't be set up; they can be corrected and the call repeated.
    pub fn exit_initialization(&mut self) -> Result<(), Fault> {
        let content = &mut self.content;
        content.refresh()?;
        content.phase = match content.interface {
            Interface::CoSimulation => Phase::StepComplete,
            Interface::ModelExchange => {
                content.hybrid = content.run.take().as_ref().map(Hybrid::start);
                Phase::EventMode
            }
        };
        Ok(())
    }

    /// `fmi2Reset`.
    pub fn reset(&mut self) {
        let content = &mut self.content;
        content.phase = Phase::Instantiated;
        content.values.copy_from_slice(&self.starts.values);
        content.experiment = Experiment::default();
        content.time = 0.0;
        content.advance = 0.0;
        content.input_rates = [0.0; INPUTS];
        content.inputs_touched = false;
        content.retuned = false;
        content.stale = true;
        content.hybrid = None;
        content.last_step = Status::Ok;
    }

    /// `fmi2DoStep` from `point` in s over `step` in s.
    ///
    /// # Errors
    /// Arguments that make no sense (nothing is changed then), or a motion that can't be integrated.
    pub fn do_step(&mut self, point: f64, step: f64) -> Result<(), Fault> {
        let content = &mut self.content;
        content.experiment.check_step(content.time, point, step)?;
        content.retune()?;
        content.apply_inputs()?;
        let target = point + step;
        let run = content.run.as_mut().expect("initialised");
        // A master's clock may lie a few digits behind ours; time never runs backwards.
        let result = run.advance_to(target.max(run.time()));
        content.input_rates = [0.0; INPUTS];
        match result {
            Ok(()) => {
                content.time = target;
                content.last_step = Status::Ok;
                Ok(())
            }
            Err(cause) => {
                content.time = run.time();
                let fault = Fault::StepStopped {
                    time: content.time,
                    cause,
                };
                content.last_step = fault.status();
                content.phase = match fault.status() {
                    Status::Discard => Phase::StepFailed,
                    _ => Phase::Error,
                };
                Err(fault)
            }
        }
    }
}

impl Content {
    /// Before anything was set.
    pub fn blank(layout: &'static Layout, interface: Interface) -> Self {
        Self {
            layout,
            interface,
            phase: Phase::Instantiated,
            values: vec![0.0; layout.variables().len()],
            experiment: Experiment::default(),
            time: 0.0,
            advance: 0.0,
            input_rates: [0.0; INPUTS],
            inputs_touched: false,
            retuned: false,
            run: None,
            hybrid: None,
            built: Vec::new(),
            stale: true,
            last_step: Status::Ok,
        }
    }

    /// Builds or restarts the run if a value has changed since.
    ///
    /// # Errors
    /// Values with which the equations can't be set up.
    pub fn refresh(&mut self) -> Result<(), PhysicsError> {
        if !self.stale {
            return Ok(());
        }
        let places = &*PLACES;
        let time = self.experiment.start;
        let inputs = places.inputs(&self.values, self.input_rates, time);
        // The tighter of both requests holds, so that a master's default can't spoil the result.
        let own = self.values[places.tolerance];
        let tolerance = self
            .experiment
            .tolerance
            .map_or(own, |asked| own.min(asked));
        match &mut self.run {
            Some(run) if places.same_model(self.layout, &self.values, &self.built) => {
                let start = places.start(self.layout, &self.values, run.model(), time);
                run.restart(inputs, &start, tolerance)?;
            }
            _ => {
                self.run = None;
                let model = setup::model(self.layout, &self.values, inputs, UserCard::effect)?;
                let start = places.start(self.layout, &self.values, &model, time);
                self.run = Some(Simulation::from_model(model, inputs, &start, tolerance)?);
                self.built.clone_from(&self.values);
            }
        }
        self.stale = false;
        self.inputs_touched = false;
        self.retuned = false;
        Ok(())
    }

    /// Brings the run up to date with everything that was set since the last call that looked at it.
    ///
    /// # Errors
    /// Values with which the equations can't be set up; they can be corrected.
    #[inline]
    pub fn catch_up(&mut self) -> Result<(), PhysicsError> {
        match self.phase {
            Phase::Initialization => self.refresh(),
            Phase::StepComplete if self.retuned || self.inputs_touched => {
                self.retune()?;
                self.apply_inputs()
            }
            Phase::EventMode | Phase::ContinuousTime => self.retune(),
            _ => Ok(()),
        }
    }

    /// Hands inputs to the run where they differ from those that hold. Setting an input to the value and
    /// the rate that it has must not disturb the run: what it has integrated ahead stays valid, and the
    /// result does not depend on how often a master sets inputs.
    ///
    /// # Errors
    /// Inputs outside the range in which the equations hold.
    pub fn apply_inputs(&mut self) -> Result<(), PhysicsError> {
        let run = self.run.as_ref().expect("initialised");
        let wanted = PLACES.inputs(&self.values, self.input_rates, run.time());
        if !run.inputs().go_on_as(&wanted) {
            self.account_energy()?;
            let run = self.run.as_mut().expect("initialised");
            run.set_inputs(wanted)?;
        }
        self.inputs_touched = false;
        Ok(())
    }
}
