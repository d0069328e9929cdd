//! The search through single effects and pairs: briefly at first, and harder while nothing explains the data.

use super::contender::{Contender, NULL_GAIN};
use super::hypothesis::Choice;
use super::pairs;
use super::path::score_alone;
use super::predictor::Point;
use super::screen::Screen;
use super::search::{self, BRIEF, FIRM, HELD};
use super::session::{Session, parallel};
use super::{terms, whole};
use crate::error::Error;
use crate::watch::Watch;

/// Single effects with which pairs are formed when none alone is enough.
const PAIR_LEADERS: usize = 2;
/// Pairs that are fitted to all shots where a single effect fell so.
const PAIRS_TRIED: usize = 4;
/// Single effects that are searched for again from their own optima.
const RESTARTED: usize = 3;

/// What has been found so far.
pub(super) struct Hunt<'a> {
    session: &'a Session<'a>,
    screen: &'a Screen<'a>,
    watch: &'a dyn Watch,
    /// All ways to choose one effect.
    list: Vec<Choice>,
    /// The reference model calibrated by itself.
    pub alone: Contender,
    /// The same, or better, from the optimum of an effect.
    pub calibrated: Contender,
    /// Single effects, best first.
    pub singles: Vec<Contender>,
    /// Single effects beside a reference model held to what is believed of it, best first; empty until that was needed.
    held: Vec<Contender>,
    /// Pairs tried, best first.
    pub pairs: Vec<Contender>,
    /// A term beyond the catalogue that explains the data by itself where no effect does.
    pub beyond: Option<Contender>,
}

/// Searches the catalogue on the shots of `screen`.
///
/// Every candidate is searched for briefly; only where none comes down to the noise, the search is repeated with the
/// reference model held to what is believed of it, and pairs are formed with the best of that. Where one does, pairs are
/// formed with it; it may be refuted even then, and the search goes on.
///
/// # Errors
/// An FMU that can't be run.
pub(super) fn hunt<'a>(
    session: &'a Session<'a>,
    screen: &'a Screen<'a>,
    watch: &'a dyn Watch,
) -> Result<Hunt<'a>, Error> {
    let base = screen.calibrate(1.0)?;
    let list = search::all_variants(session);
    let jobs: Vec<Vec<Choice>> = list.iter().map(|c| vec![c.clone()]).collect();
    let singles = screen.compete(&jobs, &base, BRIEF, watch)?;
    let mut hunt = Hunt {
        session,
        screen,
        watch,
        list,
        calibrated: screen.recalibrate(base.clone(), &singles)?,
        alone: base,
        singles,
        held: Vec::new(),
        pairs: Vec::new(),
        beyond: None,
    };
    hunt.try_harder()?;
    hunt.hold(&jobs)?;
    if hunt.is_at_floor() && hunt.is_claimed() {
        hunt.look_behind()?;
        // Fitted again from its pairs, the leader may fall only now.
        hunt.hold(&jobs)?;
    }
    if !hunt.is_at_floor() && hunt.may_be_two() {
        hunt.look_beyond()?;
        if hunt.beyond.is_none() {
            hunt.pair()?;
            hunt.refit_halves()?;
        }
    }
    hunt.refute_pairs()?;
    let to_beat = score_alone(&hunt.singles, screen.samples) - NULL_GAIN;
    let is_worth_it = |p: &&Contender| p.reaches_floor() && p.score(screen.samples) < to_beat;
    if let Some(best) = hunt
        .pairs
        .iter()
        .find(|p| !p.is_refuted)
        .filter(is_worth_it)
    {
        let others = pairs::other_forms(session, screen, best, watch)?;
        screen.keep_better(&mut hunt.pairs, others);
    }
    screen.nest(&mut hunt.singles, &hunt.calibrated)?;
    Ok(hunt)
}

