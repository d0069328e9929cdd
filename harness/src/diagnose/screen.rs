//! The shots on which hypotheses are compared, and the fits of many hypotheses to them.

use super::contender::{Contender, name};
use super::fit::Effort;
use super::hypothesis::Choice;
use super::lost_runs::without_loss;
use super::predictor::Point;
use super::search::{self, Depth, Trial, baseline, search};
use super::session::{Session, parallel};
use super::shot::Shot;
use super::whole;
use crate::error::Error;
use crate::watch::Watch;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Every how many-th group of shots is used at most while candidates are compared, ...
const SCREEN_EVERY: usize = 3;
/// ... fewer left out where so many shots would not be reached: what a poor campaign has is needed.
const ENOUGH: usize = 24;
/// A contender whose median error over the noise is below this is worth fitting further.
const PROMISING: f64 = 30.0;
/// ..., if it is also below this many times the best contender's.
const NEAR_THE_BEST: f64 = 3.0;
/// A contender whose median error over the noise is below this is worth fitting to its end.
const NEAR_THE_NOISE: f64 = 3.0;
/// Contenders that are fitted further.
const POLISHED: usize = 4;
/// Jacobians for that.
pub(super) const POLISH: usize = 14;
/// Contenders found with the reference model held that are fitted freely, ...
const FREED: usize = 10;
/// ... with so many Jacobians.
const FREE: usize = 4;
/// Candidates from whose optimum the reference model is fitted again.
const RETRIES: usize = 2;
/// Jacobians for that.
const RETRY: usize = 8;

/// Shots on which hypotheses are compared.
pub struct Screen<'a> {
    pub(super) session: &'a Session<'a>,
    /// Their indices.
    pub indices: Vec<usize>,
    /// The shots themselves.
    pub shots: Vec<Shot>,
}

impl<'a> Screen<'a> {
    /// Some of the shots of every run that is fitted.
    pub fn new(session: &'a Session<'a>) -> Self {
        let every = (session.fit_shots(1).len() / ENOUGH).clamp(1, SCREEN_EVERY);
        let indices = session.fit_shots(every);
        let shots = session.copies(&indices);
        Self::of_shots(session, indices, shots)
    }

    /// Shots at the places `indices` of the session's, their measurements perhaps replaced.
    pub fn of_shots(session: &'a Session<'a>, indices: Vec<usize>, shots: Vec<Shot>) -> Self {
        Self {
            session,
            indices,
            shots,
        }
    }

    pub(super) fn contender(&self, choices: Vec<Choice>, trial: Trial) -> Result<Contender, Error> {
        Contender::new(self.session, choices, trial, &self.indices, &self.shots)
    }

    /// Best first.
    pub fn sort(&self, contenders: &mut [Contender]) {
        contenders.sort_by(Contender::compare);
    }

