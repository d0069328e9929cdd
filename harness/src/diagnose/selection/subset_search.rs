//! Sets of effects, one of the library or two of the catalogue, where the race of single ones brought no answer.
//!
//! Over a whole segment a model that lacks two effects meets transitions at wrong times, and a fit of one of them ends in a wrong
//! valley. Over a short window the same model errs by its forces alone, and these add up: a regression on all effects at once
//! ([`crate::diagnose::initialisation::subset_regression`]) ranks all of them in the time of a few fits, and tells where to fit
//! each from. Those that explain most are fitted on the windows, fewer and fewer of them further (successive halving); the effects of the
//! best pair are exchanged ([`super::replacement`]), and the best of all are fitted on windows twice as long and on the segments.
//! Source of successive halving: Jamieson and Talwalkar, Proc. AISTATS 2016, sect. 3.

use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::initialisation::multistart::calibrating;
use crate::diagnose::initialisation::responses::Responses;
use crate::diagnose::initialisation::search_options::STRONG_PRIOR;
use crate::diagnose::initialisation::subset_regression::Explained;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::point::Point;
use crate::diagnose::selection::fitted_model::{FittedModel, effects_of, name};
use crate::diagnose::selection::further_fits::{POLISH, refitting};
use crate::diagnose::selection::screening::Screen;
use crate::diagnose::selection::windows::Windows;
use crate::diagnose::thresholds::{CLOSE, TIE};
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Shapes of each effect of which pairs are formed, those that explain most alone.
const SHAPES: usize = 5;
/// Pairs that are fitted on the shortest windows, of those that explain most to first order beside the reference model, ...
const FOLLOWED: usize = 12;
/// ... and at least so many without values along the belt: pairs with such values take up to seven of twelve places where none is hidden.
const WITHOUT_VALUES: usize = 8;
/// Effects of the library that are fitted on the windows, each alone: at least so many of those that explain most, and up to
/// [`FOLLOWED`] of those that explain more than the last pair that is followed, or more than a rival.
const ALONE: usize = 4;
/// Jacobians for a first fit of all of them: the first steps from where the regression points bring most, ...
pub(super) const FIRST: usize = 3;
/// ... and for those that are fitted further: a pair that is there comes to the noise within both.
pub(super) const SECOND: usize = 3;
/// Hypotheses that are fitted further on the shortest windows, ...
const FURTHER: usize = 8;
/// ... to their end there: after so few steps effects with states of their own lead (a constant force on a sliding drive is fifth and in
/// the end first), ...
const ENDED: usize = 6;
/// ... on windows twice as long, and on whole segments, with what ties with the last of them.
const WHOLE: usize = 2;

/// What a search among sets of effects has found.
pub(crate) struct Searched {
    /// The best single effects and pairs on whole segments, best first.
    pub models: Vec<FittedModel>,
    /// Pairs that were compared to first order alone, the one that explains most first.
    pub untried: Vec<Vec<Choice>>,
}

/// A set of responses, and how well it explains what the model leaves.
type Ranked = (Vec<usize>, Explained);

/// A hypothesis and a point to fit it from.
pub(super) type Start = (Vec<Choice>, Point);

/// The shortest windows, and effects that may be added there.
pub(super) struct Search<'a, 'b> {
    pub windows: Windows<'a>,
    /// Effects of which pairs are formed.
    pub list: &'b [Choice],
    /// Effects of the library, each alone.
    library: &'b [Choice],
    pub watch: &'b dyn Watch,
}

/// Where to fit from.
struct Starts {
    /// Sets of effects that explain most, and where to fit them from.
    starts: Vec<Start>,
    /// All pairs, the one that explains most first.
    pairs: Vec<Vec<Choice>>,
}