impl Hunt<'_> {
    /// Where the break-aways tell of the place, friction scatters: no second effect brings the motion down to the noise.
    fn may_be_two(&self) -> bool {
        !self.session.place_is_told()
    }

    /// Whether the calibrated model or the best effect is down to the noise.
    fn is_at_floor(&self) -> bool {
        let first = self.singles.first();
        self.calibrated.reaches_floor() || first.is_some_and(Contender::reaches_floor)
    }

    /// Whether the best effect is worth more than chance.
    fn is_claimed(&self) -> bool {
        let to_beat = self.calibrated.score(self.screen.samples) - NULL_GAIN;
        let first = self.singles.first();
        first.is_some_and(|s| s.score(self.screen.samples) < to_beat)
    }

    /// Whether the search may end. Values of its own along each run imitate much: that alone does not end it, nor does what
    /// falls when it is fitted to all shots.
    fn is_settled(&mut self) -> Result<bool, Error> {
        if self.calibrated.reaches_floor() {
            return Ok(true);
        }
        let may_be_two = self.may_be_two();
        match self.singles.first_mut() {
            Some(best) if best.is_local() => Ok(false),
            Some(best) if may_be_two => whole::stands(self.session, best),
            Some(best) => Ok(best.reaches_floor()),
            None => Ok(false),
        }
    }

    /// While nothing explains the data: the lines of others, fits to the end, other starts.
    fn try_harder(&mut self) -> Result<(), Error> {
        if !self.is_settled()? {
            self.screen.lend_lines(&mut self.singles, &self.list)?;
            self.screen.polish(&mut self.singles, self.watch)?;
        }
        self.restart()
    }

    /// While nothing explains the data: other starts, and the best to its end.
    fn restart(&mut self) -> Result<(), Error> {
        if !self.is_settled()? {
            self.screen
                .restart(&mut self.singles, RESTARTED, self.watch)?;
            self.screen.finish(&mut self.singles, self.watch)?;
        }
        Ok(())
    }

    /// While nothing explains the data: the reference model is held to what is believed of it, once.
    fn hold(&mut self, jobs: &[Vec<Choice>]) -> Result<(), Error> {
        let screen = self.screen;
        if self.may_be_two() && self.held.is_empty() && !self.is_settled()? && !self.watch.stop() {
            self.held = screen.compete(jobs, &screen.calibrate(FIRM)?, HELD, self.watch)?;
            let freed = screen.freed(&self.held)?;
            screen.keep_better(&mut self.singles, freed);
            let calibrated = screen.recalibrate(self.calibrated.clone(), &self.singles)?;
            self.calibrated = calibrated;
            screen.lend_lines(&mut self.singles, &self.list)?;
            screen.polish(&mut self.singles, self.watch)?;
        }
        self.restart()
    }

    /// A second effect may still hide behind a first that is down to the noise.
    fn look_behind(&mut self) -> Result<(), Error> {
        if !self.watch.stop() {
            self.screen.compare_forms(&mut self.singles)?;
        }
        self.pairs =
            pairs::behind_the_best(self.screen, &self.list, &mut self.singles, self.watch)?;
        Ok(())
    }

    /// One term beyond the catalogue that explains all goes before two effects of it.
    fn look_beyond(&mut self) -> Result<(), Error> {
        let (screen, watch) = (self.screen, self.watch);
        let terms = terms::all(self.session);
        let jobs: Vec<Vec<Choice>> = terms.into_iter().map(|t| vec![t]).collect();
        let mut found = screen.compete(&jobs, &self.calibrated, BRIEF, watch)?;
        screen.polish(&mut found, watch)?;
        screen.finish(&mut found, watch)?;
        for mut term in found {
            if whole::stands(self.session, &mut term)? {
                self.beyond = Some(term);
                break;
            }
        }
        Ok(())
    }

    /// Fits the effects of the best pair by themselves again from its optimum: where one of them is enough, it may have come
    /// down to the noise only beside the other.
    fn refit_halves(&mut self) -> Result<(), Error> {
        let Some(pair) = self.pairs.first().filter(|p| p.reaches_floor()) else {
            return Ok(());
        };
        let halves = parallel(&pair.choices, |choice| {
            let alone = std::slice::from_ref(choice);
            let h = self.session.hypothesis(alone)?;
            let centre = Point::centre(&h, &self.screen.shots);
            let start = search::widen(&pair.trial, &h, &centre);
            self.screen.fitted_from(alone, start)
        })?;
        self.screen.keep_better(&mut self.singles, halves);
        Ok(())
    }

    /// Where a single effect fell that had been down to the noise, pairs with it may do so too: the best pairs are tried until
    /// one stands.
    fn refute_pairs(&mut self) -> Result<(), Error> {
        if self.singles.iter().any(|s| s.is_refuted) {
            let at_floor = self.pairs.iter_mut().filter(|p| p.reaches_floor());
            for pair in at_floor.take(PAIRS_TRIED) {
                if self.watch.stop() || whole::stands(self.session, pair)? {
                    break;
                }
            }
        }
        Ok(())
    }

    /// Pairs of which neither effect is enough.
    fn pair(&mut self) -> Result<(), Error> {
        let mut leaders: Vec<&Contender> = self.held.iter().take(PAIR_LEADERS).collect();
        // The best of those fitted freely leads too: held, others may stand before it.
        let known = |s: &Contender| leaders.iter().any(|l| l.effects() == s.effects());
        let is_new = |s: &&Contender| self.screen.is_promising(s) && !known(s);
        let free = self.singles.first().filter(is_new);
        leaders.extend(free);
        let found = pairs::held(self.screen, &self.list, &leaders, self.watch)?;
        self.screen.keep_better(&mut self.pairs, found);
        self.screen.finish(&mut self.pairs, self.watch)
    }
}
