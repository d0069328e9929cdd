//! Calibration: multiple shooting with a loss that forgives the few shots that graze a transition.
//!
//! Objective of a search: `Q = sum_shots n/2 r(S/(n s^2)) + sum_knobs ((u - u_prior)/s_prior)^2 / 2`, with S the
//! sum of squares of a shot's n residuals and s the sensor noise; `r(x) = x` up to c = [`SURE`] and
//! `c (1 + ln(x/c))` beyond: Gaussian while a shot's error may be the noise's, and with a variance of its
//! own where it is more (Huber's idea with a logarithm); the fifth of the shots that fit worst has no say: one shot that
//! comes to graze a transition would else bar the way for all others. Objective of what is compared: the likelihood of
//! [`likelihood`] with the same priors, no shot left out. Minimised by Levenberg-Marquardt on the equivalent weighted least
//! squares; the start states of each shot are eliminated (Schur complement), so that the cost grows linearly with the
//! number of shots.

mod jacobian;
mod likelihood;
mod normal;
mod revive;

pub(super) use normal::scaled_inverse;

use self::likelihood::Likelihood;
use self::normal::{Normal, STATE_SPREAD};
use super::hypothesis::Hypothesis;
use super::predictor::{Point, Predictor};
use super::shot::Shot;
use nalgebra::{DMatrix, DVector};

/// Steps taken on one Jacobian after the first, with Broyden's update in between: each costs one
/// prediction a shot where a Jacobian costs one a knob.
const QUASI_STEPS: usize = 4;
/// Dampings that are tried with a Jacobian, ...
const TRIES: usize = 6;
/// ... and with one that was only updated: another costs as much as seven predictions.
const QUASI_TRIES: usize = 2;
/// A shot whose sum of squares grows by more than this in a step has left its basin.
const LOST: f64 = 4.0;
/// Damping of the first step, relative to the diagonal; ...
const FIRST_DAMPING: f64 = 1e-3;
/// ... of a fit that begins at the noise, where the model is as good as linear and what is left to gain lies along valleys in which
/// its constants trade: a frequency against a load that lowers it.
const FIRST_DAMPING_NEAR: f64 = 1e-8;
/// Objective over that of noise alone up to which a fit begins at the noise; ...
const NEAR: f64 = 1.3;
/// ... there, falls down to this share of the tolerance count.
const TOLERANCE_NEAR: f64 = 0.1;
/// Iterations before which shots in a wrong basin get other starts.
const REVIVALS: [usize; 3] = [1, 3, 5];
/// Mean square error of a shot in units of the noise's up to which the noise alone may have made it.
const SURE: f64 = 1.5;
/// Share of the shots, those that fit worst, that fits are compared without.
pub(super) const TRIMMED: f64 = 0.2;

/// How a fit is done.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Largest number of Jacobians.
    pub iterations: usize,
    /// Every how many-th sample is used.
    pub stride: usize,
    /// Share of each shot that is used, from its start.
    pub share: f64,
    /// A fit ends once Q falls by less than this share in an iteration.
    pub tolerance: f64,
    /// Iterations in a row that gain less than that after which a fit ends.
    pub patience: usize,
    /// Whether shared and own knobs move, or only the start states.
    pub knobs: bool,
    /// Whether the shared knobs move.
    pub shared: bool,
    /// Whether shots that start in the wrong basin get other starts.
    pub revive: bool,
    /// How many times more than the residuals' count suggests the reference model's own knobs are held to what is
    /// believed of them: more than 1 while a model may still be far off, whose residuals are no noise.
    pub belief: f64,
    /// Whether the shots that fit worst have no say, as in a search, where a model may still be far off; else the objective is
    /// that of the evidence.
    pub robust: bool,
    /// Whether the knobs of the reference model that all runs share move at all.
    pub reference: bool,
}

