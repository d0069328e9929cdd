//! What start states cost in the evidence.
//!
//! A start state x of a segment on which the data have the information H costs, with a scale T in every direction,
//!
//! ```text
//! 1/2 ln det(1 + T H T)
//! ```
//!
//! The scale of the structure's own states is the same for every model, so that it cancels but for what a model has more. That of an
//! effect's state is the spread of where the segments find it, and how far that lies from the state's typical size nobody knows
//! beforehand: believed ten times too wide, a memory costs two nats more in every segment than it should, and loses to whatever has none.
//! So the spread is a hyperparameter, one for each state of an effect, and the evidence is the mean over spreads from ten times the
//! typical size down:
//!
//! ```text
//! p(y) = mean_s prod_k integral p(y_k | x_k) N(x_k; 0, s^2) dx_k
//! ```
//!
//! with the start states of segment k moved from where the fit has them to where the narrower belief would, to first order. Holds where the
//! posterior is about normal (Laplace). Source: MacKay, Neural Computation 4 (1992) 415, sect. 4; Gelman and others, Bayesian Data
//! Analysis (2013), ch. 5 (exchangeable constants with a common spread).

use crate::diagnose::estimation::scaled_matrix::{log_determinant, scaled_solve};
use nalgebra::{DMatrix, DVector};

/// Spreads that are tried, as factors on the widest, in half decades.
const SPREADS: [f64; 7] = [1.0, 0.316, 0.1, 0.0316, 0.01, 0.00316, 0.001];

/// The start state of a segment as a fit has it.
pub(crate) struct StartState {
    /// Information of the data on its directions where the segment is met: one that is lost must not be cheaper.
    pub met: DMatrix<f64>,
    /// The same as the segment stands.
    pub now: DMatrix<f64>,
    /// Scale of each direction, the widest.
    pub scale: Vec<f64>,
    /// Which of the effects' states each direction is, and how far it lies from where that settles; `None` for the structure's own.
    pub of_effects: Vec<Option<(usize, f64)>>,
}

impl StartState {
    /// What it costs in nats where the spreads of the effects' states are these factors of the widest; `None` where the matrix is not
    /// positive definite.
    fn price(&self, spreads: &[f64]) -> Option<f64> {
        let size = self.scale.len();
        let factor = |i: usize| self.of_effects[i].map_or(1.0, |(state, _)| spreads[state]);
        let scale: Vec<f64> = (0..size).map(|i| self.scale[i] * factor(i)).collect();
        let scaled = DMatrix::from_fn(size, size, |i, j| {
            f64::from(u8::from(i == j)) + self.met[(i, j)] * scale[i] * scale[j]
        });
        let price = 0.5 * log_determinant(&scaled)?;
        if (0..size).all(|i| factor(i) == 1.0) {
            return Some(price);
        }
        // The narrower belief pulls each state towards where it settles, and it follows as far as the data let it.
        let mut matrix = self.now.clone();
        let mut pull = DVector::zeros(size);
        let mut lift = 0.0;
        for i in 0..size {
            matrix[(i, i)] += scale[i].powi(-2);
            if let Some((_, at)) = self.of_effects[i] {
                let narrower = scale[i].powi(-2) - self.scale[i].powi(-2);
                pull[i] = narrower * at;
                lift += 0.5 * narrower * at * at;
            }
        }
        let follows = scaled_solve(&matrix, &pull)?;
        Some(price + lift - 0.5 * pull.dot(&follows))
    }
}

/// What the start state of each segment costs, nats, the effects' `states` with the spreads that have most evidence; what the choice of
/// the spreads costs stands in the first. `None` where a matrix is not positive definite.
pub(crate) fn prices(starts: &[Option<StartState>], states: usize) -> Option<Vec<f64>> {
    let all = |spreads: &[f64]| -> Option<Vec<f64>> {
        let price = |start: &Option<StartState>| match start {
            Some(start) => start.price(spreads),
            None => Some(0.0),
        };
        starts.iter().map(price).collect()
    };
    let mut spreads = vec![SPREADS[0]; states];
    let mut choice = 0.0;
    for state in 0..states {
        let total = |spread: f64| {
            let mut tried = spreads.clone();
            tried[state] = spread;
            Some((spread, all(&tried)?.iter().sum::<f64>()))
        };
        let tried: Vec<(f64, f64)> = SPREADS.into_iter().filter_map(total).collect();
        let &(best, least) = tried.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let mean = tried.iter().map(|t| (least - t.1).exp()).sum::<f64>() / tried.len() as f64;
        choice -= mean.ln();
        spreads[state] = best;
    }
    let mut prices = all(&spreads)?;
    if let Some(first) = prices.first_mut() {
        *first += choice;
    }
    Some(prices)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDEST: f64 = 10.0;

    /// A segment whose start state was fitted with the widest belief to a datum of precision `information`.
    fn start(information: f64, seen: f64, state: Option<usize>) -> StartState {
        let matrix = DMatrix::from_element(1, 1, information);
        let believed = information * seen / (information + WIDEST.powi(-2));
        StartState {
            met: matrix.clone(),
            now: matrix,
            scale: vec![WIDEST],
            of_effects: vec![state.map(|s| (s, believed))],
        }
    }

    #[test]
    fn val_the_prices_are_the_evidence_of_states_with_a_common_spread() {
        // Source: marginal likelihood of z_k ~ N(0, 1/h_k + s^2), the mean over the spreads s, against what a fit with the widest
        // belief has: the least of its objective.
        let seen = [(400.0, 0.3), (90.0, -0.2), (30.0, 0.4), (900.0, 0.05)];
        let log_normal = |z: f64, variance: f64| -0.5 * z * z / variance - 0.5 * variance.ln();
        let evidence = |s: f64| -> f64 {
            let all = seen.iter();
            all.map(|&(h, z): &(f64, f64)| log_normal(z, h.recip() + s * s) - 0.5 * h.ln())
                .sum()
        };
        let of_spreads = SPREADS.map(|f| evidence(f * WIDEST));
        let top = of_spreads.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mean = of_spreads.iter().map(|e| (e - top).exp()).sum::<f64>() / 7.0;
        let expected = top + mean.ln();
        let starts = seen.map(|(h, z)| Some(start(h, z, Some(0))));
        let misfit = |(h, z): (f64, f64)| 0.5 * z * z / (h.recip() + WIDEST * WIDEST);
        let misfit: f64 = seen.into_iter().map(misfit).sum();
        let found = -misfit - prices(&starts, 1).unwrap().iter().sum::<f64>();
        assert!((found - expected).abs() < 1e-9, "{found} {expected}");
    }

    #[test]
    fn what_leaves_no_trace_costs_nothing_and_the_structures_states_what_they_did() {
        let none = [Some(start(0.0, 0.0, Some(0))), None];
        let free = prices(&none, 1).unwrap();
        assert!(free.iter().all(|p| p.abs() < 1e-12), "{free:?}");
        let own = [Some(start(2.0, 0.0, None))];
        let expected = 0.5 * (1.0 + 2.0 * WIDEST * WIDEST).ln();
        assert!((prices(&own, 0).unwrap()[0] - expected).abs() < 1e-12);
    }
}
