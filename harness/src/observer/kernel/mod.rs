//! The recursions: Kalman filter forwards, fixed-interval smoother backwards.
//!
//! Filter (Kalman 1960; covariance update in Joseph's form for a scalar measurement) and
//! smoother in the adjoint form of Bryson and Frazier 1963 / de Jong 1989, which gives the same
//! numbers as Rauch, Tung and Striebel 1965 without inverting a covariance:
//! `x_(k|N) = x_(k|k-1) + P lambda`, `P_(k|N) = P - P Lambda P`.
//!
//! The covariances depend on the pattern of samples only. Where that pattern is uniform they
//! converge, and from then on the converged gain is used; at gaps the full recursion resumes.
//! Matrix sizes are compile-time constants; an uncommon size is padded with inert states.

mod backward;
mod filter;
mod small_matrix;

use super::structure::DiscreteModel;
use backward::Forward;
use filter::{Fixed, Gain};
use nalgebra::{DMatrix, DVector};

/// Relative change per step below which a covariance counts as converged.
const CONVERGED: f64 = 1e-11;

/// Number of output directions with a variance: force, displacement, velocity.
const OUTPUTS: usize = 3;

/// Process noise whose level differs from interval to interval.
pub(in crate::observer) struct VaryingNoise<'a> {
    /// Covariance per interval at level 1.
    pub unit: &'a DMatrix<f64>,
    /// Level of interval `k` to `k + 1`.
    pub level: &'a [f64],
}

/// Something known besides what is measured at one sample:
/// `velocity w' + force F x_s = value`, with a variance; nothing if `value` is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::observer) struct Known {
    /// Factor on the tip velocity (m/s).
    pub velocity: f64,
    /// Factor on the scaled force state (m).
    pub force: f64,
    pub value: f64,
    pub variance: f64,
}

impl Known {
    pub const NOTHING: Known = Known {
        velocity: 0.0,
        force: 0.0,
        value: f64::NAN,
        variance: 1.0,
    };

    /// Tip velocity in m/s with its variance.
    pub fn velocity(value: f64, variance: f64) -> Known {
        Known {
            velocity: 1.0,
            force: 0.0,
            value,
            variance,
        }
    }

    /// Scaled force state in m with its variance.
    pub fn force(value: f64, variance: f64) -> Known {
        Known {
            velocity: 0.0,
            force: 1.0,
            value,
            variance,
        }
    }

    /// Whether the velocity is known.
    pub fn holds(&self) -> bool {
        self.is_something() && self.velocity != 0.0
    }

    pub fn is_something(&self) -> bool {
        !self.value.is_nan()
    }
}

/// One filtering or smoothing task.
pub(in crate::observer) struct Problem<'a> {
    pub model: &'a DiscreteModel,
    /// Process noise covariance per interval, the constant part.
    pub noise: DMatrix<f64>,
    /// Process noise, the varying parts.
    pub varying: Vec<VaryingNoise<'a>>,
    /// Variance of the measurement noise, in the square of what is measured.
    pub measurement_variance: f64,
    /// What was measured, in m, m/s or m/s^2; NaN where missing.
    pub measured: &'a [f64],
    /// What else is known, sample by sample.
    pub known: Option<&'a [Known]>,
    pub start: DVector<f64>,
    pub start_covariance: DMatrix<f64>,
    /// Use the converged gain where the sample pattern is uniform.
    pub converge: bool,
}

/// Terms of the Gaussian likelihood of what is measured.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::observer) struct Likelihood {
    pub count: f64,
    /// Sum of `ln s_k`.
    pub sum_log: f64,
    /// Sum of `e_k^2 / s_k`.
    pub sum_square: f64,
}

/// Smoothed quantities, scaled states.
pub(in crate::observer) struct Solution {
    /// Sample by sample, `size` states each.
    pub states: Vec<f64>,
    pub size: usize,
    /// Variance of force state (m^2), displacement (m^2) and velocity (m^2/s^2).
    pub variance: [Vec<f64>; OUTPUTS],
    /// Innovation over its standard deviation; NaN where no sample.
    pub innovation: Vec<f64>,
    pub likelihood: Likelihood,
    /// Sum of squared normalised innovations of what else was known, and their number.
    pub held: (f64, f64),
    /// Second moment of the increment of each force state per interval, if asked for.
    pub increments: Vec<Vec<f64>>,
}