/// What a fit found.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The point reached.
    pub point: Point,
    /// Objective there, of a search or of what is compared, as the fit was done.
    pub trimmed: f64,
    /// Negative logarithm of likelihood and prior there, nats, no shot left out.
    pub misfit: f64,
    /// Logarithm of the evidence by Laplace's approximation, nats, up to what is the same for every hypothesis on the same
    /// shots and samples, with the likelihood of [`likelihood`]: no shot is left out of it. Negative infinity before a fit
    /// was linearised.
    pub log_evidence: f64,
    /// Mean square residual of each shot in m^2.
    pub mean_square: Vec<f64>,
    /// Covariance of the shared knobs on their scales (empty before it was asked for).
    pub covariance: Option<DMatrix<f64>>,
}

/// Shots, noise and weights of one fit.
pub struct Data<'a> {
    /// Shots to be fitted.
    pub shots: &'a [Shot],
    /// Sensor noise of each run in m.
    pub noise: &'a [f64],
}

impl Data<'_> {
    /// Root of the `share`-quantile of the mean square errors of a fit's shots, in units of the noise.
    pub fn quantile(&self, fit: &Fit, share: f64) -> f64 {
        let mut ratio: Vec<f64> = self
            .shots
            .iter()
            .zip(&fit.mean_square)
            .map(|(shot, m)| m / self.noise[shot.run].powi(2))
            .collect();
        ratio.sort_by(f64::total_cmp);
        match ratio.len() {
            0 => f64::NAN,
            n => ratio[((n - 1) as f64 * share).round() as usize].sqrt(),
        }
    }
}

/// Directions in which a shot's start state may move: index of the state and its scale.
pub(super) fn directions(h: &Hypothesis, stuck: bool) -> Vec<usize> {
    let modal = 2 * h.modes;
    (0..modal + h.extra_states.len())
        // In rigid stick the first modal velocity follows from v_r = 0.
        .filter(|&i| !(stuck && !h.has_memory && i == 1))
        .collect()
}

/// Where a fit stands.
struct Place {
    point: Point,
    /// Residuals of each shot in m; `None` where the FMU gave up.
    residual: Vec<Option<Vec<f64>>>,
    /// Their sums of squares in m^2.
    sums: Vec<f64>,
    /// Objective without the shots that fit worst.
    merit: f64,
}

/// Steps of the difference quotients of a shot.
struct Steps {
    states: Vec<f64>,
    shared: Vec<f64>,
    own: Vec<f64>,
}

/// A fit in progress.
pub struct Fitter<'a, 'b> {
    predictor: &'b mut Predictor<'a>,
    hypothesis: &'a Hypothesis,
    data: &'b Data<'b>,
    effort: Effort,
    /// Steps of the difference quotients for each shot, adapted to the response that each has there.
    steps: Vec<Steps>,
    buffer: Vec<f64>,
    /// Objective at which each shot was last looked for in vain.
    lost_at: Vec<f64>,
    /// Side to which differences are taken, 1 or -1.
    side: f64,
}

impl<'a, 'b> Fitter<'a, 'b> {
    /// A fitter.
    pub fn new(
        predictor: &'b mut Predictor<'a>,
        hypothesis: &'a Hypothesis,
        data: &'b Data<'b>,
        effort: Effort,
    ) -> Self {
        let of_states = (0..hypothesis.modes)
            .flat_map(|_| [1e-8, 1e-5])
            .chain(hypothesis.extra_states.iter().map(|s| 1e-3 * s.1));
        let of_states: Vec<f64> = of_states.collect();
        let steps = data
            .shots
            .iter()
            .map(|shot| Steps {
                states: of_states.clone(),
                shared: hypothesis.shared.iter().map(|k| k.step).collect(),
                own: hypothesis.own[shot.run].iter().map(|k| k.step).collect(),
            })
            .collect();
        Self {
            steps,
            predictor,
            hypothesis,
            data,
            effort,
            buffer: Vec::new(),
            lost_at: vec![f64::INFINITY; data.shots.len()],
            side: 1.0,
        }
    }

    /// Times of a shot that are used.
    fn used(&self, shot: &Shot) -> usize {
        ((shot.time.len() as f64 * self.effort.share).ceil() as usize).clamp(2, shot.time.len())
    }

