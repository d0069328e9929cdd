//! Which hypothesis is believed, and how sure that is.
//!
//! Posterior probability of a hypothesis H on data D: `p(H|D) ~ p(D|H) p(H)`, with the evidence p(D|H) of Laplace's
//! approximation and the prior below. Only adequate hypotheses take part: those that leave no more than noise. Where none
//! does, something else is at work.

use super::contender::Contender;
use super::predictor::Point;
use super::search::{all_variants, settled, widen};
use super::session::{Session, parallel};
use super::{terms, whole};
use crate::error::Error;

/// Hypotheses whose posterior on the shots compared is within this of the best, nats, are compared on all shots: the evidence
/// grows with the data, and all shots and samples are up to six times those compared.
pub(super) const CLOSE: f64 = 10.0;
/// At most so many: each costs a fit to all shots.
const FINALISTS: usize = 4;
/// A second effect is so many times less probable than one: of campaigns that need any, most need one.
const SECOND: f64 = 10.0;
/// Odds over a simpler hypothesis with which an effect is named: strong evidence (Jeffreys, Theory of Probability, 1961,
/// appendix B). A name that is wrong does more harm than one that is missing.
const CLAIMED: f64 = 10.0;
/// Hypotheses less than 20 times less probable than the best can't be told from it: the usual 5 %.
pub const TIE: f64 = 3.0;
/// Probability that nothing known is missing where no hypothesis is adequate: of 35 such verdicts of the blind test 31 were
/// right, the others a search that had missed a pair (docs/blind-test.md).
const SEARCHED: f64 = 0.89;

/// Logarithm of the prior of one hypothesis with so many effects, relative to that of none: one effect is as probable as
/// none, all kinds alike.
pub(super) fn log_prior(session: &Session, effects: usize) -> f64 {
    let kinds = (all_variants(session).len() + terms::all(session).len()).max(1) as f64;
    match effects {
        0 => 0.0,
        1 => -kinds.ln(),
        _ => -(SECOND * 0.5 * kinds * (kinds - 1.0).max(1.0)).ln(),
    }
}

/// Logarithm of a hypothesis's posterior on the shots compared, up to a constant, nats.
pub(super) fn log_posterior(session: &Session, contender: &Contender) -> f64 {
    log_prior(session, contender.choices.len()) - contender.score()
}

/// Works out the posterior of every contender and gives the best adequate one's place; `None` where none is adequate. The
/// best are compared on all shots of the runs fitted; what proves inadequate there falls.
///
/// # Errors
/// An FMU that can't be run.
pub(super) fn decide(
    session: &Session,
    contenders: &mut [&mut Contender],
) -> Result<Option<usize>, Error> {
    for c in contenders.iter_mut() {
        c.log_posterior = log_posterior(session, c);
    }
    loop {
        let Some(best) = best(contenders, |c| c.reaches_floor()) else {
            return Ok(None);
        };
        if session.place_is_told() {
            // Friction scatters: fits count with another noise until the search is over.
            return Ok(Some(simplest(contenders, best)));
        }
        let close = contenders[best].log_posterior - CLOSE;
        let mut finalists: Vec<usize> = (0..contenders.len())
            .filter(|&i| contenders[i].reaches_floor())
            .filter(|&i| i == best || contenders[i].log_posterior > close)
            .collect();
        let posterior = |i: &usize| contenders[*i].log_posterior;
        finalists.sort_by(|a, b| posterior(b).total_cmp(&posterior(a)));
        finalists.truncate(FINALISTS);
        let judged = parallel(&finalists, |&i| {
            let mut contender = (*contenders[i]).clone();
            whole::stands(session, &mut contender)?;
            Ok(contender)
        })?;
        for (&i, judged) in finalists.iter().zip(judged) {
            *contenders[i] = judged;
        }
        finalists.retain(|&i| contenders[i].reaches_floor());
        if finalists.is_empty() {
            continue;
        }
        refit_from_larger(session, contenders, &finalists)?;
        // On all shots among those; the others stay as far behind the best of them as they are on the shots compared.
        let on_all = |c: &Contender| {
            let whole = c.whole.as_ref().expect("fitted to all shots above");
            log_prior(session, c.choices.len()) + whole.fit.log_evidence
        };
        let leading = finalists
            .iter()
            .copied()
            .max_by(|&a, &b| on_all(contenders[a]).total_cmp(&on_all(contenders[b])))
            .expect("not empty");
        let ahead = contenders[leading].log_posterior;
        let top = on_all(contenders[leading]);
        for i in 0..contenders.len() {
            let now = if finalists.contains(&i) {
                on_all(contenders[i]) - top
            } else if ahead.is_finite() {
                (contenders[i].log_posterior - ahead).min(0.0)
            } else {
                // The best could not be weighed before: nothing is known of the distance.
                f64::NEG_INFINITY
            };
            contenders[i].log_posterior = now;
        }
        return Ok(Some(simplest(contenders, leading)));
    }
}

