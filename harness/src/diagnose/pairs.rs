//! Pairs of effects: each of the best single effects with every other.

use super::contender::Contender;
use super::hypothesis::Choice;
use super::screen::Screen;
use super::search::{BRIEF, HELD, HIDDEN, variants};
use super::session::Session;
use super::whole;
use crate::error::Error;
use crate::watch::Watch;

/// Pairs of a leader whose second effect is searched for again from their own optima.
const RESTARTED: usize = 2;

/// Pairs of the best single effect, which is down to the noise, with every other, best first. The single is fitted again
/// from its pairs.
///
/// # Errors
/// An FMU that can't be run.
pub(super) fn behind_the_best(
    screen: &Screen,
    list: &[Choice],
    singles: &mut Vec<Contender>,
    watch: &dyn Watch,
) -> Result<Vec<Contender>, Error> {
    let leader = singles.remove(0);
    let mut pairs = screen.compete(&with(&leader.choices[0], list, &[]), &leader, HIDDEN, watch)?;
    singles.insert(0, screen.recalibrate(leader, &pairs)?);
    screen.polish(&mut pairs, watch)?;
    Ok(pairs)
}

/// Pairs of effects of which none alone explains the data, best first: each of `leaders` with every other, the reference
/// model held to what is believed of it, the best then fitted freely. Ends with the first
/// leader that has a pair without values of its own along each run down to the noise.
///
/// # Errors
/// An FMU that can't be run.
pub(super) fn held(
    screen: &Screen,
    list: &[Choice],
    leaders: &[&Contender],
    watch: &dyn Watch,
) -> Result<Vec<Contender>, Error> {
    let mut pairs: Vec<Contender> = Vec::new();
    let mut led: Vec<Choice> = Vec::new();
    // Values of their own along each run imitate much: such a leader comes last, and its pairs do not end the search.
    let (local, simple): (Vec<&Contender>, Vec<&Contender>) =
        leaders.iter().partition(|leader| leader.is_local());
    for leader in simple.into_iter().chain(local) {
        let first = &leader.choices[0];
        let mut jobs = with(first, list, &led);
        let mut found = screen.freed(&screen.compete(&jobs, leader, HELD, watch)?)?;
        screen.lend_lines(&mut found, list)?;
        screen.polish(&mut found, watch)?;
        // A wrong partner that helps brings the leader near its true values: from there the right one is near.
        if let Some(best) = found
            .first()
            .filter(|b| !b.reaches_floor() && screen.is_promising(b))
        {
            jobs.retain(|choices| *choices != best.choices);
            let again = screen.compete(&jobs, best, HIDDEN, watch)?;
            screen.keep_better(&mut found, again);
            screen.lend_lines(&mut found, list)?;
            screen.polish(&mut found, watch)?;
        }
        // As above: what is simpler than values along each run gets its chance.
        let is_simple = |p: &Contender| p.reaches_floor() && !p.is_local();
        if !found.first().is_some_and(is_simple) {
            screen.restart(&mut found, RESTARTED, watch)?;
        }
        pairs.extend(found);
        screen.sort(&mut pairs);
        led.push(first.clone());
        let explains = match pairs.first_mut() {
            Some(best) if !best.is_local() => whole::stands(screen.session, best)?,
            _ => false,
        };
        if watch.stop() || explains {
            break;
        }
    }
    Ok(pairs)
}

/// A pair that explains the data again with the other forms of its effects, from where it stands: of a leader, the form
/// was chosen before its partner was known.
///
/// # Errors
/// An FMU that can't be run.
pub(super) fn other_forms(
    session: &Session,
    screen: &Screen,
    pair: &Contender,
    watch: &dyn Watch,
) -> Result<Vec<Contender>, Error> {
    let mut out = Vec::new();
    for (place, choice) in pair.choices.iter().enumerate() {
        for form in variants(session, choice.effect) {
            if form == *choice {
                continue;
            }
            // A search adds the last effect of its list.
            let mut job = pair.choices.clone();
            job.remove(place);
            job.push(form.clone());
            for found in screen.compete(&[job], pair, BRIEF, watch)? {
                let mut choices = pair.choices.clone();
                choices[place] = form.clone();
                out.push(screen.reordered(&found, &choices)?);
            }
        }
    }
    Ok(out)
}

/// The pairs of an effect with every other that has not led yet.
fn with(first: &Choice, list: &[Choice], led: &[Choice]) -> Vec<Vec<Choice>> {
    list.iter()
        .filter(|c| c.effect != first.effect && !led.contains(c))
        .map(|c| vec![first.clone(), c.clone()])
        .collect()
}
