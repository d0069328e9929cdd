//! The fit of one hypothesis from several starts, so that a poor local minimum is not taken for a verdict.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::{Fit, FittedHypothesis};
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::estimation::fitter::Fitter;
use crate::diagnose::estimation::nesting::widen;
use crate::diagnose::initialisation::first_fits::{FirstFits, keep_better};
use crate::diagnose::initialisation::search_options::{
    BRIEF, CLIMB, FIRST_FIT, FIRST_FIT_SHARE, STRONG_PRIOR, SearchOptions,
};
use crate::diagnose::initialisation::starts::starts;
use crate::diagnose::model::hypothesis::{Choice, Hypothesis, NEARLY_OFF};
use crate::diagnose::model::point::Point;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::unknown_function::latent_name;
use crate::diagnose::thresholds::FLOOR_MEDIAN;
use crate::error::Error;
use serde::{Deserialize, Serialize};

/// Median error over the noise above which a first look is not followed where the model without the effect is down to the
/// noise.
const FAR: f64 = 3.0;

/// Jacobians for the reference model by itself: everything else starts from it, ...
const CALIBRATION: usize = 40;
/// ... and iterations in a row without a gain after which it ends, so that differences were taken to both sides: where some met a
/// transition, calibrations of fresh campaigns stood at up to three times the objective that they reach so.
const CALIBRATION_PATIENCE: usize = 3;

/// The options of a calibration: what others start from has to stand in its valley.
pub(crate) fn calibrating() -> FitOptions {
    FitOptions {
        patience: CALIBRATION_PATIENCE,
        ..FitOptions::search(CALIBRATION)
    }
}

/// The fit of a smaller hypothesis as a point of a larger one, with the effects that it lacks as nearly off
/// as their parameters allow.
fn switched_off(
    problem: &Problem,
    h: &Hypothesis,
    base: &FittedHypothesis,
    segments: &[Segment],
) -> Point {
    let mut point = widen(base, h, &Point::centre(h, segments));
    for choice in h
        .choices
        .iter()
        .filter(|c| !base.hypothesis.choices.contains(c))
    {
        let effect = &problem.catalogue[choice.effect];
        if let Some(p) = effect.switch().map(|i| &effect.parameters[i])
            && let Some(i) = h.shared_index(&format!("{}.{}", effect.id, p.name))
        {
            // Quite off it has no derivatives.
            point.shared[i] = h.shared[i].clamp(h.shared[i].position(NEARLY_OFF * p.typical));
        }
        if let Some(i) = h.shared_index(&latent_name(&effect.id, 0)) {
            point.shared[i] = NEARLY_OFF;
        }
    }
    point
}

/// Fits a hypothesis from the fit of a smaller one with the effects that this lacks switched off.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn from_nested(
    problem: &Problem,
    choices: &[Choice],
    segments: &[Segment],
    base: &FittedHypothesis,
) -> Result<FittedHypothesis, Error> {
    let hypothesis = problem.hypothesis(choices)?;
    let data = problem.data(segments);
    let off = switched_off(problem, &hypothesis, base, segments);
    let as_compared = FitOptions {
        robust: false,
        ..FitOptions::search(BRIEF.first_fit)
    };
    let question = ("run", choices, segments, data.noise, &off, as_compared);
    let fit = problem.finished.recall(&question, || {
        let mut predictor = problem.predictor(&hypothesis)?;
        Ok(Fitter::new(&mut predictor, &hypothesis, &data, as_compared).run(off.clone()))
    })?;
    Ok(FittedHypothesis { hypothesis, fit })
}

/// The point of a fit with the start states of other fits to the same segments, if `carried` also those that the segment before leads to,
/// where these bring a segment nearer to the measurement, each fitted first; `None` where none does.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn better_starts(
    problem: &Problem,
    segments: &[Segment],
    fitted: &FittedHypothesis,
    others: &[&FittedHypothesis],
    options: FitOptions,
    carried: bool,
) -> Result<Option<Point>, Error> {
    let h = &fitted.hypothesis;
    let data = problem.data(segments);
    let of_others = others.iter().map(|o| (&o.hypothesis.choices, &o.fit));
    let of_others: Vec<_> = of_others.collect();
    let mine = (&h.choices, &fitted.fit);
    let question = (
        "starts", segments, data.noise, mine, of_others, options, carried,
    );
    problem.finished.recall(&question, || {
        let mut predictor = problem.predictor(h)?;
        let mut fitter = Fitter::new(&mut predictor, h, &data, options);
        let mut point = fitted.fit.point.clone();
        let mut any = false;
        for k in 0..segments.len() {
            for other in others {
                if fitter.is_met_better(k, &other.fit, &fitted.fit) {
                    let theirs = widen(other, h, &point).start(k);
                    any |= fitter.try_start(k, &mut point, theirs);
                }
            }
        }
        if carried {
            any |= fitter.try_carried_on(&mut point);
        }
        Ok(any.then_some(point))
    })
}