/// Pairs of the effects of `list` and single effects of `library`, the best fitted to its end on whole segments. `held` is the reference
/// model held to what is believed of it: calibrated, it has been bent in the place of what is missing. What can't come near `rival`, a
/// model that explains the segments, is given up on the way.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn search(
    screen: &Screen,
    held: &FittedModel,
    (list, library): (&[Choice], &[Choice]),
    rival: Option<&FittedModel>,
    watch: &dyn Watch,
) -> Result<Searched, Error> {
    let search = Search {
        windows: Windows::quarters(screen),
        list,
        library,
        watch,
    };
    watch.step("comparing effects and pairs to first order", 0, 1);
    let Starts {
        starts,
        pairs: ranked,
    } = search.starts(held, rival)?;
    let windows = &search.windows;
    let least = match rival {
        Some(rival) => windows.log_evidence(&search.on_windows(rival)?) - CLOSE,
        None => f64::NEG_INFINITY,
    };
    // What is not weighed is not given up.
    let comes_near = |model: &FittedModel, gain: f64| {
        let most = windows.log_evidence(model) + gain;
        !most.is_finite() || !least.is_finite() || most > least
    };
    let best = search.round(&starts, |(choices, start)| {
        search.fitted(choices, start, refitting(FIRST))
    })?;
    let mut best = windows.by_evidence(best);
    let mut tried: Vec<Vec<usize>> = best.iter().map(FittedModel::effects).collect();
    best.truncate(FURTHER);
    let best = search.round(&best, |model| {
        search.fitted(&model.choices, &model.fitted.fit.point, refitting(SECOND))
    })?;
    let mut best = search.with_replaced(windows.by_evidence(best))?;
    tried.extend(best.iter().map(FittedModel::effects));
    best.retain(|model| comes_near(model, model.most_gain()));
    best.truncate(ENDED);
    // By the objective of the search, which some windows that are lost for good do not bend.
    let ended = search.round(&best, |model| {
        let start = model.fitted.fit.point.clone();
        let ended = windows
            .screen
            .continued(&model.choices, start, calibrating())?;
        let is_better = windows.log_evidence(&ended) > windows.log_evidence(model);
        Ok(if is_better { ended } else { model.clone() })
    })?;
    let longer = Windows::halves(screen);
    let mut best = windows.by_evidence(ended);
    // Windows that a fit to its end leaves unmet are taken to stay so.
    best.retain(|model| comes_near(model, model.most_gain() - model.lost));
    best.truncate(windows.count_with_ties(&best, WHOLE));
    let mut models = search.round(&best, |model| {
        let on_segments = windows.joined(&model.fitted.fit.point);
        let start = longer.divided(&model.fitted.hypothesis, &on_segments);
        let there = longer.screen.fitted(&model.choices, start, calibrating())?;
        let start = longer.joined(&there.fitted.fit.point);
        screen.fitted(&model.choices, start, refitting(POLISH))
    })?;
    screen.sort(&mut models);
    screen.finish(&mut models, watch)?;
    screen.sort(&mut models);
    // What a stop has kept from its end is not compared.
    let is_untried = |pair: &Vec<Choice>| watch.stop() || !tried.contains(&effects_of(pair));
    let untried = ranked.into_iter().filter(is_untried).collect();
    Ok(Searched { models, untried })
}

impl Windows<'_> {
    /// How many of models that stand best first are the best so many and what ties with the last of these.
    fn count_with_ties(&self, best: &[FittedModel], most: usize) -> usize {
        let evidence = |model: &FittedModel| self.log_evidence(model);
        let Some(least) = best.get(most - 1).map(evidence) else {
            return best.len();
        };
        best.iter()
            .take_while(|model| evidence(model) >= least - TIE)
            .count()
    }

    /// The best of those with the same effects, by their evidence: it counts the windows that are left unmet.
    pub(super) fn by_evidence(&self, mut all: Vec<FittedModel>) -> Vec<FittedModel> {
        all.sort_by(|a, b| self.log_evidence(b).total_cmp(&self.log_evidence(a)));
        distinct(all, FittedModel::effects)
    }
}

impl Search<'_, '_> {
    /// A fit on the shortest windows by their likelihood, none of them left out: the regression has pointed near most of them.
    pub(super) fn fitted(
        &self,
        choices: &[Choice],
        start: &Point,
        options: FitOptions,
    ) -> Result<FittedModel, Error> {
        let options = FitOptions {
            robust: false,
            ..options
        };
        self.windows
            .screen
            .continued(choices, start.clone(), options)
    }

    /// A model of the segments, fitted to the windows.
    fn on_windows(&self, model: &FittedModel) -> Result<FittedModel, Error> {
        let fitted = &model.fitted;
        let start = self.windows.divided(&fitted.hypothesis, &fitted.fit.point);
        self.fitted(&model.choices, &start, refitting(SECOND))
    }

    /// Fits of each of these, but for those that come after a stop.
    pub(super) fn round<T: Sync>(
        &self,
        all: &[T],
        fit: impl Fn(&T) -> Result<FittedModel, Error> + Sync,
    ) -> Result<Vec<FittedModel>, Error> {
        let done = AtomicUsize::new(0);
        let fitted = parallel(all, |one| {
            if self.watch.stop() {
                return Ok(None);
            }
            let fitted = fit(one)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            let name = name(self.windows.screen.problem, &fitted.choices);
            self.watch.step(&name, done, all.len());
            Ok(Some(fitted))
        })?;
        Ok(fitted.into_iter().flatten().collect())
    }

