//! The search over the lattice of hypotheses: none, one or two effects or terms, the best fit of each kept.
//!
//! Single hypotheses race. Where the calibrated model meets most segments and falls for those that it loses, the library does so next. Beside an adequate one (down to the noise) a score test tells which second effects can change the verdict.
//! Where none is an answer, single effects, those of the library and pairs are searched for together on short windows, and pairs on
//! beginnings of the segments where that brings none.

mod adequate;
mod beyond_catalogue;
mod pairs;

use crate::diagnose::initialisation::score_test::is_testable;
use crate::diagnose::initialisation::search_options::{BRIEF, STRONG_PRIOR, THOROUGH};
use crate::diagnose::model::hypothesis::Choice;
use crate::diagnose::model::problem::Problem;
use crate::diagnose::model::variants::all_variants;
use crate::diagnose::selection::decision::log_posterior;
use crate::diagnose::selection::fitted_model::FittedModel;
use crate::diagnose::selection::full_refit;
use crate::diagnose::selection::race::{Entrant, Race};
use crate::diagnose::selection::screening::{Promised, Screen};
use crate::diagnose::selection::tested::Tested;
use crate::diagnose::stages;
use crate::error::Error;
use crate::watch::Watch;

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
    let mut base = screen.calibrate(1.0)?;
    if base.leaves_runs() {
        // A few of those compared may be lost by chance; all segments tell.
        full_refit::stands(problem, &mut base)?;
    }
    watch.stage(stages::SINGLES);
    let list = all_variants(problem);
    let mut jobs: Vec<Vec<Choice>> = list.iter().map(|c| vec![c.clone()]).collect();
    let is_explained = base.reaches_floor() && !base.loses_segments();
    if is_explained {
        // What could still be missing is weak: the score test below speaks of the rest.
        jobs.retain(|choices| !is_testable(problem, choices[0].effect));
    }
    // Beside a model that explains the data an effect can only be weak.
    let search = if is_explained { BRIEF } else { THOROUGH };
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
    let mut is_settled = found.is_settled()?;
    if !is_settled && found.acts_at_times() && !problem.place_is_told() {
        watch.stage(stages::LIBRARY);
        found.add_library_effects()?;
        is_settled = found.is_settled()?;
    }
    if !is_settled {
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
        self.refute_what_is_lost();
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

    /// Whether what the calibrated model lacks acts at times: it meets most segments and was refuted for the runs that it leaves. Its
    /// constants are good then, and each effect is looked for from there.
    fn acts_at_times(&self) -> bool {
        self.alone.unmet_runs > 0 && self.alone.leaves_runs()
    }

    /// Refutes what loses as many of the segments compared as the calibrated model, where what is missing acts at times: that most are met
    /// tells nothing then.
    fn refute_what_is_lost(&mut self) {
        if !self.acts_at_times() {
            return;
        }
        let more = self.singles.iter_mut().chain(&mut self.pairs);
        let all = std::iter::once(&mut self.calibrated).chain(more);
        let lost = self.alone.fit.lost();
        for model in all.filter(|m| m.full_refit.is_none() && m.fit.lost() >= lost) {
            model.is_refuted = true;
        }
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

    /// All that was fitted.
    fn all(&self) -> impl Iterator<Item = &FittedModel> {
        let singles = std::iter::once(&self.calibrated).chain(&self.singles);
        singles.chain(&self.pairs)
    }

    /// Whether anything explains the data without values of its own along each run.
    fn has_answer(&self) -> bool {
        self.all().any(FittedModel::is_answer)
    }

    /// The best single effect, where it is more than the calibrated model.
    fn named(&self) -> Option<&FittedModel> {
        let posterior = |model: &FittedModel| log_posterior(self.problem, model);
        self.singles.first().filter(|single| {
            !self.calibrated.reaches_floor() || posterior(single) > posterior(&self.calibrated)
        })
    }
}
