//! A linear model in the place of the FMU, on which fit, elimination and evidence have closed forms.
//!
//! ```text
//! w(t) = x_1 + x_2 t + b_r + sum_c theta_c phi_c(t),   phi_c = cos((c + 1) 40 t / s)
//! ```
//!
//! (phi_4 is 1e8) with a start state x of each segment, an offset b_r of each run and shared parameters theta. Everything believed of them is
//! normal, the noise is white: the posterior is normal, and its mean, covariance and evidence follow from one linear system.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::sensitivities::Known;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::parameter::{Kind, Parameter, Scale};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{Samples, SegmentStart, SegmentValues, Simulator, Turn};
use crate::diagnose::model::work::Work;
use crate::diagnose::thresholds::STATE_SPREAD;
use crate::error::Error;
use nalgebra::{DMatrix, DVector};

pub(crate) const NOISE: f64 = 1e-6;
const RUNS: usize = 2;
const SEGMENTS: usize = 3;
const SAMPLES: usize = 60;
const INTERVAL: f64 = 1e-3;
/// What is believed of every parameter: zero, with this standard deviation in m.
const BELIEF: f64 = 3e-6;

/// A shared parameter that acts strongly, but just as the first component of the start state does.
const IMITATED: usize = 4;

/// The linear model; with `tangents` it tells its derivatives, else they are taken by differences.
pub(crate) struct LinearToy {
    tangents: bool,
    /// Beginning of the segment predicted last, in s, and its state there.
    last: (f64, [f64; 2]),
}

impl LinearToy {
    pub(crate) fn new(tangents: bool) -> Self {
        let last = (0.0, [0.0; 2]);
        Self { tangents, last }
    }
}

/// What the shared parameter with this number does.
pub(crate) fn shape(c: usize, t: f64) -> f64 {
    match c {
        IMITATED => 1e8,
        _ => (40.0 * (c + 1) as f64 * t).cos(),
    }
}

fn slope(turn: Turn, t: f64, start: f64) -> f64 {
    match turn {
        Turn::State(0) => 1.0,
        Turn::State(_) => t - start,
        Turn::Shared(c) => shape(c, t),
        Turn::PerRun(_) => 0.5,
    }
}

impl Simulator for LinearToy {
    fn predict(
        &mut self,
        segment: &Segment,
        values: SegmentValues,
        samples: Samples,
        out: &mut Vec<f64>,
    ) -> Result<bool, Error> {
        self.last = (segment.time[0], [values.state[0], values.state[1]]);
        out.clear();
        out.extend((0..samples.count).map(|i| {
            let t = segment.time[i * samples.stride];
            let of = |turn| slope(turn, t, segment.time[0]);
            let shared = values.shared.iter().enumerate();
            let states = values.state.iter().enumerate();
            shared.map(|(c, u)| u * of(Turn::Shared(c))).sum::<f64>()
                + states.map(|(c, x)| x * of(Turn::State(c))).sum::<f64>()
                + values.per_run[0] * of(Turn::PerRun(0))
        }));
        Ok(true)
    }

    fn differentiate(
        &mut self,
        segment: &Segment,
        _: SegmentValues,
        turns: &[Turn],
        samples: Samples,
        slopes: &mut Vec<f64>,
    ) -> bool {
        slopes.clear();
        for turn in turns {
            let times = (0..samples.count).map(|i| segment.time[i * samples.stride]);
            slopes.extend(times.map(|t| slope(*turn, t, segment.time[0])));
        }
        self.tangents
    }

    fn carry_on(&mut self, next: &Segment, _: &[f64], _: &[f64]) -> Result<SegmentStart, Error> {
        let (from, [deflection, rate]) = self.last;
        Ok(SegmentStart {
            state: vec![deflection + rate * (next.time[0] - from), rate],
            stuck: next.stuck,
        })
    }

    fn limit(&self, _: usize) -> f64 {
        1.0
    }
}

fn parameter(kind: Kind, name: &str) -> Parameter {
    Parameter {
        name: name.into(),
        unit: "m".into(),
        kind,
        targets: Vec::new(),
        scale: Scale::Linear,
        prior: 0.0,
        prior_std: BELIEF,
        min: -1.0,
        max: 1.0,
        step: 1e-7,
        support: None,
    }
}

