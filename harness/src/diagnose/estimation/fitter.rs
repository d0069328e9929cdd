//! Calibration: multiple shooting with a loss that forgives the few segments that graze a transition.
//!
//! Objective of a search: `Q = sum_segments n/2 r(S/(n s^2)) + sum_parameters ((u - u_prior)/s_prior)^2 / 2`, with S the
//! sum of squares of a segment's n residuals and s the sensor noise; `r(x) = x` up to c = [`SURE`] and
//! `c (1 + ln(x/c))` beyond: Gaussian while a segment's error may be the noise's, and with a variance of its
//! own where it is more (Huber's idea with a logarithm); the fifth of the segments that fit worst has no say, unless
//! the rest is met anyway: one segment that comes to graze a transition would else bar the way for all others. Objective of what is
//! compared: the likelihood of [`likelihood`] with the same priors, no segment left out. Minimised by Levenberg-Marquardt on the equivalent weighted least
//! squares; the start states of each segment are eliminated (Schur complement), so that the cost grows linearly with the
//! number of segments, and fitted anew for the few segments that bar a step.

use crate::diagnose::data::segment::{FurtherPart, Segment};
use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::estimation::likelihood::Likelihood;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::observations::Observations;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::simulator::{RUNAWAY, Samples, Simulator};
use crate::diagnose::thresholds::STATE_SPREAD;
use nalgebra::{DMatrix, DVector};

/// A segment whose sum of squares grows by more than this in a step has left its basin.
pub(crate) const LOST: f64 = 4.0;

/// Mean square error of a segment in units of the noise's up to which the noise alone may have made it.
const SURE: f64 = 1.5;
/// Share of the segments, those that fit worst, that fits are compared without.
pub(crate) const TRIMMED: f64 = 0.2;

/// Directions in which a segment's start state may move: index of the state and its scale.
pub(crate) fn directions(h: &Hypothesis, stuck: bool) -> Vec<usize> {
    let modal = 2 * h.modes;
    (0..modal + h.extra_states.len())
        // In rigid stick the first modal velocity follows from v_r = 0.
        .filter(|&i| !(stuck && !h.has_memory && i == 1))
        .collect()
}

/// Where a fit stands.
#[derive(Clone)]
pub(crate) struct Place {
    pub(crate) point: Point,
    /// Residuals of each segment in m; `None` where the FMU gave up.
    pub(crate) residual: Vec<Option<Vec<f64>>>,
    /// Their sums of squares in m^2.
    pub(crate) sums: Vec<f64>,
    /// Objective without the segments that fit worst.
    pub(crate) merit: f64,
}

/// Steps of the difference quotients of a segment.
pub(crate) struct Steps {
    pub(crate) states: Vec<f64>,
    pub(crate) shared: Vec<f64>,
    pub(crate) per_run: Vec<f64>,
}

/// A fit in progress.
pub struct Fitter<'a, 'b> {
    pub(crate) simulator: &'b mut dyn Simulator,
    pub(crate) hypothesis: &'a Hypothesis,
    pub(crate) data: &'b Observations<'b>,
    pub(crate) options: FitOptions,
    /// Steps of the difference quotients for each segment, adapted to the response that each has there.
    pub(crate) steps: Vec<Steps>,
    pub(crate) buffer: Vec<f64>,
    /// Objective at which each segment was last looked for in vain.
    pub(crate) lost_at: Vec<f64>,
    /// Side to which differences are taken, 1 or -1.
    pub(crate) side: f64,
    /// How many times more than the sensor's noise a search allows for ([`super::graduation`]).
    pub(crate) allowance: f64,
    /// Is told after each iteration where the fit stands.
    pub(crate) listener: Option<&'b dyn Listener>,
}

/// Who hears of a fit in progress, and may stop it.
pub trait Listener {
    /// An iteration has ended at `point`, with these mean square residuals of the segments in m^2; whether to go on.
    fn goes_on(&self, point: &Point, mean_square: &[f64]) -> bool;
}

