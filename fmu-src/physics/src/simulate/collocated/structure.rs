//! What depends on the structure alone: responses of slip, and a long step of stick.

use super::super::InMode;
use crate::contact::ContactMode;
use crate::integrate::collocation::{
    Chebyshev, Ladder, Oscillator, TERMS, from_values, places, spread, value_in_any,
};
use crate::integrate::linear::LinearSystem;
use crate::integrate::{MAX_STATES, Scales, Segment, State, row_of};
use crate::model::Model;
use std::cell::RefCell;
use std::sync::Arc;

/// Length of a step of stick times highest angular frequency.
const STICK: f64 = 8.0;

/// Share in the tip's velocity, against the largest, below which a mode does not matter for the tolerance.
const FAINT: f64 = 0.01;

/// A structure with its responses.
pub(super) struct Structure {
    pub(super) ladder: Ladder,
    pub(super) stick: StickStep,
}

/// One step of stick from unit states; stick is linear and does not know the belt but by its state.
pub(super) struct StickStep {
    /// Length in s.
    pub(super) length: f64,
    /// Constraint force in N.
    force: Vec<Chebyshev>,
    /// Each state, from all unit states in turn.
    states: Vec<Vec<Chebyshev>>,
    /// The states at the end.
    end: Vec<State>,
}

/// The motion along one step of stick.
pub(super) struct Stuck {
    /// Constraint force in N.
    pub(super) force: Chebyshev,
    /// How far in N it can be from its mean.
    pub(super) spread: f64,
    /// The states at the end.
    pub(super) end: State,
}

impl Stuck {
    /// Nothing yet.
    pub(super) const REST: Self = Self {
        force: [0.0; TERMS],
        spread: 0.0,
        end: [0.0; MAX_STATES],
    };
}

thread_local! {
    /// The structure of the point before: most studies vary something else.
    static LAST: RefCell<Option<Arc<Structure>>> = const { RefCell::new(None) };
}

/// The structure of a model; `None` where a mode is not an oscillation, or where none moves the tip.
pub(super) fn of(model: &Model) -> Option<Arc<Structure>> {
    let modes = model.beam().modes().iter();
    let oscillators: Vec<_> = modes
        .map(|m| Oscillator {
            frequency: m.angular_frequency(),
            damping: m.damping_ratio + 0.5 * m.damping_rate / m.angular_frequency(),
            seen: m.tip_value,
            gain: m.tip_value / m.mass,
        })
        .collect();
    LAST.with_borrow_mut(|last| {
        if let Some(known) = last
            && known.ladder.oscillators() == oscillators
        {
            return Some(known.clone());
        }
        let swings = |o: &Oscillator| o.frequency > 0.0 && (0.0..1.0).contains(&o.damping);
        if !oscillators.iter().all(swings) || !(model.beam().tip_mobility() > 0.0) {
            return None;
        }
        let made = Arc::new(Structure {
            stick: StickStep::new(model),
            ladder: Ladder::new(oscillators),
        });
        *last = Some(made.clone());
        Some(made)
    })
}

impl Structure {
    /// The smallest of the oscillators' shares in the tip's velocity, from the magnitudes of the states, in m/s; those that
    /// hardly move the tip do not count.
    pub(super) fn velocity_scale(&self, scales: &Scales) -> f64 {
        let of = |(j, o): (usize, &Oscillator)| (o.seen * scales[2 * j + 1]).abs();
        let all = || self.ladder.oscillators().iter().enumerate().map(of);
        let most = all().fold(0.0, f64::max);
        all().filter(|v| *v >= FAINT * most).fold(most, f64::min)
    }
}

impl StickStep {
    fn new(model: &Model) -> Self {
        let system = InMode {
            model,
            mode: ContactMode::Stuck,
        };
        let highest = model.highest_frequency();
        let linear = LinearSystem::probe(&system, 0.0, highest);
        let (row, _) = row_of(model.dimension(), |x| model.constraint_force(0.0, x));
        let length = STICK / highest;
        let dimension = model.dimension();
        let mut out = Self {
            length,
            force: Vec::new(),
            states: vec![Vec::new(); dimension],
            end: Vec::new(),
        };
        for i in 0..dimension {
            let mut x = [0.0; MAX_STATES];
            x[i] = 1.0;
            let mut segment = Segment::point(0.0, &x, dimension);
            linear.segment(0.0, &x, &mut segment);
            let mut at = |t: f64| {
                while t > segment.end {
                    segment.state_at(1.0, &mut x);
                    linear.segment(segment.end, &x, &mut segment);
                }
                let mut there = [0.0; MAX_STATES];
                segment.state_at(segment.theta(t), &mut there);
                there
            };
            let samples = places().map(|theta| at(theta * length));
            let series = |of: &dyn Fn(&State) -> f64| -> Chebyshev {
                from_values(&std::array::from_fn::<f64, TERMS, _>(|k| of(&samples[k])))
            };
            let force = |x: &State| row.iter().zip(x).map(|(a, b)| a * b).sum();
            out.force.push(series(&force));
            for (j, columns) in out.states.iter_mut().enumerate() {
                columns.push(series(&|x| x[j]));
            }
            out.end.push(at(length));
        }
        out
    }

    /// One step from `x`.
    pub(super) fn take(&self, x: &State, into: &mut Stuck) {
        take(self, x, into);
    }

    /// The state a time `t` in s after `x`.
    pub(super) fn state_at(&self, t: f64, x: &State) -> State {
        let mut begin = *x;
        let mut left = t / self.length;
        let mut stuck = Stuck::REST;
        while left > 1.0 {
            self.take(&begin, &mut stuck);
            begin = stuck.end;
            left -= 1.0;
        }
        inside(self, left, &begin)
    }
}

/// [`StickStep::take`], for each instruction set.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
fn take(step: &StickStep, x: &State, into: &mut Stuck) {
    let (mut force, mut end) = ([0.0; TERMS], [0.0; MAX_STATES]);
    for ((column, after), x) in step.force.iter().zip(&step.end).zip(x) {
        for k in 0..TERMS {
            force[k] = column[k].mul_add(*x, force[k]);
        }
        for i in 0..MAX_STATES {
            end[i] = after[i].mul_add(*x, end[i]);
        }
    }
    into.force = force;
    into.end = end;
    into.spread = spread(&into.force);
}

/// The state at `theta` of one step from `x`.
#[multiversion::multiversion(targets("x86_64+avx512f+avx512dq+avx512vl+fma", "x86_64+avx2+fma"))]
fn inside(step: &StickStep, theta: f64, x: &State) -> State {
    let mut out = [0.0; MAX_STATES];
    for (j, columns) in step.states.iter().enumerate() {
        let mut series = [0.0; TERMS];
        for (column, x) in columns.iter().zip(x) {
            for k in 0..TERMS {
                series[k] = column[k].mul_add(*x, series[k]);
            }
        }
        out[j] = value_in_any(&series, theta);
    }
    out
}
