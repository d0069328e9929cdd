//! The search over the lattice of hypotheses: none, one or two effects or terms, the best fit of each kept.
//!
//! Single hypotheses race. Beside an adequate one (down to the noise) a score test tells which second effects can change the verdict.
//! Where none is an answer, single effects, those of the library and pairs are searched for together on short windows, and pairs on
//! beginnings of the segments where that brings none.

use crate::diagnose::initialisation::score_test::is_testable;
use crate::diagnose::initialisation::search_options::{
    BRIEF, CURVE, HIDDEN, STRONG_PRIOR, THOROUGH,
};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::library::{File, is_library_effect};
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::variants::{all_variants, library, unknown, variants};
use crate::diagnose::selection::decision::{
    log_posterior, log_posterior_on_all, log_prior, share_starts,
};
use crate::diagnose::selection::extension::{Beside, extend, one_further};
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::race::{Entrant, Race};
use crate::diagnose::selection::screening::{Promised, RETRY, Screen, is_near_noise, last_options};
use crate::diagnose::selection::tested::Tested;
use crate::diagnose::selection::{full_refit, lengthening, subset_search};
use crate::diagnose::stages;
use crate::diagnose::thresholds::{CLOSE, FINALISTS};
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;

/// Hypotheses close to the best that are fitted to their end.
const FINISHED: usize = 6;
/// Effects of the library that are fitted before it is asked whether one is adequate.
const LIBRARY_BATCH: usize = 10;
/// Unknown functions that are fitted where the catalogue has no answer: of each place where one may act about one.
const UNKNOWN_FITTED: usize = 6;

/// What has been found so far.
pub(crate) struct Exploration<'a> {
    problem: &'a Problem<'a>,
    screen: &'a Screen<'a>,
    watch: &'a dyn Watch,
    /// All ways to choose one effect.
    list: Vec<Choice>,
    /// The reference model calibrated by itself.
    pub alone: FittedModel,
    /// The same, or better, from the optimum of an effect.
    pub calibrated: FittedModel,
    /// First looks at single effects, the one that looks best first.
    race: Vec<Entrant>,
    /// Single effects and terms, best first.
    pub singles: Vec<FittedModel>,
    /// The reference model held to what is believed of it, once that was needed.
    held_alone: Option<FittedModel>,
    /// Pairs tried, best first.
    pub pairs: Vec<FittedModel>,
    /// Pairs that were compared to first order alone ([`subset_search::Searched`]); `None` before sets were searched.
    pub untried: Option<Vec<Vec<Choice>>>,
    /// Whether unknown functions have competed.
    has_tried_unknown: bool,
    /// Effects beside an adequate hypothesis of which a score test says that no fit could change the verdict.
    pub tested: Vec<Tested>,
}

