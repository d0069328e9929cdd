//! Pairs of effects, searched for on the beginnings of segments while these lengthen, where windows brought no answer: what shows only at
//! some transitions (static friction that ages) a fit on windows may leave so uncertain that whole segments are lost.
//!
//! Over a whole segment a model that lacks two effects meets transitions at wrong times, and a fit of one of them ends in a wrong
//! valley: ranked there, what leads is seldom one of the two. Over its beginning the same model errs by its forces alone. The first
//! looks at single effects ([`super::race`]) rank one of the two first or second in 16 of 19 campaigns, and an effect that is there
//! explains a beginning alone. It is continued on longer ones until it fails; what has to be added there is the other effect.
//! Source: the objective is the smoother the shorter the pieces that are predicted (Ribeiro, Tiels, Umenberger, Schön and Aguirre,
//! Automatica 121 (2020) 109158, theorems 1 and 3).

use crate::diagnose::estimation::fit::Fit;
use crate::diagnose::estimation::fit_options::FitOptions;
use crate::diagnose::initialisation::multistart::calibrating;
use crate::diagnose::initialisation::search_options::{FIRST_FIT_SHARE, SearchOptions, THOROUGH};
use crate::diagnose::model::hypothesis::{Choice, NEARLY_OFF};
use crate::diagnose::model::point::Point;
use crate::diagnose::selection::fitted_model::{FittedModel, name};
use crate::diagnose::selection::further_fits::{POLISH, refitting};
use crate::diagnose::selection::race::{BATCH, Entrant, FOLLOWED, first_looks};
use crate::diagnose::selection::screening::Screen;
use crate::error::Error;
use crate::parallel::parallel;
use crate::watch::Watch;

/// Shares of each segment, from its start: that of first looks, and on to the whole.
const SHARES: [f64; 4] = [FIRST_FIT_SHARE, 0.6, 0.8, 1.0];
/// Single effects that are fitted to their end on the shortest beginnings, those that look best.
const FITTED: usize = 6;
/// Looks at each of them from which it is fitted.
const LOOKS: usize = 2;
/// How many of them lead pairs, one after another: one of two effects looks best or second.
const LEADERS: usize = 2;

/// Beginnings of the segments of a screen.
struct Beginnings<'a> {
    screen: &'a Screen<'a>,
    watch: &'a dyn Watch,
}

/// Pairs of effects, the best of them fitted to its end on whole segments, or a single one that explains the data after all, best
/// first: until one does that has no values of its own along each run, which imitate much. `list` are all effects, `race` are first looks at each of them alone.
///
/// # Errors
/// An FMU that can't be run.
pub(crate) fn search(
    screen: &Screen,
    list: &[Choice],
    race: &[Entrant],
    watch: &dyn Watch,
) -> Result<Vec<FittedModel>, Error> {
    let beginnings = Beginnings { screen, watch };
    let mut found: Vec<FittedModel> = Vec::new();
    let leaders = beginnings.leaders(race)?;
    let most = leaders.len();
    for (number, leader) in leaders.into_iter().enumerate() {
        if watch.stop() {
            break;
        }
        watch.step(&name(screen.problem, &leader.choices), number, most);
        let (leader, length) = beginnings.until_it_fails(leader)?;
        if length + 1 == SHARES.len() && leader.is_answer() {
            return Ok(vec![leader]);
        }
        let new = beginnings.beside(&leader, length, list)?;
        screen.keep_better(&mut found, new);
        if found.first().is_some_and(FittedModel::is_answer) {
            break;
        }
    }
    Ok(found)
}

/// So many of the hypotheses that look best, each at so many of its best looks.
fn starts(entrants: &[Entrant], most: usize, looks_each: usize) -> Vec<(&Vec<Choice>, &Fit)> {
    let best = entrants.iter().take(most);
    best.flat_map(|(choices, looks)| {
        let best = looks.best_first().into_iter().take(looks_each);
        best.map(move |look| (choices, look))
    })
    .collect()
}

impl Beginnings<'_> {
    /// A hypothesis fitted further on beginnings of a length.
    fn fitted(
        &self,
        choices: &[Choice],
        start: &Point,
        length: usize,
        options: FitOptions,
    ) -> Result<FittedModel, Error> {
        let options = FitOptions {
            share: SHARES[length],
            ..options
        };
        self.screen.continued(choices, start.clone(), options)
    }

    /// The same to its end, as the reference model is calibrated: what leads has to stand in its valley before others are added.
    fn to_its_end(
        &self,
        choices: &[Choice],
        start: &Point,
        length: usize,
    ) -> Result<FittedModel, Error> {
        self.fitted(choices, start, length, calibrating())
    }

    /// Single effects on the shortest beginnings, best first, without those with values of their own along each run.
    fn leaders(&self, entrants: &[Entrant]) -> Result<Vec<FittedModel>, Error> {
        let starts = starts(entrants, FITTED, LOOKS);
        let fitted = parallel(&starts, |(choices, look)| {
            self.to_its_end(choices, &look.point, 0)
        })?;
        let mut leaders: Vec<FittedModel> = Vec::new();
        self.screen.keep_better(&mut leaders, fitted);
        leaders.retain(|leader| !leader.is_local());
        leaders.truncate(LEADERS);
        Ok(leaders)
    }

    /// A model on longer beginnings as long as it is down to the noise, with the length at which it fails.
    fn until_it_fails(&self, mut model: FittedModel) -> Result<(FittedModel, usize), Error> {
        let mut length = 0;
        while model.is_down_to_noise() && length + 1 < SHARES.len() && !self.watch.stop() {
            length += 1;
            model = self.to_its_end(&model.choices, &model.fitted.fit.point, length)?;
        }
        Ok((model, length))
    }

    /// A leader with each other effect of a list, from where it stands on beginnings of a length and from the reference model as
    /// believed: what looks best on whole segments, the best of it fitted to its end, best first.
    fn beside(
        &self,
        leader: &FittedModel,
        length: usize,
        list: &[Choice],
    ) -> Result<Vec<FittedModel>, Error> {
        let first = &leader.choices[0];
        let others = list.iter().filter(|c| c.effect != first.effect);
        let jobs: Vec<Vec<Choice>> = others.map(|c| vec![first.clone(), c.clone()]).collect();
        let how = SearchOptions {
            first_fit_share: SHARES[length],
            barely_on: NEARLY_OFF,
            ..THOROUGH
        };
        let looks = first_looks(self.screen, &jobs, leader, how, jobs.len(), self.watch)?;
        let mut pairs = self.to_the_end(&looks, length)?;
        self.screen.finish(&mut pairs, self.watch)?;
        Ok(pairs)
    }

    /// What looks best, fitted further: the best eight at this length, the best four of these at each longer one. On whole segments, best
    /// first.
    fn to_the_end(&self, entrants: &[Entrant], length: usize) -> Result<Vec<FittedModel>, Error> {
        let best = starts(entrants, FOLLOWED, 1);
        let mut kept = parallel(&best, |(choices, look)| {
            self.fitted(choices, &look.point, length, refitting(POLISH))
        })?;
        self.screen.sort(&mut kept);
        for longer in length + 1..SHARES.len() {
            kept.truncate(BATCH);
            kept = parallel(&kept, |model| {
                let start = &model.fitted.fit.point;
                self.fitted(&model.choices, start, longer, refitting(POLISH))
            })?;
            self.screen.sort(&mut kept);
        }
        Ok(kept)
    }
}
