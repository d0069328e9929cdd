//! Segments: short pieces of a run, each predicted from a start state of its own.
//!
//! Free simulation over a whole run says nothing once the motion is irregular; over 20 ms the
//! prediction depends on the model and not on rounding. Segments start far from transitions and follow one
//! another over the whole run.

use crate::measurement::{BESIDE_JUMP, DelayBelief, Measurand, Run};
use crate::observer::{Phase, PhaseMode};
use crate::smoothing::Smoothing;
use serde::Serialize;
use std::ops::Range;

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
    /// What further sensors read at these times.
    pub further: Vec<FurtherPart>,
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

/// What a further sensor read, over a scale that gives its noise the size of the first sensor's: so all count alike in one sum of squares.
#[derive(Debug, Clone, Serialize)]
pub struct FurtherPart {
    /// Number of the sensor.
    pub sensor: usize,
    /// Its values over `scale`; zero where they do not count.
    pub measured: Vec<f64>,
    /// Whether a value counts.
    pub trusted: Vec<bool>,
    /// The sensor's unit per unit of the first one.
    pub scale: f64,
    /// Largest distance of the run's values from their mean, over `scale`.
    pub reach: f64,
    /// Samples by which its clock may be off.
    pub most_delay: usize,
}

impl FurtherPart {
    /// Those of some samples. At the ends a clock that is off may ask for times that are not predicted.
    fn piece(&self, range: Range<usize>) -> Self {
        let inner = range.start + self.most_delay..range.end.saturating_sub(self.most_delay);
        let counts = |k: usize| inner.contains(&k) && self.trusted[k];
        let value = |k: usize| if counts(k) { self.measured[k] } else { 0.0 };
        Self {
            measured: range.clone().map(value).collect(),
            trusted: range.map(counts).collect(),
            ..*self
        }
    }

    /// The same readings, believed to be `times` as uncertain.
    pub fn loosen(&mut self, times: f64) {
        self.scale *= times;
        self.reach /= times;
        self.measured.iter_mut().for_each(|y| *y /= times);
    }
}

/// Largest distance of values from their mean.
pub fn reach(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    values.map(|y| (y - mean).abs()).fold(0.0, f64::max)
}

/// Share of a sample by which a whole number of them may seem more.
const ROUNDING: f64 = 1e-9;

/// What the further sensors read in a run whose first sensor has a noise of `noise`, in its unit. What was not read does not count, nor what
/// jumps beside a transition, as far from it as a clock may be off too.
pub fn further_parts(
    run: &Run,
    smoothing: &Smoothing,
    noise: f64,
    delays: &[DelayBelief],
) -> Vec<FurtherPart> {
    let trusted = vec![true; run.time.len()];
    let record = Record::of(0, run, &trusted, smoothing, &[]);
    let records = run.further.iter().enumerate();
    let read = records.filter_map(|(sensor, record)| Some((sensor, record.as_ref()?)));
    read.map(|(sensor, read)| {
        let scale = read.noise_std / noise;
        let most_delay = delays[sensor].most / record.interval;
        let counts = |k: usize| {
            let beside = read.beside_jump + most_delay;
            let is_beside = read.beside_jump > 0.0 && record.is_beside(k, beside);
            read.values[k].is_finite() && !is_beside
        };
        let trusted: Vec<bool> = (0..run.time.len()).map(counts).collect();
        let values = read.values.iter().zip(&trusted);
        FurtherPart {
            sensor,
            measured: values
                .map(|(y, counts)| if *counts { y / scale } else { 0.0 })
                .collect(),
            trusted,
            scale,
            reach: reach(read.values.iter().copied().filter(|y| y.is_finite())) / scale,
            most_delay: (most_delay - ROUNDING).ceil() as usize,
        }
    })
    .collect()
}

/// Distance in s from a transition that is far enough for a start, ...
const FAR: f64 = 1.5e-3;
/// ... and that is too near.
const NEAR: f64 = 3e-4;
/// Longest segment in multiples of the horizon.
const LONGEST: usize = 2;

