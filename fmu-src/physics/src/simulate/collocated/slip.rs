//! Slip: a step as long as its friction is smooth, ended early where v_r comes back to zero.

use super::Collocated;
use crate::integrate::MAX_STATES;
use crate::integrate::collocation::{
    Begin, Chebyshev, LEVELS, NODES, Step, end, expand, first_below_zero, solve, without_first_root,
};

impl Collocated {
    /// One step of slip; false where none is short enough to converge.
    pub(super) fn slip(&mut self) -> bool {
        let sign = self.front_mode.sign();
        let (t, x) = (self.front, self.front_state);
        let mut level = self.first_level();
        loop {
            let begin = Begin {
                state: &x,
                sign,
                belt: self.belt,
                law: &self.law,
                tangent: self.tangent,
            };
            let Some(step) = self.solved(&mut level, &begin) else {
                return false;
            };
            let response = self.structure.ladder.response(level);
            let mut after = [0.0; MAX_STATES];
            let speed = expand(response, &begin, &step.capacity, &mut after);
            // Inside a step its polynomial counts, which is not as good as its end.
            let inner = step.roughness / (8 * NODES) as f64;
            let shorter = level + 1 < LEVELS && inner > 10.0 * self.tolerance * self.scale;
            if shorter && self.comes_near(&speed, sign, inner) {
                level += 1;
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
            let length = response.length;
            self.piece.begin(t, length, &x, self.front_mode);
            self.piece.slides(level, self.belt, &step.capacity, &speed);
            match root {
                Some(theta) if theta * length > 0.0 => {
                    let x = self.piece.state_at(&self.structure, theta);
                    self.land(t + theta * length, x);
                }
                _ => {
                    let (speed, rise) = end(&speed);
                    self.rise = rise / length;
                    self.speed = speed;
                    self.tangent = step.tangent;
                    self.departed = true;
                    let t = self.piece.end;
                    self.go_on(t, after);
                }
            }
            return true;
        }
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

    /// The first step from `level` on that converges and is smooth enough; the level found.
    fn solved(&self, level: &mut usize, begin: &Begin) -> Option<Step> {
        let ladder = &self.structure.ladder;
        let share = 10.0 * self.tolerance.sqrt();
        while *level < LEVELS {
            let step = solve(ladder, ladder.response(*level), begin, &self.goal);
            if let Some(step) = step
                && step.roughness <= self.goal.roughness.min(share * step.fastest)
            {
                return Some(step);
            }
            *level += 1;
        }
        None
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