/// The toy with so many shared parameters.
pub(crate) fn hypothesis(shared: usize) -> Hypothesis {
    Hypothesis {
        choices: Vec::new(),
        shared: (0..shared)
            .map(|c| parameter(Kind::Reference, &format!("theta_{c}")))
            .collect(),
        per_run: vec![vec![parameter(Kind::Offset, "offset")]; RUNS],
        fixed: Vec::new(),
        extra_states: Vec::new(),
        has_memory: false,
        modes: 1,
        state_scales: vec![1.0, 100.0],
        input_scales: [Some(0), Some(0)],
    }
}

/// Segments measured with white noise; the first two shared parameters act.
fn segments() -> Vec<Segment> {
    segments_of(|offset, t| 0.5 * BELIEF * offset + 2e-6 * shape(0, t) - 1e-6 * shape(1, t))
}

/// Segments of a motion, each with a start state of its own, measured with white noise; the motion is told a standard normal
/// variable of its run.
pub(crate) fn segments_of(motion: impl Fn(f64, f64) -> f64) -> Vec<Segment> {
    let mut random = fastrand::Rng::with_seed(7);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let mut all = Vec::new();
    for run in 0..RUNS {
        let offset = normal();
        for k in 0..SEGMENTS {
            let state = [2.0 * NOISE * normal(), 200.0 * NOISE * normal()];
            let first = k * SAMPLES;
            let time: Vec<f64> = (first..first + SAMPLES)
                .map(|i| INTERVAL * i as f64)
                .collect();
            let measured = time.iter().map(|&t| {
                state[0] + state[1] * (t - time[0]) + motion(offset, t) + NOISE * normal()
            });
            all.push(Segment {
                run,
                first,
                measured: measured.collect(),
                trusted: vec![true; SAMPLES],
                count: SAMPLES,
                further: Vec::new(),
                stuck: false,
                dwell: 0.0,
                travel: 0.0,
                travel_end: 0.0,
                belt_distance: 0.0,
                state: vec![0.0; 2],
                time,
            });
        }
    }
    all
}

/// A fit of the toy, on the objective of the evidence.
fn fit(h: &Hypothesis, segments: &[Segment], tangents: bool) -> Fit {
    let start = Point::centre(h, segments);
    fit_from(&mut LinearToy::new(tangents), h, segments, start, 20)
}

/// A fit of a toy from `start` with so many Jacobians, on the objective of the evidence.
pub(crate) fn fit_from(
    toy: &mut dyn Simulator,
    h: &Hypothesis,
    segments: &[Segment],
    start: Point,
    jacobians: usize,
) -> Fit {
    fit_by(toy, h, segments, start, to_its_end(jacobians))
}

/// The options of a fit with so many Jacobians that ends only where nothing moves any more, on the objective of the evidence.
fn to_its_end(jacobians: usize) -> FitOptions {
    FitOptions {
        stride: 1,
        robust: false,
        tolerance: 1e-12,
        least_fall: 0.0,
        ..FitOptions::search(jacobians)
    }
}

fn fit_by(
    toy: &mut dyn Simulator,
    h: &Hypothesis,
    segments: &[Segment],
    start: Point,
    options: FitOptions,
) -> Fit {
    let data = Observations {
        segments,
        noise: &[NOISE; RUNS],
        work: &Work::default(),
    };
    Fitter::new(toy, h, &data, options).run(start)
}

/// Columns of all that is free (shared, then each run's offset, then each segment's state) over the noise, and the data over it.
fn dense(h: &Hypothesis, segments: &[Segment]) -> (DMatrix<f64>, DVector<f64>) {
    let shared = h.shared.len();
    let free = shared + RUNS + 2 * segments.len();
    let mut matrix = DMatrix::zeros(SAMPLES * segments.len(), free);
    let mut data = DVector::zeros(SAMPLES * segments.len());
    for (k, segment) in segments.iter().enumerate() {
        for (i, &t) in segment.time.iter().enumerate() {
            let row = k * SAMPLES + i;
            data[row] = segment.measured[i] / NOISE;
            let mut put =
                |column, turn| matrix[(row, column)] = slope(turn, t, segment.time[0]) / NOISE;
            (0..shared).for_each(|c| put(c, Turn::Shared(c)));
            put(shared + segment.run, Turn::PerRun(0));
            (0..2).for_each(|c| put(shared + RUNS + 2 * k + c, Turn::State(c)));
        }
    }
    (matrix, data)
}

/// Precision of what is believed: none of the states.
fn believed(h: &Hypothesis, free: usize) -> DMatrix<f64> {
    let parameters = h.shared.len() + RUNS;
    let one = |i: usize| if i < parameters { BELIEF.powi(-2) } else { 0.0 };
    DMatrix::from_diagonal(&DVector::from_fn(free, |i, _| one(i)))
}

