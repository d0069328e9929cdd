//! The fit of one hypothesis from several starts, so that a poor local minimum is not taken for a verdict.

use super::candidate::{Candidate, Role};
use super::contender::FLOOR_MEDIAN;
use super::fit::{Effort, Fit, Fitter};
use super::hypothesis::{Choice, Hypothesis, NEARLY_OFF};
use super::knob::Knob;
use super::look::Looker;
use super::predictor::Point;
use super::session::Session;
use super::shot::Shot;
use super::starts::{start_at_line, starts};
use super::terms::is_term;
use crate::error::Error;

/// Every how many-th sample is used while searching.
pub const STRIDE: usize = 2;
/// Jacobians for a first look at a start.
const LOOK: usize = 3;
/// Share of each shot for a first look: a short horizon is less easily caught in a local minimum.
pub(super) const LOOK_SHARE: f64 = 0.4;
/// Jacobians for the starts that look best.
const CLIMB: usize = 10;
/// Starts that are followed to the end.
const FOLLOWED: usize = 2;
/// Median error over the noise above which a first look is not followed where the model without the effect is down to the
/// noise.
const FAR: f64 = 3.0;

/// A hypothesis and the best fit found.
#[derive(Clone)]
pub struct Trial {
    /// The hypothesis.
    pub hypothesis: Hypothesis,
    /// The fit.
    pub fit: Fit,
}

/// The effort of a search.
pub fn effort(iterations: usize) -> Effort {
    Effort {
        iterations,
        stride: STRIDE,
        share: 1.0,
        tolerance: 1e-3,
        patience: 1,
        knobs: true,
        shared: true,
        revive: true,
        belief: 1.0,
        robust: true,
        reference: true,
    }
}

pub(super) fn keep_better(best: &mut Option<Fit>, fit: Fit) {
    if best.as_ref().is_none_or(|b| fit.trimmed < b.trimmed) {
        *best = Some(fit);
    }
}

/// The fit of a smaller hypothesis as a point of a larger one, with the effects that it lacks as nearly off
/// as their parameters allow.
fn switched_off(session: &Session, h: &Hypothesis, base: &Trial, shots: &[Shot]) -> Point {
    let mut point = widen(base, h, &Point::centre(h, shots));
    for choice in h
        .choices
        .iter()
        .filter(|c| !base.hypothesis.choices.contains(c))
    {
        let effect = &session.catalogue[choice.effect];
        for p in effect
            .parameters
            .iter()
            .filter(|p| p.role == Role::Amplitude)
        {
            if let Some(i) = h.shared_index(&format!("{}.{}", effect.id, p.name)) {
                // Quite off it has no derivatives.
                point.shared[i] = h.shared[i].clamp(NEARLY_OFF * p.typical);
            }
        }
    }
    point
}

/// Fits a hypothesis from the fit of a smaller one with the effects that this lacks switched off.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn from_nested(
    session: &Session,
    choices: &[Choice],
    shots: &[Shot],
    base: &Trial,
) -> Result<Trial, Error> {
    let hypothesis = session.hypothesis(choices)?;
    let data = session.data(shots);
    let mut predictor = session.predictor(&hypothesis)?;
    let off = switched_off(session, &hypothesis, base, shots);
    let as_compared = Effort {
        robust: false,
        ..effort(BRIEF.look)
    };
    let fit = Fitter::new(&mut predictor, &hypothesis, &data, as_compared).run(off);
    Ok(Trial { hypothesis, fit })
}

/// Fits a hypothesis from `start`: its start states first, then all.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn settled(
    session: &Session,
    hypothesis: Hypothesis,
    shots: &[Shot],
    start: Point,
    effort: Effort,
) -> Result<Trial, Error> {
    let data = session.data(shots);
    let mut predictor = session.predictor(&hypothesis)?;
    let mut fitter = Fitter::new(&mut predictor, &hypothesis, &data, effort);
    let settled = fitter.settle(start);
    let fit = fitter.run(settled.point);
    Ok(Trial { hypothesis, fit })
}

/// How thorough a search is.
#[derive(Debug, Clone, Copy)]
pub struct Depth {
    /// Jacobians for a first look at a start.
    pub look: usize,
    /// Share of each shot for it: a short horizon is less easily caught in a local minimum, a long one tells more.
    pub look_share: f64,
    /// Starts that are followed to the end.
    pub followed: usize,
    /// Jacobians for these.
    pub climb: usize,
    /// From which nuisances starts are taken.
    pub nuisances: Nuisances,
    /// Whether first looks leave the reference model's common constants where they are.
    pub fixed_looks: bool,
    /// How firmly the reference model is held to what is believed of it after that.
    pub belief: f64,
}

/// Nuisances with which a search starts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Nuisances {
    /// The calibrated ones only, with the effect barely on.
    Calibrated,
    /// The calibrated ones, and the nominal ones with the effect at practical strength; for periodic effects the nominal ones
    /// at the strongest lines only.
    Some,
    /// Both, for every effect.
    All,
}