    /// The reference model, fitted; `belief` is how firmly it is held to what is believed of it.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn calibrate(&self, belief: f64) -> Result<Contender, Error> {
        self.contender(Vec::new(), baseline(self.session, &self.shots, belief)?)
    }

    /// Fits many hypotheses in parallel, each the base with one effect more; best first.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn compete(
        &self,
        jobs: &[Vec<Choice>],
        base: &Contender,
        depth: Depth,
        watch: &dyn Watch,
    ) -> Result<Vec<Contender>, Error> {
        let done = AtomicUsize::new(0);
        // The long ones first, so that no thread waits for the last one.
        let mut jobs: Vec<&Vec<Choice>> = jobs.iter().collect();
        let weight = |choices: &Vec<Choice>| -> usize {
            let of = |c: &Choice| self.session.catalogue[c.effect].weight();
            choices.iter().map(of).sum()
        };
        jobs.sort_by_key(|choices| std::cmp::Reverse(weight(choices)));
        let results = parallel(&jobs, |choices| {
            if watch.stop() {
                return Ok(None);
            }
            let trial = search(self.session, choices, &self.shots, &base.trial, depth)?;
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            watch.step(&name(self.session, choices), done, jobs.len());
            Ok(Some(self.contender(choices.to_vec(), trial)?))
        })?;
        let mut contenders: Vec<Contender> = results.into_iter().flatten().collect();
        self.sort(&mut contenders);
        Ok(contenders)
    }

    /// Keeps for each hypothesis the better of two fits.
    pub fn keep_better(&self, contenders: &mut Vec<Contender>, others: Vec<Contender>) {
        for other in others {
            match contenders.iter_mut().find(|c| c.choices == other.choices) {
                Some(mine) if other.is_before(mine) => *mine = other,
                Some(_) => {}
                None => contenders.push(other),
            }
        }
        self.sort(contenders);
    }

    /// Whether a contender is near enough to the noise to be worth fitting further.
    pub fn is_promising(&self, contender: &Contender) -> bool {
        contender.fit.quantile(0.5) < PROMISING
    }

    /// Fits contenders further that are near the noise but not down to it: the best ones, and where the best is down
    /// to it already, only those that need fewer parameters than it does.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn polish(&self, contenders: &mut [Contender], watch: &dyn Watch) -> Result<(), Error> {
        let enough = match contenders.first() {
            Some(best) if best.reaches_floor() => best.size(),
            _ => usize::MAX,
        };
        let near = match contenders.first() {
            // Values of its own along each run imitate much: what is simpler gets its chance from afar.
            Some(best) if best.is_local() => PROMISING,
            Some(best) => NEAR_THE_BEST * best.fit.quantile(0.5),
            None => f64::NAN,
        };
        let wanted: Vec<usize> = (0..contenders.len())
            .filter(|&i| {
                let c = &contenders[i];
                self.is_promising(c)
                    && c.fit.quantile(0.5) < near
                    && !c.reaches_floor()
                    && c.size() < enough
            })
            .take(POLISHED)
            .collect();
        if wanted.is_empty() || watch.stop() {
            return Ok(());
        }
        watch.step("fitting the best candidates further", 0, 1);
        let polished = parallel(&wanted, |&i| self.further(&contenders[i], POLISH))?;
        for (i, new) in wanted.into_iter().zip(polished) {
            if new.is_before(&contenders[i]) {
                contenders[i] = new;
            }
        }
        self.sort(contenders);
        Ok(())
    }

    /// Contenders found with the reference model held: the best ones fitted freely from there, best first.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn freed(&self, held: &[Contender]) -> Result<Vec<Contender>, Error> {
        let best = &held[..held.len().min(FREED)];
        let mut freed = parallel(best, |old| self.further(old, FREE))?;
        self.sort(&mut freed);
        Ok(freed)
    }

    /// Fits a model again from the optima of the best that extend it, with what they add switched off, so that it
    /// is not left behind in a worse minimum than they.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn recalibrate(&self, base: Contender, extended: &[Contender]) -> Result<Contender, Error> {
        let leaders: Vec<&Contender> = extended.iter().take(RETRIES).collect();
        let retried = parallel(&leaders, |single| {
            let h = self.session.hypothesis(&base.choices)?;
            let start = search::narrowed(&h, &single.trial.fit.point, &self.shots);
            self.fitted(&base.choices, start, refitting(RETRY))
        })?;
        let mut best = base;
        for retry in retried {
            if retry.is_before(&best) {
                best = retry;
            }
        }
        Ok(best)
    }

    /// Fits those candidates again that ended above the model that they extend, which is one of their own
    /// points: from there.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn nest(&self, contenders: &mut [Contender], base: &Contender) -> Result<(), Error> {
        let above: Vec<usize> = (0..contenders.len())
            .filter(|&i| contenders[i].trial.fit.misfit > base.trial.fit.misfit)
            .collect();
        let again = parallel(&above, |&i| {
            let choices = &contenders[i].choices;
            let trial = search::from_nested(self.session, choices, &self.shots, &base.trial)?;
            self.contender(choices.clone(), trial)
        })?;
        for (i, new) in above.into_iter().zip(again) {
            if new.trial.fit.misfit < contenders[i].trial.fit.misfit {
                contenders[i] = new;
            }
        }
        self.sort(contenders);
        Ok(())
    }

    /// A contender's hypothesis fitted again from where it stands.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn refit_of(&self, contender: &Contender) -> Result<Contender, Error> {
        self.further(contender, RETRY)
    }

    /// A contender fitted further from where it stands, and if that loses runs, again with what the others found.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(super) fn further(&self, old: &Contender, iterations: usize) -> Result<Contender, Error> {
        self.further_by(old, refitting(iterations))
    }

    fn further_by(&self, old: &Contender, effort: Effort) -> Result<Contender, Error> {
        let start = old.trial.fit.point.clone();
        let further = self.fitted(&old.choices, start, effort)?;
        let Some(start) = without_loss(self.session, &further, &self.shots)? else {
            return Ok(further);
        };
        let again = self.fitted(&old.choices, start, effort)?;
        let is_better = again.fit.trimmed < further.fit.trimmed;
        Ok(if is_better { again } else { further })
    }

    /// Fits the best contender to its end if it is near the noise but not down to it: what lies along a narrow valley takes more
    /// steps than a comparison affords.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(super) fn finish(
        &self,
        contenders: &mut [Contender],
        watch: &dyn Watch,
    ) -> Result<(), Error> {
        let Some(best) = contenders.first_mut() else {
            return Ok(());
        };
        if best.reaches_floor() || best.fit.quantile(0.5) > NEAR_THE_NOISE || watch.stop() {
            return Ok(());
        }
        watch.step("fitting the best candidate to its end", 0, 1);
        *best = self.to_its_end(best)?;
        Ok(())
    }

    /// A contender fitted from where it stands until nothing moves any more.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(super) fn to_its_end(&self, contender: &Contender) -> Result<Contender, Error> {
        let effort = Effort {
            stride: search::STRIDE,
            ..whole::last_effort()
        };
        let further = self.further_by(contender, effort)?;
        let is_better = further.is_before(contender);
        Ok(if is_better {
            further
        } else {
            contender.clone()
        })
    }

    /// A contender fitted further with its effects in another order.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub fn reordered(&self, found: &Contender, choices: &[Choice]) -> Result<Contender, Error> {
        let h = self.session.hypothesis(choices)?;
        let centre = Point::centre(&h, &self.shots);
        let start = search::widen(&found.trial, &h, &centre);
        self.fitted(choices, start, refitting(POLISH))
    }

    /// A hypothesis fitted from a point of its own.
    ///
    /// # Errors
    /// An FMU that can't be run.
    pub(super) fn fitted_from(&self, choices: &[Choice], start: Point) -> Result<Contender, Error> {
        self.fitted(choices, start, refitting(RETRY))
    }

    /// A hypothesis fitted from a point of its own: its start states first, then all.
    fn fitted(&self, choices: &[Choice], start: Point, effort: Effort) -> Result<Contender, Error> {
        let h = self.session.hypothesis(choices)?;
        let trial = search::settled(self.session, h, &self.shots, start, effort)?;
        self.contender(choices.to_vec(), trial)
    }
}

/// The effort of a fit that goes on from where another ended.
fn refitting(iterations: usize) -> Effort {
    Effort {
        patience: 2,
        ..search::effort(iterations)
    }
}
