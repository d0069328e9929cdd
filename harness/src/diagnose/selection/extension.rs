//! What may hide beside a hypothesis that is adequate: every effect more, by a score test on all data; those that could
//! change the verdict are fitted.
//!
//! Beside an adequate hypothesis another effect can only be weak, so that the score test gives its gain in evidence to
//! first order ([`score_test`]), at the price of a few Jacobians where a fit takes twenty. It also gives
//! the standard deviation of the strength, and with it how strong the effect may be without being seen.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::{FittedHypothesis, MOST_OVER_EXPECTED};
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::initialisation::multistart::continued;
use crate::diagnose::initialisation::score_test::{At, Lead, Promise, follow, look};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::periodic::periodic;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::variants::{all_variants, library};
use crate::diagnose::selection::decision::{log_prior, share_starts};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::further_fits::{RETRY, refitting};
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::selection::tested::Tested;
use crate::diagnose::thresholds::{CLAIMED, TIE};
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;

/// Extensions that are fitted before it is asked which others could still matter: one for each of two processors.
const BATCH: usize = 2;
/// Effects beside a leader that is not adequate that are fitted, those that promise most: two for each of two processors. Periodic ones
/// come on top.
const FITTED: usize = 4;

/// What a score test of all effects beside one hypothesis found.
pub(crate) struct Extensions {
    /// Effects that can't change the verdict, with what is expected of them or what a fit found of them.
    pub tested: Vec<Tested>,
    /// Those that could change the verdict, fitted.
    pub fitted: Vec<FittedModel>,
    /// Effects that the score test does not speak of.
    pub untested: Vec<Vec<Choice>>,
}

/// Every effect more beside one hypothesis, with what a score test on the segments compared finds of it.
pub(crate) struct Beside {
    /// The effects of that hypothesis.
    pub leader: Vec<Choice>,
    /// It with one effect more, each with what the test found; `None` where it does not speak of it.
    leads: Vec<(Vec<Choice>, Option<Lead>)>,
}

impl Beside {
    /// The tests beside `leader`.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn new(screen: &Screen, leader: &FittedModel, watch: &dyn Watch) -> Result<Self, Error> {
        let jobs = one_more(screen.problem, &leader.choices);
        let leads = screen.leads(&jobs, leader, watch)?;
        Ok(Self {
            leader: leader.choices.clone(),
            leads: jobs.into_iter().zip(leads).collect(),
        })
    }

    /// Those that the test promises a claim of, and what it promises.
    pub fn visible(&self, problem: &Problem) -> Vec<(&Vec<Choice>, &Promise)> {
        let least = price(problem, self.leader.len()) + CLAIMED.ln();
        let all = self.leads.iter();
        let all = all.filter_map(|(c, lead)| Some((c, lead.as_ref()?.promise.as_ref()?)));
        all.filter(|(_, promise)| promise.gain > least).collect()
    }
}

/// Tests every effect beside `leader` on all segments of the runs fitted, where `beside` points, and fits those that could change the
/// verdict to their end. `None` where the leader proves inadequate on all of them.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn extend(
    screen: &Screen,
    leader: &mut FittedModel,
    beside: Beside,
) -> Result<Option<Extensions>, Error> {
    let problem = screen.problem;
    let price = price(problem, leader.choices.len());
    let mut out = Extensions {
        tested: Vec::new(),
        fitted: Vec::new(),
        untested: Vec::new(),
    };
    if !full_refit::stands(problem, leader)? {
        return Ok(None);
    }
    let on_all = leader.full_refit.as_ref().expect("fitted to all by now");
    let segments = problem.copies(&problem.fit_segments(1));
    let at = At::new(problem, &segments, on_all)?;
    let promises = parallel(&beside.leads, |(choices, lead)| match lead {
        Some(lead) => follow(problem, choices, lead, &at),
        None => Ok(None),
    })?;
    let mut promising: Vec<(Vec<Choice>, Promise)> = Vec::new();
    for ((choices, _), promise) in beside.leads.into_iter().zip(promises) {
        match promise {
            None => out.untested.push(choices),
            Some(p) if p.gain > price - TIE => promising.push((choices, p)),
            Some(p) => out.tested.push(tested(choices, &p, price)),
        }
    }
    promising.sort_by(|(_, a), (_, b)| b.gain.total_cmp(&a.gain));
    let base = on_all.fit.log_evidence;
    // Beside values along the belt a pair that fares badly from here may be found from its other effect.
    let least_gain = match leader.is_local() {
        true => f64::NEG_INFINITY,
        false => price - TIE,
    };
    let options = FitOptions {
        least_evidence: base + least_gain,
        ..full_refit::last_options()
    };
    for batch in promising.chunks(BATCH) {
        let on_all = out.fitted.iter().filter_map(|m| m.full_refit.as_ref());
        let best = on_all
            .map(|f| f.fit.log_evidence - base)
            .fold(0.0, f64::max);
        let open: Vec<&(Vec<Choice>, Promise)> = batch
            .iter()
            .filter(|(_, p)| MOST_OVER_EXPECTED * p.gain >= best)
            .collect();
        let found = parallel(&open, |(choices, p)| {
            let h = problem.hypothesis(&p.choices(choices))?;
            let on_all = continued(problem, h, &segments, p.start.clone(), options)?;
            let gain = on_all.fit.log_evidence - base;
            let model = match gain > least_gain {
                true => Some(seen(screen, &segments, on_all)?),
                false => None,
            };
            Ok((gain, model))
        })?;
        for ((choices, p), (gain, model)) in open.into_iter().zip(found) {
            match model {
                Some(model) => out.fitted.push(model),
                None => out.tested.push(Tested {
                    gain,
                    log_odds: gain - price,
                    ..tested(p.choices(choices), p, price)
                }),
            }
        }
    }
    let mut models: Vec<&mut FittedModel> = out.fitted.iter_mut().collect();
    let places: Vec<usize> = (0..models.len()).collect();
    share_starts(problem, &mut models, &places, &places)?;
    Ok(Some(out))
}

