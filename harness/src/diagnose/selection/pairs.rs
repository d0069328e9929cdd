//! Pairs of effects of which neither alone explains the data.
//!
//! Over a whole segment a model that lacks two effects meets transitions at wrong times, and a fit of one of them ends in a wrong
//! valley. Over a short window the same model errs by its forces alone, and these add up: a regression on all effects at once
//! ([`crate::diagnose::initialisation::subset_regression`]) ranks all pairs of them in the time of a few fits, and tells where to fit
//! each from. Those that explain most are fitted on the windows, the best of these on windows twice as long and on the segments.

use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::initialisation::multistart::calibrating;
use crate::diagnose::initialisation::responses::Responses;
use crate::diagnose::initialisation::search_options::STRONG_PRIOR;
use crate::diagnose::initialisation::subset_regression::Explained;
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::point::Point;
use crate::diagnose::selection::fitted_model::{FittedModel, effects_of, name};
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::screening::{POLISH, Screen, refitting};
use crate::diagnose::selection::windows::Windows;
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Shapes of each effect of which pairs are formed, those that explain most alone.
const SHAPES: usize = 5;
/// Pairs that are fitted on the shortest windows, of those that explain most to first order beside the reference model.
const FOLLOWED: usize = 12;
/// Single effects that explain most, which are fitted first and beside which the others are regressed again: one that is far from linear
/// hides the other.
const LEADERS: usize = 2;
/// Pairs that are fitted of those that explain most beside each of them.
const FOLLOWED_BESIDE: usize = 4;
/// Jacobians for that: a pair that is there comes to the noise from where the regression points within so many.
const FIRST: usize = 6;
/// Pairs that are fitted on windows twice as long, ...
const LONGER: usize = 4;
/// ... and on whole segments.
const WHOLE: usize = 3;

/// What a search among pairs has found.
pub(crate) struct Searched {
    /// The best pairs on whole segments, best first.
    pub pairs: Vec<FittedModel>,
    /// Those that were not, the one that explains most first.
    pub untried: Vec<Vec<Choice>>,
}

/// A set of responses, and how well it explains what the model leaves.
type Ranked = (Vec<usize>, Explained);

/// A hypothesis and a point to fit it from.
type Start = (Vec<Choice>, Point);

/// The shortest windows, and effects that may be added there.
struct Search<'a, 'b> {
    windows: Windows<'a>,
    list: &'b [Choice],
    watch: &'b dyn Watch,
}

/// Pairs of the effects of a list, the best fitted to its end on whole segments, best first. `held` is the reference model held to
/// what is believed of it: calibrated, it has been bent in the place of what is missing.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn search(
    screen: &Screen,
    held: &FittedModel,
    list: &[Choice],
    watch: &dyn Watch,
) -> Result<Searched, Error> {
    let search = Search {
        windows: Windows::quarters(screen),
        list,
        watch,
    };
    watch.step("comparing all pairs to first order", 0, 1);
    let (starts, ranked) = search.starts(held)?;
    let done = AtomicUsize::new(0);
    let fitted = parallel(&starts, |start| {
        if watch.stop() {
            return Ok(None);
        }
        let fitted = search.fitted(start, refitting(FIRST))?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        watch.step(&name(screen.problem, &start.0), done, starts.len());
        Ok(Some(fitted))
    })?;
    let mut best: Vec<FittedModel> = Vec::new();
    screen.keep_better(&mut best, fitted.into_iter().flatten().collect());
    // The same two effects, in either order.
    let mut best = distinct(best, FittedModel::effects);
    let fitted: Vec<Vec<usize>> = best.iter().map(FittedModel::effects).collect();
    let is_untried = |pair: &Vec<Choice>| !fitted.contains(&effects_of(pair));
    let untried = ranked.into_iter().filter(is_untried).collect();
    best.truncate(LONGER);
    let longer = Windows::halves(screen);
    let best = parallel(&best, |model| {
        if watch.stop() {
            return Ok(None);
        }
        let point = model.fitted.fit.point.clone();
        let shortest = &search.windows.screen;
        let there = shortest
            .continued(&model.choices, point, calibrating())?
            .fitted;
        let on_segments = search.windows.joined(&there.fit.point);
        let start = longer.divided(&there.hypothesis, &on_segments);
        let fitted = longer.screen.fitted(&model.choices, start, calibrating())?;
        Ok(Some(fitted))
    })?;
    let mut best: Vec<FittedModel> = best.into_iter().flatten().collect();
    screen.sort(&mut best);
    best.truncate(WHOLE);
    let mut pairs = parallel(&best, |model| {
        let start = longer.joined(&model.fitted.fit.point);
        screen.fitted(&model.choices, start, refitting(POLISH))
    })?;
    screen.sort(&mut pairs);
    screen.finish(&mut pairs, watch)?;
    screen.sort(&mut pairs);
    Ok(Searched { pairs, untried })
}

impl Search<'_, '_> {
    /// A fit on the shortest windows by their likelihood, none of them left out: the regression has pointed near most of them.
    fn fitted(&self, start: &Start, options: FitOptions) -> Result<FittedModel, Error> {
        let options = FitOptions {
            robust: false,
            ..options
        };
        let (choices, start) = start;
        self.windows
            .screen
            .continued(choices, start.clone(), options)
    }

    /// Where to fit pairs from: those that explain most, beside the reference model and beside the single effects that do; and all
    /// pairs, the one that explains most first.
    fn starts(&self, held: &FittedModel) -> Result<(Vec<Start>, Vec<Vec<Choice>>), Error> {
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
        let at = |(set, explained): &Ranked| responses.start(set, explained);
        let best = ranked.iter().take(FOLLOWED);
        let mut starts = best.map(at).collect::<Result<Vec<Start>, Error>>()?;
        let may_lead = |(set, _): &&Ranked| !responses.all[set[0]].has_many_values();
        let best_of_each = possible(alone, &responses);
        let leaders = best_of_each.iter().filter(may_lead).take(LEADERS).map(at);
        let leaders = leaders.collect::<Result<Vec<Start>, Error>>()?;
        let leaders = parallel(&leaders, |start| match self.watch.stop() {
            true => Ok(None),
            false => Ok(Some(self.fitted(start, calibrating())?)),
        })?;
        for leader in leaders.iter().flatten() {
            let first = leader.choices[0].effect;
            let others = self.list.iter().filter(|c| c.effect != first);
            let others: Vec<Choice> = others.cloned().collect();
            let beside = self.responses(leader, &others)?;
            let found = possible(self.alone(&beside)?, &beside);
            for (set, explained) in found.iter().take(FOLLOWED_BESIDE) {
                starts.push(beside.start(set, explained)?);
            }
        }
        let choice = |&i: &usize| responses.all[i].choice.clone();
        let pairs = ranked
            .iter()
            .map(|(set, _)| set.iter().map(choice).collect());
        let pairs = pairs.collect();
        Ok((starts, pairs))
    }

    fn responses<'s>(
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
    fn alone(&self, responses: &Responses) -> Result<Vec<Ranked>, Error> {
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
fn possible(mut ranked: Vec<Ranked>, responses: &Responses) -> Vec<Ranked> {
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

/// Whether a pair without values of its own along each run explains the data; those imitate much.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn explains(screen: &Screen, best: Option<&mut FittedModel>) -> Result<bool, Error> {
    match best {
        Some(best) if !best.is_local() => full_refit::stands(screen.problem, best),
        _ => Ok(false),
    }
}