#[test]
fn val_a_fit_is_the_mean_of_the_posterior() {
    // Source: the normal equations of all parameters and start states, solved as one dense system.
    let (h, segments) = (hypothesis(3), segments());
    let (matrix, data) = dense(&h, &segments);
    let information = matrix.tr_mul(&matrix) + believed(&h, matrix.ncols());
    let mean = information
        .lu()
        .solve(&matrix.tr_mul(&data))
        .expect("regular");
    for tangents in [true, false] {
        let fit = fit(&h, &segments, tangents);
        for c in 0..3 {
            let error = fit.point.shared[c] - mean[c];
            assert!(error.abs() < 1e-5 * BELIEF, "{c}: {error:e} m");
        }
        for run in 0..RUNS {
            let error = fit.point.per_run[run][0] - mean[3 + run];
            assert!(error.abs() < 1e-5 * BELIEF, "run {run}: {error:e} m");
        }
        for (k, state) in fit.point.states.iter().enumerate() {
            let error = state[0] - mean[3 + RUNS + 2 * k];
            assert!(error.abs() < 1e-5 * BELIEF, "segment {k}: {error:e} m");
        }
    }
}

#[test]
fn val_the_covariance_is_that_with_the_start_states_free() {
    // Source: the block of the inverse of the dense information matrix (Schur complement).
    let (h, segments) = (hypothesis(3), segments());
    let (matrix, _) = dense(&h, &segments);
    let information = matrix.tr_mul(&matrix) + believed(&h, matrix.ncols());
    let inverse = information.try_inverse().expect("regular");
    let covariance = fit(&h, &segments, true).covariance.expect("asked for");
    for i in 0..3 {
        for j in 0..3 {
            let scale = (inverse[(i, i)] * inverse[(j, j)]).sqrt();
            let error = (covariance[(i, j)] - inverse[(i, j)]) / scale;
            assert!(error.abs() < 1e-6, "{i} {j}: {error:e}");
        }
    }
}

/// Logarithm of the marginal likelihood up to a constant: `-1/2 (y' C^-1 y + ln det C)`, C the covariance of the data over the
/// noise, all that is free being normal. The states' standard deviation is that of [`STATE_SPREAD`].
fn log_marginal_likelihood(h: &Hypothesis, segments: &[Segment]) -> f64 {
    let (matrix, data) = dense(h, segments);
    let parameters = h.shared.len() + RUNS;
    let variance = |i: usize| match i.checked_sub(parameters) {
        None => BELIEF * BELIEF,
        Some(state) => (STATE_SPREAD * NOISE * h.state_scales[state % 2]).powi(2),
    };
    let prior = DMatrix::from_diagonal(&DVector::from_fn(matrix.ncols(), |i, _| variance(i)));
    let covariance =
        DMatrix::identity(data.len(), data.len()) + &matrix * prior * matrix.transpose();
    let factor = covariance.cholesky().expect("positive definite");
    let log_determinant: f64 = factor.l().diagonal().iter().map(|v| 2.0 * v.ln()).sum();
    -0.5 * (data.dot(&factor.solve(&data)) + log_determinant)
}

#[test]
fn val_evidence_compares_hypotheses_as_their_marginal_likelihoods_do() {
    // Source: the normal distribution of the data with everything free integrated out.
    let segments = segments();
    let by_fit: Vec<f64> = (1..=4)
        .map(|n| fit(&hypothesis(n), &segments, true).log_evidence)
        .collect();
    let exact: Vec<f64> = (1..=4)
        .map(|n| log_marginal_likelihood(&hypothesis(n), &segments))
        .collect();
    for n in 1..4 {
        let error = (by_fit[n] - by_fit[0]) - (exact[n] - exact[0]);
        assert!(error.abs() < 0.1, "{} parameters: {error} nats", n + 1);
    }
    // The second parameter acts, the third and the fourth do not: each costs what it could have been.
    assert!(by_fit[1] > by_fit[0] + 3.0, "{by_fit:?}");
    assert!(by_fit[2] < by_fit[1], "{by_fit:?}");
    assert!(by_fit[3] < by_fit[2], "{by_fit:?}");
}

#[test]
fn val_what_a_start_state_imitates_is_known_as_well_as_believed_and_no_worse() {
    // Source: data that do not depend on a parameter leave its variance as it was.
    let (h, segments) = (hypothesis(IMITATED + 1), segments());
    let fit = fit(&h, &segments, true);
    let covariance = fit.covariance.expect("asked for");
    let std = covariance[(IMITATED, IMITATED)].sqrt();
    assert!(
        (std / BELIEF - 1.0).abs() < 1e-3,
        "{std:e} m of {BELIEF:e} m"
    );
}

