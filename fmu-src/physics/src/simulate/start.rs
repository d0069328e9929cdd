//! Where a run starts, and how its contact is placed: anew, or at the present time.

use super::{End, InMode, Simulation, Statistics};
use crate::belt::Inputs;
use crate::contact::ContactMode;
use crate::energy::Energy;
use crate::error::{PhysicsError, require};
use crate::integrate::dop853::Dop853;
use crate::integrate::{MAX_STATES, Segment, State};
use crate::model::Model;
use crate::model::series::Workspace;
use crate::parameters::ModelParameters;
use crate::real::{Real, ZERO, value};

/// How the contact starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum StartContact {
    /// Stick where v_r is zero to rounding and the constraint force is within its limit.
    #[default]
    Automatic,
    /// Stick where the force allows it: the velocity is projected on v_r = 0 first.
    Stick,
    /// Slip, even if v_r is tiny; where it is zero to rounding, as `Automatic`.
    Slip,
}

/// Where and how a run starts.
#[derive(Debug, Clone, PartialEq)]
pub struct Start {
    /// Start time in s.
    pub time: Real,
    /// Start state in the order of [`Model`].
    pub state: State,
    /// Mode of the contact.
    pub contact: StartContact,
    /// Place on the belt where the tip stands, in m; with `settled` that on a belt whose drive does not give way, which one that
    /// does shifts by its displacement: so that runs cut into pieces pass the same places.
    pub belt_travel: Real,
    /// Time in s for which the contact has stuck already.
    pub dwell: Real,
    /// Whether equilibrium values are added to the effects' states.
    pub settled: bool,
}

impl Default for Start {
    fn default() -> Self {
        Self {
            time: ZERO,
            state: [ZERO; MAX_STATES],
            contact: StartContact::Automatic,
            belt_travel: ZERO,
            dwell: ZERO,
            settled: false,
        }
    }
}

impl Simulation {
    /// A run from `start`.
    ///
    /// # Errors
    /// Parameters, inputs or a start outside the range in which the equations hold.
    pub fn new(
        parameters: &ModelParameters,
        inputs: Inputs,
        start: &Start,
        tolerance: f64,
    ) -> Result<Self, PhysicsError> {
        let model = Model::new(parameters, inputs)?;
        Self::from_model(model, inputs, start, tolerance)
    }

    /// A run of a model that is built already, from `start`.
    ///
    /// # Errors
    /// Inputs or a start outside the range in which the equations hold.
    pub fn from_model(
        model: Model,
        inputs: Inputs,
        start: &Start,
        tolerance: f64,
    ) -> Result<Self, PhysicsError> {
        let mut run = Self {
            tolerance,
            scales: [0.0; MAX_STATES],
            time: start.time,
            front: start.time,
            front_state: start.state,
            front_mode: ContactMode::Stuck,
            segment: Segment::point(start.time, &start.state, model.dimension()),
            room: Workspace::default(),
            segment_mode: ContactMode::Stuck,
            segment_is_ready: true,
            end: End::Smooth,
            stepper: Dop853::default(),
            stick_system: None,
            first_slip_step: 0.05 / model.highest_frequency(),
            departed: false,
            transition_count: 0,
            last_transition: start.time,
            recorded: None,
            energy: None,
            statistics: Statistics::default(),
            model,
        };
        run.restart(inputs, start, tolerance)?;
        Ok(run)
    }

    /// Starts another model in place of this one, from `start`: no room is made anew.
    ///
    /// # Errors
    /// As [`Simulation::restart`].
    pub fn replace(
        &mut self,
        model: Model,
        inputs: Inputs,
        start: &Start,
        tolerance: f64,
    ) -> Result<(), PhysicsError> {
        self.first_slip_step = 0.05 / model.highest_frequency();
        self.model = model;
        self.stick_system = None;
        self.restart(inputs, start, tolerance)
    }

