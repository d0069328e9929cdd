//! Levenberg-Marquardt on the equivalent weighted least squares, with Broyden's updates between Jacobians.

use crate::diagnose::estimation::fit::{Fit, MOST_OVER_EXPECTED};
use crate::diagnose::estimation::fitter::{Fitter, LOST, Place, sum_of_squares};
use crate::diagnose::estimation::information::Information;
use crate::diagnose::estimation::normal_equations::Normal;
use crate::diagnose::estimation::sensitivities::{Known, Linear, Turned};
use crate::diagnose::model::point::Point;
use nalgebra::{DMatrix, DVector};

/// Steps taken on one Jacobian after the first, with Broyden's update in between: each costs one
/// prediction a segment where a Jacobian costs one a parameter.
const QUASI_STEPS: usize = 4;

/// Dampings that are tried with a Jacobian, ...
const TRIES: usize = 6;

/// ... and with one that was only updated: another costs as much as seven predictions.
const QUASI_TRIES: usize = 2;

/// Damping of the first step, relative to the diagonal; ...
const FIRST_DAMPING: f64 = 1e-3;

/// ... of a fit that begins at the noise, where the model is as good as linear and what is left to gain lies along valleys in which
/// its constants trade: a frequency against a load that lowers it.
const FIRST_DAMPING_NEAR: f64 = 1e-8;

/// The least damping of a step, ...
const LEAST_DAMPING: f64 = 1e-9;

/// ... and at the noise: what is believed adds 1e-9 to the diagonal, relative to what the data show, for constants that only act
/// together.
const LEAST_DAMPING_NEAR: f64 = 1e-12;

/// Objective over that of noise alone up to which a fit is at the noise; ...
const NEAR: f64 = 1.3;

/// ... where it begins there, falls down to this share of the tolerance count.
const TOLERANCE_NEAR: f64 = 0.1;

/// Part of a step after which its bend is taken, ...
const PART: f64 = 0.1;

/// ... and the longest acceleration beside it: both as in Transtrum and Sethna (2012, sect. 4).
const MOST_BEND: f64 = 0.75;

/// Iterations before which segments in a wrong basin get other starts.
const RESTARTS: [usize; 3] = [1, 3, 5];

/// How a step is looked for.
struct Descent {
    /// The least damping.
    least: f64,
    /// Dampings that are tried.
    tries: usize,
    /// Whether along the bend of the way.
    bends: bool,
    /// Whether the start states of the few segments that bar a step follow it.
    follows: bool,
}

impl Fitter<'_, '_> {
    /// Minimises the objective from `start`.
    pub fn run(&mut self, start: Point) -> Fit {
        self.data.work.fit();
        let mut here = self.evaluate(start);
        let graduation = self.graduation(&here);
        let noise_alone: f64 = (0..here.sums.len()).map(|k| 0.5 * self.count(k)).sum();
        let kept = self.kept_count(here.sums.len()) as f64 / here.sums.len().max(1) as f64;
        let is_near = |merit: f64| merit < NEAR * kept * noise_alone;
        let (first_damping, tolerance) = if is_near(here.merit) {
            (FIRST_DAMPING_NEAR, TOLERANCE_NEAR * self.options.tolerance)
        } else {
            (FIRST_DAMPING, self.options.tolerance)
        };
        let least_fall = self.options.least_fall;
        let enough = |before: f64| (tolerance * before.abs()).max(least_fall);
        let mut damping = first_damping;
        // Where all was differentiated last, by derivatives and not by updates.
        let mut differentiated = None;
        let mut strikes = 0;
        for iteration in 0..self.options.iterations {
            if self.options.reinitialise && RESTARTS.contains(&iteration) {
                self.reinitialise(&mut here);
            }
            self.allow(graduation.at(iteration), &mut here);
            let before = here.merit;
            let mut linear = self.linearise_all(&here);
            if self.options.parameters {
                differentiated = Some((here.clone(), linear.clone()));
                if is_near(here.merit) && self.falls_short(&here, &linear) {
                    break;
                }
            }
            for quasi in 0..=QUASI_STEPS {
                let system = Normal::assemble(self, &here, &linear);
                let is_worn = quasi > 0 && self.options.parameters;
                let tries = if is_worn { QUASI_TRIES } else { TRIES };
                let at_noise = self.allowance == 1.0 && is_near(here.merit);
                let known = damping;
                let least = if at_noise {
                    LEAST_DAMPING_NEAR
                } else {
                    LEAST_DAMPING
                };
                let how = Descent {
                    least,
                    tries,
                    bends: at_noise && !is_worn && self.options.parameters,
                    follows: !is_worn && self.options.parameters,
                };
                let found = self.descend(&here, (&system, &linear), &mut damping, how);
                if is_worn && (found.is_none() || at_noise) {
                    // It was the Jacobian that failed, not the length of the step; near the noise, what an updated Jacobian needs says
                    // nothing of the next one.
                    damping = known;
                }
                let Some(next) = found else {
                    break;
                };
                let fall = here.merit - next.merit;
                self.update(&mut linear, &here, &next);
                here = next;
                if fall < enough(before) {
                    break;
                }
            }
            if !self.goes_on(&here) {
                break;
            }
            if self.allowance > 1.0 {
                continue;
            }
            if before - here.merit < enough(before) {
                strikes += 1;
                if strikes == self.options.patience {
                    break;
                }
                // Differences to the other side, in case those taken met a transition.
                self.side = -self.side;
                damping = first_damping;
            } else {
                strikes = 0;
            }
        }
        self.allow(1.0, &mut here);
        let information = differentiated
            .as_ref()
            .map(|(there, linear)| Information::at(self, there, linear));
        let Some(information) = information else {
            return self.fit_at(here);
        };
        let covariance = information.covariance();
        let state_prices = information.state_prices();
        let occam = state_prices.as_ref().and_then(|p| information.occam(p));
        let occam = occam.unwrap_or(f64::NEG_INFINITY);
        let expected_fall = information.expected_fall();
        let fit = self.fit_at(here);
        Fit {
            covariance,
            log_evidence: occam - fit.misfit,
            state_prices: state_prices.unwrap_or_default(),
            expected_fall,
            ..fit
        }
    }