/// Price in nats of an effect more than so many, beyond that of its constants.
pub(crate) fn price(problem: &Problem, effects: usize) -> f64 {
    log_prior(problem, effects) - log_prior(problem, effects + 1)
}

/// A hypothesis with each effect of the catalogue and the library that it lacks.
pub(crate) fn one_more(problem: &Problem, choices: &[Choice]) -> Vec<Vec<Choice>> {
    let all = all_variants(problem).into_iter().chain(library(problem));
    all.filter(|more| choices.iter().all(|c| c.effect != more.effect))
        .map(|more| choices.iter().cloned().chain([more]).collect())
        .collect()
}

/// A leader with one effect more, for those that a score test finds worth their price, the most promising ones. Of effects with a
/// frequency of their own only the first and what ties with it: to first order they all promise what the residual has of lines,
/// whatever makes these, and would leave no room for others.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn one_further(
    screen: &Screen,
    leader: &FittedModel,
    iterations: usize,
    watch: &dyn Watch,
) -> Result<Vec<FittedModel>, Error> {
    let problem = screen.problem;
    let jobs = one_more(problem, &leader.choices);
    let promising = worth_their_price(screen, jobs, leader, watch)?;
    let is_periodic = |choices: &[Choice]| {
        let new = choices.last().expect("one effect more");
        periodic(&problem.catalogue[new.effect]).is_some()
    };
    let (mut lines, mut promising): (Vec<_>, Vec<_>) =
        promising.into_iter().partition(|(c, _)| is_periodic(c));
    promising.truncate(FITTED);
    let most = lines.first().map_or(0.0, |(_, p)| p.gain);
    lines.retain(|(_, p)| p.gain > most - TIE);
    lines.truncate(FITTED);
    promising.extend(lines);
    fitted_as_promised(screen, &promising, iterations)
}

/// Those of `jobs`, each `base` with one effect more, that a score test finds worth their price, with what it promises, best first.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn worth_their_price(
    screen: &Screen,
    jobs: Vec<Vec<Choice>>,
    base: &FittedModel,
    watch: &dyn Watch,
) -> Result<Vec<(Vec<Choice>, Promise)>, Error> {
    let price = price(screen.problem, base.choices.len());
    let all = screen.by_promise(jobs, base, watch)?.into_iter();
    let all = all.filter_map(|(choices, promise)| Some((choices, promise?)));
    Ok(all.filter(|(_, promise)| promise.gain > price).collect())
}

/// Hypotheses, each fitted from where its score test expects it, then further for so many steps.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn fitted_as_promised(
    screen: &Screen,
    promised: &[(Vec<Choice>, Promise)],
    steps: usize,
) -> Result<Vec<FittedModel>, Error> {
    parallel(promised, |(choices, promise)| {
        let there = screen.fitted_from(&promise.choices(choices), promise.start.clone())?;
        screen.further(&there, steps)
    })
}

fn tested(choices: Vec<Choice>, promise: &Promise, price: f64) -> Tested {
    // A strength of z standard deviations gains z^2/2 but for the price of the constant, and must be worth the claim.
    let needed = |occam: f64| (2.0 * (occam + price + CLAIMED.ln())).sqrt();
    Tested {
        choices,
        gain: promise.gain,
        fall: promise.fall,
        log_odds: promise.gain - price,
        detection_limit: promise.strength.map(|s| s.std * needed(s.occam)),
    }
}

/// A hypothesis fitted to all `segments` of the runs fitted, also on those of the screen.
fn seen(
    screen: &Screen,
    segments: &[Segment],
    on_all: FittedHypothesis,
) -> Result<FittedModel, Error> {
    let problem = screen.problem;
    let all = problem.fit_segments(1);
    let on_all = full_refit::with_lost_runs(problem, on_all, &all, segments)?;
    let on_screen = full_refit::restricted(&on_all.fit.point, &all, &screen.indices);
    let choices = &on_all.hypothesis.choices;
    let mut model = screen.continued(choices, on_screen, refitting(RETRY))?;
    full_refit::put(problem, &mut model, segments, on_all)?;
    Ok(model)
}

/// Largest gain in evidence by an effect more than `base` on these segments, to which it was fitted, nats: the same test and the
/// same fits as of the data measured. Zero where no effect promises to be worth its price.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn largest_gain(
    problem: &Problem,
    segments: &[Segment],
    base: &FittedHypothesis,
) -> Result<f64, Error> {
    let jobs = one_more(problem, &base.hypothesis.choices);
    let price = price(problem, base.hypothesis.choices.len());
    let at = At::new(problem, segments, base)?;
    let gains = parallel(&jobs, |choices| {
        let lead = look(problem, choices, &at)?;
        let Some(p) = lead.and_then(|lead| lead.promise) else {
            return Ok(0.0);
        };
        if p.gain < price - TIE {
            return Ok(0.0);
        }
        let h = problem.hypothesis(&p.choices(choices))?;
        let options = FitOptions {
            least_evidence: base.fit.log_evidence,
            ..full_refit::last_options()
        };
        let fitted = continued(problem, h, segments, p.start, options)?;
        Ok(fitted.fit.log_evidence - base.fit.log_evidence)
    })?;
    Ok(gains.into_iter().fold(0.0, f64::max))
}
