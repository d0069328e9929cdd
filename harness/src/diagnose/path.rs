//! Which of the effects compared are believed.

use super::candidate::Role;
use super::contender::{Contender, NULL_GAIN};
use super::hypothesis::Choice;
use super::session::Session;

/// Whether an effect has values along the belt.
pub(super) fn is_profile(session: &Session, choice: &Choice) -> bool {
    let parameters = &session.catalogue[choice.effect].parameters;
    parameters.iter().any(|p| p.role == Role::Node)
}

/// The score of the best single effect if it explains the data, which a second effect must beat by more than chance.
pub(super) fn score_alone(singles: &[Contender], samples: f64) -> f64 {
    match singles.first() {
        Some(single) if single.reaches_floor() => single.score(samples),
        _ => f64::INFINITY,
    }
}

/// The effects that are believed, taken out of the lists.
pub(super) fn believed_path(
    singles: &mut Vec<Contender>,
    pairs: &mut Vec<Contender>,
    calibrated: &Contender,
    samples: f64,
) -> Vec<Contender> {
    // A second effect is believed if it brings the errors down to the noise and is worth more than chance.
    let alone = score_alone(singles, samples);
    // Nor is it if one of the two is worth as much alone, unless that is known to be wrong.
    let half = |p: &Contender| {
        let of_pair = singles
            .iter()
            .filter(|s| p.effects().contains(&s.choices[0].effect) && !s.is_refuted);
        of_pair.map(|s| s.score(samples)).fold(alone, f64::min)
    };
    let believed = |p: &Contender| p.reaches_floor() && p.score(samples) < half(p) - NULL_GAIN;
    let mut path = Vec::new();
    let unrefuted = pairs.iter().position(|p| !p.is_refuted);
    if let Some(best) = unrefuted.filter(|&i| believed(&pairs[i])) {
        let pair = pairs.remove(best);
        let first = singles.iter().position(|s| s.choices[0] == pair.choices[0]);
        path.extend(first.map(|i| singles.remove(i)));
        path.push(pair);
        return path;
    }
    let Some(first) = singles.first() else {
        return path;
    };
    // What comes down to the noise goes before what gains more for each of its parameters but does not, if it fits better by
    // more than chance and predicts better what was kept out.
    let error = |c: &Contender| c.holdout.as_ref().map_or(f64::NAN, |h| h.nrmse);
    let complete = singles.iter().position(|s| {
        s.reaches_floor()
            && s.score(samples) < calibrated.score(samples) - NULL_GAIN
            && s.fit.trimmed < first.fit.trimmed - NULL_GAIN
            && error(s) < error(first)
    });
    let chosen = match complete {
        Some(i) if !first.reaches_floor() => i,
        _ => 0,
    };
    if singles[chosen].score(samples) < calibrated.score(samples) {
        path.push(singles.remove(chosen));
    }
    path
}