/// Fits a hypothesis further from `start`, which a fit to the same segments has reached.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn continued(
    problem: &Problem,
    hypothesis: Hypothesis,
    segments: &[Segment],
    start: Point,
    options: FitOptions,
) -> Result<FittedHypothesis, Error> {
    let all = (hypothesis, segments, options);
    recalled(problem, "continued", all, start, |fitter, start| {
        fitter.run(start)
    })
}

/// Fits a hypothesis from `start`: its start states first, then all.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn settled(
    problem: &Problem,
    hypothesis: Hypothesis,
    segments: &[Segment],
    start: Point,
    options: FitOptions,
) -> Result<FittedHypothesis, Error> {
    let all = (hypothesis, segments, options);
    recalled(problem, "settled", all, start, |fitter, start| {
        let settled = fitter.fit_initial_states(start);
        fitter.run(settled.point)
    })
}

/// A fit of this name from `start`, or the one that was finished before.
fn recalled(
    problem: &Problem,
    name: &str,
    (hypothesis, segments, options): (Hypothesis, &[Segment], FitOptions),
    start: Point,
    fit: impl Fn(&mut Fitter, Point) -> Fit,
) -> Result<FittedHypothesis, Error> {
    let data = problem.data(segments);
    let own = hypothesis.per_run.iter().flatten();
    let beliefs = hypothesis.shared.iter().chain(own);
    let beliefs: Vec<(f64, f64)> = beliefs.map(|p| (p.prior, p.prior_std)).collect();
    let of = (&hypothesis.choices, beliefs);
    let question = (name, of, segments, data.noise, &start, options);
    let fit = problem.finished.recall(&question, || {
        let mut predictor = problem.predictor(&hypothesis)?;
        let mut fitter = Fitter::new(&mut predictor, &hypothesis, &data, options);
        Ok(fit(&mut fitter, start.clone()))
    })?;
    Ok(FittedHypothesis { hypothesis, fit })
}

/// First looks at a hypothesis from all the starts that a search takes.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct FirstLooks {
    /// The best of those that were about to arrive at the noise, and were followed at once.
    pub followed: Option<Fit>,
    /// The others, best first.
    pub seen: Vec<Fit>,
}

impl FirstLooks {
    /// All of them, best first.
    pub fn best_first(&self) -> Vec<&Fit> {
        let mut all: Vec<&Fit> = self.followed.iter().chain(&self.seen).collect();
        all.sort_by(|a, b| a.trimmed.total_cmp(&b.trimmed));
        all
    }
}

/// Looks at the reference model with `known` effects and the last of `choices` newly added.
///
/// `base` is the fit without the new effect, on the same segments; the search starts from it with the effect
/// nearly off, and from the priors with the effect at practical strengths.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn first_looks(
    problem: &Problem,
    choices: &[Choice],
    segments: &[Segment],
    base: &FittedHypothesis,
    search: SearchOptions,
) -> Result<FirstLooks, Error> {
    let hypothesis = problem.hypothesis(choices)?;
    let data = problem.data(segments);
    let search = search.beside(&base.fit, &data);
    let from = (&base.hypothesis.choices, &base.fit);
    let question = ("look", choices, segments, data.noise, from, search);
    problem.finished.recall(&question, || {
        let new = hypothesis.new_effect();
        let mut predictor = problem.predictor(&hypothesis)?;
        let starts = starts(
            problem,
            &hypothesis,
            new,
            base,
            &data,
            &mut predictor,
            search,
        );
        let mut first_fits = FirstFits::new(&hypothesis, &data, search);
        let seen = first_fits.of(&mut predictor, starts);
        Ok(FirstLooks {
            followed: first_fits.best,
            seen,
        })
    })
}

/// Fits a hypothesis of which the first looks are known: the best of them followed to their end, unless one has arrived.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn followed(
    problem: &Problem,
    choices: &[Choice],
    segments: &[Segment],
    base: &FittedHypothesis,
    search: SearchOptions,
    looks: &FirstLooks,
) -> Result<FittedHypothesis, Error> {
    let hypothesis = problem.hypothesis(choices)?;
    let data = problem.data(segments);
    let search = search.beside(&base.fit, &data);
    let from = (&base.hypothesis.choices, &base.fit);
    let question = ("search", choices, segments, data.noise, from, search);
    let fit = problem.finished.recall(&question, || {
        best_of_looks(problem, &hypothesis, segments, base, search, looks)
    })?;
    Ok(FittedHypothesis { hypothesis, fit })
}