/// Searches the catalogue and the terms beyond it on the segments of `screen`.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn explore<'a>(
    problem: &'a Problem<'a>,
    screen: &'a Screen<'a>,
    watch: &'a dyn Watch,
) -> Result<Exploration<'a>, Error> {
    let base = screen.calibrate(1.0)?;
    watch.stage(stages::SINGLES);
    let list = all_variants(problem);
    let mut jobs: Vec<Vec<Choice>> = list.iter().map(|c| vec![c.clone()]).collect();
    if base.reaches_floor() {
        // What could still be missing is weak: the score test below speaks of the rest.
        jobs.retain(|choices| !is_testable(problem, choices[0].effect));
    }
    // Beside a model that explains the data an effect can only be weak.
    let search = if base.reaches_floor() {
        BRIEF
    } else {
        THOROUGH
    };
    let race = Race::new(screen, &jobs, &base, search, watch)?;
    let singles = race.run(watch)?;
    let mut found = Exploration {
        problem,
        screen,
        watch,
        list,
        calibrated: screen.recalibrate(base.clone(), &singles)?,
        alone: base,
        race: race.entrants,
        singles,
        held_alone: None,
        pairs: Vec::new(),
        untried: None,
        has_tried_unknown: false,
        tested: Vec::new(),
    };
    if !found.is_settled()? {
        found.search_sets()?;
    } else if !problem.place_is_told() {
        watch.stage(stages::LIBRARY);
        // On whole segments a fit of another effect may lose its way.
        if found.library_may_explain()? {
            found.search_on_windows(&[])?;
        }
    }
    found.compare_adequate()?;
    // What seemed adequate may have fallen on all segments.
    if !found.is_adequate() && found.untried.is_none() {
        found.search_sets()?;
        found.compare_adequate()?;
    }
    let is_open = !watch.stop() && !problem.place_is_told() && !found.is_adequate();
    if is_open && !found.pair_explains()? {
        found.pair_from_halves()?;
    }
    if !watch.stop() && !problem.place_is_told() && !found.has_answer() {
        found.pair_beside_nearest()?;
    }
    if is_open && !found.pair_explains()? {
        watch.stage(stages::PAIRS_FURTHER);
        found.pair_on_beginnings()?;
        found.compare_adequate()?;
    }
    found.tell_roughness()?;
    found.refit_halves()?;
    found.other_forms_of_pair()?;
    // Values along the belt imitate much beside another effect too: before such a pair is named, or what explains most where nothing
    // explains all, the whole library competes.
    if found.needs_unknown_functions() && !found.is_adequate() {
        watch.stage(stages::LIBRARY);
        found.add_library_effects()?;
    }
    // What has no name comes after all that has one.
    found.try_unknown_functions()?;
    screen.nest(&mut found.singles, &found.calibrated)?;
    Ok(found)
}

