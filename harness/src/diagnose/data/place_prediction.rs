//! The force at break-away predicted by the place on the belt.

use crate::diagnose::data::break_away_events::Event;
use crate::metric::median;
use nalgebra::{DMatrix, DVector, RowDVector};

/// Permutations with which a prediction by the place is compared.
const PERMUTATIONS: usize = 199;
/// Widths of the weight that are tried, in units of the median distance of the events.
const WIDTHS: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// The places of events, and how each event is predicted from the others by the place.
pub(crate) struct Places {
    /// For each width in m, the weights of the others (columns) in the prediction of each event (rows).
    weights: Vec<(f64, DMatrix<f64>)>,
}

impl Places {
    /// From the break-aways of a run.
    pub fn new(events: &[Event]) -> Self {
        let spacing = median_distance(events);
        let weights = WIDTHS.iter().map(|w| w * spacing).map(|width| {
            let mut all = DMatrix::zeros(events.len(), events.len());
            for (i, event) in events.iter().enumerate() {
                let row = weights(events, event.place, width, Some(i));
                all.set_row(i, &RowDVector::from_vec(row));
            }
            (width, all)
        });
        Self {
            weights: weights.collect(),
        }
    }

    /// The width that predicts forces best, and its root mean square error.
    pub fn best(&self, forces: &DVector<f64>) -> (f64, f64) {
        let error = |w: &DMatrix<f64>| (w * forces - forces).norm() / (forces.len() as f64).sqrt();
        self.weights
            .iter()
            .map(|(width, w)| (*width, error(w)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .expect("widths are tried")
    }

    /// Share of the permutations of the forces that are predicted with an error as small.
    pub fn by_chance(&self, forces: &DVector<f64>, error: f64) -> f64 {
        let mut random = fastrand::Rng::with_seed(1);
        let mut shuffled = forces.clone();
        let as_small = (0..PERMUTATIONS).filter(|_| {
            random.shuffle(shuffled.as_mut_slice());
            self.best(&shuffled).1 <= error
        });
        (1 + as_small.count()) as f64 / (1 + PERMUTATIONS) as f64
    }
}

/// Weights of events in the mean near a place; `without` is left out.
pub(crate) fn weights(
    events: &[Event],
    place: f64,
    width: f64,
    without: Option<usize>,
) -> Vec<f64> {
    let exponent = |e: &Event| -0.5 * ((e.place - place) / width).powi(2);
    let counts = |i: usize| Some(i) != without;
    let nearest = events
        .iter()
        .enumerate()
        .filter(|(i, _)| counts(*i))
        .map(|(_, e)| exponent(e))
        .fold(f64::NEG_INFINITY, f64::max);
    // Relative to the nearest one, so that a lonely event is predicted by its neighbour.
    let mut out: Vec<f64> = events
        .iter()
        .enumerate()
        .map(|(i, e)| {
            if counts(i) {
                (exponent(e) - nearest).exp()
            } else {
                0.0
            }
        })
        .collect();
    let sum: f64 = out.iter().sum();
    out.iter_mut().for_each(|w| *w /= sum);
    out
}

fn median_distance(events: &[Event]) -> f64 {
    let mut places: Vec<f64> = events.iter().map(|e| e.place).collect();
    places.sort_by(f64::total_cmp);
    let mut distances: Vec<f64> = places.windows(2).map(|w| w[1] - w[0]).collect();
    median(&mut distances).max(1e-12)
}
