//! What the data tell of all that is free: covariance, and what the evidence pays for it.

use crate::diagnose::estimation::fitter::{Fitter, Place, directions};
use crate::diagnose::estimation::normal_equations::priors;
use crate::diagnose::estimation::scaled_matrix::{
    clamped_inverse, log_determinant, scaled_inverse, scaled_solve,
};
use crate::diagnose::estimation::sensitivities::Linear;
use crate::diagnose::estimation::start_prices::{StartState, prices};
use crate::diagnose::thresholds::STATE_SPREAD;
use nalgebra::{DMatrix, DVector};

/// Damping of a matrix that is inverted as it is, relative to the diagonal: far below what beliefs add there, 1e-9 for
/// constants that the data show to 1e-6 and only act together with others.
const LEAST_DAMPING: f64 = 1e-13;

/// Information at a place where everything has been differentiated.
pub(crate) struct Information<'i, 'a, 'b> {
    fitter: &'i Fitter<'a, 'b>,
    here: &'i Place,
    linear: &'i [Option<Linear>],
    /// That on the parameters (shared, then each run's own) with the priors, every segment's start state free.
    matrix: DMatrix<f64>,
    /// Descent of the objective by the same parameters, likewise.
    gradient: DVector<f64>,
    /// Fall of the objective by the start states alone, nats.
    fall_of_starts: f64,
    /// First column of each run's own parameters.
    own_first: Vec<usize>,
}

impl<'i, 'a, 'b> Information<'i, 'a, 'b> {
    /// The information at a place. It is the matrix of the normal equations with the start states eliminated, computed without
    /// a difference of large numbers: along a direction that the data hardly show, that difference has no digit left (seen: mass,
    /// pressing force and a bristle's stiffness, which only show together, had 50 times the standard deviation believed of them).
    pub fn at(fitter: &'i Fitter<'a, 'b>, here: &'i Place, linear: &'i [Option<Linear>]) -> Self {
        let h = fitter.hypothesis;
        let (mut matrix, mut gradient, own_first) = priors(fitter, &here.point);
        let kept = fitter.kept(&here.sums);
        let mut fall_of_starts = 0.0;
        for (k, l) in linear.iter().enumerate().filter(|(k, _)| kept[*k]) {
            let Some(l) = l else { continue };
            let run = fitter.data.segments[k].run;
            let first = own_first[run];
            let own = first..first + h.per_run[run].len();
            let columns: Vec<usize> = (0..h.shared.len()).chain(own).collect();
            let weight = fitter.weight(k, here.sums[k]);
            let list = directions(h, here.point.stuck[k]);
            let believed = state_precision(fitter, &list);
            let state: Vec<f64> = list.iter().map(|&i| here.point.states[k][i]).collect();
            let (of_segment, descent, fall) = projected(l, weight, (&believed, &state));
            fall_of_starts += fall;
            for (i, &ci) in columns.iter().enumerate() {
                gradient[ci] += descent[i];
                for (j, &cj) in columns.iter().enumerate() {
                    matrix[(ci, cj)] += of_segment[(i, j)];
                }
            }
        }
        Self {
            fitter,
            here,
            linear,
            matrix,
            gradient,
            fall_of_starts,
            own_first,
        }
    }

    /// Fall of the objective to the least of its quadratic model by the parameters beyond that by the start states alone, nats:
    /// `1/2 g' H^-1 g`; infinite where H is not positive definite.
    pub fn expected_fall(&self) -> f64 {
        let step = scaled_solve(&self.matrix, &self.gradient);
        step.map_or(f64::INFINITY, |step| 0.5 * self.gradient.dot(&step))
    }

    /// The same by all that is free.
    pub fn expected_fall_of_all(&self) -> f64 {
        self.expected_fall() + self.fall_of_starts
    }

    /// Matrix and gradient.
    pub fn into_system(self) -> (DMatrix<f64>, DVector<f64>) {
        (self.matrix, self.gradient)
    }

    /// Covariance of the shared parameters on their scales.
    pub fn covariance(&self) -> Option<DMatrix<f64>> {
        let inverse = scaled_inverse(&self.matrix, LEAST_DAMPING)
            .or_else(|| clamped_inverse(&self.matrix))?;
        let shared = self.fitter.hypothesis.shared.len();
        Some(inverse.view((0, 0), (shared, shared)).into_owned())
    }

