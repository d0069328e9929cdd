//! Start states drawn from what the beginning of a segment tells of them.
//!
//! In stick the tip goes with the belt whatever the beam does inside, so that a segment with a short slip at its start tells little of
//! the second mode until the contact breaks away, and a start that misses the break-away has no derivatives that lead there. What the
//! beginning leaves open is, by Laplace's approximation, a normal distribution about its best fit,
//!
//! ```text
//! x ~ N(x0, WIDER^2 (X'X / s^2 + P)^-1)
//! ```
//!
//! with X the derivatives of the samples of the beginning by the start state, s^2 their mean square residual or that of the noise where it
//! is more, and P what is believed of the states of effects. Of draws from it the one that meets more of the segment best leads on. Holds
//! where the constants are nearly those that made the data. Related: particle filters weight draws by what comes next and keep many
//! (Doucet, de Freitas and Gordon, Sequential Monte Carlo Methods in Practice, Springer 2001, ch. 1); here one is kept and fitted.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::data::white_noise::gaussian;
use crate::diagnose::estimation::fitter::{Fitter, directions, sum_of_squares};
use crate::diagnose::estimation::scaled_matrix::scaled_inverse;
use crate::diagnose::estimation::sensitivities::Turned;
use crate::diagnose::model::point::Point;
use crate::diagnose::thresholds::STATE_SPREAD;
use nalgebra::{DMatrix, DVector};

/// Draws: along one direction that is open they lie a tenth of its standard deviation apart.
pub(crate) const DRAWS: usize = 48;
/// How many times wider they lie than constants held exactly would have it: these are fitted to segments that were met.
const WIDER: f64 = 2.0;

/// The posterior of a start state, that of the samples used.
pub(crate) struct StartPosterior {
    /// Cholesky factor of the covariance of the directions.
    factor: DMatrix<f64>,
    /// The directions, as indices of the state.
    directions: Vec<usize>,
}

impl StartPosterior {
    /// A start state drawn about `centre`.
    pub(crate) fn draw(&self, centre: &[f64], random: &mut fastrand::Rng, to: &mut [f64]) {
        let normal = DVector::from_fn(self.directions.len(), |_, _| gaussian(random));
        let moved = &self.factor * normal;
        to.copy_from_slice(centre);
        for (&i, by) in self.directions.iter().zip(&moved) {
            to[i] += by;
        }
    }
}

/// The random numbers of a segment, the same in each fit.
pub(crate) fn random_of(segment: &Segment) -> fastrand::Rng {
    fastrand::Rng::with_seed((segment.run as u64) << 32 | segment.first as u64)
}

impl Fitter<'_, '_> {
    /// The posterior of the start state of segment `k`, which was fitted to the samples used; `None` where rounding leaves none.
    pub(crate) fn start_posterior(&mut self, k: usize, point: &Point) -> Option<StartPosterior> {
        let residual = self.residual(k, point);
        let noise = self.data.noise[self.data.segments[k].run];
        let variance = (sum_of_squares(&residual) / self.count(k)).max(noise * noise);
        let l = self.linearise(k, point, residual?, Turned::State);
        let directions = directions(self.hypothesis, point.stuck[k]);
        let mut information = l.states.tr_mul(&l.states);
        let mut unused = DVector::zeros(directions.len());
        let state = &point.states[k];
        self.add_state_prior(&directions, state, variance, &mut information, &mut unused);
        // What shows later only lies about where it does in the evidence.
        for (c, &i) in directions.iter().enumerate() {
            if let (true, Some(scale)) = (
                information[(c, c)] == 0.0,
                self.hypothesis.state_scales.get(i),
            ) {
                information[(c, c)] = variance * (STATE_SPREAD * noise * scale).powi(-2);
            }
        }
        let covariance = scaled_inverse(&information, 0.0)? * (variance * WIDER * WIDER);
        Some(StartPosterior {
            factor: covariance.cholesky()?.l(),
            directions,
        })
    }

    /// Puts that of the draws into `point` with which segment `k` is met best over the samples used, if it is met better than by the
    /// start that is there.
    pub(crate) fn draw_start(
        &mut self,
        k: usize,
        point: &mut Point,
        posterior: &StartPosterior,
        random: &mut fastrand::Rng,
    ) {
        let centre = point.states[k].clone();
        let mut best = (self.sum(k, point), centre.clone());
        for _ in 0..DRAWS {
            posterior.draw(&centre, random, &mut point.states[k]);
            let sum = self.sum(k, point);
            if sum < best.0 {
                best = (sum, point.states[k].clone());
            }
        }
        point.states[k] = best.1;
    }
}