/// A record of which pieces are taken, with what its smoother found.
struct Record<'a> {
    run: usize,
    /// Place of the first sample within the run.
    first: usize,
    time: &'a [f64],
    measured: &'a [f64],
    trusted: &'a [bool],
    smoothing: &'a Smoothing,
    further: &'a [FurtherPart],
    /// Sample interval of the run in s.
    interval: f64,
}

impl<'a> Record<'a> {
    /// A whole run.
    fn of(
        index: usize,
        run: &'a Run,
        trusted: &'a [bool],
        smoothing: &'a Smoothing,
        further: &'a [FurtherPart],
    ) -> Self {
        Self {
            run: index,
            first: 0,
            time: &run.time,
            measured: &run.measured,
            trusted,
            smoothing,
            further,
            interval: run.sample_interval(),
        }
    }

    /// Place of sample `k` on the smoother's grid.
    fn slot(&self, k: usize) -> usize {
        ((self.time[k] - self.smoothing.first_time) / self.interval).round() as usize
    }

    fn phases(&self) -> &[Phase] {
        &self.smoothing.stick_slip.phases
    }

    /// Time in s of sample `k` on the smoother's grid.
    fn grid_time(&self, k: usize) -> f64 {
        self.slot(k) as f64 * self.interval
    }

    /// Distance in s of sample `k` from the nearest transition.
    fn clearance(&self, k: usize) -> f64 {
        let t = self.grid_time(k);
        let begins = self.phases().iter().skip(1);
        begins
            .map(|p| (p.start - t).abs())
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether sample `k` lies within so many samples of a transition.
    fn is_beside(&self, k: usize, samples: f64) -> bool {
        self.clearance(k) <= samples * self.interval
    }

    /// The sample of `range` that counts, is `allowed` and lies furthest from transitions, up to what is far enough; of several the
    /// one nearest to sample `near`.
    fn clearest(
        &self,
        range: Range<usize>,
        near: usize,
        allowed: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        let far = |k: usize| self.clearance(k).min(FAR);
        let best = |all: &dyn Fn(usize) -> bool| {
            let some = range.clone().filter(|&k| self.trusted[k] && allowed(k));
            some.filter(|&k| all(k)).max_by(|&a, &b| {
                let by_place = b.abs_diff(near).cmp(&a.abs_diff(near));
                far(a).total_cmp(&far(b)).then(by_place)
            })
        };
        // Fits use every so many-th sample from the start on: one at which slower sensors read too, where there is one.
        best(&|k| self.further.iter().all(|part| part.trusted[k])).or_else(|| best(&|_| true))
    }

    /// The phase of the contact at sample `k`; `None` before the first.
    fn phase(&self, k: usize) -> Option<&Phase> {
        let t = self.grid_time(k);
        self.phases().iter().rev().find(|p| p.start <= t)
    }

    fn slips(&self, k: usize) -> bool {
        self.phase(k).is_some_and(|p| p.mode != PhaseMode::Stick)
    }

    /// Distance in m that belt and tip have moved against each other until sample `k`.
    fn travel(&self, k: usize) -> f64 {
        let tip = &self.smoothing.stick_slip.smoothed.displacement;
        let moved = tip[self.slot(k).min(tip.len() - 1)] - tip[0];
        self.belt_distance(k) - moved
    }

    fn belt_distance(&self, k: usize) -> f64 {
        let belt = &self.smoothing.belt_path;
        belt.at(self.time[k] - self.smoothing.first_time)
    }

    fn piece(&self, range: Range<usize>) -> Segment {
        let (first, last) = (range.start, range.end - 1);
        let phase = self.phase(first).unwrap_or(&self.phases()[0]);
        let stuck = phase.mode == PhaseMode::Stick;
        let smoothed = &self.smoothing.stick_slip.smoothed;
        let slot = self.slot(first);
        let modes = smoothed.q.iter().zip(&smoothed.q_dot);
        let trusted = self.trusted[range.clone()].to_vec();
        Segment {
            run: self.run,
            first: self.first + first,
            time: self.time[range.clone()].to_vec(),
            measured: self.measured[range.clone()].to_vec(),
            further: self
                .further
                .iter()
                .map(|f| f.piece(range.clone()))
                .collect(),
            count: trusted.iter().filter(|&&t| t).count(),
            trusted,
            stuck,
            dwell: match stuck {
                true => self.grid_time(first) - phase.start,
                false => 0.0,
            },
            travel: self.travel(first),
            travel_end: self.travel(last),
            belt_distance: self.belt_distance(first),
            state: modes.flat_map(|(q, v)| [q[slot], v[slot]]).collect(),
        }
    }
}

/// Cuts a run into segments of `horizon` s to twice that.
///
/// A segment starts in slip where it can: slipping, all modes show in the displacement, while in stick the
/// tip goes with the belt whatever the beam does inside, until it breaks away.
pub fn cut(
    (index, run): (usize, &Run),
    smoothing: &Smoothing,
    further: &[FurtherPart],
    horizon: f64,
) -> Vec<Segment> {
    let interval = run.sample_interval();
    let mut trusted = run.trusted();
    let length = (horizon / interval).round() as usize;
    if run.measurand == Measurand::Acceleration {
        let record = Record::of(index, run, &trusted, smoothing, further);
        let beside = (0..trusted.len()).filter(|&k| record.is_beside(k, BESIDE_JUMP));
        let beside: Vec<usize> = beside.collect();
        beside.into_iter().for_each(|k| trusted[k] = false);
    }
    let record = Record::of(index, run, &trusted, smoothing, further);
    let best = |window: Range<usize>, slip: bool| {
        let begin = window.start;
        record.clearest(window, begin, |k| record.slips(k) == slip)
    };
    // The first samples are the smoother's worst, so the first segment starts a little later.
    let margin = (length / 20).max(4);
    let mut starts = Vec::new();
    let mut at = margin;
    while at + length <= run.time.len() {
        let last = run.time.len() - length + 1;
        let near = best(at..(at + length / 5).min(last), true)
            .or_else(|| best(at..(at + length * LONGEST).min(last), true))
            .filter(|&k| record.clearance(k) > NEAR);
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
    (0..starts.len())
        .map(|i| record.piece(starts[i]..end_of(i)))
        .collect()
}

impl Segment {
    /// Whether the segment begins no further behind another of its run than that one is long.
    pub fn follows(&self, before: &Segment) -> bool {
        self.run == before.run && self.first <= before.first + 2 * before.time.len()
    }

    /// Number of values that count, of all sensors.
    pub fn counted(&self) -> usize {
        let further = self.further.iter().flat_map(|part| &part.trusted);
        self.count + further.filter(|&&t| t).count()
    }

    /// Windows of about `length` samples that the segment falls into, each with a start of its own; the first starts where the
    /// segment does.
    pub fn windows(&self, smoothing: &Smoothing, interval: f64, length: usize) -> Vec<Segment> {
        let record = Record {
            run: self.run,
            first: self.first,
            time: &self.time,
            measured: &self.measured,
            trusted: &self.trusted,
            further: &self.further,
            smoothing,
            interval,
        };
        let count = self.time.len();
        let parts = (count / length).max(1);
        let reach = count / parts / 4;
        let start = |i: usize| {
            let even = i * count / parts;
            record.clearest(even - reach..even + reach + 1, even, |_| true)
        };
        let starts: Vec<usize> = std::iter::once(0)
            .chain((1..parts).filter_map(start))
            .collect();
        let ends = starts.iter().skip(1).copied().chain([count]);
        let ranges = starts.iter().zip(ends);
        ranges.map(|(&a, b)| record.piece(a..b)).collect()
    }
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