    fn residual(&mut self, k: usize, point: &Point) -> Option<Vec<f64>> {
        let shot = &self.data.shots[k];
        let used = self.used(shot);
        let mut out = std::mem::take(&mut self.buffer);
        let result = self.predictor.predict(
            shot,
            &point.shared,
            &point.own[shot.run],
            &point.states[k],
            point.stuck[k],
            used,
            self.effort.stride,
            &mut out,
        );
        let stride = self.effort.stride;
        let residual = result.ok().map(|_| {
            let mut residual: Vec<f64> = out
                .iter()
                .enumerate()
                .map(|(i, y)| {
                    if shot.trusted[i * stride] {
                        shot.measured[i * stride] - y
                    } else {
                        0.0
                    }
                })
                .collect();
            // What ran away counts as far off from there on: without a value, a fit that begins far from the data would
            // have nothing to descend on.
            residual.resize(used.div_ceil(stride), self.predictor.limit(shot.run));
            residual
        });
        self.buffer = out;
        residual.filter(|r| r.iter().all(|v| v.is_finite()))
    }

    /// Number of samples that were predicted before the motion ran away.
    fn predicted(&self, k: usize, residual: &[f64]) -> usize {
        let limit = self.predictor.limit(self.data.shots[k].run);
        // What was predicted is nearer than that, or zero where it is not trusted.
        let end = residual.iter().position(|r| *r == limit && limit > 0.0);
        end.unwrap_or(residual.len())
    }

    fn count(&self, k: usize) -> f64 {
        let shot = &self.data.shots[k];
        (shot.count as f64 * self.effort.share / self.effort.stride as f64).max(1.0)
    }

    fn loss(&self, k: usize, sum: f64) -> f64 {
        if !self.effort.robust {
            return self.likelihood(k).loss(sum);
        }
        let n = self.count(k);
        let noise = self.data.noise[self.data.shots[k].run];
        let limit = SURE * noise * noise;
        if sum <= n * limit {
            0.5 * sum / (noise * noise)
        } else {
            0.5 * n * SURE * (1.0 + (sum / (n * limit)).ln())
        }
    }

    /// Weight of a shot's squares in the equivalent least squares: twice the derivative of its loss.
    fn weight(&self, k: usize, sum: f64) -> f64 {
        if !self.effort.robust {
            return self.likelihood(k).weight(sum);
        }
        let noise = self.data.noise[self.data.shots[k].run];
        SURE / (SURE * noise * noise).max(sum / self.count(k))
    }

    /// Whether a shared knob moves.
    fn moves(&self, knob: &super::knob::Knob) -> bool {
        self.effort.shared && (knob.of_effect() || self.effort.reference)
    }

    /// Precision of what is believed of a knob.
    fn precision(&self, knob: &super::knob::Knob) -> f64 {
        let belief = if knob.of_effect() {
            1.0
        } else {
            self.effort.belief
        };
        belief * knob.prior_std.powi(-2)
    }

    fn prior_loss(&self, point: &Point) -> f64 {
        self.knob_prior(point) + self.state_prior(point)
    }

    fn knob_prior(&self, point: &Point) -> f64 {
        let one = |knob: &super::knob::Knob, u: f64| {
            if knob.prior_std > 0.0 {
                0.5 * self.precision(knob) * (u - knob.position(knob.prior)).powi(2)
            } else {
                0.0
            }
        };
        let shared: f64 = self
            .hypothesis
            .shared
            .iter()
            .zip(&point.shared)
            .map(|(k, u)| one(k, *u))
            .sum();
        let runs: Vec<usize> = self.runs();
        let own: f64 = runs
            .iter()
            .map(|&r| {
                self.hypothesis.own[r]
                    .iter()
                    .zip(&point.own[r])
                    .map(|(k, u)| one(k, *u))
                    .sum::<f64>()
            })
            .sum();
        shared + own
    }

    fn state_prior(&self, point: &Point) -> f64 {
        let modal = 2 * self.hypothesis.modes;
        let mut sum = 0.0;
        for x in &point.states {
            for (value, (_, nominal)) in x[modal..].iter().zip(&self.hypothesis.extra_states) {
                sum += 0.5 * (value / (STATE_SPREAD * nominal)).powi(2);
            }
        }
        sum
    }

