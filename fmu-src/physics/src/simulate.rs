//! The event loop: integrate a smooth piece, locate the transition that ends it, apply it, go on.

#[cfg(not(feature = "tangent"))]
pub(crate) mod collocated;
mod expanded;
#[cfg(not(feature = "tangent"))]
mod piece;
mod sample;
#[cfg(not(feature = "tangent"))]
pub mod snapshot;
mod stick;

use crate::belt::Inputs;
use crate::contact::{ContactMode, Transition};
use crate::effects::ContactForce;
use crate::energy::Energy;
use crate::error::{PhysicsError, require};
use crate::integrate::dop853::Dop853;
use crate::integrate::roots::first_below_zero;
use crate::integrate::{MAX_DEGREE, MAX_STATES, Scales, Segment, State, System, row_of};
use crate::model::Model;
use crate::model::series::Workspace;
use crate::parameters::ModelParameters;
use crate::real::{Real, ZERO, root, value};
pub use sample::Row;
use std::sync::Arc;
#[cfg(not(feature = "tangent"))]
pub(crate) use stick::DEPARTURE_VELOCITY;
use stick::StickSystem;

/// A run whose steps are shorter than this on average, in s, over [`PATIENCE`] of them is given up.
const LEAST_PROGRESS: f64 = 1e-7;
/// Number of steps after which progress is judged.
const PATIENCE: u64 = 2_000;
/// Nodes at which a static limit that varies in time is interpolated.
const LIMIT_NODES: usize = 9;

/// Relative tolerance at which transitions of the default model are good to 1e-6 s over seconds.
pub const DEFAULT_TOLERANCE: f64 = 1e-10;

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

/// What can be observed at the present time, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outputs {
    /// Tip displacement w in m.
    pub displacement: Real,
    /// Tip velocity w' in m/s.
    pub velocity: Real,
    /// Tip acceleration w'' in m/s^2.
    pub acceleration: Real,
    /// Friction force on the tip in N, positive along the belt's motion.
    pub friction_force: Real,
    /// Relative velocity v_r in m/s.
    pub relative_velocity: Real,
    /// Mode of the contact.
    pub mode: ContactMode,
    /// Displacement in m after the measuring chain.
    pub measured_displacement: Real,
    /// Velocity in m/s where the sensor looks.
    pub measured_velocity: Real,
    /// Acceleration in m/s^2 where the sensor looks.
    pub measured_acceleration: Real,
    /// Place on the belt in m.
    pub belt_travel: Real,
    /// Time since stick began in s.
    pub dwell: Real,
}

impl Outputs {
    /// The observables of a state at time `t` in s.
    pub fn of(model: &Model, t: Real, x: &State, mode: ContactMode) -> Self {
        let mut rates = [ZERO; MAX_STATES];
        let contact: ContactForce = model.evaluate(t, x, mode, &mut rates);
        let motion = model.motion(t, x, mode);
        let of_rates = model.tip(&rates);
        let (_, acceleration) = of_rates;
        Self {
            displacement: motion.displacement,
            velocity: motion.velocity,
            acceleration,
            friction_force: contact.force,
            relative_velocity: motion.relative_velocity,
            mode,
            measured_displacement: model.measured_displacement(t, x, mode),
            measured_velocity: motion.sensor_velocity,
            measured_acceleration: model.sensor(&rates, of_rates).1,
            belt_travel: motion.travel,
            dwell: motion.dwell,
        }
    }
}

/// Work of the integrator, for tests that catch "same answer, more work".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Statistics {
    /// Pieces of slip integrated.
    pub slip_steps: u64,
    /// Pieces of stick integrated.
    pub stick_steps: u64,
    /// Evaluations of the rates; each power of a series counts as one.
    pub evaluations: u64,
}

/// What ends the present segment.
#[derive(Clone, Copy)]
enum End {
    Smooth,
    Event(Transition),
}

/// The model within one mode, as the integrators see it.
struct InMode<'a> {
    model: &'a Model,
    mode: ContactMode,
}