impl Solution {
    /// A solution to be filled by [`Solution::take`].
    pub fn empty(count: usize, size: usize) -> Self {
        Self {
            states: vec![0.0; count * size],
            size,
            variance: std::array::from_fn(|_| vec![0.0; count]),
            innovation: vec![f64::NAN; count],
            likelihood: Likelihood::default(),
            held: (0.0, 0.0),
            increments: Vec::new(),
        }
    }

    /// Takes the samples `range` from a solution of a part that begins at sample `from`.
    pub fn take(&mut self, part: &Solution, from: usize, range: std::ops::Range<usize>) {
        let inner = range.start - from..range.end - from;
        let scaled = |r: &std::ops::Range<usize>| r.start * self.size..r.end * self.size;
        self.states[scaled(&range)].copy_from_slice(&part.states[scaled(&inner)]);
        for (out, column) in self.variance.iter_mut().zip(&part.variance) {
            out[range.clone()].copy_from_slice(&column[inner.clone()]);
        }
        self.innovation[range].copy_from_slice(&part.innovation[inner]);
        self.likelihood.count += part.likelihood.count;
        self.likelihood.sum_log += part.likelihood.sum_log;
        self.likelihood.sum_square += part.likelihood.sum_square;
        self.held.0 += part.held.0;
        self.held.1 += part.held.1;
    }

    /// Root mean square of the normalised innovations of what else was known; 0 if there was none.
    pub fn held_misfit(&self) -> f64 {
        (self.held.0 / self.held.1.max(1.0)).sqrt()
    }
}

/// Filters only and returns the likelihood.
pub(in crate::observer) fn likelihood(problem: &Problem) -> Likelihood {
    dispatch(problem, Task::Likelihood).likelihood
}

/// Filters and smooths. `increments` asks for the second moments of the force increments.
pub(in crate::observer) fn smooth(problem: &Problem, increments: bool) -> Solution {
    dispatch(problem, Task::Smooth { increments })
}

#[derive(Clone, Copy, PartialEq)]
enum Task {
    Likelihood,
    Smooth { increments: bool },
}

fn dispatch(problem: &Problem, task: Task) -> Solution {
    match problem.model.output.len() {
        ..=3 => run::<3>(problem, task),
        4 => run::<4>(problem, task),
        5 => run::<5>(problem, task),
        6 => run::<6>(problem, task),
        7 => run::<7>(problem, task),
        8 => run::<8>(problem, task),
        9..=12 => run::<12>(problem, task),
        13..=18 => run::<18>(problem, task),
        _ => run::<34>(problem, task),
    }
}

fn run<const N: usize>(problem: &Problem, task: Task) -> Solution {
    let fixed = Fixed::<N>::new(problem);
    let count = problem.measured.len();
    let size = problem.model.output.len();
    let mut likelihood = Likelihood::default();
    let mut add = |gain: &Gain<N>, e: f64| {
        if gain.variance.is_finite() {
            likelihood.count += 1.0;
            likelihood.sum_log += gain.variance.ln();
            likelihood.sum_square += e * e / gain.variance;
        }
    };
    let mut solution = Solution::empty(0, size);
    let Task::Smooth { increments } = task else {
        fixed.filter(|_, _, _, gain, e, _| add(gain, e));
        solution.likelihood = likelihood;
        return solution;
    };
    let mut forward = Forward::<N> {
        states: Vec::with_capacity(count),
        innovation: Vec::with_capacity(count),
        held_innovation: Vec::new(),
        number: Vec::with_capacity(count),
        gains: Vec::new(),
    };
    solution.innovation.reserve(count);
    fixed.filter(|_, x, number, gain, e, e_held| {
        add(gain, e);
        forward.states.push(*x);
        forward.innovation.push(e);
        if fixed.known.is_some() {
            forward.held_innovation.push(e_held);
            if gain.held_variance.is_finite() {
                solution.held.0 += e_held * e_held / gain.held_variance;
                solution.held.1 += 1.0;
            }
        }
        if forward.gains.len() <= number as usize {
            forward.gains.push(*gain);
        }
        forward.number.push(number);
        solution.innovation.push(if gain.variance.is_finite() {
            e / gain.variance.sqrt()
        } else {
            f64::NAN
        });
    });
    solution.likelihood = likelihood;
    solution.states = vec![0.0; count * size];
    solution.variance = std::array::from_fn(|_| vec![0.0; count]);
    if increments {
        let states = size - problem.model.force_index;
        solution.increments = vec![vec![0.0; count]; states];
    }
    fixed.backward(&forward, problem.model, &mut solution);
    solution
}
