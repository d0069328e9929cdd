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

use super::structure::DiscreteModel;
use nalgebra::{DMatrix, DVector};

/// Relative change per step below which a covariance counts as converged.
const CONVERGED: f64 = 1e-11;

/// Number of output directions with a variance: force, displacement, velocity.
const OUTPUTS: usize = 3;

/// Process noise whose level differs from interval to interval.
pub(super) struct VaryingNoise<'a> {
    /// Covariance per interval at level 1.
    pub unit: &'a DMatrix<f64>,
    /// Level of interval `k` to `k + 1`.
    pub level: &'a [f64],
}

/// Something known besides the displacement at one sample:
/// `velocity w' + force F x_s = value`, with a variance; nothing if `value` is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Known {
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

    pub fn is_something(&self) -> bool {
        !self.value.is_nan()
    }
}

/// One filtering or smoothing task.
pub(super) struct Problem<'a> {
    pub model: &'a DiscreteModel,
    /// Process noise covariance per interval, the constant part.
    pub noise: DMatrix<f64>,
    /// Process noise, the varying parts.
    pub varying: Vec<VaryingNoise<'a>>,
    /// Variance of the measurement noise in m^2.
    pub measurement_variance: f64,
    /// Displacement in m; NaN where missing.
    pub displacement: &'a [f64],
    /// What else is known, sample by sample.
    pub known: Option<&'a [Known]>,
    pub start: DVector<f64>,
    pub start_covariance: DMatrix<f64>,
    /// Use the converged gain where the sample pattern is uniform.
    pub converge: bool,
}

/// Terms of the Gaussian likelihood of the displacement.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Likelihood {
    pub count: f64,
    /// Sum of `ln s_k`.
    pub sum_log: f64,
    /// Sum of `e_k^2 / s_k`.
    pub sum_square: f64,
}

