//! Stick: the exact linear motion where there is one, and the break-away that ends it.

use super::slip::interpolate;
use super::{End, InMode, Simulation};
use crate::belt::Inputs;
use crate::contact::{ContactMode, Transition};
use crate::error::PhysicsError;
use crate::integrate::linear::{LinearOutput, LinearSystem};
use crate::integrate::roots::first_below_zero;
use crate::integrate::series::stays_positive;
use crate::integrate::{MAX_DEGREE, MAX_STATES, row_of};
use crate::model::Model;
use crate::real::{Real, ZERO, real, root, value};
use std::sync::Arc;

/// Relative velocity in m/s with which slip leaves stick. At break-away friction balances the motion,
/// so v_r = 0 is a rest from which slip grows like exp(t/tau); this seed fixes its direction against
/// rounding. The golden values use the same seed; without it, transitions come about 2e-13 s later.
pub(crate) const DEPARTURE_VELOCITY: f64 = 1e-13;

/// The linear motion of stick, with the constraint force along it.
pub(super) struct StickSystem {
    pub(super) linear: LinearSystem,
    /// F_c in N over a step.
    force: LinearOutput,
}

impl StickSystem {
    /// Adds the constraint force to linear equations read at time `t` in s.
    pub(super) fn new(linear: LinearSystem, model: &Model, t: Real) -> Self {
        let (row, offset) = row_of(model.dimension(), |x| model.constraint_force(t, x));
        Self {
            force: linear.output(&row, offset),
            linear,
        }
    }
}

impl Simulation {
    /// Forgets the equations of stick if they do not hold under new inputs; time does not enter them.
    pub(super) fn keep_stick_system(&mut self, inputs: &Inputs) {
        let same = Inputs {
            since: inputs.since,
            ..self.model.inputs
        };
        if same != *inputs {
            self.stick_system = None;
        }
    }

    /// Reads off the linear equations of stick.
    pub(super) fn probe_stick(&self) -> LinearSystem {
        let system = InMode {
            model: &self.model,
            mode: ContactMode::Stuck,
        };
        LinearSystem::probe(&system, self.front, self.model.highest_frequency())
    }

    /// One step of stick, ended early where the constraint force exceeds its limit.
    pub(super) fn stick_segment(&mut self) -> Result<(), PhysicsError> {
        // A limit that is not a number would never be exceeded.
        if let Some(fault) = self
            .model
            .fault(self.front, &self.front_state, ContactMode::Stuck)
        {
            return Err(fault);
        }
        if self.model.is_linear_in_stick() {
            self.linear_stick();
            return Ok(());
        }
        if self.model.has_series() {
            if self.expanded_stick() {
                return Ok(());
            }
            self.restart_stepper();
        }
        let system = InMode {
            model: &self.model,
            mode: ContactMode::Stuck,
        };
        if self
            .stepper
            .step(&system, self.tolerance, &self.scales)
            .is_err()
        {
            return Err(self.stalled());
        }
        self.stepper.segment(&system, &mut self.segment);
        self.segment_is_ready = true;
        self.statistics.stick_steps += 1;
        match self.break_away_of_samples() {
            Some(theta) => self.break_away(theta),
            None => {
                let mut x = [ZERO; MAX_STATES];
                self.segment.state_at(real(1.0), &mut x);
                self.stay(x);
            }
        }
        Ok(())
    }

    /// One step of the exact linear motion. Its polynomials are worked out only if they are needed.
    fn linear_stick(&mut self) {
        if self.stick_system.is_none() {
            let system = StickSystem::new(self.probe_stick(), &self.model, self.front);
            self.stick_system = Some(Arc::new(system));
        }
        let system = self.stick_system.as_ref().expect("just made");
        let x = self.front_state;
        system.linear.begin(self.front, &x, &mut self.segment);
        self.segment_is_ready = false;
        self.statistics.stick_steps += 1;
        let end = system.linear.end_of_step(&x);
        let settled = self.model.keeps_limit_constant() && self.model.keeps_force_steady();
        let root = if settled {
            let limit = self.model.static_limit(self.front, &x);
            // With derivatives the polynomial costs more than the look at its values that spares it.
            if cfg!(feature = "tangent") && system.force.bound(&x) < value(limit) {
                self.stay(end);
                return;
            }
            earliest(&system.force.polynomial(&x), &[limit], 1.0)
        } else {
            self.ready_segment();
            let degree = self.segment.degree;
            match self.model.follow_stick(&self.segment, &mut self.room) {
                Some(stick) => earliest(&stick.force[..=degree], &stick.limit[..=degree], 1.0),
                None => self.break_away_of_samples(),
            }
        };
        match root {
            None => self.stay(end),
            Some(theta) => {
                self.ready_segment();
                self.break_away(theta);
            }
        }
    }

