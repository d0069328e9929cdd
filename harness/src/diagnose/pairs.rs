//! Pairs of effects: each of the best single effects with every other.

use super::contender::Contender;
use super::fit::TRIMMED;
use super::hypothesis::Choice;
use super::screen::Screen;
use super::search::{BRIEF, HIDDEN, variants};
use super::session::Session;
use crate::error::Error;
use crate::watch::Watch;

/// Share of the misfit above the noise that a single effect must remove to lead pairs, if it is not the best.
const LEAST_HELP: f64 = 0.1;
/// Pairs of a leader that are tried with its other forms too.
const OTHER_FORMS: usize = 4;

/// Pairs of the best `leaders` single effects with every other, best first. `calibrated` is the model without them. Ends with the first leader that has a pair
/// down to the noise. Leaders that are down to the noise themselves are fitted again from their pairs.
///
/// # Errors
/// An FMU that can't be run.
pub(super) fn with_leaders(
    session: &Session,
    screen: &Screen,
    list: &[Choice],
    calibrated: &Contender,
    singles: &mut Vec<Contender>,
    leaders: usize,
    watch: &dyn Watch,
) -> Result<Vec<Contender>, Error> {
    let floor = 0.5 * (1.0 - TRIMMED) * screen.samples;
    let least = LEAST_HELP * (calibrated.fit.trimmed - floor).max(0.0);
    let mut pairs: Vec<Contender> = Vec::new();
    let mut led: Vec<usize> = Vec::new();
    while led.len() < leaders {
        let Some(place) = singles
            .iter()
            .position(|s| !led.contains(&s.choices[0].effect))
            .filter(|&i| led.is_empty() || calibrated.fit.trimmed - singles[i].fit.trimmed > least)
        else {
            break;
        };
        let leader = &singles[place];
        let first = leader.choices[0].clone();
        let jobs: Vec<Vec<Choice>> = list
            .iter()
            .filter(|c| c.effect != first.effect && !led.contains(&c.effect))
            .map(|c| vec![first.clone(), c.clone()])
            .collect();
        led.push(first.effect);
        let depth = if leader.reaches_floor() {
            HIDDEN
        } else {
            BRIEF
        };
        let found = screen.compete(&jobs, leader, depth, watch)?;
        if leader.reaches_floor() {
            let leader = singles.remove(place);
            let leader = screen.recalibrate(leader, &found)?;
            singles.insert(place, leader);
        }
        pairs.extend(found);
        screen.sort(&mut pairs);
        screen.polish(&mut pairs, watch)?;
        let done = |pairs: &[Contender]| pairs.first().is_some_and(Contender::reaches_floor);
        if !done(&pairs) && !watch.stop() {
            let others = other_forms(session, screen, &first, singles, &pairs, watch)?;
            if !others.is_empty() {
                pairs.extend(others);
                screen.sort(&mut pairs);
                screen.polish(&mut pairs, watch)?;
            }
        }
        if watch.stop() || done(&pairs) {
            break;
        }
    }
    Ok(pairs)
}

/// The best pairs of a leader again with its other forms: alone, the wrong form may look better than the right one.
fn other_forms(
    session: &Session,
    screen: &Screen,
    first: &Choice,
    singles: &[Contender],
    pairs: &[Contender],
    watch: &dyn Watch,
) -> Result<Vec<Contender>, Error> {
    let partners: Vec<&Choice> = pairs
        .iter()
        .filter(|p| p.choices[0] == *first && screen.is_promising(p))
        .map(|p| &p.choices[1])
        .take(OTHER_FORMS)
        .collect();
    let mut out = Vec::new();
    for form in variants(session, first.effect) {
        let base = singles.iter().find(|s| s.choices == [form.clone()]);
        let (Some(base), false) = (base, form == *first) else {
            continue;
        };
        let jobs: Vec<Vec<Choice>> = partners
            .iter()
            .map(|partner| vec![form.clone(), (*partner).clone()])
            .collect();
        out.extend(screen.compete(&jobs, base, BRIEF, watch)?);
    }
    Ok(out)
}
