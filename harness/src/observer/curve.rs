//! The friction curve by shooting: sharper than binning the smoothed force.
//!
//! At break-away the tip runs through 0.1 m/s within a few samples, and there the smoothed force
//! is smeared. Here every slip event of the record is simulated from the stick before it to the
//! stick after it, with a friction curve given by its values at nodes; the node values and the
//! start state of every event are those that fit the displacement best (multiple shooting, Bock
//! 1983; Levenberg-Marquardt with the start states eliminated event by event). An exponential is
//! fitted first, because with free node values from the start the search gets stuck.
//!
//! Holds for rigid sticking, where friction in slip depends on the speed alone, equally in both
//! directions, and breaks away at `mu(0)`; what does not follow shows in
//! [`FrictionCurve::misfit`].

use super::characteristic::Contact;
use super::error::ObserverError;
use super::segmentation::{Phase, PhaseMode};
use super::shooting::{Plant, Shot, State};
use super::stick_slip::{BeltVelocity, StickSlip};
use super::structure::{MODE_LIMIT, Structure};
use nalgebra::{DMatrix, DVector};

/// A friction curve with its uncertainty.
#[derive(Debug, Clone, PartialEq)]
pub struct FrictionCurve {
    /// Node speeds in m/s: squares of evenly spaced values from 0.
    pub speed: Vec<f64>,
    /// Friction coefficient at the nodes (1); the first is the static coefficient.
    pub mu: Vec<f64>,
    /// Standard deviation of the node values (1), widened by the misfit.
    pub mu_std: Vec<f64>,
    /// Number of slip samples nearest to each node.
    pub count: Vec<usize>,
    /// Number of slip events used.
    pub events: usize,
    /// Root mean square deviation of the displacement over the sensor noise (1); about 1 where the
    /// curve explains the slip events.
    pub misfit: f64,
}

impl FrictionCurve {
    /// Coefficient at speed `v >= 0` in m/s (piecewise cubic in the root of the speed).
    pub fn at(&self, v: f64) -> f64 {
        let fastest = self.speed.last().copied().unwrap_or(1.0);
        Basis::new(fastest, self.speed.len()).value(&self.mu, v)
    }
}

/// Choices for [`friction_curve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveSettings {
    /// Number of nodes.
    pub nodes: usize,
    /// Most Levenberg-Marquardt steps.
    pub steps: usize,
    /// Most slip events used, spread over the record.
    pub events: usize,
}

impl Default for CurveSettings {
    fn default() -> Self {
        Self {
            nodes: 20,
            steps: 40,
            events: 60,
        }
    }
}

/// Samples of stick before the found break-away at which an event starts.
const LEAD: usize = 10;
/// Samples of stick after arrival that are still compared.
const TAIL: usize = 3;
/// Longest event in samples.
const LONGEST: usize = 2_000;
/// Standard deviation of the second differences of the node values' departure from an exponential
/// (1).
const BEND: f64 = 0.003;
/// Events whose misfit exceeds this multiple of the median count less.
const OUTLIER: f64 = 3.0;

/// Speeds in m/s over which the first guesses fall.
const FALLS: [f64; 3] = [0.03, 0.008, 0.12];
/// Misfit from which on no other first guess is tried.
const GOOD: f64 = 1.2;

/// Piecewise cubic (Catmull and Rom 1974) over `u = sqrt(v)` with evenly spaced nodes, even in `u`.
#[derive(Clone, Copy)]
struct Basis {
    step: f64,
    nodes: usize,
}

impl Basis {
    fn new(fastest: f64, nodes: usize) -> Self {
        Self {
            step: fastest.sqrt() / (nodes - 1) as f64,
            nodes,
        }
    }

    fn weights(&self, v: f64) -> [(usize, f64); 4] {
        let u = (v.max(0.0).sqrt() / self.step).min(self.nodes as f64 - 1.0 - 1e-9);
        let first = u.floor();
        let t = u - first;
        let weights = [
            0.5 * (-t + 2.0 * t * t - t.powi(3)),
            0.5 * (2.0 - 5.0 * t * t + 3.0 * t.powi(3)),
            0.5 * (t + 4.0 * t * t - 3.0 * t.powi(3)),
            0.5 * (-t * t + t.powi(3)),
        ];
        std::array::from_fn(|i| {
            let node = (first as usize + i).abs_diff(1).min(self.nodes - 1);
            (node, weights[i])
        })
    }

    fn value(&self, mu: &[f64], v: f64) -> f64 {
        self.weights(v).iter().map(|(i, w)| w * mu[*i]).sum()
    }
}