impl<'a, 'b> Fitter<'a, 'b> {
    /// A fitter.
    pub fn new(
        simulator: &'b mut dyn Simulator,
        hypothesis: &'a Hypothesis,
        data: &'b Observations<'b>,
        options: FitOptions,
    ) -> Self {
        let of_states = (0..hypothesis.modes)
            .flat_map(|_| [1e-8, 1e-5])
            .chain(hypothesis.extra_states.iter().map(|s| 1e-3 * s.1));
        let of_states: Vec<f64> = of_states.collect();
        let steps = data
            .segments
            .iter()
            .map(|segment| Steps {
                states: of_states.clone(),
                shared: hypothesis.shared.iter().map(|k| k.step).collect(),
                per_run: hypothesis.per_run[segment.run]
                    .iter()
                    .map(|k| k.step)
                    .collect(),
            })
            .collect();
        Self {
            steps,
            simulator,
            hypothesis,
            data,
            options,
            buffer: Vec::new(),
            lost_at: vec![f64::INFINITY; data.segments.len()],
            side: 1.0,
            allowance: 1.0,
            listener: None,
        }
    }

    /// The same with someone who hears of each iteration.
    pub fn told_to(self, listener: &'b dyn Listener) -> Self {
        Self {
            listener: Some(listener),
            ..self
        }
    }

    /// Tells the listener where the fit stands; whether it goes on.
    pub(crate) fn goes_on(&self, here: &Place) -> bool {
        self.listener.is_none_or(|listener| {
            let means: Vec<f64> = self.mean_squares(&here.sums);
            listener.goes_on(&here.point, &means)
        })
    }

    fn mean_squares(&self, sums: &[f64]) -> Vec<f64> {
        (0..sums.len()).map(|k| sums[k] / self.count(k)).collect()
    }

    /// Mean squares of each segment's residuals by each of its sensors; empty where all have but one.
    fn by_sensor(&self, residual: &[Option<Vec<f64>>]) -> Vec<Vec<f64>> {
        let segments = self.data.segments;
        if segments.iter().all(|s| s.further.is_empty()) {
            return Vec::new();
        }
        let of_segment = |(segment, residual): (&Segment, &Option<Vec<f64>>)| {
            let further = segment.further.iter();
            let further = further.map(|part| self.count_of_further(segment, part));
            let counts = std::iter::once(self.count_of_first(segment)).chain(further);
            let Some(residual) = residual else {
                return counts.map(|_| f64::INFINITY).collect();
            };
            let sensors = residual.chunks(residual.len() / (1 + segment.further.len()));
            let mean = |(rows, count): (&[f64], f64)| {
                let sum: f64 = rows.iter().map(|r| r * r).sum();
                if count > 0.0 { sum / count } else { f64::NAN }
            };
            sensors.zip(counts).map(mean).collect()
        };
        segments.iter().zip(residual).map(of_segment).collect()
    }

    /// Times of a segment that are used.
    pub(crate) fn used(&self, segment: &Segment) -> usize {
        ((segment.time.len() as f64 * self.options.share).ceil() as usize)
            .clamp(2, segment.time.len())
    }

    /// Residuals of the samples used: those of the first sensor, then those of each further one. `None` where the FMU gave up.
    pub(crate) fn residual(&mut self, k: usize, point: &Point) -> Option<Vec<f64>> {
        let segment = &self.data.segments[k];
        let used = self.used(segment);
        let mut out = std::mem::take(&mut self.buffer);
        let result = self.simulator.predict(
            segment,
            point.values(k, segment.run),
            Samples::of(used, self.options.stride).of_all_sensors(),
            &mut out,
        );
        let residual = result.ok().map(|_| self.residual_of(k, &out));
        self.buffer = out;
        residual.filter(|r| r.iter().all(|v| v.is_finite()))
    }