    /// Adds the weak prior on deviations of the effects' states from equilibrium; `variance` is that of
    /// the residuals that the system counts as one.
    fn add_state_prior(
        &self,
        list: &[usize],
        state: &[f64],
        variance: f64,
        xx: &mut DMatrix<f64>,
        gx: &mut DVector<f64>,
    ) {
        let modal = 2 * self.hypothesis.modes;
        for (c, &i) in list.iter().enumerate() {
            if i >= modal {
                let precision =
                    variance * (STATE_SPREAD * self.hypothesis.extra_states[i - modal].1).powi(-2);
                xx[(c, c)] += precision;
                gx[c] -= precision * state[i];
            }
        }
    }

    fn runs(&self) -> Vec<usize> {
        let mut runs: Vec<usize> = self.data.shots.iter().map(|s| s.run).collect();
        runs.sort_unstable();
        runs.dedup();
        runs
    }

    /// Predicts every shot at a point.
    fn evaluate(&mut self, point: Point) -> Place {
        let residual: Vec<Option<Vec<f64>>> = (0..self.data.shots.len())
            .map(|k| self.residual(k, &point))
            .collect();
        let mut place = Place {
            sums: residual.iter().map(sum_of_squares).collect(),
            point,
            residual,
            merit: 0.0,
        };
        place.merit = self.trimmed(&place.point, &place.sums);
        place
    }

    /// Minimises the objective from `start`.
    pub fn run(&mut self, start: Point) -> Fit {
        let mut here = self.evaluate(start);
        let noise_alone: f64 = (0..here.sums.len()).map(|k| 0.5 * self.count(k)).sum();
        let (first_damping, tolerance) = if here.merit
            < NEAR * self.kept_count(here.sums.len()) as f64 / here.sums.len().max(1) as f64
                * noise_alone
        {
            (FIRST_DAMPING_NEAR, TOLERANCE_NEAR * self.effort.tolerance)
        } else {
            (FIRST_DAMPING, self.effort.tolerance)
        };
        let mut damping = first_damping;
        let (mut covariance, mut occam) = (None, f64::NEG_INFINITY);
        let mut strikes = 0;
        for iteration in 0..self.effort.iterations {
            if self.effort.revive && REVIVALS.contains(&iteration) {
                self.revive(&mut here);
            }
            let before = here.merit;
            let mut linear = self.linearise_all(&here);
            for quasi in 0..=QUASI_STEPS {
                let system = Normal::assemble(self, &here, &linear);
                if quasi == 0 && self.effort.knobs {
                    covariance = system.covariance();
                    occam = system.occam(self).unwrap_or(f64::NEG_INFINITY);
                }
                let is_worn = quasi > 0 && self.effort.knobs;
                let tries = if is_worn { QUASI_TRIES } else { TRIES };
                let known = damping;
                let Some(next) = self.descend(&here, &system, &mut damping, tries) else {
                    if is_worn {
                        // It was the Jacobian that failed, not the length of the step.
                        damping = known;
                    }
                    break;
                };
                let fall = here.merit - next.merit;
                self.update(&mut linear, &here, &next);
                here = next;
                if fall < tolerance * before.abs() {
                    break;
                }
            }
            if before - here.merit < tolerance * before.abs() {
                strikes += 1;
                if strikes == self.effort.patience {
                    break;
                }
                // Differences to the other side, in case those taken met a transition.
                self.side = -self.side;
                damping = first_damping;
            } else {
                strikes = 0;
            }
        }
        self.fit_at(here, covariance, occam)
    }

