//! What is searched, and first guesses of it.

use super::search::Search;
use super::shooting::State;
use crate::observer::characteristic::Contact;
use crate::observer::segmentation::PhaseMode;
use crate::observer::stick_slip::StickSlip;
use crate::observer::structure::MODE_LIMIT;
use nalgebra::DVector;

/// What is searched: a falling exponential first, which is well behaved, then the node values.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Form {
    /// `[mu_0, mu_slow, ln v_s, c]`: `mu_slow + (mu_0 - mu_slow) exp(-v/v_s) + c v`.
    Exponential,
    Nodes,
}

#[derive(Clone)]
pub(super) struct Guess {
    pub(super) form: Form,
    pub(super) parameters: Vec<f64>,
    /// What the parameters are smooth about.
    pub(super) baseline: Vec<f64>,
    pub(super) starts: Vec<State>,
}

impl Guess {
    pub(super) fn departure(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.parameters) - DVector::from_column_slice(&self.baseline)
    }
}

impl Search<'_> {
    /// An exponential that falls over `fall` m/s, through the start's first and last values.
    pub(super) fn exponential(&self, fall: f64, contact: &Contact, found: &StickSlip) -> Guess {
        let start = self.start(contact, found);
        let n = start.parameters.len();
        let middle = start.parameters[2 * n / 3];
        Guess {
            form: Form::Exponential,
            parameters: vec![
                start.parameters[0].max(1.05 * middle),
                middle,
                fall.ln(),
                0.0,
            ],
            baseline: vec![0.0; 4],
            starts: start.starts,
        }
    }

    /// Node values by least squares of the smoothed force, start states from the smoother.
    pub(super) fn start(&self, contact: &Contact, found: &StickSlip) -> Guess {
        let n = self.basis.nodes;
        let (mut a, mut b) = (&self.roughness * 1e-2, DVector::zeros(n));
        for phase in contact.phases.iter().filter(|p| p.complete) {
            let stick = phase.mode == PhaseMode::Stick;
            let first = if stick { phase.past - 1 } else { phase.first };
            for k in first..phase.past {
                let v = contact.relative_velocity[k];
                // The last force in stick is the static one.
                let (speed, mu) = if stick {
                    (0.0, contact.force[k].abs() / contact.normal_force.at(k))
                } else {
                    (
                        v.abs(),
                        -contact.force[k] * v.signum() / contact.normal_force.at(k),
                    )
                };
                for (i, w) in self.basis.weights(speed) {
                    b[i] += w * mu;
                    for (j, x) in self.basis.weights(speed) {
                        a[(i, j)] += w * x;
                    }
                }
            }
        }
        let mu = a
            .lu()
            .solve(&b)
            .unwrap_or_else(|| DVector::from_element(n, 0.3));
        let starts = self
            .shots
            .iter()
            .map(|shot| {
                let mut x = [0.0; 2 * MODE_LIMIT];
                for (j, (q, v)) in found
                    .smoothed
                    .q
                    .iter()
                    .zip(&found.smoothed.q_dot)
                    .enumerate()
                {
                    (x[2 * j], x[2 * j + 1]) = (q[shot.first], v[shot.first]);
                }
                x
            })
            .collect();
        Guess {
            form: Form::Nodes,
            baseline: vec![0.0; n],
            parameters: mu.iter().copied().collect(),
            starts,
        }
    }
}
