//! Slip: a step as long as its friction is smooth, ended early where v_r comes back to zero.

use super::Collocated;
use crate::integrate::collocation::{
    Begin, Chebyshev, Expected, LEVELS, NODES, TERMS, end, expand, first_below_zero, solve,
    without_first_root,
};
use crate::integrate::{MAX_STATES, State};

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
        let mut after = [0.0; MAX_STATES];
        loop {
            if !self.solved(&mut level, sign, &x) {
                return false;
            }
            let (step, response) = (&self.step, self.structure.ladder.response(level));
            let begin = self.begin(sign, &x);
            let mut speed = [0.0; TERMS];
            expand(response, &begin, &step.capacity, &mut speed, &mut after);
            // Inside a step its polynomial counts, which is not as good as its end.
            let inner = step.roughness / (8 * NODES) as f64;
            let shorter = level + 1 < LEVELS && inner > 10.0 * self.tolerance * self.scale;
            if shorter && self.comes_near(&speed, sign, inner) {
                level += 1;
                self.memory.leave();
                continue;
            }
            let root = if self.departed {
                first_below_zero(&speed, 0.0)
            } else {
                // From rest, v_r = 0 at the begin is a root of its own that must not be found: divide it out.
                first_below_zero(&without_first_root(&speed), 0.0)
            };
            self.level = level;
            if !self.departed {
                self.departure_level = level;
            }
            let tangent = self.memory.remember(level, step.along.as_ref());
            let length = response.length;
            self.piece.begin(t, length, &x, self.front_mode);
            self.piece.slides(level, self.belt, &step.capacity, &speed);
            self.vary_slip(level, sign);
            match root {
                Some(theta) if theta * length > 0.0 => {
                    let x = self.piece.state_at(&self.structure, theta);
                    self.land(t + theta * length, x);
                }
                _ => {
                    let (speed, rise) = end(&speed);
                    self.rise = rise / length;
                    self.speed = speed;
                    self.tangent = tangent;
                    self.departed = true;
                    let t = self.piece.end;
                    self.go_on(t, after);
                }
            }
            return true;
        }
    }

    fn begin<'a>(&'a self, sign: f64, x: &'a State) -> Begin<'a> {
        Begin {
            state: x,
            sign,
            belt: self.belt,
            law: &self.law,
        }
    }

    /// The first step from `level` on that converges and is smooth enough, and its level; false if there is none.
    fn solved(&mut self, level: &mut usize, sign: f64, x: &State) -> bool {
        let share = 10.0 * self.tolerance.sqrt();
        while *level < LEVELS {
            let expected = match self.memory.expected() {
                Some(known) => Expected::Known(&known.along),
                None => Expected::Tangent(self.tangent),
            };
            let ladder = &self.structure.ladder;
            let response = ladder.response(*level);
            let (step, law, belt) = (&mut self.step, &self.law, self.belt);
            let begin = Begin {
                state: x,
                sign,
                belt,
                law,
            };
            if solve(ladder, response, &begin, expected, &self.goal, step)
                && step.roughness <= self.goal.roughness.min(share * step.fastest)
            {
                return true;
            }
            // Another slip's steps do not help any more.
            self.memory.leave();
            *level += 1;
        }
        false
    }

    /// Whether an error of `inner` in m/s could hide or feign an arrival, or a turning point of the tip.
    fn comes_near(&self, speed: &Chebyshev, sign: f64, inner: f64) -> bool {
        let below = |mut gap: Chebyshev| {
            gap[0] -= inner;
            first_below_zero(&gap, 0.0).is_some()
        };
        let arrives = if self.departed {
            below(*speed)
        } else {
            first_below_zero(&without_first_root(speed), 0.0).is_some()
        };
        // The tip turns where the sliding speed is the belt's.
        let mut gap = *speed;
        gap[0] += sign * self.belt;
        if self.begin_gap(sign) < 0.0 {
            gap.iter_mut().for_each(|c| *c = -*c);
        }
        arrives || below(gap)
    }

    /// How much faster in m/s the contact slides at the front than at a turning point.
    fn begin_gap(&self, sign: f64) -> f64 {
        self.speed + sign * self.belt
    }

    /// The level to try first: that of the last departure, or one longer than the last, unless the slip is about to end.
    fn first_level(&self) -> usize {
        if !self.departed {
            return self.departure_level;
        }
        let mut level = self.level.saturating_sub(1);
        if self.rise < 0.0 {
            let longest = (self.speed + self.goal.overshoot) / -self.rise;
            while level + 1 < LEVELS && self.structure.ladder.length(level) > longest {
                level += 1;
            }
        }
        level
    }
}