    /// Logarithm of the share of the prior's volume that the posterior takes up, nats: the price of all that is free, with that of the
    /// start states ([`Self::state_prices`]).
    ///
    /// ```text
    /// -1/2 ln det(S H S) - sum_segments (price of the start state)
    /// ```
    ///
    /// with H the information matrix of the parameters with the priors, S the priors' standard deviations, and the price of a start state
    /// as [`start_prices`](super::start_prices) has it, with the scale [`STATE_SPREAD`] times the sensor's noise for deflections, times the
    /// mode's angular frequency for velocities, and times their typical size for the states of effects, narrowed there as the data tell.
    /// Holds where the posterior is about normal (Laplace);
    /// MacKay, Information Theory, Inference, and Learning Algorithms (2003), eq. 28.10. `None` where the matrix is not
    /// positive definite.
    pub fn occam(&self, state_prices: &[f64]) -> Option<f64> {
        let f = self.fitter;
        let h = f.hypothesis;
        let mut matrix = self.matrix.clone();
        let mut free = Vec::new();
        let of_run = |(run, first): (usize, &usize)| {
            let first = *first;
            let own = h.per_run[run].iter().enumerate();
            own.map(move |(i, k)| (first + i, k))
        };
        let per_run = self.own_first.iter().enumerate().flat_map(of_run);
        let shared = h.shared.iter().enumerate().filter(|(_, k)| f.moves(k));
        for (c, parameter) in shared.chain(per_run).filter(|(_, k)| k.prior_std > 0.0) {
            let volume = parameter.volume_std();
            matrix[(c, c)] += volume.powi(-2) - parameter.prior_std.powi(-2);
            free.push((c, volume));
        }
        let scaled = DMatrix::from_fn(free.len(), free.len(), |i, j| {
            let ((a, s), (b, t)) = (free[i], free[j]);
            matrix[(a, b)] * s * t
        });
        let of_states: f64 = state_prices.iter().sum();
        Some(-0.5 * log_determinant(&scaled)? - of_states)
    }

    /// What the start state of each segment costs in it ([`super::start_prices`]); `None` where the matrix of one is not positive definite.
    pub fn state_prices(&self) -> Option<Vec<f64>> {
        let all = self.linear.iter().enumerate();
        let start = |(k, linear): (usize, &Option<Linear>)| Some(self.start(k, linear.as_ref()?));
        let starts: Vec<Option<StartState>> = all.map(start).collect();
        prices(&starts, self.fitter.hypothesis.extra_states.len())
    }

    /// The start state of a segment.
    fn start(&self, k: usize, linear: &Linear) -> StartState {
        let f = self.fitter;
        let h = f.hypothesis;
        let list = directions(h, self.here.point.stuck[k]);
        let spread = STATE_SPREAD * f.data.noise[f.data.segments[k].run];
        let modal = h.state_scales.len();
        let scale = list.iter().map(|&i| match h.state_scales.get(i) {
            Some(scale) => scale * spread,
            None => STATE_SPREAD * h.extra_states[i - modal].1,
        });
        let at = &self.here.point.states[k];
        let of_effects = list.iter().map(|&i| Some((i.checked_sub(modal)?, at[i])));
        let squares = linear.states.tr_mul(&linear.states);
        StartState {
            met: f.likelihood(k).weight(0.0) * &squares,
            now: f.weight(k, self.here.sums[k]) * squares,
            scale: scale.collect(),
            of_effects: of_effects.collect(),
        }
    }
}

/// Precision of what is believed of each component of a start state: nothing but for the states of effects.
fn state_precision(f: &Fitter, list: &[usize]) -> Vec<f64> {
    let size = list.len();
    let state = vec![0.0; f.hypothesis.state_scales.len() + f.hypothesis.extra_states.len()];
    let mut matrix = DMatrix::zeros(size, size);
    f.add_state_prior(list, &state, 1.0, &mut matrix, &mut DVector::zeros(size));
    matrix.diagonal().iter().copied().collect()
}

/// Information of a segment on the parameters and descent by them, its start state free: `w P' P` and `w P' r`, and the fall by the
/// start state alone, `1/2 w |Q' r|^2`, with r the residuals and P what of the derivatives by the parameters no change of the
/// start state explains, `K - Q Q' K` with `Q R` the derivatives by the state, below them a row for what is believed of each of
/// its components, precision and value (QR decomposition).
fn projected(
    linear: &Linear,
    weight: f64,
    (believed, state): (&[f64], &[f64]),
) -> (DMatrix<f64>, DVector<f64>, f64) {
    let (rows, states) = linear.states.shape();
    let root = weight.sqrt();
    let mut by_state = linear.states.clone().insert_rows(rows, states, 0.0) * root;
    let mut residual = DVector::zeros(rows + states);
    for (to, r) in residual.iter_mut().zip(&linear.residual) {
        *to = root * r;
    }
    for (c, precision) in believed.iter().enumerate() {
        by_state[(rows + c, c)] = precision.sqrt();
        residual[rows + c] = -precision.sqrt() * state[c];
        let norm = by_state.column(c).norm();
        if norm > 0.0 {
            by_state.column_mut(c).unscale_mut(norm);
        }
    }
    let mut free = linear.parameters.clone().insert_rows(rows, states, 0.0) * root;
    let q = by_state.qr().q();
    // Twice is enough (Kahan, in Parlett, The Symmetric Eigenvalue Problem, 1998, section 6.9).
    for _ in 0..2 {
        let explained = &q * q.tr_mul(&free);
        free -= explained;
    }
    let fall = 0.5 * q.tr_mul(&residual).norm_squared();
    (free.tr_mul(&free), free.tr_mul(&residual), fall)
}