/// How firmly the reference model's own constants are held while a hypothesis may still lack something. Its residuals
/// are no noise then: a hundred samples in a row err alike, and counted one by one they would bend frequencies, damping and
/// friction far beyond what is believed of them, into valleys from which no effect leads out.
pub const FIRM: f64 = 1000.0;

/// Every start is looked at, the best two are followed to the end.
pub const THOROUGH: Depth = Depth {
    look: LOOK,
    look_share: LOOK_SHARE,
    followed: FOLLOWED,
    climb: CLIMB,
    nuisances: Nuisances::All,
    fixed_looks: false,
    belief: 1.0,
};
/// For hypotheses that a rival at the noise floor has all but ruled out, and for pairs.
pub const BRIEF: Depth = Depth {
    look: 2,
    look_share: LOOK_SHARE,
    followed: 1,
    climb: 5,
    nuisances: Nuisances::Some,
    fixed_looks: true,
    belief: 1.0,
};
/// For effects of which one alone does not explain the data: the reference model is held to what is believed of it.
pub const HELD: Depth = Depth {
    look_share: 1.0,
    belief: FIRM,
    ..BRIEF
};
/// For a second effect that may hide behind one that explains the data: near what is known.
pub const HIDDEN: Depth = Depth {
    nuisances: Nuisances::Calibrated,
    fixed_looks: false,
    ..BRIEF
};

impl Depth {
    /// The effort of a first look at a start.
    pub(super) fn first_look(self) -> Effort {
        Effort {
            share: self.look_share,
            revive: false,
            belief: if self.fixed_looks { FIRM } else { 1.0 },
            reference: !self.fixed_looks,
            ..effort(self.look)
        }
    }

    /// The effort of a fit that is followed, with so many Jacobians.
    pub(super) fn following(self, iterations: usize) -> Effort {
        Effort {
            belief: self.belief,
            ..effort(iterations)
        }
    }
}

/// Ways to choose an effect: one for each value of its settings that are switches.
pub fn variants(session: &Session, effect: usize) -> Vec<Choice> {
    let card = &session.catalogue[effect];
    let is_profile = card.parameters.iter().any(|p| p.role == Role::Node);
    let switch = card
        .parameters
        .iter()
        .position(|p| p.role == Role::Setting && p.min == 0.0 && p.max == 1.0);
    match switch {
        Some(index) if !is_profile => (0..2)
            .map(|v| Choice {
                effect,
                settings: vec![(index, f64::from(v))],
            })
            .collect(),
        _ => vec![Choice {
            effect,
            settings: Vec::new(),
        }],
    }
}

/// All ways to choose one effect of the catalogue.
pub fn all_variants(session: &Session) -> Vec<Choice> {
    variants_of(session, |effect| !is_term(&effect.id))
}

/// All ways to choose one of the effects `wanted`.
pub fn variants_of(session: &Session, wanted: impl Fn(&Candidate) -> bool) -> Vec<Choice> {
    (0..session.catalogue.len())
        .filter(|&effect| wanted(&session.catalogue[effect]))
        .flat_map(|effect| variants(session, effect))
        .collect()
}

/// Fits the reference model with `known` effects and the last of `choices` newly added.
///
/// `base` is the fit without the new effect, on the same shots; the search starts from it with the effect
/// nearly off, and from the priors with the effect at practical strengths.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn search(
    session: &Session,
    choices: &[Choice],
    shots: &[Shot],
    base: &Trial,
    depth: Depth,
) -> Result<Trial, Error> {
    let hypothesis = session.hypothesis(choices)?;
    let new = choices.last().expect("a search adds an effect").effect;
    let data = session.data(shots);
    let mut predictor = session.predictor(&hypothesis)?;
    let starts = starts(
        session,
        &hypothesis,
        new,
        base,
        &data,
        &mut predictor,
        depth,
    );
    let mut looker = Looker::new(&hypothesis, &data, depth);
    let looks = looker.look(&mut predictor, starts);
    // Beside a model that is down to the noise without it an effect can only be weak.
    let is_new = !base.hypothesis.choices.iter().any(|c| c.effect == new);
    let is_weak = is_new && data.quantile(&base.fit, 0.5) <= FLOOR_MEDIAN;
    let is_hopeless = |look: &Fit| is_weak && data.quantile(look, 0.5) > FAR;
    if !looker.has_arrived() {
        let open = looks.iter().filter(|look| !is_hopeless(look));
        for look in open.take(depth.followed) {
            looker.follow(&mut predictor, look.point.clone(), base.fit.trimmed);
        }
    }
    let mut best = looker.best;
    let can_be_off = session.catalogue[new].find_role(Role::Amplitude).is_some();
    if let (None, Some(look), false) = (&best, looks.first(), can_be_off) {
        // As it stands: there is nothing to return to, and the model without it explains the data.
        let mut fitter = Fitter::new(&mut predictor, &hypothesis, &data, effort(0));
        let fit = fitter.run(look.point.clone());
        return Ok(Trial { hypothesis, fit });
    }
    // Never worse than without the effect.
    if best.as_ref().is_none_or(|b| b.trimmed > base.fit.trimmed) {
        let off = switched_off(session, &hypothesis, base, shots);
        let fit = Fitter::new(
            &mut predictor,
            &hypothesis,
            &data,
            depth.following(depth.look),
        )
        .run(off);
        keep_better(&mut best, fit);
    }
    let fit = best.expect("there is at least one start");
    Ok(Trial { hypothesis, fit })
}