#[test]
fn val_what_a_smaller_hypothesis_knows_need_not_be_differentiated_again() {
    // Source: the dense information matrix and descent of all that is free, the start states eliminated (Schur complement).
    let (smaller, h, segments) = (hypothesis(2), hypothesis(3), segments());
    let work = Work::default();
    let data = Observations {
        segments: &segments,
        noise: &[NOISE; RUNS],
        work: &work,
    };
    let options = FitOptions {
        stride: 1,
        robust: false,
        ..FitOptions::search(1)
    };
    let there = fit(&smaller, &segments, true).point;
    let mut toy = LinearToy::new(true);
    let linear = Fitter::new(&mut toy, &smaller, &data, options).linearised_at(there.clone());
    let known = Known {
        hypothesis: &smaller,
        stuck: &there.stuck,
        linear: &linear,
    };
    let mut point = there.clone();
    point.shared.push(0.0);
    let (found, descent) =
        Fitter::new(&mut toy, &h, &data, options).reduced_beside(known, point.clone());
    let (matrix, measured) = dense(&h, &segments);
    let free = DVector::from_iterator(
        matrix.ncols(),
        point
            .shared
            .iter()
            .chain(point.per_run.iter().flatten())
            .chain(point.states.iter().flatten())
            .copied(),
    );
    let prior = believed(&h, matrix.ncols());
    let whole = matrix.tr_mul(&matrix) + &prior;
    let all = matrix.tr_mul(&(measured - &matrix * &free)) - prior * &free;
    let (kept, left) = (3 + RUNS, matrix.ncols() - 3 - RUNS);
    let across = whole.view((0, kept), (kept, left)).into_owned();
    let of_states = whole.view((kept, kept), (left, left)).into_owned();
    let solved = of_states.lu();
    let expected = whole.view((0, 0), (kept, kept))
        - &across * solved.solve(&across.transpose()).expect("regular");
    let expected_descent = all.rows(0, kept)
        - &across
            * solved
                .solve(&all.rows(kept, left).into_owned())
                .expect("regular");
    for i in 0..kept {
        let size = expected[(i, i)].sqrt();
        let error = (descent[i] - expected_descent[i]) / size;
        assert!(error.abs() < 1e-4, "descent {i}: {error:e}");
        for j in 0..kept {
            let error = (found[(i, j)] - expected[(i, j)]) / (size * expected[(j, j)].sqrt());
            assert!(error.abs() < 1e-6, "{i} {j}: {error:e}");
        }
    }
}

#[test]
fn val_beside_a_bound_the_others_are_where_the_posterior_given_it_has_its_mean() {
    // Source: the normal equations of all that is free with the bounded parameter at its bound, solved as one dense system.
    let (mut h, segments) = (hypothesis(3), segments());
    let bound = 1e-6;
    h.shared[0].max = bound;
    let (matrix, data) = dense(&h, &segments);
    let data = data - matrix.column(0) * bound;
    let information = matrix.tr_mul(&matrix) + believed(&h, matrix.ncols());
    let (matrix, information) = (
        matrix.remove_column(0),
        information.remove_row(0).remove_column(0),
    );
    let mean = information
        .lu()
        .solve(&matrix.tr_mul(&data))
        .expect("regular");
    let fit = fit(&h, &segments, true);
    assert_eq!(fit.point.shared[0], bound);
    for c in 1..3 {
        let error = fit.point.shared[c] - mean[c - 1];
        assert!(error.abs() < 1e-5 * BELIEF, "{c}: {error:e} m");
    }
}

#[test]
fn a_fit_ends_where_its_evidence_can_not_reach_what_is_asked() {
    let (smaller, h, segments) = (hypothesis(2), hypothesis(3), segments());
    let mut start = fit(&smaller, &segments, true).point;
    start.shared.push(0.0);
    let fitted = |least_evidence: f64| {
        let options = FitOptions {
            least_evidence,
            ..to_its_end(20)
        };
        let toy = &mut LinearToy::new(true);
        fit_by(toy, &h, &segments, start.clone(), options)
    };
    let at_its_end = fitted(f64::NEG_INFINITY);
    assert_ne!(at_its_end.point, start);
    let evidence = at_its_end.log_evidence;
    assert_eq!(fitted(evidence - 1.0).point, at_its_end.point);
    // The third parameter does not act: it gains less than a nat.
    let short = fitted(evidence + 5.0);
    assert_eq!(short.point, start);
    assert!(short.log_evidence <= evidence);
}