/// A hypothesis of which the first looks are known, where it stands after the best of them, or without its new effect if that is
/// better.
///
/// # Errors
/// An FMU that can't be instantiated.
pub(crate) fn passed_over(
    problem: &Problem,
    choices: &[Choice],
    segments: &[Segment],
    base: &FittedHypothesis,
    looks: &FirstLooks,
) -> Result<FittedHypothesis, Error> {
    let hypothesis = problem.hypothesis(choices)?;
    let data = problem.data(segments);
    let mut predictor = problem.predictor(&hypothesis)?;
    let mut fitter = Fitter::new(&mut predictor, &hypothesis, &data, FitOptions::search(0));
    let can_be_off = problem.catalogue[hypothesis.new_effect()]
        .switch()
        .is_some();
    let mut best = looks.followed.clone();
    if let Some(seen) = looks.seen.first() {
        keep_better(&mut best, fitter.run(seen.point.clone()));
    }
    if can_be_off || best.is_none() {
        let off = switched_off(problem, &hypothesis, base, segments);
        keep_better(&mut best, fitter.run(off));
    }
    let fit = best.expect("a look or none");
    Ok(FittedHypothesis { hypothesis, fit })
}

/// [`first_looks`], the best [`followed`].
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn search(
    problem: &Problem,
    choices: &[Choice],
    segments: &[Segment],
    base: &FittedHypothesis,
    search: SearchOptions,
) -> Result<FittedHypothesis, Error> {
    let looks = first_looks(problem, choices, segments, base, search)?;
    followed(problem, choices, segments, base, search, &looks)
}

/// The best fit of a hypothesis of which the first looks are known.
fn best_of_looks(
    problem: &Problem,
    hypothesis: &Hypothesis,
    segments: &[Segment],
    base: &FittedHypothesis,
    search: SearchOptions,
    looks: &FirstLooks,
) -> Result<Fit, Error> {
    let new = hypothesis.new_effect();
    let data = problem.data(segments);
    let mut predictor = problem.predictor(hypothesis)?;
    let mut first_fits = FirstFits::new(hypothesis, &data, search);
    first_fits.best.clone_from(&looks.followed);
    let found = &looks.seen;
    // Beside a model that is down to the noise without it an effect can only be weak.
    let is_new = !base.hypothesis.choices.iter().any(|c| c.effect == new);
    let is_weak = is_new && base.fit.error_quantile(&data, 0.5) <= FLOOR_MEDIAN;
    let is_hopeless = |first_fit: &Fit| is_weak && first_fit.error_quantile(&data, 0.5) > FAR;
    // The objective without the effect, as looks at it are judged.
    let without = match search.trims {
        true => base.fit.trimmed,
        false => {
            let (h, as_judged) = (&base.hypothesis, search.following(0));
            let mut predictor = problem.predictor(h)?;
            let mut fitter = Fitter::new(&mut predictor, h, &data, as_judged);
            fitter.run(base.fit.point.clone()).trimmed
        }
    };
    if !first_fits.has_arrived() {
        let open = found.iter().filter(|first_fit| !is_hopeless(first_fit));
        for first_fit in open.take(search.followed) {
            first_fits.follow(&mut predictor, first_fit.point.clone(), without);
            if !search.trims && first_fits.has_arrived() {
                break;
            }
        }
    }
    let mut best = first_fits.best;
    let can_be_off = problem.catalogue[new].switch().is_some();
    if let (None, Some(first_fit), false) = (&best, found.first(), can_be_off) {
        // As it stands: there is nothing to return to, and the model without it explains the data.
        let mut fitter = Fitter::new(&mut predictor, hypothesis, &data, FitOptions::search(0));
        let fit = fitter.run(first_fit.point.clone());
        return Ok(fit);
    }
    // Never worse than without the effect.
    if best.as_ref().is_none_or(|b| b.trimmed > without) {
        let off = switched_off(problem, hypothesis, base, segments);
        let fit = Fitter::new(
            &mut predictor,
            hypothesis,
            &data,
            search.following(search.first_fit),
        )
        .run(off);
        keep_better(&mut best, fit);
    }
    Ok(best.expect("there is at least one start"))
}

/// The fit of the reference model itself, held to what is believed of it in the first look and, by `belief`, after.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn baseline(
    problem: &Problem,
    segments: &[Segment],
    belief: f64,
) -> Result<FittedHypothesis, Error> {
    let hypothesis = problem.hypothesis(&[])?;
    let data = problem.data(segments);
    let start = Point::centre(&hypothesis, segments);
    let first_fit = FitOptions {
        share: FIRST_FIT_SHARE,
        reinitialise: false,
        belief: STRONG_PRIOR,
        ..FitOptions::search(FIRST_FIT)
    };
    // Where the break-aways tell of the place, friction scatters: no fit comes near the noise, and one that goes on follows the
    // scatter of the runs fitted.
    let climb = match problem.place_is_told() {
        true => FitOptions::search(CLIMB),
        false => calibrating(),
    };
    let climb = FitOptions { belief, ..climb };
    let question = ("baseline", segments, data.noise, &start, first_fit, climb);
    let fit = problem.finished.recall(&question, || {
        let mut predictor = problem.predictor(&hypothesis)?;
        let seen = Fitter::new(&mut predictor, &hypothesis, &data, first_fit).run(start.clone());
        let mut fitter = Fitter::new(&mut predictor, &hypothesis, &data, climb);
        let settled = fitter.fit_initial_states(seen.point);
        Ok(fitter.run(settled.point))
    })?;
    Ok(FittedHypothesis { hypothesis, fit })
}