    /// Information matrix and gradient of the knobs at a point, each shot's start state projected out.
    pub fn reduced_at(&mut self, point: Point) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let here = self.evaluate(point);
        let linear = self.linearise_all(&here);
        let (matrix, gradient, _) = Normal::assemble(self, &here, &linear).reduced(0.0)?;
        Some((matrix, gradient))
    }

    /// Negative logarithm of likelihood and prior at a place, nats; held constants pay no more than they are believed.
    fn misfit(&self, here: &Place) -> f64 {
        let losses = here.sums.iter().enumerate();
        let losses = losses.map(|(k, &sum)| self.likelihood(k).loss(sum));
        losses.sum::<f64>() + self.prior_loss(&here.point)
    }

    fn likelihood(&self, k: usize) -> Likelihood {
        let noise = self.data.noise[self.data.shots[k].run];
        Likelihood::new(self.count(k), noise, 2 * self.hypothesis.modes)
    }

    /// The fit that a place is; `occam` is what the evidence pays for all that is free.
    fn fit_at(&self, here: Place, covariance: Option<DMatrix<f64>>, occam: f64) -> Fit {
        let mean_square = (0..here.sums.len())
            .map(|k| here.sums[k] / self.count(k))
            .collect();
        let misfit = self.misfit(&here);
        Fit {
            trimmed: here.merit,
            misfit,
            log_evidence: occam - misfit,
            point: here.point,
            mean_square,
            covariance,
        }
    }

    /// One step of Levenberg-Marquardt; `None` if no damping gives a fall.
    fn descend(
        &mut self,
        here: &Place,
        system: &Normal,
        damping: &mut f64,
        tries: usize,
    ) -> Option<Place> {
        for _ in 0..tries {
            let trial = system.step(self, &here.point, *damping);
            if let Some(next) = trial.and_then(|trial| self.better(trial, here)) {
                *damping = (*damping * 0.2).max(1e-9);
                return Some(next);
            }
            *damping *= 8.0;
        }
        None
    }

    /// Evaluates a trial; where a shot fared much worse than before, its old start state gets a chance. `None` if the trial is
    /// no better, which may show before all shots are predicted.
    fn better(&mut self, mut point: Point, old: &Place) -> Option<Place> {
        let count = self.data.shots.len();
        let prior = self.knob_prior(&point);
        let (mut residuals, mut sums) = (Vec::with_capacity(count), Vec::with_capacity(count));
        // Losses so far, the smallest first.
        let mut losses: Vec<f64> = Vec::with_capacity(count);
        for k in 0..count {
            let mut residual = self.residual(k, &point);
            let mut sum = sum_of_squares(&residual);
            if sum > LOST * old.sums[k] {
                let new = std::mem::replace(&mut point.states[k], old.point.states[k].clone());
                let again = self.residual(k, &point);
                let sum_again = sum_of_squares(&again);
                if sum_again < sum {
                    (residual, sum) = (again, sum_again);
                } else {
                    point.states[k] = new;
                }
            }
            let loss = self.loss(k, sum);
            losses.insert(losses.partition_point(|l| *l < loss), loss);
            residuals.push(residual);
            sums.push(sum);
            // Those that count in the end weigh at least as much as these.
            let sure = losses.len().saturating_sub(count - self.kept_count(count));
            if prior + losses[..sure].iter().sum::<f64>() > old.merit {
                return None;
            }
        }
        let merit = self.trimmed(&point, &sums);
        (merit < old.merit).then_some(Place {
            point,
            residual: residuals,
            sums,
            merit,
        })
    }

    /// How many of so many shots count.
    fn kept_count(&self, shots: usize) -> usize {
        let left_out = if self.effort.robust { TRIMMED } else { 0.0 };
        (shots as f64 * (1.0 - left_out)).ceil() as usize
    }

    /// Which shots count: all but those that fit worst.
    fn kept(&self, sums: &[f64]) -> Vec<bool> {
        let losses: Vec<f64> = (0..sums.len()).map(|k| self.loss(k, sums[k])).collect();
        let mut order: Vec<usize> = (0..sums.len()).collect();
        order.sort_by(|&a, &b| losses[a].total_cmp(&losses[b]));
        let mut kept = vec![false; sums.len()];
        for &k in &order[..self.kept_count(sums.len())] {
            kept[k] = true;
        }
        kept
    }

    fn trimmed(&self, point: &Point, sums: &[f64]) -> f64 {
        let kept = self.kept(sums);
        let losses = (0..sums.len())
            .filter(|&k| kept[k])
            .map(|k| self.loss(k, sums[k]));
        self.prior_loss(point) + losses.sum::<f64>()
    }
}

/// Sum of the squares; infinite where the FMU gave up.
fn sum_of_squares(residual: &Option<Vec<f64>>) -> f64 {
    residual
        .as_ref()
        .map_or(f64::INFINITY, |r| r.iter().map(|v| v * v).sum())
}