    /// Whether the evidence can't reach what is asked of it, as far as the derivatives at a place tell: near the noise, since far from it
    /// the likelihood falls by more than its quadratic model has.
    fn falls_short(&self, here: &Place, linear: &[Option<Linear>]) -> bool {
        let least = self.options.least_evidence;
        if least == f64::NEG_INFINITY || self.options.robust || self.allowance > 1.0 {
            return false;
        }
        let information = Information::at(self, here, linear);
        let prices = information.state_prices();
        let occam = prices.and_then(|p| information.occam(&p));
        let most_fall = MOST_OVER_EXPECTED * information.expected_fall_of_all();
        occam.is_some_and(|occam| occam - self.misfit(here) + most_fall < least)
    }

    /// All segments linearised at a point.
    pub(crate) fn linearised_at(&mut self, point: Point) -> Vec<Option<Linear>> {
        let here = self.evaluate(point);
        self.linearise_all(&here)
    }

    /// Information matrix and descent of the objective by the parameters at a point, each segment's start state projected out.
    /// Residuals and derivatives by what a smaller hypothesis has are those known at its point; `point` differs from that by so little
    /// of an effect that they are the same.
    pub(crate) fn reduced_beside(
        &mut self,
        known: Known,
        point: Point,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let residual = |l: &Option<Linear>| l.as_ref().map(|l| l.residual.clone());
        let residual: Vec<Option<Vec<f64>>> = known.linear.iter().map(residual).collect();
        let linear: Vec<Option<Linear>> = residual
            .iter()
            .enumerate()
            .map(|(k, r)| Some(self.linearise(k, &point, r.clone()?, Turned::Beside(known))))
            .collect();
        let here = Place {
            sums: residual.iter().map(sum_of_squares).collect(),
            residual,
            merit: f64::NAN,
            point,
        };
        Information::at(self, &here, &linear).into_system()
    }

    /// One step of Levenberg-Marquardt, along the bend of the way where it is asked for; `None` if no damping gives a fall.
    fn descend(
        &mut self,
        here: &Place,
        (system, linear): (&Normal, &[Option<Linear>]),
        damping: &mut f64,
        how: Descent,
    ) -> Option<Place> {
        for _ in 0..how.tries {
            let mut trial = system.step(self, &here.point, *damping);
            if how.bends
                && let Some(straight) = &trial
            {
                let bent = self.accelerated(here, (system, linear), straight, *damping);
                trial = bent.or(trial);
            }
            if let Some(next) = trial.and_then(|trial| self.better(trial, here, how.follows)) {
                *damping = (*damping * 0.2).max(how.least);
                return Some(next);
            }
            *damping *= 8.0;
        }
        None
    }

    /// A step with what the bend of the way adds to second order (geodesic acceleration, Transtrum and Sethna, arXiv:1201.5885, 2012,
    /// eq. 7): constants that only show together trade along valleys that are narrow and bent. `None` where that is longer than the
    /// step allows, or not determined.
    fn accelerated(
        &mut self,
        here: &Place,
        (system, linear): (&Normal, &[Option<Linear>]),
        straight: &Point,
        damping: f64,
    ) -> Option<Point> {
        let from = &here.point;
        let part = from.towards(straight, PART);
        let half_bend = |f: &mut Self, k: usize| {
            let (before, l) = (here.residual[k].as_ref()?, linear[k].as_ref()?);
            let after = f.residual(k, &part)?;
            let first_order = system.first_order(f, k, l, (from, straight))?;
            let change = DVector::from_fn(before.len(), |i, _| after[i] - before[i]);
            Some((change + first_order * PART) / (PART * PART))
        };
        let bends: Vec<_> = (0..linear.len()).map(|k| half_bend(self, k)).collect();
        let bent = system.pulled_by(self, here, linear, &bends);
        let bent = bent.step(self, straight, damping)?;
        let is_short =
            system.length(straight, &bent) < 0.5 * MOST_BEND * system.length(from, straight);
        is_short.then_some(bent)
    }

    /// Evaluates a fit; where a segment fared much worse than before, its old start state gets a chance. `None` if the trial is
    /// no better, which may show before all segments are predicted. With `follows`, the few segments that alone bar a step have their
    /// start states fitted at its end.
    fn better(&mut self, mut point: Point, old: &Place, follows: bool) -> Option<Place> {
        let count = self.data.segments.len();
        let prior = self.parameter_prior(&point);
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
            let loss = match follows {
                true => self.loss(k, sum).min(self.loss(k, old.sums[k])),
                false => self.loss(k, sum),
            };
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
        let mut next = Place {
            point,
            residual: residuals,
            sums,
            merit,
        };
        if follows && next.merit >= old.merit {
            self.follow(&mut next, old);
        }
        (next.merit < old.merit).then_some(next)
    }
}