impl Exploration<'_> {
    /// Whether the calibrated model or a single hypothesis is adequate.
    fn is_adequate(&self) -> bool {
        let mut all = std::iter::once(&self.calibrated).chain(&self.singles);
        all.any(FittedModel::reaches_floor)
    }

    /// Whether the search among single hypotheses may end. Values of its own along each run imitate much: that alone does not
    /// end it, nor does what falls when it is fitted to all segments.
    fn is_settled(&mut self) -> Result<bool, Error> {
        let is_adequate = self.calibrated.reaches_floor();
        let least = match is_adequate {
            true => log_posterior(self.problem, &self.calibrated),
            false => f64::NEG_INFINITY,
        };
        while !self.watch.stop() {
            self.screen.sort(&mut self.singles);
            let is_answer = |single: &&mut FittedModel| {
                single.is_answer() && log_posterior(self.problem, single) > least
            };
            let Some(best) = self.singles.first_mut().filter(is_answer) else {
                return Ok(is_adequate);
            };
            *best = self.screen.to_its_end(best)?;
            if full_refit::stands(self.problem, best)? {
                return Ok(true);
            }
        }
        Ok(is_adequate)
    }

    /// Compares what is adequate, and what may hide behind it.
    fn compare_adequate(&mut self) -> Result<(), Error> {
        if self.is_adequate() {
            self.watch.stage(stages::CLOSE);
            self.finish_close()?;
            self.watch.stage(stages::EXTENSIONS);
            self.extend_leader()?;
        }
        Ok(())
    }

    /// Values along the belt of adequate pairs, as rough as the data tell. What was fitted to all segments has the roughness of the leader
    /// that it extends.
    fn tell_roughness(&mut self) -> Result<(), Error> {
        let is_open = |m: &&mut FittedModel| m.full_refit.is_none() && m.reaches_floor();
        for model in self.pairs.iter_mut().filter(is_open) {
            if self.watch.stop() {
                return Ok(());
            }
            *model = self.screen.with_told_roughness(model.clone())?;
        }
        self.screen.sort(&mut self.pairs);
        Ok(())
    }

    /// Fits the hypotheses whose evidence is close to the best to their end, so that they compare, and the forms of the best
    /// from each other.
    fn finish_close(&mut self) -> Result<(), Error> {
        if self.watch.stop() {
            return Ok(());
        }
        self.screen.compare_forms(&mut self.singles)?;
        let smaller = &self.calibrated;
        let jobs: Vec<Vec<Choice>> = self.singles.iter().map(|c| c.choices.clone()).collect();
        let expected = match smaller.reaches_floor() {
            true => self.screen.promises(&jobs, smaller, self.watch)?,
            false => jobs.iter().map(|_| None).collect(),
        };
        // What a search has not reached yet, a score test may promise.
        let within_reach = |i: usize| {
            let promised = expected[i].as_ref().map(|p| p.gain - smaller.score());
            promised
                .unwrap_or(f64::NEG_INFINITY)
                .max(-self.singles[i].score())
                + log_prior(self.problem, 1)
        };
        let best = (0..self.singles.len())
            .map(within_reach)
            .fold(log_posterior(self.problem, smaller), f64::max);
        let mut close: Vec<usize> = (0..self.singles.len())
            .filter(|&i| within_reach(i) > best - CLOSE)
            .collect();
        close.sort_by(|&a, &b| within_reach(b).total_cmp(&within_reach(a)));
        close.truncate(FINISHED);
        let ended = parallel(&close, |&i| {
            let now = &self.singles[i];
            match &expected[i] {
                Some(p) if p.gain - smaller.score() > -now.score() => {
                    let start = p.start.clone();
                    let there = self.screen.fitted_from(&p.choices(&now.choices), start)?;
                    self.screen.to_its_end(&there)
                }
                _ => self.screen.to_its_end(now),
            }
        })?;
        for (i, new) in close.into_iter().zip(ended) {
            if !self.singles[i].is_before(&new) {
                self.singles[i] = new;
            }
        }
        self.screen.sort(&mut self.singles);
        let calibrated = self
            .screen
            .recalibrate(self.calibrated.clone(), &self.singles)?;
        self.calibrated = self.screen.to_its_end(&calibrated)?;
        Ok(())
    }

    /// Fits what is adequate and close to the best to all segments, until one of it stands there: what leads on those compared may leave
    /// others unmet.
    fn close_on_all(&mut self) -> Result<(), Error> {
        loop {
            let all = std::iter::once(&mut self.calibrated).chain(&mut self.singles);
            let mut close: Vec<&mut FittedModel> = all.filter(|m| m.reaches_floor()).collect();
            let posterior = |model: &FittedModel| log_posterior(self.problem, model);
            close.sort_by(|a, b| posterior(b).total_cmp(&posterior(a)));
            let Some(best) = close.first().map(|m| posterior(m)) else {
                return Ok(());
            };
            close.retain(|m| posterior(m) >= best - CLOSE);
            close.truncate(FINALISTS);
            let judged = parallel(&close, |model| {
                let mut model = (**model).clone();
                full_refit::stands(self.problem, &mut model)?;
                Ok(model)
            })?;
            for (model, judged) in close.iter_mut().zip(judged) {
                **model = judged;
            }
            let standing = (0..close.len()).filter(|&i| close[i].reaches_floor());
            let standing: Vec<usize> = standing.collect();
            share_starts(self.problem, &mut close, &standing, &standing)?;
            if !standing.is_empty() || self.watch.stop() {
                return Ok(());
            }
        }
    }

    /// A further effect may hide behind what is adequate, also behind the calibrated model itself, and then another behind that.
    fn extend_leader(&mut self) -> Result<(), Error> {
        let mut extended: Option<Vec<Choice>> = None;
        let mut searched: Option<Beside> = None;
        while !self.watch.stop() && !self.problem.place_is_told() {
            // What imitates much takes longest to extend, and what extends it imitates more: its rivals come first.
            if self.leader_is_local() {
                self.try_unknown_functions()?;
            }
            self.close_on_all()?;
            let posterior = |c: &FittedModel| {
                log_posterior_on_all(self.problem, c).unwrap_or(f64::NEG_INFINITY)
            };
            let leader = std::iter::once(&mut self.calibrated)
                .chain(&mut self.singles)
                .filter(|c| c.reaches_floor())
                .max_by(|a, b| posterior(a).total_cmp(&posterior(b)))
                .filter(|c| extended.as_ref() != Some(&c.choices));
            let Some(leader) = leader else {
                return Ok(());
            };
            let known = searched.take().filter(|b| b.leader == leader.choices);
            let is_known = known.is_some();
            let beside = match known {
                Some(beside) => beside,
                None => Beside::new(self.screen, leader, self.watch)?,
            };
            if extended.is_none() && !is_known {
                let leader = leader.clone();
                if self.search_beside(&leader, &beside)? {
                    return Ok(());
                }
                searched = Some(beside);
                continue;
            }
            // A leader that falls when it is fitted to all segments is marked, so that the next one is looked at.
            let Some(found) = extend(self.screen, leader, beside)? else {
                continue;
            };
            let leader = leader.clone();
            self.tested = found.tested;
            let hidden = self.hidden(found.untested, &leader)?;
            let beside_partners = self.beside_partners(&found.fitted, &leader)?;
            if !leader.choices.is_empty() {
                self.screen.keep_better(&mut self.pairs, found.fitted);
                self.screen.keep_better(&mut self.pairs, hidden);
                self.screen.keep_better(&mut self.pairs, beside_partners);
                return Ok(());
            }
            self.screen.keep_better(&mut self.singles, found.fitted);
            self.screen.keep_better(&mut self.singles, hidden);
            extended = Some(leader.choices);
        }
        Ok(())
    }

    /// Pairs beside a leader with values along the belt, again from where the other effect is alone. The values have taken its place,
    /// and the way back is a valley so narrow and bent that no fit gets along it; beside the other effect they find theirs.
    fn beside_partners(
        &self,
        pairs: &[FittedModel],
        leader: &FittedModel,
    ) -> Result<Vec<FittedModel>, Error> {
        if !leader.is_local() {
            return Ok(Vec::new());
        }
        let found = parallel(pairs, |pair| {
            let (new, old) = pair.choices.split_last().expect("two effects");
            let mut singles = self.singles.iter();
            let Some(partner) = singles.find(|s| s.choices.first() == Some(new)) else {
                return Ok(None);
            };
            let job: Vec<Choice> = std::iter::once(new).chain(old).cloned().collect();
            let found = self.screen.compete(&[job], partner, THOROUGH, self.watch)?;
            let Some(found) = found.first() else {
                return Ok(None);
            };
            let found = self.screen.reordered(found, &pair.choices)?;
            let mut found = self.screen.to_its_end(&found)?;
            full_refit::stands(self.problem, &mut found)?;
            Ok(Some(found))
        })?;
        Ok(found.into_iter().flatten().collect())
    }

    /// Searches near a leader that looks adequate for effects more that were not found yet.
    fn hidden(
        &self,
        mut jobs: Vec<Vec<Choice>>,
        leader: &FittedModel,
    ) -> Result<Vec<FittedModel>, Error> {
        let is_new = |choices: &Vec<Choice>| {
            let mut known = self.singles.iter().chain(&self.pairs);
            known.all(|model| model.choices != *choices)
        };
        jobs.retain(is_new);
        let mut found = self.screen.compete(&jobs, leader, HIDDEN, self.watch)?;
        self.end_adequate(&mut found, leader)?;
        Ok(found)
    }

    /// Fits the best of what is adequate to its end: the leader beside which it was found stands there, and what does not would lose by
    /// that alone. What is too far behind the leader for all that its derivatives promise stays where it is.
    fn end_adequate(
        &self,
        found: &mut Vec<FittedModel>,
        leader: &FittedModel,
    ) -> Result<(), Error> {
        let close = log_posterior(self.problem, leader) - CLOSE;
        let within_reach = |model: &FittedModel| {
            let fall = model.most_gain();
            let is_weighed = model.score().is_finite() && fall.is_finite();
            // Of values along the belt the roughness may not be told yet.
            !is_weighed || model.is_local() || log_posterior(self.problem, model) + fall > close
        };
        let adequate = found
            .iter()
            .filter(|model| model.reaches_floor() && within_reach(model));
        let adequate: Vec<&FittedModel> = adequate.take(FINISHED).collect();
        let ended = parallel(&adequate, |model| self.screen.to_its_end(model))?;
        self.screen.keep_better(found, ended);
        Ok(())
    }

    /// Searches beside a leader that looks adequate for the further effects that a score test on the segments compared promises a claim
    /// of. Whether a pair was found that is more probable than the leader.
    fn search_beside(&mut self, leader: &FittedModel, beside: &Beside) -> Result<bool, Error> {
        let visible = beside.visible(self.problem);
        if visible.is_empty() {
            return Ok(false);
        }
        let mut found = parallel(&visible, |(choices, promise)| {
            let start = promise.start.clone();
            self.screen
                .continued(&promise.choices(choices), start, last_options())
        })?;
        self.screen.sort(&mut found);
        if leader.choices.is_empty() {
            self.screen.keep_better(&mut self.singles, found);
            return Ok(false);
        }
        self.end_adequate(&mut found, leader)?;
        let is_more_probable = |pair: &FittedModel| {
            let posterior = log_posterior(self.problem, pair);
            pair.reaches_floor() && posterior > log_posterior(self.problem, leader)
        };
        let is_any = found.iter().any(is_more_probable);
        self.screen.keep_better(&mut self.pairs, found);
        Ok(is_any)
    }

    /// The reference model held to what is believed of it. What it leaves is due to what is missing, where a calibrated one
    /// has been bent in its place.
    fn held_alone(&mut self) -> Result<FittedModel, Error> {
        if self.held_alone.is_none() {
            self.held_alone = Some(self.screen.calibrate(STRONG_PRIOR)?);
        }
        Ok(self.held_alone.clone().expect("just made"))
    }

    /// Effects, each alone, in the order of what a score test beside `alone` promises of them. Far from the noise the test orders
    /// and says no more.
    fn by_promise(
        &self,
        alone: &FittedModel,
        effects: Vec<Choice>,
    ) -> Result<Vec<Promised>, Error> {
        let jobs = effects.into_iter().map(|c| vec![c]).collect();
        self.screen.by_promise(jobs, alone, self.watch)
    }

    /// Whether the catalogue has no answer: nothing of it is adequate but with values along each run, which imitate much, or with these
    /// it is more probable than without.
    fn needs_unknown_functions(&self) -> bool {
        let is_of_catalogue = |c: &&FittedModel| {
            let mut effects = c.choices.iter();
            effects.all(|e| !is_library_effect(&self.problem.catalogue[e.effect].id))
        };
        let has_answer = self
            .all()
            .filter(is_of_catalogue)
            .any(FittedModel::is_answer);
        (!has_answer || self.leader_is_local()) && !self.problem.place_is_told()
    }

    /// Whether the most probable of what is adequate has values of its own along each run.
    fn leader_is_local(&self) -> bool {
        let posterior = |model: &FittedModel| log_posterior(self.problem, model);
        let adequate = self.all().filter(|m| m.reaches_floor());
        let leader = adequate.max_by(|a, b| posterior(a).total_cmp(&posterior(b)));
        leader.is_some_and(FittedModel::is_local)
    }

    /// Lets unknown functions compete where the catalogue has no answer, once.
    fn try_unknown_functions(&mut self) -> Result<(), Error> {
        if self.has_tried_unknown || !self.needs_unknown_functions() {
            return Ok(());
        }
        self.has_tried_unknown = true;
        self.watch.stage(stages::UNKNOWN);
        self.add_unknown_functions()
    }

    /// All that was fitted.
    fn all(&self) -> impl Iterator<Item = &FittedModel> {
        let singles = std::iter::once(&self.calibrated).chain(&self.singles);
        singles.chain(&self.pairs)
    }

    /// Whether anything explains the data without values of its own along each run.
    fn has_answer(&self) -> bool {
        self.all().any(FittedModel::is_answer)
    }

    /// Pairs of the best single effect near the noise and what a score test beside it promises most of: there first order holds on whole
    /// segments, where windows leave states of effects free.
    fn pair_beside_nearest(&mut self) -> Result<(), Error> {
        let is_near = |s: &&FittedModel| is_near_noise(s) && !s.is_local();
        let Some(nearest) = self.singles.iter().find(is_near).cloned() else {
            return Ok(());
        };
        let mut found = one_further(self.screen, &nearest, RETRY, self.watch)?;
        self.screen.sort(&mut found);
        self.end_adequate(&mut found, &nearest)?;
        self.screen.keep_better(&mut self.pairs, found);
        Ok(())
    }

    /// Unknown functions as the only thing that the calibrated model lacks: hypotheses like the others.
    fn add_unknown_functions(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let alone = self.held_alone()?;
        let ranked = self.by_promise(&alone, unknown(self.problem))?;
        let acting = self.adequate_of_library();
        let is_wanted = |(place, (choices, _)): &(usize, Promised)| {
            *place < UNKNOWN_FITTED || self.acts_like(choices, &acting)
        };
        let best = ranked.into_iter().enumerate().filter(is_wanted);
        let jobs: Vec<Vec<Choice>> = best.map(|(_, (choices, _))| choices).collect();
        let held = screen.compete(&jobs, &alone, CURVE, watch)?;
        let mut found = screen.freed(&held)?;
        screen.finish(&mut found, watch)?;
        // A brief fit tells only what may be the most probable of all.
        let posterior = |model: &FittedModel| log_posterior(self.problem, model);
        let adequate = self.all().filter(|m| m.reaches_floor());
        let best = adequate.map(posterior).fold(f64::NEG_INFINITY, f64::max);
        let found = parallel(&found, |model: &FittedModel| {
            let is_open = model.reaches_floor() && posterior(model) + model.most_gain() > best;
            let ended = match is_open {
                true => screen.to_its_end(model)?,
                false => model.clone(),
            };
            screen.with_told_smoothness(ended)
        })?;
        screen.keep_better(&mut self.singles, held);
        screen.keep_better(&mut self.singles, found);
        Ok(())
    }

    /// The effects of the library that are adequate, each alone.
    fn adequate_of_library(&self) -> Vec<File> {
        let adequate = self.singles.iter().filter(|m| m.reaches_floor());
        let id = |m: &FittedModel| &self.problem.catalogue[m.choices[0].effect].id;
        adequate.filter_map(|m| File::of_library(id(m))).collect()
    }

    /// Whether a hypothesis is an unknown function with the place and the argument of one of these effects, whose curve it shows.
    fn acts_like(&self, choices: &[Choice], effects: &[File]) -> bool {
        let id = &self.problem.catalogue[choices[0].effect].id;
        let mut functions = self.problem.unknown_functions.iter();
        functions.any(|f| {
            let is_its = |e: &File| e.place() == f.place && e.argument == f.argument;
            f.id == *id && effects.iter().any(is_its)
        })
    }

    /// The effects of the library, best first by what a score test beside the calibrated model promises of them.
    fn ordered_library(&self) -> Result<Vec<Promised>, Error> {
        self.by_promise(&self.calibrated, library(self.problem))
    }

    /// The best single effect, where it is more than the calibrated model.
    fn named(&self) -> Option<&FittedModel> {
        let posterior = |model: &FittedModel| log_posterior(self.problem, model);
        self.singles.first().filter(|single| {
            !self.calibrated.reaches_floor() || posterior(single) > posterior(&self.calibrated)
        })
    }

    /// Whether an effect of the library may explain the data as well as the best single effect does, which is adequate and fitted to its
    /// end: it leaves segments unmet, or a score test at the calibrated model promises no less of another. Not where nothing is named but
    /// the calibrated model, beside which they are tested anyway.
    fn library_may_explain(&self) -> Result<bool, Error> {
        let Some(best) = self.named() else {
            return Ok(false);
        };
        if best.leaves_segments() {
            return Ok(true);
        }
        let jobs = [best.choices.clone()];
        let gained = self.calibrated.score() - best.score();
        let promised = self.screen.promises(&jobs, &self.calibrated, self.watch)?;
        let least = promised[0].as_ref().map_or(gained, |p| p.gain);
        let of_library = self.ordered_library()?;
        let first = of_library.first().and_then(|(_, p)| p.as_ref());
        Ok(first.is_some_and(|p| p.gain >= least))
    }

    /// Effects of the library as the only thing that the calibrated model lacks, hypotheses like the others, until one is adequate and
    /// meets all segments. A score test orders them. Far from the noise it can't tell more.
    fn add_library_effects(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let alone = self.calibrated.clone();
        let ordered = self.ordered_library()?;
        let jobs: Vec<Vec<Choice>> = ordered.into_iter().map(|(choices, _)| choices).collect();
        let mut found: Vec<FittedModel> = Vec::new();
        for batch in jobs.chunks(LIBRARY_BATCH) {
            let new = screen.compete(batch, &alone, BRIEF, watch)?;
            screen.keep_better(&mut found, new);
            // What a brief fit leaves unmet, the same fit to its end may meet.
            let best = found.first().filter(|m| m.reaches_floor());
            if let Some(ended) = best.map(|m| screen.to_its_end(m)).transpose()? {
                screen.keep_better(&mut found, vec![ended]);
            }
            if watch.stop() || found.first().is_some_and(FittedModel::meets_all) {
                break;
            }
        }
        screen.polish(&mut found, watch)?;
        screen.finish(&mut found, watch)?;
        screen.keep_better(&mut self.singles, found);
        Ok(())
    }

    /// Sets of effects, from where a regression on windows points.
    fn search_sets(&mut self) -> Result<(), Error> {
        self.untried = Some(Vec::new());
        // Where the break-aways tell of the place, friction scatters: no effect brings the motion down to the noise.
        if self.problem.place_is_told() || self.watch.stop() {
            return Ok(());
        }
        self.watch.stage(stages::SETS);
        let list = self.list.clone();
        self.untried = Some(self.search_on_windows(&list)?);
        Ok(())
    }

    /// Pairs of a list and effects of the library, as short windows tell them; the pairs that were not tried. Without a list the library
    /// rivals the best single effect.
    fn search_on_windows(&mut self, list: &[Choice]) -> Result<Vec<Vec<Choice>>, Error> {
        let held = self.held_alone()?;
        let library = library(self.problem);
        let may_rival = |named: &&FittedModel| list.is_empty() && !named.is_local();
        let rival = self.named().filter(may_rival);
        let effects = (list, &library[..]);
        let found = subset_search::search(self.screen, &held, effects, rival, self.watch)?;
        let (singles, pairs) = found.models.into_iter().partition(|m| m.choices.len() == 1);
        self.screen.keep_better(&mut self.singles, singles);
        self.screen.keep_better(&mut self.pairs, pairs);
        Ok(found.untried)
    }

    /// Pairs on beginnings of the segments that lengthen, from the single effects that look best there.
    fn pair_on_beginnings(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let found = lengthening::search(screen, &self.list, &self.race, watch)?;
        let (singles, pairs): (Vec<_>, Vec<_>) =
            found.into_iter().partition(|m| m.choices.len() == 1);
        screen.keep_better(&mut self.singles, singles);
        screen.keep_better(&mut self.pairs, pairs);
        let has = |model: &FittedModel, pair: &[Choice]| {
            pair.iter().all(|c| model.effects().contains(&c.effect))
        };
        let is_tried = |pair: &Vec<Choice>| self.pairs.iter().any(|model| has(model, pair));
        if let Some(untried) = &mut self.untried {
            untried.retain(|pair| !is_tried(pair));
        }
        Ok(())
    }

    /// Whether a pair explains the data: one is adequate, and stays so on all segments.
    fn pair_explains(&mut self) -> Result<bool, Error> {
        while !self.watch.stop() {
            self.screen.sort(&mut self.pairs);
            match self.pairs.first_mut() {
                Some(best) if best.reaches_floor() => {
                    if full_refit::stands(self.problem, best)? {
                        return Ok(true);
                    }
                }
                _ => return Ok(false),
            }
        }
        Ok(false)
    }

    /// An effect of a pair by itself, from where the pair stands.
    fn half(&self, pair: &FittedModel, choice: &Choice) -> Result<FittedModel, Error> {
        let alone = std::slice::from_ref(choice);
        let start = self.screen.point_like(pair, alone)?;
        self.screen.fitted_from(alone, start)
    }

    /// The best pair again from each of its effects alone, where it is near the noise and not down to it: what short windows tell of
    /// strengths and start states may lie beside the valley that ends there, and one effect alone is in it where it explains most.
    fn pair_from_halves(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let is_open = |p: &&FittedModel| {
            p.choices.len() == 2 && is_near_noise(p) && !p.reaches_floor() && !watch.stop()
        };
        let Some(pair) = self.pairs.first().filter(is_open) else {
            return Ok(());
        };
        let found = parallel(&[0, 1], |&first| {
            let [base, added] = [first, 1 - first].map(|i| pair.choices[i].clone());
            let half = self.half(pair, &base)?;
            let found = screen.compete(&[vec![base, added]], &half, THOROUGH, watch)?;
            let Some(found) = found.first() else {
                return Ok(None);
            };
            let found = screen.reordered(found, &pair.choices)?;
            Ok(Some(screen.to_its_end(&found)?))
        })?;
        let found = found.into_iter().flatten().collect();
        screen.keep_better(&mut self.pairs, found);
        Ok(())
    }

    /// Fits the effects of the best pair by themselves again from its optimum: where one of them is enough, it may have come
    /// down to the noise only beside the other.
    fn refit_halves(&mut self) -> Result<(), Error> {
        let Some(pair) = self.pairs.first().filter(|p| p.reaches_floor()) else {
            return Ok(());
        };
        // As far as the pair was fitted: where the other effect does nothing both end in one place.
        let halves = parallel(&pair.choices, |choice| {
            self.screen.to_its_end(&self.half(pair, choice)?)
        })?;
        self.screen.keep_better(&mut self.singles, halves);
        Ok(())
    }

    /// A pair that is believed again with the other forms of its effects, from where it stands: of a leader, the form was
    /// chosen before its partner was known.
    fn other_forms_of_pair(&mut self) -> Result<(), Error> {
        let Some(pair) = self.pairs.iter().find(|p| !p.is_refuted) else {
            return Ok(());
        };
        let singles = self.singles.iter().filter(|s| s.reaches_floor());
        let alone = singles
            .map(FittedModel::score)
            .fold(f64::INFINITY, f64::min);
        if !pair.reaches_floor() || pair.score() > alone {
            return Ok(());
        }
        let mut others = Vec::new();
        for (place, choice) in pair.choices.iter().enumerate() {
            for form in variants(self.problem, choice.effect) {
                if form == *choice {
                    continue;
                }
                // A search adds the last effect of its list.
                let mut job = pair.choices.clone();
                job.remove(place);
                job.push(form.clone());
                for found in self.screen.compete(&[job], pair, BRIEF, self.watch)? {
                    let mut choices = pair.choices.clone();
                    choices[place] = form.clone();
                    others.push(self.screen.reordered(&found, &choices)?);
                }
            }
        }
        self.screen.keep_better(&mut self.pairs, others);
        Ok(())
    }
}
