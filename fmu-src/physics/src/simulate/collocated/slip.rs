//! Slip: a step as long as its friction is smooth, ended early where v_r comes back to zero.

use super::{Collocated, Pace};
use crate::integrate::State;
use crate::integrate::collocation::{
    Begin, Expected, LEVELS, NODES, expand, first_below_zero, solve, without_first_root,
};

/// Roughness that is aimed at, as a share of what is allowed.
const AIM: f64 = 0.05;

impl Collocated {
    /// One step of slip; false where none is short enough to converge.
    pub(super) fn slip(&mut self) -> bool {
        let sign = self.front_mode.sign();
        let (t, x) = (self.front, self.front_state);
        if !self.departed {
            self.memory.depart(sign, &x);
        }
        let mut level = match self.memory.expected() {
            Some(known) => known.level,
            None => self.first_level(),
        };
        loop {
            if !self.solved(&mut level, sign, &x) {
                return false;
            }
            let (step, response) = (&self.step, self.structure.ladder.response(level));
            // Inside a step its polynomial counts, which is not as good as its end.
            let inner = step.roughness / (8 * NODES) as f64;
            let shorter = level + 1 < LEVELS && inner > 10.0 * self.tolerance * self.scale;
            if shorter && self.comes_near(sign, inner) {
                level += 1;
                self.memory.leave();
                continue;
            }
            let root = self.arrival(0.0);
            let roughness = step.roughness;
            self.pace = Pace { level, roughness };
            if !self.departed {
                self.departure = self.pace;
            }
            let tangent = self.memory.remember(level, step);
            let length = response.length;
            self.piece.begin(t, length, &x, self.front_mode);
            self.piece.slides(level, self.belt, &step.capacity);
            self.vary_slip(level, sign);
            match root {
                Some(theta) if theta * length > 0.0 => {
                    let x = self.piece.state_at(&self.structure, theta);
                    self.land(t + theta * length, x);
                }
                _ => {
                    let [speed, rise] = self.piece.course.last;
                    self.rise = rise / length;
                    self.speed = speed;
                    self.tangent = tangent;
                    self.departed = true;
                    self.go_on(self.piece.end, self.piece.course.end);
                }
            }
            return true;
        }
    }

    /// The first step from `level` on that converges and is smooth enough, its level, and the course of the piece along it; false
    /// if there is none.
    fn solved(&mut self, level: &mut usize, sign: f64, x: &State) -> bool {
        let share = 10.0 * self.tolerance.sqrt();
        let begin = Begin {
            state: x,
            sign,
            belt: self.belt,
            law: &self.law,
        };
        while *level < LEVELS {
            let expected = match self.memory.expected() {
                Some(known) => Expected::Known {
                    along: &known.along,
                    renew: self.memory.renews(),
                },
                None => Expected::Tangent(self.tangent),
            };
            let ladder = &self.structure.ladder;
            let response = ladder.response(*level);
            let step = &mut self.step;
            if solve(ladder, response, &begin, expected, &self.goal, step)
                && step.roughness <= self.goal.roughness.min(share * step.fastest)
            {
                expand(response, &begin, &step.capacity, &mut self.piece.course);
                return true;
            }
            // Another slip's steps do not help any more.
            self.memory.leave();
            *level += 1;
        }
        false
    }

    /// Where in the step the contact comes to rest, or as near to it as `inner` in m/s.
    fn arrival(&self, inner: f64) -> Option<f64> {
        let course = &self.piece.course;
        if !self.departed {
            // From rest, v_r = 0 at the begin is a root of its own that must not be found: divide it out.
            return first_below_zero(&without_first_root(&course.speed), 0.0);
        }
        if course.speed[0] - inner >= course.spread {
            return None;
        }
        let mut gap = course.speed;
        gap[0] -= inner;
        first_below_zero(&gap, 0.0)
    }

    /// Whether an error of `inner` in m/s could hide or feign an arrival, or a turning point of the tip.
    fn comes_near(&self, sign: f64, inner: f64) -> bool {
        // The tip turns where the sliding speed is the belt's.
        let course = &self.piece.course;
        let ahead = if self.begin_gap(sign) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let mean = ahead * (course.speed[0] + sign * self.belt) - inner;
        let turns = || {
            let mut gap = course.speed.map(|c| ahead * c);
            gap[0] = mean;
            first_below_zero(&gap, 0.0).is_some()
        };
        self.arrival(inner).is_some() || (!(mean >= course.spread) && turns())
    }

    /// How much faster in m/s the contact slides at the front than at a turning point.
    fn begin_gap(&self, sign: f64) -> f64 {
        self.speed + sign * self.belt
    }

    /// The level to try first: as long as the last step was smooth, unless the slip is about to end.
    fn first_level(&self) -> usize {
        if !self.departed {
            return self.longer(&self.departure);
        }
        // An octave more is tried in any case: what slides faster gets smoother.
        let mut level = self
            .longer(&self.pace)
            .min(self.pace.level.saturating_sub(2));
        if self.rise < 0.0 {
            let longest = (self.speed + self.goal.overshoot) / -self.rise;
            while level + 1 < LEVELS && self.structure.ladder.length(level) > longest {
                level += 1;
            }
        }
        level
    }

    /// The level of a step that is about as rough as wanted, from that of another: the last coefficients of a polynomial
    /// follow the power of the length that they belong to.
    fn longer(&self, pace: &Pace) -> usize {
        let spare = AIM * self.goal.roughness / pace.roughness.max(f64::MIN_POSITIVE);
        // Half an octave each.
        let levels = spare.log2().max(0.0) / (0.5 * (NODES - 1) as f64);
        pace.level.saturating_sub(levels as usize)
    }
}