impl System for InMode<'_> {
    fn dimension(&self) -> usize {
        self.model.dimension()
    }
    #[inline]
    fn rates(&self, t: Real, x: &State, rates: &mut State) {
        self.model.rates(t, x, self.mode, rates);
    }
}

/// A run of the model. Integrates ahead of the present time in steps of its own and interpolates,
/// so that results do not depend on where the caller stops; a change of inputs discards what lies ahead.
#[derive(Clone)]
pub struct Simulation {
    model: Model,
    tolerance: f64,
    scales: Scales,
    time: Real,
    /// State and mode at `front`, the end of the segment.
    front: Real,
    front_state: State,
    front_mode: ContactMode,
    segment: Segment,
    room: Workspace,
    segment_mode: ContactMode,
    /// The polynomials of a segment are worked out only once somebody looks at them.
    segment_is_ready: bool,
    end: End,
    stepper: Dop853,
    /// The equations of stick under the present inputs, where they are linear.
    stick_system: Option<Arc<StickSystem>>,
    first_slip_step: f64,
    /// The slip has left v_r = 0 by more than rounding, so that a return counts as arrival.
    departed: bool,
    transition_count: u64,
    last_transition: Real,
    recorded: Option<Vec<Transition>>,
    energy: Option<Energy>,
    statistics: Statistics,
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
    fn place(
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
    fn hold(&mut self, x: State) -> Result<(), PhysicsError> {
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
    fn begin_piece(&mut self) {
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
    fn restart_stepper(&mut self) {
        let system = InMode {
            model: &self.model,
            mode: self.front_mode,
        };
        self.stepper.restart(&system, self.front, &self.front_state);
    }

    /// Changes the inputs at the present time.
    ///
    /// # Errors
    /// Inputs outside the range in which the equations hold; the run stays as it was.
    pub fn set_inputs(&mut self, inputs: Inputs) -> Result<(), PhysicsError> {
        let inputs = Inputs {
            since: self.time,
            ..inputs
        };
        inputs.check()?;
        // What lies ahead in the segment is dropped, what has passed is not.
        self.count_energy(self.time);
        let x = self.state();
        let mode = self.segment_mode;
        let travel = self.model.motion(self.time, &x, mode).travel;
        let dwell_began = self.model.stick_since;
        self.keep_stick_system(&inputs);
        self.model.inputs = inputs;
        self.scales = self.model.state_scales();
        self.front_state = x;
        self.model.stick_since = dwell_began;
        let moved = self.model.relative_velocity(self.time, &x);
        let was_stuck = mode == ContactMode::Stuck;
        let still = moved.abs() <= 1e-12 * (inputs.belt_velocity.abs() + moved.abs() + 1e-6);
        let contact = if was_stuck && still {
            StartContact::Stick
        } else {
            StartContact::Slip
        };
        self.place(contact, false, travel)?;
        if self.model.has_memory() && self.front_mode != mode && still {
            // At rest to rounding the law with memory goes on with the sign before.
            self.front_mode = mode;
            self.hold(x)?;
        }
        // Slip goes on; slip out of stick has departed where the belt's new velocity makes it. At rest
        // nothing has departed, or the rest itself would be taken for the end of the slip.
        self.departed |= !was_stuck && !still;
        if was_stuck != (self.front_mode == ContactMode::Stuck) {
            self.note(Transition {
                time: self.time,
                from: mode,
                to: self.front_mode,
            });
        }
        Ok(())
    }

    /// Goes on at the present time with another model, whose state is `x` in its own order: parameters
    /// that change during a run. Counts, energies and the place on the belt go on.
    ///
    /// # Errors
    /// A state with which the new model can't start; the run is then of no use.
    pub fn set_model(&mut self, model: Model, x: State) -> Result<(), PhysicsError> {
        let t = self.time;
        self.count_energy(t);
        let mode = self.segment_mode;
        let travel = self.model.motion(t, &self.state(), mode).travel;
        let now = self.model.inputs;
        let inputs = now.from(t);
        let dwell_began = self.model.stick_since;
        let sticks = mode == ContactMode::Stuck;
        self.model = model;
        self.model.inputs = inputs;
        self.model.travel_offset = ZERO;
        self.model.stick_since = dwell_began;
        self.stick_system = None;
        self.scales = self.model.state_scales();
        self.first_slip_step = 0.05 / self.model.highest_frequency();
        self.front_state = x;
        let contact = if sticks {
            StartContact::Stick
        } else {
            StartContact::Slip
        };
        self.place(contact, false, travel)?;
        self.departed |= !sticks;
        if sticks && self.front_mode != ContactMode::Stuck {
            self.note(Transition {
                time: t,
                from: mode,
                to: self.front_mode,
            });
        }
        Ok(())
    }

    /// Inputs that hold now.
    pub fn inputs(&self) -> Inputs {
        self.model.inputs
    }

    /// Present time in s.
    pub fn time(&self) -> Real {
        self.time
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Advances to time `t` in s, not before the present.
    ///
    /// # Errors
    /// A motion that is no longer finite, or no progress in time; the run stays at the last good time.
    pub fn advance_to(&mut self, t: Real) -> Result<(), PhysicsError> {
        self.pass_to(t)?;
        self.ready_segment();
        Ok(())
    }

    /// Advances to time `t` in s without working out the interpolant there.
    fn pass_to(&mut self, t: Real) -> Result<(), PhysicsError> {
        let (mut steps, mut since) = (0, (self.time, self.transition_count));
        while t >= self.segment.end {
            self.time = self.segment.end;
            self.finish_segment();
            self.next_segment()?;
            steps += 1;
            if steps % PATIENCE == 0 {
                if self.time - since.0 < LEAST_PROGRESS * PATIENCE as f64 {
                    return Err(PhysicsError::Stalled {
                        time: value(self.time),
                        step: self.segment.length,
                        transitions: self.transition_count - since.1,
                    });
                }
                since = (self.time, self.transition_count);
            }
        }
        self.time = t;
        Ok(())
    }

    /// Works out the interpolant of the present segment.
    fn ready_segment(&mut self) {
        if self.segment_is_ready {
            return;
        }
        self.segment_is_ready = true;
        if self.segment_mode == ContactMode::Stuck {
            self.ready_stick();
        } else {
            let system = InMode {
                model: &self.model,
                mode: self.segment_mode,
            };
            self.stepper.segment(&system, &mut self.segment);
        }
    }

    /// Counts the energy that flows in the present segment up to time `until` in s.
    fn count_energy(&mut self, until: Real) {
        if self.energy.is_some() {
            self.ready_segment();
        }
        if let Some(energy) = &mut self.energy {
            energy.add(&self.model, &self.segment, self.segment_mode, until);
        }
    }

    /// Counts what the finished segment ended with.
    fn finish_segment(&mut self) {
        self.count_energy(self.segment.end);
        if let End::Event(transition) = self.end {
            self.note(transition);
            self.end = End::Smooth;
        }
    }

    fn note(&mut self, transition: Transition) {
        // A law with memory has no discrete modes: its change of sign is only a place to restart.
        if self.model.has_memory() {
            return;
        }
        self.transition_count += 1;
        self.last_transition = transition.time;
        if transition.to == ContactMode::Stuck {
            self.model.stick_since = transition.time;
        }
        if let Some(list) = &mut self.recorded {
            list.push(transition);
        }
    }

    fn next_segment(&mut self) -> Result<(), PhysicsError> {
        let (t, x, mode) = (self.front, self.front_state, self.front_mode);
        self.segment_mode = mode;
        let done = if mode != ContactMode::Stuck {
            if self.model.has_series() {
                self.expanded_slip(false)
            } else {
                self.slip_segment(false)
            }
        } else {
            self.stick_segment()
        };
        let finite = self.front_state[..self.model.dimension()]
            .iter()
            .all(|v| v.is_finite());
        match done {
            Ok(()) if finite => Ok(()),
            failed => Err(self
                .fault_near(t, &x, mode)
                .or(failed.err())
                .unwrap_or(PhysicsError::NotFinite { time: value(t) })),
        }
    }

    /// An effect that can't be evaluated at this instant or shortly after it: the better explanation of
    /// a run that can't go on.
    fn fault_near(&self, t: Real, x: &State, mode: ContactMode) -> Option<PhysicsError> {
        if let Some(fault) = self.model.fault(t, x, mode) {
            return Some(fault);
        }
        let mut rates = [ZERO; MAX_STATES];
        self.model.rates(t, x, mode, &mut rates);
        if !rates.iter().all(|r| r.is_finite()) {
            return None;
        }
        [1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6]
            .into_iter()
            .find_map(|h| {
                let ahead = std::array::from_fn(|i| x[i] + h * rates[i]);
                self.model.fault(t + h, &ahead, mode)
            })
    }

    fn stalled(&self) -> PhysicsError {
        PhysicsError::Stalled {
            time: value(self.front),
            step: self.stepper.next_length,
            transitions: 0,
        }
    }

    /// One step of slip, ended early where v_r comes back to zero; `turned` where the direction of the
    /// slip has just been corrected.
    fn slip_segment(&mut self, turned: bool) -> Result<(), PhysicsError> {
        let sign = self.front_mode.sign();
        let system = InMode {
            model: &self.model,
            mode: self.front_mode,
        };
        if self
            .stepper
            .step(&system, self.tolerance, &self.scales)
            .is_err()
        {
            return Err(self.stalled());
        }
        self.statistics.slip_steps += 1;
        self.segment_is_ready = false;
        self.segment.start = self.stepper.start;
        self.segment.length = self.stepper.length;
        self.segment.end = self.stepper.start + self.stepper.length;
        let end_time = self.segment.end;
        let end_gap = sign * self.model.relative_velocity(end_time, &self.stepper.x_end);
        let mut root = None;
        if self.may_return(sign, end_gap) {
            self.ready_segment();
            let (gap, degree) = self.gap_polynomial(sign);
            // From rest, v_r(0) = 0 is a root of its own that must not be found: divide it out.
            root = if self.departed {
                first_below_zero(&gap[..=degree], 0.0, 1.0)
            } else {
                first_below_zero(&gap[1..=degree], 0.0, 1.0)
            };
            // A law with memory has no break-away force that tells the direction of slip from rest.
            let astray = gap[1] < 0.0 || (root.is_none() && end_gap < 0.0);
            if self.model.has_memory() && !self.departed && !turned && astray {
                self.front_mode = ContactMode::slip_towards(-sign);
                self.segment_mode = self.front_mode;
                self.begin_piece();
                return self.slip_segment(true);
            }
        }
        match root {
            Some(theta) if theta * self.segment.length > 0.0 => self.arrive(theta, sign),
            _ => {
                self.departed = true;
                self.front = end_time;
                self.front_state = self.stepper.x_end;
                self.end = End::Smooth;
                Ok(())
            }
        }
    }

    /// Cheap test whether v_r might touch zero inside the step: the cubic through values and slopes at
    /// both ends, with a margin for what the cubic does not see.
    fn may_return(&self, sign: f64, end_gap: Real) -> bool {
        if end_gap <= 0.0 || !self.departed {
            return true;
        }
        let h = self.stepper.length;
        let start_gap = sign
            * self
                .model
                .relative_velocity(self.stepper.start, &self.stepper.x_start);
        let (t0, t1) = (self.stepper.start, self.stepper.start + h);
        let (d0, d1) = (
            h * self
                .model
                .relative_acceleration(t0, self.stepper.rates_at_start()),
            h * self
                .model
                .relative_acceleration(t1, self.stepper.rates_at_end()),
        );
        let bend = d0.abs().max(d1.abs());
        start_gap.min(end_gap) < 0.75 * bend
    }

    /// Polynomial of sgn * v_r over the segment, and its degree.
    fn gap_polynomial(&self, sign: f64) -> ([Real; MAX_DEGREE + 1], usize) {
        let mut gap = [ZERO; MAX_DEGREE + 1];
        let (start, dimension) = (self.segment.start, self.segment.dimension);
        let (row, offset) = row_of(dimension, |x| self.model.relative_velocity(start, x));
        gap[0] = sign * offset;
        gap[1] = -sign * self.model.inputs.belt_acceleration * self.segment.length;
        for i in 0..dimension {
            let row = sign * row[i];
            if row != 0.0 {
                for (g, c) in gap
                    .iter_mut()
                    .zip(&self.segment.coefficients)
                    .take(self.segment.degree + 1)
                {
                    *g += row * c[i];
                }
            }
        }
        let mut degree = self.segment.degree;
        if self.model.has_belt_ripple() {
            let (start, length) = (self.segment.start, self.segment.length);
            let ripple = interpolate(|theta| {
                self.model.belt_ripple(start + theta * length) - self.model.belt_ripple(start)
            });
            for (g, r) in gap.iter_mut().zip(ripple) {
                *g -= sign * r;
            }
            degree = degree.max(LIMIT_NODES - 1);
        }
        (gap, degree)
    }

    /// Locates v_r = 0 near `theta` on the step itself and ends the segment there.
    fn arrive(&mut self, theta: Real, sign: f64) -> Result<(), PhysicsError> {
        let mode = self.front_mode;
        let system = InMode {
            model: &self.model,
            mode,
        };
        let start = self.segment.start;
        // The interpolant is of lower order than the step: take the step anew and correct by Newton.
        let mut h = value(theta) * self.segment.length;
        for _ in 0..2 {
            self.stepper.retake(&system, h);
            let t = start + h;
            let gap = self.model.relative_velocity(t, &self.stepper.x_end);
            let slope = self
                .model
                .relative_acceleration(t, self.stepper.rates_at_end());
            let slope = value(slope);
            let correction = if slope == 0.0 {
                0.0
            } else {
                -value(gap) / slope
            };
            if correction.abs() > 1e-3 * h || correction == 0.0 {
                break;
            }
            h += correction;
        }
        self.stepper.retake(&system, h);
        let after = |h: Real| {
            let mut x = self.stepper.x_end;
            for (x, rate) in x.iter_mut().zip(self.stepper.rates_at_end()) {
                *x += rate * (h - value(h));
            }
            x
        };
        let h = root(h, |h| self.model.relative_velocity(start + h, &after(h)));
        self.land(start + h, after(h), sign);
        Ok(())
    }

    /// Ends the segment at time `t` in state `x`, where v_r = 0, and decides how the motion goes on.
    fn land(&mut self, t: Real, mut x: State, sign: f64) {
        let mode = self.front_mode;
        self.segment.end = t;
        if self.model.has_memory() {
            self.front_mode = ContactMode::slip_towards(-sign);
        } else {
            self.model.project_on_stick(t, &mut x);
            self.model.stick_since = t;
            self.front_mode = self.model.mode_at_rest(t, &x);
            if self.front_mode == ContactMode::Stuck {
                self.model.on_stick(&mut x);
            }
        }
        self.end = End::Event(Transition {
            time: t,
            from: mode,
            to: self.front_mode,
        });
        self.front = t;
        self.front_state = x;
        self.departed = false;
        // Slip that goes on across v_r = 0 keeps its step; stick needs none.
        self.stepper.next_length = self
            .stepper
            .next_length
            .min(self.segment.length)
            .max(self.first_slip_step);
        self.begin_piece();
    }

    /// Writes the state at the present time.
    pub fn state(&self) -> State {
        let mut x = [ZERO; MAX_STATES];
        self.segment.state_at(self.segment.theta(self.time), &mut x);
        x
    }

    /// The observables at the present time.
    pub fn outputs(&self) -> Outputs {
        self.outputs_at(self.time)
    }

    /// The observables at a time within the present segment or next to it.
    fn outputs_at(&self, t: Real) -> Outputs {
        let mut x = [ZERO; MAX_STATES];
        self.segment.state_at(self.segment.theta(t), &mut x);
        Outputs::of(&self.model, t, &x, self.segment_mode)
    }

    /// The rates of the observables at the present time, each per second. The motion's own are exact,
    /// the others central differences on the present segment (1e-6 relative).
    ///
    /// # Errors
    /// As [`Simulation::advance_to`].
    pub fn output_rates(&mut self) -> Result<Outputs, PhysicsError> {
        // A run that has just been placed has no segment yet.
        self.advance_to(self.time)?;
        let step = 1e-3 * self.segment.length;
        let (a, now, b) = (
            self.outputs_at(self.time - step),
            self.outputs(),
            self.outputs_at(self.time + step),
        );
        let rate = |a: Real, b: Real| (b - a) / (2.0 * step);
        Ok(Outputs {
            displacement: now.velocity,
            velocity: now.acceleration,
            acceleration: rate(a.acceleration, b.acceleration),
            friction_force: rate(a.friction_force, b.friction_force),
            relative_velocity: rate(a.relative_velocity, b.relative_velocity),
            mode: now.mode,
            measured_displacement: rate(a.measured_displacement, b.measured_displacement),
            measured_velocity: now.measured_acceleration,
            measured_acceleration: rate(a.measured_acceleration, b.measured_acceleration),
            belt_travel: -now.relative_velocity,
            dwell: rate(a.dwell, b.dwell),
        })
    }

    /// Mode of the contact at the present time.
    pub fn contact_mode(&self) -> ContactMode {
        self.segment_mode
    }

    /// The displacement at the present time as the sensor gives it, in m; cheaper than all outputs.
    pub fn measured_displacement(&self) -> Real {
        self.model
            .measured_displacement(self.time, &self.state(), self.segment_mode)
    }

    /// Number of transitions so far.
    pub fn transition_count(&self) -> u64 {
        self.transition_count
    }

    /// Time of the last transition in s, the start time before the first.
    pub fn last_transition_time(&self) -> Real {
        self.last_transition
    }

    /// Keeps a list of transitions from now on.
    pub fn record_transitions(&mut self) {
        self.recorded.get_or_insert_default();
    }

    /// The transitions recorded.
    pub fn transitions(&self) -> &[Transition] {
        self.recorded.as_deref().unwrap_or_default()
    }

    /// Keeps account of energies from now on.
    pub fn account_energy(&mut self) {
        self.energy.get_or_insert_with(Energy::default);
    }

    /// Energies are being accounted for.
    pub fn accounts_energy(&self) -> bool {
        self.energy.is_some()
    }

    /// Energies in J since accounting began; `None` where it has not.
    pub fn energy(&self) -> Option<Energy> {
        let mut energy = self.energy?;
        energy.add(&self.model, &self.segment, self.segment_mode, self.time);
        energy.stored = self.model.stored_energy(&self.state());
        Some(energy)
    }

    /// Work done so far.
    pub fn statistics(&self) -> Statistics {
        Statistics {
            evaluations: self.stepper.evaluations,
            ..self.statistics
        }
    }
}

/// Monomial coefficients of the interpolant at Chebyshev points of the second kind on [0, 1].
fn interpolate(f: impl Fn(f64) -> Real) -> [Real; LIMIT_NODES] {
    let node =
        |i: usize| 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / (LIMIT_NODES - 1) as f64).cos();
    // Newton's divided differences, expanded into powers.
    let nodes: [f64; LIMIT_NODES] = std::array::from_fn(node);
    let mut table = nodes.map(&f);
    for level in 1..LIMIT_NODES {
        for i in (level..LIMIT_NODES).rev() {
            table[i] = (table[i] - table[i - 1]) / (nodes[i] - nodes[i - level]);
        }
    }
    let mut c = [ZERO; LIMIT_NODES];
    for i in (0..LIMIT_NODES).rev() {
        for k in (1..LIMIT_NODES).rev() {
            c[k] = c[k - 1] - nodes[i] * c[k];
        }
        c[0] = table[i] - nodes[i] * c[0];
    }
    c
}