    /// One step of stick by its series; false where that does not hold.
    fn expanded_stick(&mut self) -> bool {
        self.segment.start = self.front;
        self.segment.coefficients[0] = self.front_state;
        let stick = self.model.expand_stick(
            self.tolerance,
            &self.scales,
            &mut self.segment,
            &mut self.room,
        );
        let Some(stick) = stick.filter(|stick| self.is_far_enough(stick.reach)) else {
            return false;
        };
        let degree = self.segment.degree;
        self.stepper.evaluations += degree as u64;
        self.statistics.stick_steps += 1;
        self.segment_is_ready = true;
        self.segment.end = self.front + stick.reach * self.segment.length;
        match earliest(
            &stick.force[..=degree],
            &stick.limit[..=degree],
            stick.reach,
        ) {
            Some(theta) => self.break_away(theta),
            None => {
                let mut x = [ZERO; MAX_STATES];
                self.segment.state_at(real(stick.reach), &mut x);
                self.stay(x);
            }
        }
        true
    }

    /// Works out the polynomials of a segment of linear stick.
    pub(super) fn ready_stick(&mut self) {
        let system = self.stick_system.as_ref().expect("stick is linear");
        let (start, end) = (self.segment.start, self.segment.end);
        let x = self.segment.coefficients[0];
        system.linear.segment(start, &x, &mut self.segment);
        self.segment.end = end;
    }

    /// Goes on sticking in state `x` at the end of the segment.
    fn stay(&mut self, x: [Real; MAX_STATES]) {
        self.front = self.segment.end;
        self.front_state = x;
        self.end = End::Smooth;
    }

    /// Ends the segment at `theta`, where the constraint force reaches its limit.
    fn break_away(&mut self, theta: Real) {
        let mut x = [ZERO; MAX_STATES];
        self.segment.state_at(theta, &mut x);
        let t = self.segment.start + theta * self.segment.length;
        let force = self.model.constraint_force(t, &x);
        self.model.project_on_stick(t, &mut x);
        self.front_mode = ContactMode::slip_towards(-force);
        self.model.on_break_away(&mut x);
        self.model
            .push(real(self.front_mode.sign() * DEPARTURE_VELOCITY), &mut x);
        self.segment.end = t;
        self.front = t;
        self.front_state = x;
        self.end = End::Event(Transition {
            time: t,
            from: ContactMode::Stuck,
            to: self.front_mode,
        });
        self.departed = false;
        self.stepper.next_length = self.first_slip_step;
        self.begin_piece();
    }

    /// Break-away where the limit or the force is any smooth function: interpolated at Chebyshev nodes
    /// over the segment, searched as a polynomial, and polished on the function itself.
    fn break_away_of_samples(&self) -> Option<Real> {
        let s = &self.segment;
        let gap = |theta: Real, side: f64| {
            let mut x = [ZERO; MAX_STATES];
            s.state_at(theta, &mut x);
            let t = s.start + theta * s.length;
            self.model.static_limit(t, &x) - side * self.model.constraint_force(t, &x)
        };
        let mut found: Option<Real> = None;
        for side in [1.0, -1.0] {
            let polynomial = interpolate(|theta| gap(real(theta), side));
            let high = found.map_or(1.0, value);
            if let Some(theta) = first_below_zero(&polynomial, 0.0, high) {
                let theta = polish(value(theta), |theta| value(gap(real(theta), side)));
                found = Some(root(theta, |theta| gap(theta, side)));
            }
        }
        found
    }
}

/// The earliest of the two ways in which |force| can exceed `limit` on theta in (0, end]; both are
/// polynomials.
fn earliest(force: &[Real], limit: &[Real], end: f64) -> Option<Real> {
    // Most pieces of stick stay far below the limit, which sums of magnitudes prove.
    let largest = |f: &[Real]| {
        f.iter()
            .rev()
            .fold(0.0, |sum, c| sum * end + value(*c).abs())
    };
    if largest(force) < limit[0] - largest(&limit[1..]) * end {
        return None;
    }
    let mut gap = [ZERO; MAX_DEGREE + 1];
    let n = force.len();
    let mut found: Option<Real> = None;
    for side in [1.0, -1.0] {
        for (g, f) in gap.iter_mut().zip(force) {
            *g = -side * f;
        }
        for (g, l) in gap.iter_mut().zip(limit) {
            *g += l;
        }
        let high = found.map_or(end, value);
        if !stays_positive(&gap[..n], high) {
            found = first_below_zero(&gap[..n], 0.0, high).or(found);
        }
    }
    found
}

/// Improves a root of `f` (positive before, negative after) found on its interpolant.
fn polish(theta: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (theta, theta + 1e-6);
    let (mut fa, mut fb) = (f(a), f(b));
    for _ in 0..8 {
        if fa == fb {
            break;
        }
        let next = (b - fb * (b - a) / (fb - fa)).clamp(theta - 1e-3, theta + 1e-3);
        (a, fa) = (b, fb);
        b = next;
        fb = f(b);
        if (b - a).abs() < 1e-14 {
            break;
        }
    }
    b.clamp(0.0, 1.0)
}