/// Smoothed quantities, scaled states.
pub(super) struct Solution {
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
pub(super) fn likelihood(problem: &Problem) -> Likelihood {
    dispatch(problem, Task::Likelihood).likelihood
}

/// Filters and smooths. `increments` asks for the second moments of the force increments.
pub(super) fn smooth(problem: &Problem, increments: bool) -> Solution {
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

type Vector<const N: usize> = [f64; N];
type Matrix<const N: usize> = [[f64; N]; N];

/// What the filter knows at one sample before it sees it, and the gains there.
#[derive(Clone, Copy)]
struct Gain<const N: usize> {
    covariance: Matrix<N>,
    gain: Vector<N>,
    /// Innovation variance; infinite where there is no sample.
    variance: f64,
    /// The same for what else is known, applied after the displacement.
    held_gain: Vector<N>,
    held_variance: f64,
}

struct Fixed<'a, const N: usize> {
    a: Matrix<N>,
    c: Vector<N>,
    velocity: Vector<N>,
    noise: Matrix<N>,
    varying: Vec<(Matrix<N>, &'a [f64])>,
    r: f64,
    force_index: usize,
    displacement: &'a [f64],
    known: Option<&'a [Known]>,
    start: Vector<N>,
    start_covariance: Matrix<N>,
    converge: bool,
}

impl<'a, const N: usize> Fixed<'a, N> {
    fn new(problem: &'a Problem) -> Self {
        Self {
            a: matrix(&problem.model.transition),
            c: vector(&problem.model.output),
            velocity: vector(&problem.model.velocity),
            noise: matrix(&problem.noise),
            varying: problem
                .varying
                .iter()
                .map(|v| (matrix(v.unit), v.level))
                .collect(),
            r: problem.measurement_variance,
            force_index: problem.model.force_index,
            displacement: problem.displacement,
            known: problem.known,
            start: vector(&problem.start),
            start_covariance: matrix(&problem.start_covariance),
            converge: problem.converge && problem.varying.is_empty(),
        }
    }

    fn known_at(&self, k: usize) -> Option<&Known> {
        self.known
            .map(|known| &known[k])
            .filter(|k| k.is_something())
    }

    /// The row of something known over the states.
    fn row(&self, known: &Known) -> Vector<N> {
        let mut row = self.velocity.map(|v| v * known.velocity);
        row[self.force_index] += known.force;
        row
    }

    /// Process noise covariance of interval `k` to `k + 1`.
    fn noise_at(&self, k: usize) -> Matrix<N> {
        let mut q = self.noise;
        for (unit, level) in &self.varying {
            add_scaled(&mut q, unit, level[k]);
        }
        q
    }

    fn gain(
        &self,
        covariance: &Matrix<N>,
        seen: bool,
        known: Option<&Known>,
    ) -> (Gain<N>, Matrix<N>) {
        let mut p = *covariance;
        let mut out = Gain {
            covariance: *covariance,
            gain: [0.0; N],
            variance: f64::INFINITY,
            held_gain: [0.0; N],
            held_variance: f64::INFINITY,
        };
        if seen {
            (out.gain, out.variance) = measure(&mut p, &self.c, self.r);
        }
        if let Some(known) = known {
            (out.held_gain, out.held_variance) = measure(&mut p, &self.row(known), known.variance);
        }
        (out, p)
    }

    /// Runs the filter; `visit(k, predicted state, gain number, gain, innovation, held innovation)`.
    fn filter(&self, mut visit: impl FnMut(usize, &Vector<N>, u32, &Gain<N>, f64, f64)) {
        let mut x = self.start;
        let mut p = self.start_covariance;
        let mut number = 0_u32;
        let mut steady: Option<Gain<N>> = None;
        for (k, &y) in self.displacement.iter().enumerate() {
            let (seen, known) = (!y.is_nan(), self.known_at(k));
            let gain = match steady {
                Some(gain) if seen && known.is_none() => gain,
                _ => {
                    steady = None;
                    number += u32::from(k > 0);
                    let (gain, filtered) = self.gain(&p, seen, known);
                    let mut next = congruence(&self.a, &filtered);
                    add_scaled(&mut next, &self.noise, 1.0);
                    for (unit, level) in &self.varying {
                        add_scaled(&mut next, unit, level[k]);
                    }
                    if self.converge && seen && known.is_none() && close(&p, &next) {
                        steady = Some(gain);
                    } else {
                        p = next;
                    }
                    gain
                }
            };
            let e = if seen { y - dot(&self.c, &x) } else { 0.0 };
            let mut filtered = x;
            axpy(&mut filtered, e, &gain.gain);
            let mut e_held = 0.0;
            if let Some(known) = known {
                e_held = known.value - dot(&self.row(known), &filtered);
                axpy(&mut filtered, e_held, &gain.held_gain);
            }
            visit(k, &x, number, &gain, e, e_held);
            x = times(&self.a, &filtered);
        }
    }

    fn backward(&self, forward: &Forward<N>, model: &DiscreteModel, solution: &mut Solution) {
        let n = self.displacement.len();
        let f = model.force_index;
        let mut unit = [0.0; N];
        unit[f] = 1.0;
        let directions = [unit, self.c, self.velocity];
        let mut lambda = [0.0; N];
        // Information of the later samples, without and with the present one.
        let mut information: Matrix<N> = [[0.0; N]; N];
        let mut seen = information;
        let mut variance = [0.0; OUTPUTS];
        // Set while the information stays at its converged value for this gain.
        let mut steady: Option<u32> = None;
        for k in (0..n).rev() {
            let number = forward.number[k];
            let gain = &forward.gains[number as usize];
            let held = self.known_at(k).map(|known| self.row(known));
            if let Some(row) = &held {
                let e = forward.held_innovation[k];
                let t = e / gain.held_variance - dot(&gain.held_gain, &lambda);
                axpy(&mut lambda, t, row);
            }
            if gain.variance.is_finite() {
                let t = forward.innovation[k] / gain.variance - dot(&gain.gain, &lambda);
                axpy(&mut lambda, t, &self.c);
            }
            let p = &gain.covariance;
            let mut x = forward.states[k];
            for (x, row) in x.iter_mut().zip(p) {
                *x += dot(row, &lambda);
            }
            solution.states[k * solution.size..(k + 1) * solution.size]
                .copy_from_slice(&x[..solution.size]);
            if steady != Some(number) {
                steady = None;
                seen = information;
                if let Some(row) = &held {
                    absorb(&mut seen, row, &gain.held_gain, gain.held_variance);
                }
                if gain.variance.is_finite() {
                    absorb(&mut seen, &self.c, &gain.gain, gain.variance);
                }
                for (variance, u) in variance.iter_mut().zip(&directions) {
                    let pu = times(p, u);
                    *variance = (dot(u, &pu) - quadratic(&seen, &pu)).max(0.0);
                }
            }
            for (out, value) in solution.variance.iter_mut().zip(variance) {
                out[k] = value;
            }
            if k > 0 && !solution.increments.is_empty() {
                let q = self.noise_at(k - 1);
                for (state, out) in solution.increments.iter_mut().enumerate() {
                    let row = &q[f + state];
                    let mean = dot(row, &lambda);
                    out[k - 1] = mean * mean + row[f + state] - quadratic(&seen, row);
                }
            }
            lambda = transposed_times(&self.a, &lambda);
            if steady.is_none() {
                let next = transposed_congruence(&self.a, &seen);
                let uniform = k > 0 && forward.number[k - 1] == number;
                if self.converge && uniform && close(&information, &next) {
                    steady = Some(number);
                }
                information = next;
            }
        }
    }
}

/// What the filter leaves for the smoother.
struct Forward<const N: usize> {
    states: Vec<Vector<N>>,
    innovation: Vec<f64>,
    held_innovation: Vec<f64>,
    number: Vec<u32>,
    gains: Vec<Gain<N>>,
}

fn run<const N: usize>(problem: &Problem, task: Task) -> Solution {
    let fixed = Fixed::<N>::new(problem);
    let count = problem.displacement.len();
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

/// Scalar measurement `row x` with variance `r`: gain, innovation variance; `p` is updated.
fn measure<const N: usize>(p: &mut Matrix<N>, row: &Vector<N>, r: f64) -> (Vector<N>, f64) {
    let h = times(p, row);
    let s = dot(row, &h) + r;
    let gain = h.map(|h| h / s);
    for i in 0..N {
        for j in 0..=i {
            let value = p[i][j] - gain[i] * h[j] - h[i] * gain[j] + s * gain[i] * gain[j];
            p[i][j] = value;
            p[j][i] = value;
        }
    }
    (gain, s)
}

/// Takes a measurement into the smoother's information: `(I - K c)' M (I - K c) + c' c / s`.
fn absorb<const N: usize>(m: &mut Matrix<N>, row: &Vector<N>, gain: &Vector<N>, s: f64) {
    let h = times(m, gain);
    let t = dot(gain, &h) + 1.0 / s;
    for i in 0..N {
        for j in 0..=i {
            let value = m[i][j] - row[i] * h[j] - h[i] * row[j] + t * row[i] * row[j];
            m[i][j] = value;
            m[j][i] = value;
        }
    }
}

fn close<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> bool {
    (0..N).all(|i| {
        (0..=i).all(|j| (a[i][j] - b[i][j]).abs() <= CONVERGED * (a[i][i] * a[j][j]).abs().sqrt())
    })
}

fn dot<const N: usize>(a: &Vector<N>, b: &Vector<N>) -> f64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += a[i] * b[i];
    }
    sum
}

fn axpy<const N: usize>(y: &mut Vector<N>, a: f64, x: &Vector<N>) {
    for i in 0..N {
        y[i] += a * x[i];
    }
}

fn times<const N: usize>(a: &Matrix<N>, x: &Vector<N>) -> Vector<N> {
    std::array::from_fn(|i| dot(&a[i], x))
}

fn transposed_times<const N: usize>(a: &Matrix<N>, x: &Vector<N>) -> Vector<N> {
    let mut out = [0.0; N];
    for i in 0..N {
        axpy(&mut out, x[i], &a[i]);
    }
    out
}

fn quadratic<const N: usize>(m: &Matrix<N>, x: &Vector<N>) -> f64 {
    dot(x, &times(m, x))
}

fn add_scaled<const N: usize>(m: &mut Matrix<N>, other: &Matrix<N>, factor: f64) {
    for i in 0..N {
        axpy(&mut m[i], factor, &other[i]);
    }
}

/// `A P A'` for symmetric `P`.
fn congruence<const N: usize>(a: &Matrix<N>, p: &Matrix<N>) -> Matrix<N> {
    let mut ap = [[0.0; N]; N];
    for i in 0..N {
        for l in 0..N {
            axpy(&mut ap[i], a[i][l], &p[l]);
        }
    }
    let mut out = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..=i {
            let value = dot(&ap[i], &a[j]);
            out[i][j] = value;
            out[j][i] = value;
        }
    }
    out
}

/// `A' M A` for symmetric `M`.
fn transposed_congruence<const N: usize>(a: &Matrix<N>, m: &Matrix<N>) -> Matrix<N> {
    let mut ma = [[0.0; N]; N];
    for i in 0..N {
        for l in 0..N {
            axpy(&mut ma[i], m[i][l], &a[l]);
        }
    }
    let mut out = [[0.0; N]; N];
    for l in 0..N {
        for i in 0..N {
            axpy(&mut out[i], a[l][i], &ma[l]);
        }
    }
    out
}

fn vector<const N: usize>(v: &DVector<f64>) -> Vector<N> {
    std::array::from_fn(|i| if i < v.len() { v[i] } else { 0.0 })
}

fn matrix<const N: usize>(m: &DMatrix<f64>) -> Matrix<N> {
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            if i < m.nrows() && j < m.ncols() {
                m[(i, j)]
            } else {
                0.0
            }
        })
    })
}
