//! Calibration: multiple shooting with a loss that forgives the few shots that graze a transition.
//!
//! Objective: `Q = sum_shots n/2 ln(1 + S/(n s^2)) + sum_knobs ((u - u_prior)/s_prior)^2 / 2`, with S the
//! sum of squares of a shot's n residuals and s the sensor noise: each shot has an error variance of its
//! own, at least the noise's (Student-t on shots). Minimised by Levenberg-Marquardt on the equivalent
//! weighted least squares; the start states of each shot are eliminated (Schur complement), so that the
//! cost grows linearly with the number of shots.

use super::hypothesis::Hypothesis;
use super::predictor::{Point, Predictor};
use super::shot::Shot;
use nalgebra::{DMatrix, DVector};

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
    /// Whether shared and own knobs move, or only the start states.
    pub knobs: bool,
    /// Whether the shared knobs move.
    pub shared: bool,
    /// Whether shots that start in the wrong basin get other starts.
    pub revive: bool,
}

/// What a fit found.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The point reached.
    pub point: Point,
    /// Objective there.
    pub objective: f64,
    /// Objective without the fifth of the shots that fit worst: what fits are compared by, since one
    /// grazing shot more or less says nothing about the model.
    pub trimmed: f64,
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
    /// How independent the samples are: residuals of neighbouring samples count together.
    pub weight: f64,
}

/// Directions in which a shot's start state may move: index of the state and its scale.
pub(super) fn directions(h: &Hypothesis, stuck: bool) -> Vec<usize> {
    let modal = 2 * h.modes;
    (0..modal + h.extra_states.len())
        // In rigid stick the first modal velocity follows from v_r = 0.
        .filter(|&i| !(stuck && !h.has_memory && i == 1))
        .collect()
}

struct Linear {
    residual: Vec<f64>,
    states: DMatrix<f64>,
    knobs: DMatrix<f64>,
}

/// A fit in progress.
pub struct Fitter<'a, 'b> {
    predictor: &'b mut Predictor<'a>,
    hypothesis: &'a Hypothesis,
    data: &'b Data<'b>,
    effort: Effort,
    /// Step of each difference quotient, adapted to the response.
    shared_step: Vec<f64>,
    own_step: Vec<Vec<f64>>,
    state_step: Vec<f64>,
    buffer: Vec<f64>,
}

