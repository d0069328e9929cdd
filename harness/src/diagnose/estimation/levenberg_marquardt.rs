//! Levenberg-Marquardt on the equivalent weighted least squares, with Broyden's updates between Jacobians.

use crate::diagnose::estimation::fit::Fit;
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

/// Objective over that of noise alone up to which a fit begins at the noise; ...
const NEAR: f64 = 1.3;

/// ... there, falls down to this share of the tolerance count.
const TOLERANCE_NEAR: f64 = 0.1;

/// Iterations before which segments in a wrong basin get other starts.
const RESTARTS: [usize; 3] = [1, 3, 5];

impl Fitter<'_, '_> {
    /// Minimises the objective from `start`.
    pub fn run(&mut self, start: Point) -> Fit {
        self.data.work.fit();
        let mut here = self.evaluate(start);
        let graduation = self.graduation(&here);
        let noise_alone: f64 = (0..here.sums.len()).map(|k| 0.5 * self.count(k)).sum();
        let (first_damping, tolerance) = if here.merit
            < NEAR * self.kept_count(here.sums.len()) as f64 / here.sums.len().max(1) as f64
                * noise_alone
        {
            (FIRST_DAMPING_NEAR, TOLERANCE_NEAR * self.options.tolerance)
        } else {
            (FIRST_DAMPING, self.options.tolerance)
        };
        let least = self.options.least_fall;
        let enough = |before: f64| (tolerance * before.abs()).max(least);
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
            }
            for quasi in 0..=QUASI_STEPS {
                let system = Normal::assemble(self, &here, &linear);
                let is_worn = quasi > 0 && self.options.parameters;
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
        let covariance = information.as_ref().and_then(Information::covariance);
        let occam = information.as_ref().and_then(Information::occam);
        self.fit_at(here, covariance, occam.unwrap_or(f64::NEG_INFINITY))
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

    /// Evaluates a fit; where a segment fared much worse than before, its old start state gets a chance. `None` if the trial is
    /// no better, which may show before all segments are predicted.
    fn better(&mut self, mut point: Point, old: &Place) -> Option<Place> {
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
}