/// Estimates the friction curve of a record.
///
/// `found` from [`super::smooth_stick_slip`] on the same displacement (m, NaN where missing).
pub fn friction_curve(
    structure: &Structure,
    displacement: &[f64],
    belt: BeltVelocity,
    contact: &Contact,
    found: &StickSlip,
    settings: &CurveSettings,
) -> Result<FrictionCurve, ObserverError> {
    contact.check()?;
    let search = Search::new(structure, displacement, belt, contact, found, settings)?;
    let mut first: Option<(Guess, Linear)> = None;
    for fall in FALLS {
        let start = search.exponential(fall, contact, found);
        let fit = search.optimise(start, settings.steps / 2);
        if first.as_ref().is_none_or(|f| fit.1.cost < f.1.cost) {
            first = Some(fit);
        }
        if first
            .as_ref()
            .is_some_and(|f| f.1.sum < GOOD * GOOD * f.1.count)
        {
            break;
        }
    }
    let Some((guess, _)) = first.map(|(guess, _)| search.optimise(guess, settings.steps)) else {
        return Err(ObserverError::TooFewEvents {
            what: "the friction curve",
            found: 0,
            needed: 1,
            unit: "converged fits",
            action: "use the binned characteristic",
        });
    };
    let (guess, best) = search.optimise(search.to_nodes(&guess), settings.steps);
    let misfit = (best.sum / best.count).sqrt();
    let inverse = search.reduced(&best, 0.0).0.pseudo_inverse(1e-14);
    let std = |i: usize| match &inverse {
        Ok(inverse) => inverse[(i, i)].max(0.0).sqrt() * misfit.max(1.0),
        Err(_) => f64::INFINITY,
    };
    let mut count = vec![0; settings.nodes];
    for phase in contact.phases.iter().filter(|p| p.mode != PhaseMode::Stick) {
        for v in &contact.relative_velocity[phase.first..phase.past] {
            let u = (v.abs().sqrt() / search.basis.step).round() as usize;
            count[u.min(settings.nodes - 1)] += 1;
        }
    }
    Ok(FrictionCurve {
        speed: (0..settings.nodes)
            .map(|i| (i as f64 * search.basis.step).powi(2))
            .collect(),
        mu_std: (0..settings.nodes).map(std).collect(),
        mu: guess.parameters,
        count,
        events: search.shots.len(),
        misfit,
    })
}

/// What is searched: a falling exponential first, which is well behaved, then the node values.
#[derive(Clone, Copy, PartialEq)]
enum Form {
    /// `[mu_0, mu_slow, ln v_s, c]`: `mu_slow + (mu_0 - mu_slow) exp(-v/v_s) + c v`.
    Exponential,
    Nodes,
}

#[derive(Clone)]
struct Guess {
    form: Form,
    parameters: Vec<f64>,
    /// What the parameters are smooth about.
    baseline: Vec<f64>,
    starts: Vec<State>,
}

impl Guess {
    fn departure(&self) -> DVector<f64> {
        DVector::from_column_slice(&self.parameters) - DVector::from_column_slice(&self.baseline)
    }
}

/// Normal equations about a guess.
struct Linear {
    cost: f64,
    sum: f64,
    count: f64,
    weights: Vec<f64>,
    /// Over the node values, with the roughness.
    mu: DMatrix<f64>,
    mu_gradient: DVector<f64>,
    /// Per event: over the start state, mixed, and gradient.
    events: Vec<(DMatrix<f64>, DMatrix<f64>, DVector<f64>)>,
}

struct Search<'a> {
    plant: Plant,
    displacement: &'a [f64],
    offset: f64,
    interval: f64,
    noise: f64,
    basis: Basis,
    shots: Vec<Shot>,
    /// Steps for numerical derivatives by the start state.
    scale: Vec<f64>,
    roughness: DMatrix<f64>,
}

