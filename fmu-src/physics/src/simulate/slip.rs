//! Slip step by step: the polynomial of sgn v_r tells whether a step ends in v_r = 0, Newton's method
//! on the step itself where.

use super::{End, InMode, Simulation};
use crate::contact::{ContactMode, Transition};
use crate::error::PhysicsError;
use crate::integrate::roots::first_below_zero;
use crate::integrate::{MAX_DEGREE, State, row_of};
use crate::real::{Real, ZERO, root, value};

/// Nodes at which a static limit that varies in time is interpolated.
const LIMIT_NODES: usize = 9;

impl Simulation {
    /// One step of slip, ended early where v_r comes back to zero; `turned` where the direction of the
    /// slip has just been corrected.
    pub(super) fn slip_segment(&mut self, turned: bool) -> Result<(), PhysicsError> {
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
    pub(super) fn land(&mut self, t: Real, mut x: State, sign: f64) {
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
}

/// Monomial coefficients of the interpolant at Chebyshev points of the second kind on [0, 1].
pub(super) fn interpolate(f: impl Fn(f64) -> Real) -> [Real; LIMIT_NODES] {
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
