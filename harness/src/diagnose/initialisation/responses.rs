//! A model on short windows and what all effects change there: the regression on sets of effects ([`super::subset_regression`]), and where
//! it points.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::nesting::widen;
use crate::diagnose::estimation::sensitivities::Linear;
use crate::diagnose::initialisation::effect_response::{Response, move_own, responses_of};
use crate::diagnose::initialisation::score_test::{At, one_step};
use crate::diagnose::initialisation::subset_regression::{
    Belief, Effect, Explained, Regression, Window,
};
use crate::diagnose::model::hypothesis::{Choice, Hypothesis};
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::error::Error;
use crate::parallel::parallel;
use nalgebra::{DMatrix, DVector};

/// A model on short windows, and all that effects change there.
pub(crate) struct Responses<'a> {
    problem: &'a Problem<'a>,
    segments: &'a [Segment],
    base: &'a FittedHypothesis,
    regression: Regression,
    /// Of all effects, in their shapes.
    pub all: Vec<Response>,
}

impl<'a> Responses<'a> {
    /// What each of `list` changes beside `base` on `segments`, to which that was fitted; `is_first` tells which of them no other leads up
    /// to.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn new(
        problem: &'a Problem<'a>,
        segments: &'a [Segment],
        base: &'a FittedHypothesis,
        list: &[Choice],
        is_first: impl Fn(usize) -> bool,
    ) -> Result<Self, Error> {
        let at = At::new(problem, segments, base)?;
        let h = &base.hypothesis;
        let regression = {
            let data = problem.data(segments);
            let mut predictor = problem.predictor(h)?;
            let fitter = Fitter::new(&mut predictor, h, &data, one_step());
            let windows = at.linear().iter().enumerate();
            let windows = windows.map(|(k, linear)| Window {
                residual: DVector::from_vec(
                    linear.as_ref().map_or(Vec::new(), |l| l.residual.clone()),
                ),
                states: linear
                    .as_ref()
                    .map_or(DMatrix::zeros(0, 0), |l| l.states.clone()),
                nuisances: of_runs(h, segments[k].run, linear.as_ref()),
                likelihood: fitter.likelihood(k),
                is_first: is_first(k),
            });
            Regression::new(windows.collect(), beliefs(base))
        };
        let made = parallel(list, |choice| responses_of(problem, choice, &at))?;
        let beside_states = |mut response: Response| {
            response.effect = regression.beside_states(response.effect);
            response
        };
        let all = made.into_iter().flatten().map(beside_states).collect();
        Ok(Self {
            problem,
            segments,
            base,
            regression,
            all,
        })
    }

    /// How well the responses at these places explain together what the model leaves.
    pub fn explained_by(&self, set: &[usize]) -> Option<Explained> {
        let set: Vec<&Effect> = set.iter().map(|&i| &self.all[i].effect).collect();
        self.regression.explained_by(&set)
    }

    /// The model with the effects of such a set, in the place of the one that is `removed`, and the point where it explains that best.
    ///
    /// # Errors
    /// Effects that the FMU does not have.
    pub fn start(
        &self,
        set: &[usize],
        explained: &Explained,
        removed: Option<usize>,
    ) -> Result<(Vec<Choice>, Point), Error> {
        let responses: Vec<&Response> = set.iter().map(|&i| &self.all[i]).collect();
        let added = responses.iter().map(|r| &r.choice);
        let known = &self.base.hypothesis;
        let kept = known.choices.iter().filter(|c| Some(c.effect) != removed);
        let choices: Vec<Choice> = kept.chain(added).cloned().collect();
        let h = self.problem.hypothesis(&choices)?;
        let mut point = widen(self.base, &h, &Point::centre(&h, self.segments));
        let mut changes = explained.nuisances.iter();
        for (parameter, change) in known.shared.iter().zip(changes.by_ref()) {
            if let Some(i) = h.shared_index(&parameter.name) {
                point.shared[i] = h.shared[i].clamp(point.shared[i] + change);
            }
        }
        for (run, parameters) in known.per_run.iter().enumerate() {
            for (parameter, change) in parameters.iter().zip(changes.by_ref()) {
                move_own(&h, &mut point, run, &parameter.name, |u| u + change);
            }
        }
        for (response, coefficients) in responses.iter().zip(&explained.effects) {
            response.put(&h, &mut point, coefficients);
        }
        Ok((choices, point))
    }
}

/// Beliefs in all parameters, shared ones first, then each run's own.
fn beliefs(base: &FittedHypothesis) -> Vec<Belief> {
    let (h, point) = (&base.hypothesis, &base.fit.point);
    let own = h
        .per_run
        .iter()
        .flatten()
        .zip(point.per_run.iter().flatten());
    let all = h.shared.iter().zip(&point.shared).chain(own);
    let belief = |(p, u): (&Parameter, &f64)| Belief {
        std: p.prior_std,
        offset: match p.prior_std > 0.0 {
            true => u - p.position(p.prior),
            false => 0.0,
        },
    };
    all.map(belief).collect()
}

/// Derivatives of a window of one run by all parameters in that order.
fn of_runs(h: &Hypothesis, run: usize, linear: Option<&Linear>) -> DMatrix<f64> {
    let own: usize = h.per_run.iter().map(Vec::len).sum();
    let shared = h.shared.len();
    let Some(linear) = linear else {
        return DMatrix::zeros(0, shared + own);
    };
    let mut all = DMatrix::zeros(linear.residual.len(), shared + own);
    let first = shared + h.per_run[..run].iter().map(Vec::len).sum::<usize>();
    for (c, column) in linear.parameters.column_iter().enumerate() {
        let place = if c < shared { c } else { first + c - shared };
        all.set_column(place, &column);
    }
    all
}