    /// Residuals that a prediction leaves.
    pub(crate) fn residual_of(&self, k: usize, predicted: &[f64]) -> Vec<f64> {
        let segment = &self.data.segments[k];
        let stride = self.options.stride;
        let rows = self.used(segment).div_ceil(stride);
        let left = |measured: &[f64], trusted: &[bool], i: usize, y: f64| {
            if trusted[i * stride] {
                measured[i * stride] - y
            } else {
                0.0
            }
        };
        let of_sensor = predicted.len() / (1 + segment.further.len());
        let (first, others) = predicted.split_at(of_sensor);
        let mut residual: Vec<f64> = first
            .iter()
            .enumerate()
            .map(|(i, y)| left(&segment.measured, &segment.trusted, i, *y))
            .collect();
        // What ran away counts as far off from there on: without a value, a fit that begins far from the data would
        // have nothing to descend on.
        residual.resize(rows, self.simulator.limit(segment.run));
        for (number, part) in segment.further.iter().enumerate() {
            let from = residual.len();
            let own = others[number * of_sensor..(number + 1) * of_sensor].iter();
            let own = own.enumerate();
            residual.extend(own.map(|(i, y)| left(&part.measured, &part.trusted, i, *y)));
            let ran_away = residual.len() - from..rows;
            let limit = |i: usize| match part.trusted[i * stride] {
                true => RUNAWAY * part.reach,
                false => 0.0,
            };
            residual.extend(ran_away.map(limit));
        }
        residual
    }

    /// Number of samples that were predicted before the motion ran away.
    pub(crate) fn predicted(&self, k: usize, residual: &[f64]) -> usize {
        let segment = &self.data.segments[k];
        let limit = self.simulator.limit(segment.run);
        let first = &residual[..residual.len() / (1 + segment.further.len())];
        // What was predicted is nearer than that, or zero where it is not trusted.
        let end = first.iter().position(|r| *r == limit && limit > 0.0);
        end.unwrap_or(first.len())
    }

    pub(crate) fn count(&self, k: usize) -> f64 {
        let segment = &self.data.segments[k];
        let further = segment.further.iter();
        let further: f64 = further
            .map(|part| self.count_of_further(segment, part))
            .sum();
        self.count_of_first(segment) + further
    }

    fn count_of_first(&self, segment: &Segment) -> f64 {
        (segment.count as f64 * self.options.share / self.options.stride as f64).max(1.0)
    }

    /// Readings of a further sensor that count, exactly: one that is slower than the first may read at none of the samples of a stride.
    fn count_of_further(&self, segment: &Segment, part: &FurtherPart) -> f64 {
        let used = part.trusted[..self.used(segment)].iter();
        used.step_by(self.options.stride).filter(|&&t| t).count() as f64
    }

    pub(crate) fn loss(&self, k: usize, sum: f64) -> f64 {
        if !self.options.robust {
            return self.likelihood(k).loss(sum);
        }
        let n = self.count(k);
        let noise = self.allowance * self.data.noise[self.data.segments[k].run];
        let limit = SURE * noise * noise;
        if sum <= n * limit {
            0.5 * sum / (noise * noise)
        } else {
            0.5 * n * SURE * (1.0 + (sum / (n * limit)).ln())
        }
    }

    /// Weight of a segment's squares in the equivalent least squares: twice the derivative of its loss.
    pub(crate) fn weight(&self, k: usize, sum: f64) -> f64 {
        if !self.options.robust {
            return self.likelihood(k).weight(sum);
        }
        let noise = self.allowance * self.data.noise[self.data.segments[k].run];
        SURE / (SURE * noise * noise).max(sum / self.count(k))
    }

    /// Whether a shared parameter moves.
    pub(crate) fn moves(&self, parameter: &crate::diagnose::model::parameter::Parameter) -> bool {
        self.options.shared && (parameter.of_effect() || self.options.reference)
    }

    /// Precision of what is believed of a parameter.
    pub(crate) fn precision(
        &self,
        parameter: &crate::diagnose::model::parameter::Parameter,
    ) -> f64 {
        let belief = if parameter.of_effect() {
            1.0
        } else {
            self.options.belief
        };
        belief * parameter.prior_std.powi(-2)
    }