impl<'a, 'b> Fitter<'a, 'b> {
    /// A fitter.
    pub fn new(
        predictor: &'b mut Predictor<'a>,
        hypothesis: &'a Hypothesis,
        data: &'b Data<'b>,
        effort: Effort,
    ) -> Self {
        let mut state_step = Vec::new();
        for j in 0..hypothesis.modes {
            let _ = j;
            state_step.extend([1e-8, 1e-5]);
        }
        state_step.extend(hypothesis.extra_states.iter().map(|s| 1e-3 * s.1));
        Self {
            shared_step: hypothesis.shared.iter().map(|k| k.step).collect(),
            own_step: hypothesis
                .own
                .iter()
                .map(|run| run.iter().map(|k| k.step).collect())
                .collect(),
            state_step,
            predictor,
            hypothesis,
            data,
            effort,
            buffer: Vec::new(),
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
        let residual = result.ok().filter(|done| *done).map(|_| {
            out.iter()
                .enumerate()
                .map(|(i, y)| {
                    if shot.trusted[i * stride] {
                        shot.measured[i * stride] - y
                    } else {
                        0.0
                    }
                })
                .collect::<Vec<f64>>()
        });
        self.buffer = out;
        residual.filter(|r| r.iter().all(|v| v.is_finite()))
    }

    fn count(&self, k: usize) -> f64 {
        let shot = &self.data.shots[k];
        (shot.count as f64 * self.effort.share / self.effort.stride as f64).max(1.0)
    }

    fn loss(&self, k: usize, sum: f64) -> f64 {
        let n = self.count(k);
        let noise = self.data.noise[self.data.shots[k].run];
        0.5 * n * self.data.weight * (1.0 + sum / (n * noise * noise)).ln()
    }

    fn prior_loss(&self, point: &Point) -> f64 {
        let one = |knob: &super::knob::Knob, u: f64| {
            if knob.prior_std > 0.0 {
                0.5 * ((u - knob.position(knob.prior)) / knob.prior_std).powi(2)
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
        shared + own + self.state_prior(point)
    }

    fn state_prior(&self, point: &Point) -> f64 {
        let modal = 2 * self.hypothesis.modes;
        let mut sum = 0.0;
        for x in &point.states {
            for (value, (_, nominal)) in x[modal..].iter().zip(&self.hypothesis.extra_states) {
                sum += 0.5 * (value / (10.0 * nominal)).powi(2);
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
                    variance * (10.0 * self.hypothesis.extra_states[i - modal].1).powi(-2);
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

    /// Objective and sums of squares.
    fn evaluate(&mut self, point: &Point) -> (f64, Vec<f64>) {
        let mut total = self.prior_loss(point);
        let mut sums = Vec::with_capacity(self.data.shots.len());
        for k in 0..self.data.shots.len() {
            let sum = self
                .residual(k, point)
                .map_or(f64::INFINITY, |r| r.iter().map(|v| v * v).sum());
            total += self.loss(k, sum);
            sums.push(sum);
        }
        (total, sums)
    }

    /// Residual and its derivatives for one shot; `None` where the FMU gives up.
    fn linearise(&mut self, k: usize, point: &Point) -> Option<Linear> {
        let shot = &self.data.shots[k];
        let h = self.hypothesis;
        let residual = self.residual(k, point)?;
        let n = residual.len();
        let noise = self.data.noise[shot.run];
        let used = self.used(shot);
        let target = (0.3 * noise).max(3e-9);
        let stuck = point.stuck[k];
        let list = directions(h, stuck);
        let own = h.own[shot.run].len();
        let mut states = DMatrix::zeros(n, list.len());
        let mut knobs = DMatrix::zeros(n, h.shared.len() + own);
        let mut trial = Point {
            shared: point.shared.clone(),
            own: vec![Vec::new(); point.own.len()],
            states: Vec::new(),
            stuck: Vec::new(),
        };
        trial.own[shot.run] = point.own[shot.run].clone();
        let mut state = point.states[k].clone();
        let stride = self.effort.stride;
        let mut out = Vec::new();
        let mut column =
            |this: &mut Self, trial: &Point, state: &[f64], step: f64, into: &mut [f64]| -> f64 {
                let done = this.predictor.predict(
                    shot,
                    &trial.shared,
                    &trial.own[shot.run],
                    state,
                    stuck,
                    used,
                    stride,
                    &mut out,
                );
                let mut norm = 0.0;
                if matches!(done, Ok(true)) {
                    for (i, y) in out.iter().enumerate() {
                        let changed = if shot.trusted[i * stride] {
                            shot.measured[i * stride] - y
                        } else {
                            0.0
                        };
                        let slope = (residual[i] - changed) / step;
                        into[i] = if slope.is_finite() { slope } else { 0.0 };
                        norm += into[i] * into[i];
                    }
                }
                (norm / n as f64).sqrt() * step.abs()
            };
        for (c, &i) in list.iter().enumerate() {
            let step = self.state_step[i];
            state[i] += step;
            let response = column(
                self,
                &trial,
                &state,
                step,
                states.column_mut(c).as_mut_slice(),
            );
            state[i] = point.states[k][i];
            adapt(&mut self.state_step[i], response, target);
        }
        if self.effort.knobs {
            if self.effort.shared {
                for c in 0..h.shared.len() {
                    let knob = &h.shared[c];
                    let step = towards_inside(knob, point.shared[c], self.shared_step[c]);
                    trial.shared[c] += step;
                    let response = column(
                        self,
                        &trial,
                        &state,
                        step,
                        knobs.column_mut(c).as_mut_slice(),
                    );
                    trial.shared[c] = point.shared[c];
                    adapt(&mut self.shared_step[c], response, target);
                }
            }
            for c in 0..own {
                let knob = &h.own[shot.run][c];
                let outside = knob.support.is_some_and(|(low, high)| {
                    shot.travel_end.max(shot.travel) < low
                        || shot.travel.min(shot.travel_end) > high
                });
                if knob.prior_std == 0.0 || outside {
                    continue;
                }
                let at = point.own[shot.run][c];
                let step = towards_inside(knob, at, self.own_step[shot.run][c]);
                trial.own[shot.run][c] += step;
                let response = column(
                    self,
                    &trial,
                    &state,
                    step,
                    knobs.column_mut(h.shared.len() + c).as_mut_slice(),
                );
                trial.own[shot.run][c] = at;
                if knob.support.is_none() {
                    adapt(&mut self.own_step[shot.run][c], response, target);
                }
            }
        }
        Some(Linear {
            residual,
            states,
            knobs,
        })
    }

    fn sum(&mut self, k: usize, point: &Point) -> f64 {
        self.residual(k, point)
            .map_or(f64::INFINITY, |r| r.iter().map(|v| v * v).sum())
    }

    /// Fits the start state of one shot alone, from the start it has in `point`.
    fn fit_start(&mut self, k: usize, point: &mut Point, iterations: usize) -> f64 {
        let knobs = std::mem::replace(&mut self.effort.knobs, false);
        let mut sum = self.sum(k, point);
        let mut damping = 1e-3;
        for _ in 0..iterations {
            let Some(l) = self.linearise(k, point) else {
                break;
            };
            let list = directions(self.hypothesis, point.stuck[k]);
            let mut xx = l.states.tr_mul(&l.states);
            let mut gx = l.states.tr_mul(&DVector::from_vec(l.residual));
            self.add_state_prior(
                &list,
                &point.states[k],
                sum / self.count(k),
                &mut xx,
                &mut gx,
            );
            let before = sum;
            for _ in 0..4 {
                if let Some(inverse) = scaled_inverse(&xx, damping) {
                    let step = inverse * &gx;
                    let old = point.states[k].clone();
                    for (c, &i) in list.iter().enumerate() {
                        point.states[k][i] += step[c];
                    }
                    let new = self.sum(k, point);
                    if new < sum {
                        sum = new;
                        damping *= 0.1;
                        break;
                    }
                    point.states[k] = old;
                }
                damping *= 10.0;
            }
            if before - sum < 1e-2 * before {
                break;
            }
        }
        self.effort.knobs = knobs;
        sum
    }

    /// Tries for each shot the start that another fit found, and keeps it where it is better.
    pub fn borrow(&mut self, point: &mut Point, sums: &mut [f64], other: &Point) {
        for k in 0..sums.len() {
            let noise = self.data.noise[self.data.shots[k].run];
            if sums[k] < 4.0 * self.count(k) * noise * noise {
                continue;
            }
            let mine = point.start(k);
            let modal = 2 * self.hypothesis.modes;
            point.states[k][..modal].copy_from_slice(&other.states[k][..modal]);
            point.stuck[k] = other.stuck[k];
            let sum = self.fit_start(k, point, 4);
            if sum < sums[k] {
                sums[k] = sum;
            } else {
                point.states[k] = mine.state;
                point.stuck[k] = mine.stuck;
            }
        }
    }

    /// Gives shots that fit far worse than the others another start: the end of the shot before, the
    /// smoothed state, and both with the other mode of the contact.
    pub fn revive(&mut self, point: &mut Point, sums: &mut [f64]) {
        let ratio = |this: &Self, k: usize, sum: f64| {
            let noise = this.data.noise[this.data.shots[k].run];
            sum / (this.count(k) * noise * noise)
        };
        let mut sorted: Vec<f64> = (0..sums.len()).map(|k| ratio(self, k, sums[k])).collect();
        sorted.sort_by(f64::total_cmp);
        // At most the worst third, and only those far above the better half.
        let limit =
            (16.0 * sorted[sorted.len() * 2 / 5].max(1.0)).max(sorted[sorted.len() * 2 / 3]);
        for k in 0..sums.len() {
            if ratio(self, k, sums[k]) < limit {
                continue;
            }
            let shot = &self.data.shots[k];
            let mut starts = Vec::new();
            if k > 0
                && self.data.shots[k - 1].run == shot.run
                && ratio(self, k - 1, sums[k - 1]) < limit
            {
                let _ = self.sum(k - 1, point);
                if let Ok(start) = self.predictor.carry_on(shot) {
                    starts.push(start);
                }
            }
            let mut smoothed = shot.state.clone();
            smoothed.resize(point.states[k].len(), 0.0);
            starts.push(super::predictor::ShotStart {
                state: smoothed.clone(),
                stuck: !shot.stuck,
            });
            starts.push(super::predictor::ShotStart {
                state: smoothed,
                stuck: shot.stuck,
            });
            let mut best = (sums[k], point.start(k));
            for start in starts {
                point.states[k] = start.state;
                point.stuck[k] = start.stuck;
                let sum = self.fit_start(k, point, 4);
                if sum < best.0 {
                    best = (sum, point.start(k));
                }
                if ratio(self, k, best.0) < limit {
                    break;
                }
            }
            sums[k] = best.0;
            point.states[k] = best.1.state;
            point.stuck[k] = best.1.stuck;
        }
    }

    /// Minimises the objective from `start`.
    pub fn run(&mut self, start: Point) -> Fit {
        let mut point = start;
        let (mut objective, mut sums) = self.evaluate(&point);
        let mut damping = 1e-3;
        let mut covariance = None;
        for iteration in 0..self.effort.iterations {
            if self.effort.revive && (iteration == 2 || iteration == 6) {
                self.revive(&mut point, &mut sums);
                objective = self.total(&point, &sums);
            }
            let system = Normal::assemble(self, &point, &sums);
            let before = objective;
            let mut accepted = false;
            for _ in 0..6 {
                let Some(trial) = system.step(self, &point, damping) else {
                    damping *= 10.0;
                    continue;
                };
                let (trial, q, s) = self.repair(trial, &point, &sums);
                if q < objective {
                    point = trial;
                    objective = q;
                    sums = s;
                    accepted = true;
                    damping = (damping * 0.2).max(1e-9);
                    break;
                }
                damping *= 8.0;
            }
            covariance = system.covariance();
            if !accepted || before - objective < self.effort.tolerance * before.abs() {
                break;
            }
        }
        let trimmed = self.trimmed(&point, &sums);
        let mean_square = sums
            .iter()
            .enumerate()
            .map(|(k, s)| s / self.count(k))
            .collect();
        Fit {
            point,
            objective,
            trimmed,
            mean_square,
            covariance,
        }
    }

    /// Evaluates a trial; where a shot fared much worse than before, its old start state gets a chance.
    fn repair(
        &mut self,
        mut trial: Point,
        old: &Point,
        old_sums: &[f64],
    ) -> (Point, f64, Vec<f64>) {
        let (_, mut sums) = self.evaluate(&trial);
        for k in 0..sums.len() {
            if sums[k] > 4.0 * old_sums[k] {
                let new = std::mem::replace(&mut trial.states[k], old.states[k].clone());
                let sum = self
                    .residual(k, &trial)
                    .map_or(f64::INFINITY, |r| r.iter().map(|v| v * v).sum());
                if sum < sums[k] {
                    sums[k] = sum;
                } else {
                    trial.states[k] = new;
                }
            }
        }
        let q = self.total(&trial, &sums);
        (trial, q, sums)
    }

    fn trimmed(&self, point: &Point, sums: &[f64]) -> f64 {
        let mut losses: Vec<f64> = sums
            .iter()
            .enumerate()
            .map(|(k, s)| self.loss(k, *s))
            .collect();
        losses.sort_by(f64::total_cmp);
        losses.truncate((losses.len() * 4).div_ceil(5));
        self.prior_loss(point) + losses.iter().sum::<f64>()
    }

    fn total(&self, point: &Point, sums: &[f64]) -> f64 {
        self.prior_loss(point)
            + sums
                .iter()
                .enumerate()
                .map(|(k, s)| self.loss(k, *s))
                .sum::<f64>()
    }
}

/// Keeps difference quotients in the linear range: the response should be a fraction of the noise.
fn adapt(step: &mut f64, response: f64, target: f64) {
    if response > 0.0 && response.is_finite() {
        *step *= (target / response).clamp(0.2, 5.0).powf(0.5);
    }
}

/// A step that stays within the knob's bounds.
fn towards_inside(knob: &super::knob::Knob, at: f64, step: f64) -> f64 {
    if knob.clamp(at + step) == at + step {
        step
    } else {
        -step
    }
}

/// The weighted normal equations, with each shot's start state eliminated.
struct Normal {
    matrix: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Per shot: H_xx, H_xk, g_x, indices of the states.
    blocks: Vec<Option<Block>>,
    shared: usize,
    /// First column of each run's own knobs.
    own_first: Vec<usize>,
    moves: bool,
}

struct Block {
    xx: DMatrix<f64>,
    xk: DMatrix<f64>,
    gx: DVector<f64>,
    list: Vec<usize>,
    columns: Vec<usize>,
    kk: DMatrix<f64>,
    gk: DVector<f64>,
}

/// Matrix and gradient of the knobs, and the inverse of each shot's block of start states.
type Reduced = (DMatrix<f64>, DVector<f64>, Vec<Option<DMatrix<f64>>>);

impl Normal {
    fn assemble(f: &mut Fitter, point: &Point, sums: &[f64]) -> Self {
        let h = f.hypothesis;
        let shared = h.shared.len();
        let mut own_first = Vec::new();
        let mut size = shared;
        for run in &h.own {
            own_first.push(size);
            size += run.len();
        }
        let mut normal = Self {
            matrix: DMatrix::zeros(size, size),
            gradient: DVector::zeros(size),
            blocks: Vec::new(),
            shared,
            own_first,
            moves: f.effort.knobs,
        };
        for k in 0..f.data.shots.len() {
            let shot = &f.data.shots[k];
            let n = f.count(k);
            let noise = f.data.noise[shot.run];
            let Some(l) = f.linearise(k, point) else {
                normal.blocks.push(None);
                continue;
            };
            let weight = f.data.weight / (noise * noise + sums[k] / n);
            let r = DVector::from_vec(l.residual);
            let list = directions(h, point.stuck[k]);
            let mut xx = weight * l.states.tr_mul(&l.states);
            let mut gx = weight * l.states.tr_mul(&r);
            f.add_state_prior(&list, &point.states[k], 1.0, &mut xx, &mut gx);
            let first = normal.own_first[shot.run];
            let columns: Vec<usize> = (0..shared)
                .chain(first..first + h.own[shot.run].len())
                .collect();
            let xk = weight * l.states.tr_mul(&l.knobs);
            let kk = weight * l.knobs.tr_mul(&l.knobs);
            let gk = weight * l.knobs.tr_mul(&r);
            normal.blocks.push(Some(Block {
                xx,
                xk,
                gx,
                list,
                columns,
                kk,
                gk,
            }));
        }
        let mut prior = |c: usize, knob: &super::knob::Knob, u: f64| {
            if knob.prior_std > 0.0 {
                let precision = knob.prior_std.powi(-2);
                normal.matrix[(c, c)] += precision;
                normal.gradient[c] -= precision * (u - knob.position(knob.prior));
            } else {
                normal.matrix[(c, c)] += 1.0;
            }
        };
        for (c, knob) in h.shared.iter().enumerate() {
            prior(c, knob, point.shared[c]);
        }
        let firsts = normal.own_first.clone();
        let mut prior = |c: usize, knob: &super::knob::Knob, u: f64| {
            if knob.prior_std > 0.0 {
                let precision = knob.prior_std.powi(-2);
                normal.matrix[(c, c)] += precision;
                normal.gradient[c] -= precision * (u - knob.position(knob.prior));
            } else {
                normal.matrix[(c, c)] += 1.0;
            }
        };
        for (run, knobs) in h.own.iter().enumerate() {
            for (i, knob) in knobs.iter().enumerate() {
                prior(firsts[run] + i, knob, point.own[run][i]);
            }
        }
        normal
    }

    /// The reduced system of the knobs at a damping: `H + damping diag(H)`.
    fn reduced(&self, damping: f64) -> Option<Reduced> {
        let mut matrix = self.matrix.clone();
        let mut gradient = self.gradient.clone();
        for i in 0..matrix.nrows() {
            matrix[(i, i)] *= 1.0 + damping;
        }
        let mut inverses = Vec::new();
        for block in &self.blocks {
            let Some(b) = block else {
                inverses.push(None);
                continue;
            };
            let inverse = scaled_inverse(&b.xx, damping)?;
            if self.moves {
                let t = &inverse * &b.xk;
                let schur = &b.kk - b.xk.tr_mul(&t);
                let reduced = &b.gk - t.tr_mul(&b.gx);
                for (i, &ci) in b.columns.iter().enumerate() {
                    gradient[ci] += reduced[i];
                    for (j, &cj) in b.columns.iter().enumerate() {
                        matrix[(ci, cj)] += schur[(i, j)];
                    }
                    matrix[(ci, ci)] += damping * b.kk[(i, i)];
                }
            }
            inverses.push(Some(inverse));
        }
        Some((matrix, gradient, inverses))
    }

    fn step(&self, f: &Fitter, point: &Point, damping: f64) -> Option<Point> {
        let (matrix, gradient, inverses) = self.reduced(damping)?;
        let mut trial = point.clone();
        let mut moved = DVector::zeros(matrix.nrows());
        if self.moves {
            let step = scaled_solve(&matrix, &gradient)?;
            let h = f.hypothesis;
            if f.effort.shared {
                for c in 0..self.shared {
                    let u = h.shared[c].clamp(point.shared[c] + limited(step[c], &h.shared[c]));
                    moved[c] = u - point.shared[c];
                    trial.shared[c] = u;
                }
            }
            for (run, knobs) in h.own.iter().enumerate() {
                for (i, knob) in knobs.iter().enumerate() {
                    if knob.prior_std > 0.0 {
                        let c = self.own_first[run] + i;
                        let u = knob.clamp(point.own[run][i] + step[c]);
                        moved[c] = u - point.own[run][i];
                        trial.own[run][i] = u;
                    }
                }
            }
        }
        for (k, block) in self.blocks.iter().enumerate() {
            let (Some(b), Some(inverse)) = (block, &inverses[k]) else {
                continue;
            };
            let part = DVector::from_iterator(b.columns.len(), b.columns.iter().map(|&c| moved[c]));
            let step = inverse * (&b.gx - &b.xk * part);
            for (c, &i) in b.list.iter().enumerate() {
                trial.states[k][i] += step[c];
            }
        }
        Some(trial)
    }

    fn covariance(&self) -> Option<DMatrix<f64>> {
        let (matrix, _, _) = self.reduced(1e-9)?;
        let inverse = scaled_inverse(&matrix, 1e-9)?;
        Some(
            inverse
                .view((0, 0), (self.shared, self.shared))
                .into_owned(),
        )
    }
}

/// At most one e-fold of a logarithmic knob at a time.
fn limited(step: f64, knob: &super::knob::Knob) -> f64 {
    match knob.scale {
        super::knob::Scale::Log => step.clamp(-0.7, 0.7),
        super::knob::Scale::Linear => step,
    }
}

fn scaling(matrix: &DMatrix<f64>) -> DVector<f64> {
    DVector::from_iterator(
        matrix.nrows(),
        (0..matrix.nrows()).map(|i| {
            if matrix[(i, i)] > 0.0 {
                matrix[(i, i)].sqrt().recip()
            } else {
                1.0
            }
        }),
    )
}

fn scaled(matrix: &DMatrix<f64>, scale: &DVector<f64>, damping: f64) -> DMatrix<f64> {
    DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        let value = matrix[(i, j)] * scale[i] * scale[j];
        if i == j {
            value.max(1e-14) * (1.0 + damping) + 1e-13
        } else {
            value
        }
    })
}

fn scaled_solve(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Option<DVector<f64>> {
    let scale = scaling(matrix);
    let solution = scaled(matrix, &scale, 0.0)
        .cholesky()?
        .solve(&right.component_mul(&scale));
    Some(solution.component_mul(&scale))
}

pub(super) fn scaled_inverse(matrix: &DMatrix<f64>, damping: f64) -> Option<DMatrix<f64>> {
    let scale = scaling(matrix);
    let inverse = scaled(matrix, &scale, damping).cholesky()?.inverse();
    Some(DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        inverse[(i, j)] * scale[i] * scale[j]
    }))
}
