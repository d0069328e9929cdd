//! Segments: short pieces of a run, each predicted from a start state of its own.
//!
//! Free simulation over a whole run says nothing once the motion is irregular; over 20 ms the
//! prediction depends on the model and not on rounding. Segments start far from transitions and follow one
//! another over the whole run.

use crate::diagnose::data::smoothing::Smoothing;
use crate::measurement::{Measurand, Run};
use crate::observer::PhaseMode;
use serde::Serialize;

/// A piece of a run.
#[derive(Debug, Clone, Serialize)]
pub struct Segment {
    /// Index of the run.
    pub run: usize,
    /// First sample within the run.
    pub first: usize,
    /// Times in s; the first is the start.
    pub time: Vec<f64>,
    /// What was measured at these times, in m, m/s or m/s^2.
    pub measured: Vec<f64>,
    /// Whether a sample counts: clipped and held ones do not, nor accelerations beside a transition.
    pub trusted: Vec<bool>,
    /// Number of samples that count.
    pub count: usize,
    /// Whether the tip sticks at the start.
    pub stuck: bool,
    /// Time in s since stick began.
    pub dwell: f64,
    /// Distance in m that belt and tip have moved against each other since the run began.
    pub travel: f64,
    /// The same at the end of the segment.
    pub travel_end: f64,
    /// Distance in m that the belt has run when the segment starts.
    pub belt_distance: f64,
    /// Smoothed modal displacements in m and velocities in m/s: q_1, q_1', q_2, q_2', ...
    pub state: Vec<f64>,
}

/// Distance in s from a transition that is far enough for a start, ...
const FAR: f64 = 1.5e-3;
/// ... and that is too near.
const NEAR: f64 = 3e-4;
/// Distance in samples from a transition within which an acceleration does not count. It jumps there, by thousands of times the
/// noise, and of the two samples about a jump that moves a little within its interval each may lie on either side.
const BESIDE_JUMP: f64 = 1.5;
/// Longest segment in multiples of the horizon.
const LONGEST: usize = 2;

/// Cuts a run into segments of `horizon` s to twice that.
///
/// A segment starts in slip where it can: slipping, all modes show in the displacement, while in stick the
/// tip goes with the belt whatever the beam does inside, until it breaks away.
pub fn cut(index: usize, run: &Run, smoothing: &Smoothing, horizon: f64) -> Vec<Segment> {
    let h = run.sample_interval();
    let mut trusted = run.trusted();
    let length = (horizon / h).round() as usize;
    let s = &smoothing.stick_slip;
    let slot = |k: usize| ((run.time[k] - run.time[0]) / h).round() as usize;
    let clearance = |k: usize| {
        let t = slot(k) as f64 * h;
        s.phases
            .iter()
            .skip(1)
            .map(|p| (p.start - t).abs())
            .fold(f64::INFINITY, f64::min)
    };
    if run.measurand == Measurand::Acceleration {
        for (k, trusted) in trusted.iter_mut().enumerate() {
            *trusted &= clearance(k) > BESIDE_JUMP * h;
        }
    }
    let slips = |k: usize| {
        let t = slot(k) as f64 * h;
        let phase = s.phases.iter().rev().find(|p| p.start <= t);
        phase.is_some_and(|p| p.mode != PhaseMode::Stick)
    };
    // The best sample of a window: furthest from transitions, up to what is far enough.
    let best = |window: std::ops::Range<usize>, slip: bool| {
        window
            .filter(|&k| trusted[k] && slips(k) == slip)
            .max_by(|&a, &b| {
                clearance(a)
                    .min(FAR)
                    .total_cmp(&clearance(b).min(FAR))
                    .then(b.cmp(&a))
            })
    };
    // The first samples are the smoother's worst, so the first segment starts a little later.
    let margin = (length / 20).max(4);
    let mut starts = Vec::new();
    let mut at = margin;
    while at + length <= run.time.len() {
        let last = run.time.len() - length + 1;
        let near = best(at..(at + length / 5).min(last), true)
            .or_else(|| best(at..(at + length * LONGEST).min(last), true))
            .filter(|&k| clearance(k) > NEAR);
        match near.or_else(|| best(at..(at + length / 5).min(last), false)) {
            Some(k) => {
                starts.push(k);
                at = k + length;
            }
            None => at += length / 5 + 1,
        }
    }
    // A segment lasts until the next one starts, so that a long stick is followed to its break-away.
    let end_of = |i: usize| {
        let first = starts[i];
        let next = starts.get(i + 1).copied().unwrap_or(first + length);
        next.clamp(first + length, first + length * LONGEST)
    };
    let ends: Vec<usize> = (0..starts.len()).map(end_of).collect();
    let travel = |k: usize| {
        let displacement = s.smoothed.displacement[slot(k).min(s.smoothed.displacement.len() - 1)]
            - s.smoothed.displacement[0];
        smoothing.belt_path.at(run.time[k] - run.time[0]) - displacement
    };
    starts
        .into_iter()
        .zip(ends)
        .map(|(first, end)| {
            let range = first..end;
            let t = slot(first) as f64 * h;
            let phase = s
                .phases
                .iter()
                .rev()
                .find(|p| p.start <= t)
                .unwrap_or(&s.phases[0]);
            let stuck = phase.mode == PhaseMode::Stick;
            let mut state = Vec::new();
            for j in 0..s.smoothed.q.len() {
                state.push(s.smoothed.q[j][slot(first)]);
                state.push(s.smoothed.q_dot[j][slot(first)]);
            }
            Segment {
                run: index,
                first,
                time: run.time[range.clone()].to_vec(),
                measured: run.measured[range.clone()].to_vec(),
                count: trusted[range.clone()].iter().filter(|&&t| t).count(),
                trusted: trusted[range.clone()].to_vec(),
                stuck,
                dwell: if stuck { t - phase.start } else { 0.0 },
                travel: travel(first),
                travel_end: travel(end - 1),
                belt_distance: smoothing.belt_path.at(run.time[first] - run.time[0]),
                state,
            }
        })
        .collect()
}

/// At most `most` segments of a run, in groups of `group` neighbours spread evenly over it, those groups first in which
/// the contact changes its mode: a long record of stick teaches little more than a short one.
pub fn thin(
    segments: Vec<Segment>,
    smoothing: &Smoothing,
    most: usize,
    group: usize,
) -> Vec<Segment> {
    if segments.len() <= most {
        return segments;
    }
    let phases = &smoothing.stick_slip.phases;
    let changes = |segment: &Segment, origin: f64| {
        let (start, end) = (
            segment.time[0] - origin,
            segment.time[segment.time.len() - 1] - origin,
        );
        phases
            .iter()
            .skip(1)
            .any(|p| p.start > start && p.start < end)
    };
    let origin = smoothing.first_time;
    let groups: Vec<&[Segment]> = segments.chunks(group).collect();
    let (eventful, quiet): (Vec<usize>, Vec<usize>) =
        (0..groups.len()).partition(|&g| groups[g].iter().any(|s| changes(s, origin)));
    let wanted = (most / group).max(1);
    let evenly = |from: &[usize], count: usize| -> Vec<usize> {
        (0..count.min(from.len()))
            .map(|i| from[i * from.len() / count.min(from.len())])
            .collect()
    };
    let mut chosen = evenly(&eventful, wanted);
    chosen.extend(evenly(&quiet, wanted - chosen.len()));
    chosen.sort_unstable();
    chosen
        .into_iter()
        .flat_map(|g| groups[g].to_vec())
        .collect()
}