impl<'a> Search<'a> {
    fn new(
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

    fn optimise(&self, mut guess: Guess, steps: usize) -> (Guess, Linear) {
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

    fn node_speeds(&self) -> Vec<f64> {
        (0..self.basis.nodes)
            .map(|i| (i as f64 * self.basis.step).powi(2))
            .collect()
    }

    fn nodes(&self, form: Form, p: &[f64]) -> Vec<f64> {
        match form {
            Form::Nodes => p.to_vec(),
            Form::Exponential => self
                .node_speeds()
                .iter()
                .map(|v| p[1] + (p[0] - p[1]) * (-v / p[2].exp()).exp() + p[3] * v)
                .collect(),
        }
    }

    fn to_nodes(&self, guess: &Guess) -> Guess {
        let nodes = self.nodes(guess.form, &guess.parameters);
        Guess {
            form: Form::Nodes,
            baseline: nodes.clone(),
            parameters: nodes,
            starts: guess.starts.clone(),
        }
    }

    /// An exponential that falls over `fall` m/s, through the start's first and last values.
    fn exponential(&self, fall: f64, contact: &Contact, found: &StickSlip) -> Guess {
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
    fn start(&self, contact: &Contact, found: &StickSlip) -> Guess {
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

    /// Deviations of one event over the noise; 0 where the sample is missing.
    fn deviations(&self, shot: &Shot, start: &State, mu: &[f64]) -> DVector<f64> {
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
    fn bending(&self, form: Form) -> DMatrix<f64> {
        match form {
            Form::Nodes => self.roughness.clone(),
            Form::Exponential => DMatrix::zeros(4, 4),
        }
    }

    fn roughness_cost(&self, guess: &Guess) -> f64 {
        let p = guess.departure();
        p.dot(&(self.bending(guess.form) * &p))
    }

    fn cost(&self, guess: &Guess, weights: &[f64]) -> f64 {
        let mu = self.nodes(guess.form, &guess.parameters);
        let fit: f64 = self
            .shots
            .iter()
            .zip(&guess.starts)
            .zip(weights)
            .map(|((shot, start), weight)| {
                weight * self.deviations(shot, start, &mu).norm_squared()
            })
            .sum();
        fit + self.roughness_cost(guess)
    }

    fn linearise(&self, guess: &Guess) -> Linear {
        let n = guess.parameters.len();
        let here = self.nodes(guess.form, &guess.parameters);
        let bending = self.bending(guess.form);
        let bases: Vec<DVector<f64>> = self
            .shots
            .iter()
            .zip(&guess.starts)
            .map(|(shot, start)| self.deviations(shot, start, &here))
            .collect();
        let rms: Vec<f64> = bases
            .iter()
            .map(|b| (b.norm_squared() / b.len() as f64).sqrt())
            .collect();
        let mut sorted = rms.clone();
        sorted.sort_by(f64::total_cmp);
        let bound = OUTLIER * sorted[sorted.len() / 2];
        let weights: Vec<f64> = rms.iter().map(|r| (bound / r).min(1.0).powi(2)).collect();
        let mut out = Linear {
            cost: self.roughness_cost(guess),
            sum: 0.0,
            count: 0.0,
            mu_gradient: &bending * guess.departure(),
            mu: bending,
            events: Vec::new(),
            weights,
        };
        for (i, (shot, start)) in self.shots.iter().zip(&guess.starts).enumerate() {
            let base = &bases[i];
            let weight = out.weights[i];
            let by_mu = DMatrix::from_columns(
                &(0..n)
                    .map(|node| {
                        let mut beside = guess.parameters.clone();
                        beside[node] += 1e-6;
                        let mu = self.nodes(guess.form, &beside);
                        (self.deviations(shot, start, &mu) - base) / 1e-6
                    })
                    .collect::<Vec<_>>(),
            );
            let by_start = DMatrix::from_columns(
                &(0..self.scale.len())
                    .map(|state| {
                        let mut x = *start;
                        x[state] += 1e-7 * self.scale[state];
                        (self.deviations(shot, &x, &here) - base) / 1e-7
                    })
                    .collect::<Vec<_>>(),
            );
            out.cost += weight * base.norm_squared();
            out.sum += weight * base.norm_squared();
            out.count += weight * base.len() as f64;
            out.mu += weight * by_mu.tr_mul(&by_mu);
            out.mu_gradient += weight * by_mu.tr_mul(base);
            out.events.push((
                weight * by_start.tr_mul(&by_start),
                weight * by_start.tr_mul(&by_mu),
                weight * by_start.tr_mul(base),
            ));
        }
        out
    }

    /// Normal equations of the node values with the start states eliminated (Schur complement).
    fn reduced(&self, linear: &Linear, damping: f64) -> (DMatrix<f64>, DVector<f64>) {
        let mut matrix = linear.mu.clone();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] *= 1.0 + damping;
        }
        let mut gradient = linear.mu_gradient.clone();
        for (own, mixed, own_gradient) in &linear.events {
            let solved = damped(own, damping);
            matrix -= mixed.tr_mul(&(&solved * mixed));
            gradient -= mixed.tr_mul(&(&solved * own_gradient));
        }
        (matrix, gradient)
    }

    fn step(&self, guess: &Guess, linear: &Linear, damping: f64) -> Guess {
        let (matrix, gradient) = self.reduced(linear, damping);
        let mut out = guess.clone();
        let Some(change) = matrix.lu().solve(&-gradient) else {
            return out;
        };
        for (parameter, change) in out.parameters.iter_mut().zip(change.iter()) {
            *parameter += change;
        }
        for (start, (own, mixed, own_gradient)) in out.starts.iter_mut().zip(&linear.events) {
            let change_of_start = -damped(own, damping) * (own_gradient + mixed * &change);
            for (i, change) in change_of_start.iter().enumerate() {
                start[i] += change * self.scale[i];
            }
        }
        out
    }
}

/// Inverse of a start state's normal matrix; the direction that leaves stick is projected out by
/// the simulation, so it is singular without a ridge.
fn damped(own: &DMatrix<f64>, damping: f64) -> DMatrix<f64> {
    let mut matrix = own.clone();
    let ridge = 1e-10 * own.amax();
    for i in 0..matrix.nrows() {
        matrix[(i, i)] = matrix[(i, i)] * (1.0 + damping) + ridge;
    }
    let size = matrix.nrows();
    matrix
        .cholesky()
        .map_or_else(|| DMatrix::zeros(size, size), |c| c.inverse())
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
