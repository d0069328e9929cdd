//! Slip by Taylor series: the polynomial of each step is exact to the tolerance, events included.

use super::{End, Simulation};
use crate::contact::ContactMode;
use crate::error::PhysicsError;
use crate::integrate::MAX_STATES;
use crate::integrate::roots::first_below_zero;
use crate::integrate::series::stays_positive;
use crate::real::{ZERO, real, value};

impl Simulation {
    /// One step of slip by its series, ended early where v_r comes back to zero; `turned` where the
    /// direction of the slip has just been corrected.
    pub(super) fn expanded_slip(&mut self, turned: bool) -> Result<(), PhysicsError> {
        let sign = self.front_mode.sign();
        let t = self.front;
        self.segment.start = t;
        self.segment.coefficients[0] = self.front_state;
        let reach = self.model.expand_slip(
            self.front_mode,
            self.tolerance,
            &self.scales,
            &mut self.segment,
            &mut self.room,
        );
        let Some(reach) = reach.filter(|reach| self.is_far_enough(*reach)) else {
            // A change of regime within the step: for the integrator that controls its error.
            self.restart_stepper();
            return self.slip_segment(turned);
        };
        let degree = self.segment.degree;
        self.stepper.evaluations += degree as u64;
        self.statistics.slip_steps += 1;
        self.segment_is_ready = true;
        let gap = self.room.sliding_speed();
        let rises = gap[1];
        let root = if !self.departed {
            // From rest, v_r(0) = 0 is a root of its own that must not be found: divide it out.
            let mut rest = *gap;
            rest[1] = rises.max(0.0);
            first_below_zero(&rest[1..=degree], 0.0, reach)
        } else if stays_positive(&gap[..=degree], reach) {
            None
        } else {
            first_below_zero(&gap[..=degree], 0.0, reach)
        };
        let mut x = [ZERO; MAX_STATES];
        self.segment.state_at(real(reach), &mut x);
        self.segment.end = t + reach * self.segment.length;
        if self.model.has_memory() && !self.departed && !turned {
            // A law with memory has no break-away force that tells the direction of slip from rest.
            let end_gap = sign * self.model.relative_velocity(self.segment.end, &x);
            if rises < 0.0 || (root.is_none() && end_gap < 0.0) {
                self.front_mode = ContactMode::slip_towards(-sign);
                self.segment_mode = self.front_mode;
                return self.expanded_slip(true);
            }
        }
        match root {
            Some(theta) if theta * self.segment.length > 0.0 => {
                self.segment.state_at(theta, &mut x);
                self.land(t + theta * self.segment.length, x, sign);
            }
            _ => {
                self.departed = true;
                self.front = self.segment.end;
                self.front_state = x;
                self.end = End::Smooth;
            }
        }
        Ok(())
    }

    /// Whether a step up to `reach` advances time by more than its resolution.
    pub(super) fn is_far_enough(&self, reach: f64) -> bool {
        reach * self.segment.length > 1e-15 + 8.0 * f64::EPSILON * value(self.segment.start).abs()
    }
}