    /// Where to fit from: what explains most beside the reference model; and all pairs, the one that explains most first.
    fn starts(&self, held: &FittedModel, rival: Option<&FittedModel>) -> Result<Starts, Error> {
        let start = self
            .windows
            .divided(&held.fitted.hypothesis, &held.fitted.fit.point);
        let options = FitOptions {
            belief: STRONG_PRIOR,
            ..refitting(POLISH)
        };
        let held = self.windows.screen.continued(&[], start, options)?;
        let responses = self.responses(&held, self.list)?;
        let alone = self.alone(&responses)?;
        let ranked = self.pairs(&responses, &alone)?;
        let at = |(set, explained): &Ranked| responses.start(set, explained, None);
        // Values along the belt imitate much, with whatever effect beside them: others come on top, where these leave no room for them.
        let mut others = 0;
        let is_followed = |(place, (set, _)): &(usize, &Ranked)| {
            let is_local = set.iter().any(|&i| responses.all[i].has_many_values());
            others += usize::from(!is_local);
            *place < FOLLOWED || (!is_local && others <= WITHOUT_VALUES)
        };
        let followed = ranked.iter().enumerate().filter(is_followed);
        let followed: Vec<&Ranked> = followed.map(|(_, ranked)| ranked).collect();
        let starts = followed.iter().map(|ranked| at(ranked));
        let mut starts = starts.collect::<Result<Vec<Start>, Error>>()?;
        let library = self.responses(&held, self.library)?;
        let of_library = possible(self.alone(&library)?, &library);
        // One that explains less than every pair followed, or than the rival to first order likewise, is not fitted beyond the least number.
        let last = followed.last().filter(|_| followed.len() >= FOLLOWED);
        let least = match rival {
            Some(rival) => self.first_order(&held, &rival.choices)?,
            None => last.map_or(f64::INFINITY, |(_, pair)| pair.score),
        };
        let explaining = of_library.partition_point(|(_, explained)| explained.score < least);
        let most = explaining.clamp(ALONE, FOLLOWED);
        for (set, explained) in of_library.iter().take(most) {
            starts.push(library.start(set, explained, None)?);
        }
        let choice = |&i: &usize| responses.all[i].choice.clone();
        let pairs = ranked
            .iter()
            .map(|(set, _)| set.iter().map(choice).collect());
        Ok(Starts {
            starts,
            pairs: pairs.collect(),
        })
    }

    /// How well the best of these choices explains, alone and to first order.
    fn first_order(&self, base: &FittedModel, choices: &[Choice]) -> Result<f64, Error> {
        let alone = self.alone(&self.responses(base, choices)?)?;
        let best = alone.first().map(|(_, explained)| explained.score);
        Ok(best.unwrap_or(f64::INFINITY))
    }

    pub(super) fn responses<'s>(
        &'s self,
        base: &'s FittedModel,
        list: &[Choice],
    ) -> Result<Responses<'s>, Error> {
        let screen = &self.windows.screen;
        let is_first = |k: usize| self.windows.begins_segment(k);
        Responses::new(
            screen.problem,
            &screen.segments,
            &base.fitted,
            list,
            is_first,
        )
    }

    /// Sets of responses that the data determine, the one that explains most first.
    fn ranked(&self, responses: &Responses, sets: &[Vec<usize>]) -> Result<Vec<Ranked>, Error> {
        let found = parallel(sets, |set| match self.watch.stop() {
            true => Ok(None),
            false => Ok(responses.explained_by(set).map(|e| (set.clone(), e))),
        })?;
        let mut found: Vec<Ranked> = found.into_iter().flatten().collect();
        found.sort_by(|(_, a), (_, b)| a.score.total_cmp(&b.score));
        Ok(found)
    }

    /// Each response alone, also where it is pulled to where it can't be: beside another effect it may not.
    pub(super) fn alone(&self, responses: &Responses) -> Result<Vec<Ranked>, Error> {
        let sets: Vec<Vec<usize>> = (0..responses.all.len()).map(|i| vec![i]).collect();
        self.ranked(responses, &sets)
    }

    /// All pairs of effects, each in the shapes that explain most.
    fn pairs(&self, responses: &Responses, alone: &[Ranked]) -> Result<Vec<Ranked>, Error> {
        let effect = |i: usize| responses.all[i].choice.effect;
        let mut shapes: Vec<usize> = Vec::new();
        for (set, _) in alone {
            let known = shapes.iter().filter(|&&i| effect(i) == effect(set[0]));
            if known.count() < SHAPES {
                shapes.push(set[0]);
            }
        }
        let sets = shapes.iter().enumerate().flat_map(|(n, &i)| {
            let others = shapes[n + 1..].iter();
            let others = others.filter(move |&&j| effect(i) != effect(j));
            others.map(move |&j| vec![i, j])
        });
        let ranked = self.ranked(responses, &sets.collect::<Vec<_>>())?;
        Ok(possible(ranked, responses))
    }
}

/// The best set of those with the same effects that are pulled to nowhere where they can't be.
pub(super) fn possible(mut ranked: Vec<Ranked>, responses: &Responses) -> Vec<Ranked> {
    ranked.retain(|(_, explained)| explained.is_possible);
    distinct(ranked, |(set, _)| {
        effects_of(set.iter().map(|&i| &responses.all[i].choice))
    })
}

/// The first of those that have the same effects.
fn distinct<T>(mut all: Vec<T>, effects: impl Fn(&T) -> Vec<usize>) -> Vec<T> {
    let mut seen: Vec<Vec<usize>> = Vec::new();
    all.retain(|one| {
        let effects = effects(one);
        let is_new = !seen.contains(&effects);
        seen.push(effects);
        is_new
    });
    all
}
