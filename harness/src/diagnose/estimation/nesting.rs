//! Points of nested hypotheses: what a smaller one knows, carried over to a larger one, and back.

use crate::diagnose::data::segment::Segment;
use crate::diagnose::estimation::fit::FittedHypothesis;
use crate::diagnose::model::hypothesis::Hypothesis;
use crate::diagnose::model::parameter::Parameter;
use crate::diagnose::model::point::Point;
use crate::diagnose::model::profile_values::{follow_profile, have_same_places, values_along};

/// The point of a smaller hypothesis that a larger one's point is without what it adds: shared and own parameters and
/// states of the smaller come first in the larger.
pub fn narrowed(h: &Hypothesis, from: &Point, segments: &[Segment]) -> Point {
    let mut start = Point::centre(h, segments);
    start.shared.copy_from_slice(&from.shared[..h.shared.len()]);
    for (per_run, theirs) in start.per_run.iter_mut().zip(&from.per_run) {
        let count = per_run.len();
        per_run.copy_from_slice(&theirs[..count]);
    }
    for (state, theirs) in start.states.iter_mut().zip(&from.states) {
        let count = state.len();
        state.copy_from_slice(&theirs[..count]);
    }
    start.stuck.clone_from(&from.stuck);
    start
}

/// A point of the larger hypothesis that agrees with a point of the smaller one.
pub fn widen(base: &FittedHypothesis, hypothesis: &Hypothesis, point: &Point) -> Point {
    let mut out = point.clone();
    for (i, parameter) in base.hypothesis.shared.iter().enumerate() {
        if let Some(j) = hypothesis.shared_index(&parameter.name) {
            out.shared[j] = base.fit.point.shared[i];
        }
    }
    for (run, own) in out.per_run.iter_mut().enumerate() {
        let known = &base.fit.point.per_run[run];
        let (few, all) = (&base.hypothesis.per_run[run], &hypothesis.per_run[run]);
        widen_per_run((few, known), all, own);
    }
    for (state, known) in out.states.iter_mut().zip(&base.fit.point.states) {
        widen_state(&base.hypothesis, known, hypothesis, state);
    }
    out.stuck.clone_from(&base.fit.point.stuck);
    out
}

/// What a run has of its own under a larger hypothesis, as under a smaller one; what that lacks stays as it is.
pub fn widen_per_run((few, known): (&[Parameter], &[f64]), all: &[Parameter], own: &mut [f64]) {
    for (parameter, value) in few.iter().zip(known) {
        if let Some(i) = all.iter().position(|k| k.name == parameter.name) {
            own[i] = *value;
        }
    }
    if !have_same_places(few, all) {
        follow_profile(all, &values_along(few, known), own);
    }
}

/// The start state of a segment under a larger hypothesis that agrees with that under a smaller one; other states of effects
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
