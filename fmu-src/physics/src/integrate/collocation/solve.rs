//! The step itself: from what is expected of it to the force at its nodes.

use super::iterate::Iteration;
use super::response::{Ladder, Response};
use super::{Characteristic, NODES, Nodes};
use crate::integrate::State;

/// How exact a step must be, and how far it may go.
#[derive(Debug, Clone, Copy)]
pub struct Goal {
    /// Speed in m/s that counts as nothing.
    pub speed: f64,
    /// The same as a share of the largest speed in the step.
    pub share: f64,
    /// Largest [`Step::roughness`] in m/s.
    pub roughness: f64,
    /// Speed in m/s by which a step may run beyond u = 0.
    pub overshoot: f64,
}

/// The tangent of the characteristic at one speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    /// The speed in m/s.
    pub speed: f64,
    /// The force in N.
    pub force: f64,
    /// The slope in N s/m.
    pub slope: f64,
}

/// What a step starts from, and what acts.
#[derive(Debug, Clone, Copy)]
pub struct Begin<'a> {
    /// The states.
    pub state: &'a State,
    /// Sign s of the sliding speed.
    pub sign: f64,
    /// Velocity v0 in m/s.
    pub belt: f64,
    /// The characteristic.
    pub law: &'a Characteristic,
}

/// The characteristic at the nodes of a step.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Along {
    /// Sliding speed u in m/s.
    pub speed: Nodes,
    /// Force p in N.
    pub force: Nodes,
    /// Slope p' in N s/m.
    pub slope: Nodes,
    /// Half the second derivative, p''/2 in N s^2/m^2.
    pub half_bend: Nodes,
    /// A bound of the third derivative in N s^3/m^3 near these speeds ([`Characteristic::third_near`]).
    pub third: f64,
}

impl Along {
    /// The tangent at the last node.
    pub fn last(&self) -> Tangent {
        Tangent {
            speed: self.speed[NODES - 1],
            force: self.force[NODES - 1],
            slope: self.slope[NODES - 1],
        }
    }
}

/// What is expected of a step.
#[derive(Debug, Clone, Copy)]
pub enum Expected<'a> {
    /// Speeds near its begin.
    Tangent(Tangent),
    /// Speeds near those of a step of the same length that was solved before.
    Known {
        /// The characteristic along that step.
        along: &'a Along,
        /// Whether it is to be worked out anew along this one, although it need not.
        renew: bool,
    },
}

/// A step solved.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Step {
    /// Force p in N at the nodes.
    pub capacity: Nodes,
    /// Slope p' in N s/m at the nodes.
    pub slope: Nodes,
    /// The characteristic at the nodes, where it was worked out, and not taken from a step that was solved before.
    pub along: Option<Along>,
    /// Iterations about the step solved before, where nothing had to be worked out.
    pub iterations: usize,
    /// Largest sliding speed in m/s at the nodes.
    pub fastest: f64,
    /// The larger of the two last Legendre coefficients of p, as the change of speed in m/s that it would make over the step
    /// as a constant force.
    pub roughness: f64,
}

/// The force at the nodes of a step into `step`, from what is expected of it; false where the iteration does not converge, or
/// where the step is far too rough or runs too far beyond u = 0.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
pub fn solve(
    ladder: &Ladder,
    response: &Response,
    begin: &Begin,
    expected: Expected,
    goal: &Goal,
    step: &mut Step,
) -> bool {
    solve_in_any(ladder, response, begin, expected, goal, step)
}

#[inline(always)]
fn solve_in_any(
    ladder: &Ladder,
    response: &Response,
    begin: &Begin,
    expected: Expected,
    goal: &Goal,
    step: &mut Step,
) -> bool {
    let on = (ladder, response);
    match expected {
        Expected::Known { along, renew } => {
            let slopes = [along.slope[0], along.slope[NODES - 1]];
            let near = (&along.force, &along.speed);
            let mut iteration = Iteration::start(on, begin, goal, slopes, near);
            !iteration.runs_over()
                && (iteration.about(along, renew, step) || iteration.iterate(false, step))
        }
        Expected::Tangent(t) => {
            let near = (&[t.force; NODES], &[t.speed; NODES]);
            let mut iteration = Iteration::start(on, begin, goal, [t.slope; 2], near);
            !iteration.runs_over() && iteration.iterate(true, step)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::MAX_STATES;
    use crate::integrate::collocation::expand::expand_in_any;
    use crate::integrate::collocation::{Course, Oscillator, expand};

    // Source: the same functions compiled for the least processor, where every product is fused by the library.
    #[test]
    fn val_vectors_of_any_width_find_the_same_digits() {
        let oscillator = |frequency, seen: f64| Oscillator {
            frequency,
            damping: 0.001,
            seen,
            gain: seen / 0.4,
        };
        let ladder = Ladder::new(vec![oscillator(500.0, 2.0), oscillator(3200.0, -2.0)]);
        let law = Characteristic {
            constant: 16.5,
            linear: 0.3,
            weight: [16.5, 16.5, 16.5],
            rate: [50.0, 0.25],
            squared: false,
        };
        let goal = Goal {
            speed: 1e-12,
            share: 1e-8,
            roughness: 1e-6,
            overshoot: 0.01,
        };
        let mut solved = 0;
        for level in 0..8 {
            for i in 0..40 {
                let mut state = [0.0; MAX_STATES];
                state[0] = 1e-3 - 5e-5 * f64::from(i);
                state[1] = -0.02 * f64::from(i);
                state[3] = 0.01 * f64::from(i % 7);
                let speed = 0.1 - 2.0 * state[1] + 2.0 * state[3];
                let begin = Begin {
                    state: &state,
                    sign: -1.0,
                    belt: 0.1,
                    law: &law,
                };
                let expected = Expected::Tangent(law.tangent(speed));
                let response = ladder.response(level);
                let (mut step, mut same) = (Step::default(), Step::default());
                let here = solve(&ladder, response, &begin, expected, &goal, &mut step);
                let there = solve_in_any(&ladder, response, &begin, expected, &goal, &mut same);
                assert_eq!((here, step), (there, same));
                if !here {
                    continue;
                }
                solved += 1;
                let (mut wide, mut narrow) = (Course::REST, Course::REST);
                expand(response, &begin, &step.capacity, &mut wide);
                expand_in_any(response, &begin, &step.capacity, &mut narrow);
                assert_eq!(wide, narrow);
            }
        }
        assert!(solved > 100, "{solved}");
    }
}