/// Fits each finalist again from the optimum of those that extend it, so that none is left in a worse minimum than what is one
/// of its own points but for an effect.
fn refit_from_larger(
    session: &Session,
    contenders: &mut [&mut Contender],
    finalists: &[usize],
) -> Result<(), Error> {
    let extends = |large: usize, small: usize| {
        let (large, small) = (&contenders[large].choices, &contenders[small].choices);
        large.len() > small.len() && small.iter().all(|c| large.contains(c))
    };
    let jobs: Vec<(usize, usize)> = finalists
        .iter()
        .flat_map(|&small| finalists.iter().map(move |&large| (small, large)))
        .filter(|&(small, large)| extends(large, small))
        .collect();
    let all = session.fit_shots(1);
    let shots = session.copies(&all);
    let again = parallel(&jobs, |&(small, large)| {
        let h = session.hypothesis(&contenders[small].choices)?;
        let larger = contenders[large].whole.as_ref();
        let larger = larger.expect("finalists are fitted to all shots");
        let start = widen(larger, &h, &Point::centre(&h, &shots));
        settled(session, h, &shots, start, whole::last_effort())
    })?;
    for ((small, _), trial) in jobs.into_iter().zip(again) {
        let whole = &mut contenders[small].whole;
        if whole
            .as_ref()
            .is_none_or(|w| trial.fit.log_evidence > w.fit.log_evidence)
        {
            *whole = Some(trial);
        }
    }
    Ok(())
}

/// The simplest adequate hypothesis that is not [`CLAIMED`] times less probable than the leading one: what is named beyond it
/// must be worth the claim.
fn simplest(contenders: &[&mut Contender], leading: usize) -> usize {
    let enough = contenders[leading].log_posterior - CLAIMED.ln();
    let effects = |i: &usize| contenders[*i].choices.len();
    (0..contenders.len())
        .filter(|i| effects(i) < effects(&leading))
        .filter(|&i| contenders[i].reaches_floor() && contenders[i].log_posterior > enough)
        .min_by(|a, b| {
            let posterior = |i: &usize| contenders[*i].log_posterior;
            effects(a)
                .cmp(&effects(b))
                .then(posterior(b).total_cmp(&posterior(a)))
        })
        .unwrap_or(leading)
}

fn best(contenders: &[&mut Contender], wanted: impl Fn(&Contender) -> bool) -> Option<usize> {
    let all = (0..contenders.len()).filter(|&i| wanted(contenders[i]));
    all.max_by(|&a, &b| {
        let posterior = |i: usize| contenders[i].log_posterior;
        posterior(a).total_cmp(&posterior(b))
    })
}

/// Probabilities of contenders from their posteriors.
pub(super) fn probabilities(contenders: &[&Contender]) -> Vec<f64> {
    let rows: Vec<(f64, bool)> = contenders
        .iter()
        .map(|c| (c.log_posterior, c.reaches_floor()))
        .collect();
    shares(&rows)
}

/// Probabilities from the logarithms of posteriors up to a constant, and whether each hypothesis is adequate. The adequate
/// ones share all; where none is, all share the little that is left beside something unknown. What was not compared (NaN)
/// has none.
fn shares(rows: &[(f64, bool)]) -> Vec<f64> {
    let any = rows.iter().any(|(_, adequate)| *adequate);
    let counts = |row: &(f64, bool)| row.0.is_finite() && (row.1 || !any);
    let of_those = rows.iter().filter(|row| counts(row)).map(|row| row.0);
    let top = of_those.fold(f64::NEG_INFINITY, f64::max);
    let weight = |row: &(f64, bool)| match counts(row) {
        true => (row.0 - top).exp(),
        false => 0.0,
    };
    let total: f64 = rows.iter().map(weight).sum();
    let known = if any { 1.0 } else { 1.0 - SEARCHED };
    let share = |row| known * weight(row) / total.max(f64::MIN_POSITIVE);
    rows.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adequate_hypotheses_share_all_by_their_posteriors() {
        let odds = 9.0_f64.ln();
        let found = shares(&[
            (5.0 + odds, true),
            (5.0, true),
            (50.0, false),
            (f64::NAN, true),
        ]);
        for (share, expected) in found.iter().zip([0.9, 0.1, 0.0, 0.0]) {
            assert!((share - expected).abs() < 1e-12, "{found:?}");
        }
    }

    #[test]
    fn where_none_is_adequate_something_unknown_is_as_probable_as_the_search_is_good() {
        let found = shares(&[(-800.0, false), (-803.0, false)]);
        assert!((found.iter().sum::<f64>() - (1.0 - SEARCHED)).abs() < 1e-12);
        assert!(found[0] > found[1]);
    }
}