    /// Starts the same model anew, in place: the same motion as a new run gives, without building
    /// the model again. Records and energies begin again where they were kept.
    ///
    /// # Errors
    /// Inputs or a start outside the range in which the equations hold; the run is then of no use
    /// until it is started anew.
    pub fn restart(
        &mut self,
        inputs: Inputs,
        start: &Start,
        tolerance: f64,
    ) -> Result<(), PhysicsError> {
        require(
            tolerance > 0.0 && tolerance < 0.1,
            "tolerance",
            tolerance,
            "1",
            "between 0 and 0.1",
        )?;
        require(true, "start time", start.time, "s", "finite")?;
        require(true, "belt_travel.start", start.belt_travel, "m", "finite")?;
        require(
            start.dwell >= 0.0,
            "dwell_time.start",
            start.dwell,
            "s",
            "zero or positive",
        )?;
        for value in start.state {
            require(true, "start state", value, "SI", "finite")?;
        }
        inputs.check()?;
        let inputs = Inputs {
            since: start.time,
            ..inputs
        };
        self.keep_stick_system(&inputs);
        self.model.inputs = inputs;
        self.model.travel_offset = ZERO;
        self.model.stick_since = start.time - start.dwell;
        self.tolerance = tolerance;
        self.scales = self.model.state_scales();
        self.time = start.time;
        self.front_state = start.state;
        self.transition_count = 0;
        self.last_transition = start.time;
        self.stepper.evaluations = 0;
        self.statistics = Statistics::default();
        if let Some(list) = &mut self.recorded {
            list.clear();
        }
        if let Some(energy) = &mut self.energy {
            *energy = Energy::default();
        }
        self.place(start.contact, start.settled, start.belt_travel)
    }

    /// Puts the front state into its mode at the present time.
    pub(super) fn place(
        &mut self,
        contact: StartContact,
        settled: bool,
        travel: Real,
    ) -> Result<(), PhysicsError> {
        let t = self.time;
        let mut x = self.front_state;
        let dwell_began = self.model.stick_since;
        self.place_on_belt(travel, t, &x);
        if settled {
            // A drive that gives way shifts the belt, so settle with the mode that the motion suggests.
            let v_r = self.model.relative_velocity(t, &x);
            let mode = if contact == StartContact::Stick {
                ContactMode::Stuck
            } else {
                ContactMode::slip_towards(v_r)
            };
            let mode = if self.model.has_memory() {
                ContactMode::slip_towards(v_r)
            } else {
                mode
            };
            self.model.settle(t, &mut x, mode);
            // What the drive gives shifts the belt besides.
            self.place_on_belt(travel + self.model.belt_give(&x).displacement, t, &x);
        }
        let v_r = self.model.relative_velocity(t, &x);
        let rigid = !self.model.has_memory();
        // At rest only the force tells whether the contact slips, and which way.
        let rests = contact == StartContact::Stick || self.model.is_at_rest(t, &x);
        self.front_mode = if rigid && rests {
            self.model.project_on_stick(t, &mut x);
            self.model.mode_at_rest(t, &x)
        } else {
            ContactMode::slip_towards(v_r)
        };
        if self.front_mode == ContactMode::Stuck {
            self.model.on_stick(&mut x);
            self.model.stick_since = dwell_began;
        } else {
            self.model.stick_since = t;
        }
        if let Some(fault) = self.model.fault(t, &x, self.front_mode) {
            return Err(fault);
        }
        self.front_state = x;
        self.hold(x)
    }

    /// Shifts the belt so that the tip stands at the place `travel` in m.
    fn place_on_belt(&mut self, travel: Real, t: Real, x: &State) {
        let at = self.model.motion(t, x, ContactMode::Stuck);
        self.model.travel_offset += travel - at.travel;
    }

    /// Forgets what lies ahead and waits at the present time with state `x`.
    pub(super) fn hold(&mut self, x: State) -> Result<(), PhysicsError> {
        if !x.iter().all(|v| v.is_finite()) {
            return Err(PhysicsError::NotFinite {
                time: value(self.time),
            });
        }
        self.front = self.time;
        self.front_state = x;
        self.segment.start = self.time;
        self.segment.end = self.time;
        self.segment.length = 1.0;
        self.segment.degree = 0;
        self.segment.dimension = self.model.dimension();
        self.segment.coefficients[0] = x;
        self.segment_is_ready = true;
        self.segment_mode = self.front_mode;
        self.end = End::Smooth;
        self.departed =
            self.front_mode != ContactMode::Stuck && !self.model.is_at_rest(self.time, &x);
        self.stepper.next_length = self.first_slip_step;
        self.begin_piece();
        Ok(())
    }

    /// Prepares the integrator for the mode at the front.
    pub(super) fn begin_piece(&mut self) {
        if self.front_mode != ContactMode::Stuck {
            // A series needs nothing but the state.
            if !self.model.has_series() {
                self.restart_stepper();
            }
        } else if !self.model.is_linear_in_stick() {
            self.stepper.next_length = self.first_slip_step;
            if !self.model.has_series() {
                self.restart_stepper();
            }
        }
    }

    /// Sets the step-by-step integrator on the front state.
    pub(super) fn restart_stepper(&mut self) {
        let system = InMode {
            model: &self.model,
            mode: self.front_mode,
        };
        self.stepper.restart(&system, self.front, &self.front_state);
    }
}
