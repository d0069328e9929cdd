//! The search for node values and start states.

use super::basis::Basis;
use super::guess::{Form, Guess};
use super::linear::Linear;
use super::shooting::{Plant, Shot, State};
use super::{BEND, CurveSettings, LEAD, LONGEST, TAIL};
use crate::observer::characteristic::Contact;
use crate::observer::error::ObserverError;
use crate::observer::segmentation::{Phase, PhaseMode};
use crate::observer::stick_slip::{BeltVelocity, StickSlip};
use crate::observer::structure::Structure;
use nalgebra::{DMatrix, DVector};

pub(super) struct Search<'a> {
    pub(super) plant: Plant,
    pub(super) displacement: &'a [f64],
    pub(super) offset: f64,
    pub(super) interval: f64,
    pub(super) noise: f64,
    pub(super) basis: Basis,
    pub(super) shots: Vec<Shot>,
    /// Steps for numerical derivatives by the start state.
    pub(super) scale: Vec<f64>,
    pub(super) roughness: DMatrix<f64>,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        structure: &Structure,
        displacement: &'a [f64],
        belt: BeltVelocity,
        contact: &Contact,
        found: &StickSlip,
        settings: &CurveSettings,
    ) -> Result<Self, ObserverError> {
        let mut shots = shots(contact, belt);
        let needed = 3;
        if shots.len() < needed || settings.nodes < 4 {
            return Err(ObserverError::TooFewEvents {
                what: "the friction curve",
                found: shots.len(),
                needed,
                unit: "slip phases between two sticks",
                action: "record longer, lower the belt speed, or use the binned characteristic",
            });
        }
        let every = shots.len().div_ceil(settings.events.max(1));
        shots = shots.into_iter().step_by(every).collect();
        let fastest = shots
            .iter()
            .flat_map(|s| &contact.relative_velocity[s.first..s.past])
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        let size =
            |columns: &[Vec<f64>], j: usize| columns[j].iter().fold(0.0_f64, |m, q| m.max(q.abs()));
        let modes = structure.modes().len();
        let scale = (0..2 * modes)
            .map(|i| {
                let columns = if i % 2 == 0 {
                    &found.smoothed.q
                } else {
                    &found.smoothed.q_dot
                };
                size(columns, i / 2).max(f64::MIN_POSITIVE)
            })
            .collect();
        let nodes = settings.nodes;
        let bends = DMatrix::from_fn(nodes - 2, nodes, |i, j| match j as i64 - i as i64 {
            0 | 2 => 1.0 / BEND,
            1 => -2.0 / BEND,
            _ => 0.0,
        });
        Ok(Self {
            plant: Plant::new(structure),
            displacement,
            offset: found.smoothed.offset,
            interval: found.smoothed.sample_interval,
            noise: found.smoothed.noise_std,
            basis: Basis::new(fastest, nodes),
            shots,
            scale,
            roughness: bends.tr_mul(&bends),
        })
    }

    pub(super) fn optimise(&self, mut guess: Guess, steps: usize) -> (Guess, Linear) {
        let mut best = self.linearise(&guess);
        let mut damping = 1e-3;
        for _ in 0..steps {
            let trial = self.step(&guess, &best, damping);
            let next = self.cost(&trial, &best.weights);
            if next < best.cost {
                let gain = (best.cost - next) / best.cost;
                guess = trial;
                best = self.linearise(&guess);
                damping *= 0.2;
                if gain < 1e-4 {
                    break;
                }
            } else {
                damping *= 10.0;
                if damping > 1e8 {
                    break;
                }
            }
        }
        (guess, best)
    }

    pub(super) fn node_speeds(&self) -> Vec<f64> {
        (0..self.basis.nodes)
            .map(|i| (i as f64 * self.basis.step).powi(2))
            .collect()
    }

    pub(super) fn nodes(&self, form: Form, p: &[f64]) -> Vec<f64> {
        match form {
            Form::Nodes => p.to_vec(),
            Form::Exponential => self
                .node_speeds()
                .iter()
                .map(|v| p[1] + (p[0] - p[1]) * (-v / p[2].exp()).exp() + p[3] * v)
                .collect(),
        }
    }

    pub(super) fn to_nodes(&self, guess: &Guess) -> Guess {
        let nodes = self.nodes(guess.form, &guess.parameters);
        Guess {
            form: Form::Nodes,
            baseline: nodes.clone(),
            parameters: nodes,
            starts: guess.starts.clone(),
        }
    }

    /// Deviations of one event over the noise; 0 where the sample is missing.
    pub(super) fn deviations(&self, shot: &Shot, start: &State, mu: &[f64]) -> DVector<f64> {
        let curve = |v: f64| self.basis.value(mu, v);
        let w = self.plant.shoot(shot, start, self.interval, &curve);
        DVector::from_iterator(
            w.len(),
            w.iter()
                .zip(&self.displacement[shot.first..shot.past])
                .map(|(w, y)| {
                    if y.is_nan() {
                        0.0
                    } else {
                        (w + self.offset - y) / self.noise
                    }
                }),
        )
    }

    /// Roughness matrix of the form's parameters.
    pub(super) fn bending(&self, form: Form) -> DMatrix<f64> {
        match form {
            Form::Nodes => self.roughness.clone(),
            Form::Exponential => DMatrix::zeros(4, 4),
        }
    }

    pub(super) fn roughness_cost(&self, guess: &Guess) -> f64 {
        let p = guess.departure();
        p.dot(&(self.bending(guess.form) * &p))
    }
}

/// Slip events that lie between two sticks.
fn shots(contact: &Contact, belt: BeltVelocity) -> Vec<Shot> {
    let sticks: Vec<&Phase> = contact
        .phases
        .iter()
        .filter(|p| p.mode == PhaseMode::Stick)
        .collect();
    sticks
        .windows(2)
        .filter(|pair| pair[0].past - pair[0].first > LEAD)
        .map(|pair| {
            let first = pair[0].past - LEAD;
            let past = (pair[1].first + TAIL).min(pair[1].past);
            Shot {
                first,
                past,
                belt: belt.at(pair[0].past),
                normal: contact.normal_force.at(pair[0].past),
            }
        })
        .filter(|shot| shot.past - shot.first <= LONGEST)
        .collect()
}