    pub(crate) fn prior_loss(&self, point: &Point) -> f64 {
        self.parameter_prior(point) + self.state_prior(point)
    }

    pub(crate) fn parameter_prior(&self, point: &Point) -> f64 {
        let one = |parameter: &crate::diagnose::model::parameter::Parameter, u: f64| {
            if parameter.prior_std > 0.0 {
                0.5 * self.precision(parameter) * (u - parameter.position(parameter.prior)).powi(2)
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
        let per_run: f64 = runs
            .iter()
            .map(|&r| {
                self.hypothesis.per_run[r]
                    .iter()
                    .zip(&point.per_run[r])
                    .map(|(k, u)| one(k, *u))
                    .sum::<f64>()
            })
            .sum();
        shared + per_run
    }

    pub(crate) fn state_prior(&self, point: &Point) -> f64 {
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
    pub(crate) fn add_state_prior(
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

    pub(crate) fn runs(&self) -> Vec<usize> {
        let mut runs: Vec<usize> = self.data.segments.iter().map(|s| s.run).collect();
        runs.sort_unstable();
        runs.dedup();
        runs
    }

    /// Predicts every segment at a point.
    pub(crate) fn evaluate(&mut self, point: Point) -> Place {
        let residual: Vec<Option<Vec<f64>>> = (0..self.data.segments.len())
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

    /// Negative logarithm of likelihood and prior at a place, nats; held constants pay no more than they are believed.
    pub(crate) fn misfit(&self, here: &Place) -> f64 {
        let losses = here.sums.iter().enumerate();
        let losses = losses.map(|(k, &sum)| self.likelihood(k).loss(sum));
        losses.sum::<f64>() + self.prior_loss(&here.point)
    }

    pub(crate) fn likelihood(&self, k: usize) -> Likelihood {
        let noise = self.data.noise[self.data.segments[k].run];
        Likelihood::new(self.count(k), noise, 2 * self.hypothesis.modes)
    }

    /// The fit that a place is, without what derivatives tell.
    pub(crate) fn fit_at(&self, here: Place) -> Fit {
        let mean_square = self.mean_squares(&here.sums);
        let by_sensor = self.by_sensor(&here.residual);
        Fit {
            trimmed: here.merit,
            misfit: self.misfit(&here),
            by_sensor,
            ..Fit::unfitted(here.point, mean_square)
        }
    }

    /// How many of so many segments count.
    pub(crate) fn kept_count(&self, segments: usize) -> usize {
        let left_out = match self.options.trims && self.options.robust && self.allowance == 1.0 {
            true => TRIMMED,
            false => 0.0,
        };
        (segments as f64 * (1.0 - left_out)).ceil() as usize
    }

    /// Which segments count: all but those that fit worst.
    pub(crate) fn kept(&self, sums: &[f64]) -> Vec<bool> {
        let losses: Vec<f64> = (0..sums.len()).map(|k| self.loss(k, sums[k])).collect();
        let mut order: Vec<usize> = (0..sums.len()).collect();
        order.sort_by(|&a, &b| losses[a].total_cmp(&losses[b]));
        let mut kept = vec![false; sums.len()];
        for &k in &order[..self.kept_count(sums.len())] {
            kept[k] = true;
        }
        kept
    }

    pub(crate) fn trimmed(&self, point: &Point, sums: &[f64]) -> f64 {
        let kept = self.kept(sums);
        let losses = (0..sums.len())
            .filter(|&k| kept[k])
            .map(|k| self.loss(k, sums[k]));
        self.prior_loss(point) + losses.sum::<f64>()
    }
}

/// Sum of the squares; infinite where the FMU gave up.
pub(crate) fn sum_of_squares(residual: &Option<Vec<f64>>) -> f64 {
    residual
        .as_ref()
        .map_or(f64::INFINITY, |r| r.iter().map(|v| v * v).sum())
}