/// Fits a hypothesis whose last effect is periodic from the fit of another that holds all the others, at the frequency or
/// wavelength `value` there; `None` where the model shows no response to it.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn at_line(
    session: &Session,
    choices: &[Choice],
    shots: &[Shot],
    lender: &Trial,
    value: f64,
) -> Result<Option<Trial>, Error> {
    let hypothesis = session.hypothesis(choices)?;
    let effect = &session.catalogue[choices.last().expect("a periodic effect").effect];
    let data = session.data(shots);
    let mut predictor = session.predictor(&hypothesis)?;
    let start = start_at_line(&hypothesis, effect, &data, &mut predictor, lender, value);
    let Some(start) = start else {
        return Ok(None);
    };
    let fit = Fitter::new(&mut predictor, &hypothesis, &data, effort(CLIMB)).run(start);
    Ok(Some(Trial { hypothesis, fit }))
}

/// The fit of the reference model itself, held to what is believed of it in the first look and, by `belief`, after.
///
/// # Errors
/// An FMU that can't be instantiated.
pub fn baseline(session: &Session, shots: &[Shot], belief: f64) -> Result<Trial, Error> {
    let hypothesis = session.hypothesis(&[])?;
    let data = session.data(shots);
    let mut predictor = session.predictor(&hypothesis)?;
    let start = Point::centre(&hypothesis, shots);
    let look = Effort {
        share: LOOK_SHARE,
        revive: false,
        belief: FIRM,
        ..effort(LOOK)
    };
    let seen = Fitter::new(&mut predictor, &hypothesis, &data, look).run(start);
    let mut fitter = Fitter::new(
        &mut predictor,
        &hypothesis,
        &data,
        Effort {
            belief,
            ..effort(CLIMB)
        },
    );
    let settled = fitter.settle(seen.point);
    let fit = fitter.run(settled.point);
    Ok(Trial { hypothesis, fit })
}

/// The point of a smaller hypothesis that a larger one's point is without what it adds: shared and own knobs and
/// states of the smaller come first in the larger.
pub fn narrowed(h: &Hypothesis, from: &Point, shots: &[Shot]) -> Point {
    let mut start = Point::centre(h, shots);
    start.shared.copy_from_slice(&from.shared[..h.shared.len()]);
    for (own, theirs) in start.own.iter_mut().zip(&from.own) {
        let count = own.len();
        own.copy_from_slice(&theirs[..count]);
    }
    for (state, theirs) in start.states.iter_mut().zip(&from.states) {
        let count = state.len();
        state.copy_from_slice(&theirs[..count]);
    }
    start.stuck.clone_from(&from.stuck);
    start
}

/// A point of the larger hypothesis that agrees with a point of the smaller one.
pub fn widen(base: &Trial, hypothesis: &Hypothesis, point: &Point) -> Point {
    let mut out = point.clone();
    for (i, knob) in base.hypothesis.shared.iter().enumerate() {
        if let Some(j) = hypothesis.shared_index(&knob.name) {
            out.shared[j] = base.fit.point.shared[i];
        }
    }
    for (run, knobs) in base.hypothesis.own.iter().enumerate() {
        let known = &base.fit.point.own[run];
        widen_own(knobs, known, &hypothesis.own[run], &mut out.own[run]);
    }
    for (state, known) in out.states.iter_mut().zip(&base.fit.point.states) {
        widen_state(&base.hypothesis, known, hypothesis, state);
    }
    out.stuck.clone_from(&base.fit.point.stuck);
    out
}

/// What a run has of its own under a larger hypothesis, as under a smaller one; what that lacks stays as it is.
pub fn widen_own(smaller: &[Knob], known: &[f64], larger: &[Knob], own: &mut [f64]) {
    for (knob, value) in smaller.iter().zip(known) {
        if let Some(i) = larger.iter().position(|k| k.name == knob.name) {
            own[i] = *value;
        }
    }
}

/// The start state of a shot under a larger hypothesis that agrees with that under a smaller one; other states of effects
/// stay as they are.
pub fn widen_state(smaller: &Hypothesis, known: &[f64], larger: &Hypothesis, state: &mut [f64]) {
    let modal = 2 * larger.modes;
    state[..modal].copy_from_slice(&known[..modal]);
    for (i, (reference, _)) in smaller.extra_states.iter().enumerate() {
        let same = larger.extra_states.iter().position(|s| s.0 == *reference);
        if let Some(j) = same {
            state[modal + j] = known[modal + i];
        }
    }
}
