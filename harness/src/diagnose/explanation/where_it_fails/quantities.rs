//! The six quantities and their intervals.

use super::level::{BySegment, LEAST, Level, sorted};
use crate::diagnose::data::contact_phase::ContactPhase;
use crate::diagnose::explanation::misses::Miss;
use crate::diagnose::explanation::replay::Replay;
use crate::diagnose::explanation::spectrum::over_noise;
use crate::diagnose::model::problem::Problem;
use crate::report::number;
use std::collections::BTreeMap;

/// Intervals of displacement.
pub const ROWS: usize = 6;
/// Stick, and intervals of the relative velocity in slip.
pub const COLUMNS: usize = 7;
/// Intervals of time.
const TIMES: usize = 10;
/// Intervals of belt travel of each run, at most.
const PLACES: usize = 8;

pub fn by_contact_phase(misses: &[Miss]) -> Vec<Level> {
    let place = |phase: ContactPhase| match phase {
        ContactPhase::Stick => "in stick",
        ContactPhase::BreakAway => "at break-away",
        ContactPhase::Accelerating => "in slip that grows faster",
        ContactPhase::Decelerating => "in slip that grows slower",
        ContactPhase::Arrival => "at arrival (re-stick)",
    };
    let slot = |m: &Miss| ContactPhase::ALL.iter().position(|p| *p == m.contact_phase);
    let found = sorted(misses.iter().map(|m| (slot(m), m.segment, m.size)), 5);
    let levels = ContactPhase::ALL.iter().zip(&found);
    levels
        .enumerate()
        .map(|(i, (p, b))| Level::new(place(*p).to_owned(), i as f64, 0, b))
        .collect()
}

/// Equal intervals of what values cover.
#[derive(Debug, Clone, Copy)]
struct Intervals {
    low: f64,
    width: f64,
    count: usize,
}

impl Intervals {
    fn over(values: impl Iterator<Item = f64>, count: usize) -> Intervals {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
            (l.min(v), h.max(v))
        });
        Intervals {
            low,
            width: (high - low) / count as f64,
            count,
        }
    }

    fn slot(&self, value: f64) -> Option<usize> {
        let at = (value - self.low) / self.width;
        at.is_finite()
            .then(|| (at.max(0.0) as usize).min(self.count - 1))
    }

    fn edges(&self, i: usize) -> (f64, f64) {
        let edge = |i: usize| self.low + self.width * i as f64;
        (edge(i), edge(i + 1))
    }
}

/// `12.5 to 15.0 mm`, of values times `factor`: as many decimals as tell the edges apart.
fn range((from, to): (f64, f64), factor: f64, unit: &str) -> String {
    let width = factor * (to - from);
    let decimals = (-(width / 5.0).log10()).ceil().clamp(0.0, 9.0) as usize;
    let show = |v: f64| {
        let text = format!("{:.decimals$}", factor * v);
        // What rounds to zero has no sign.
        match text.parse() {
            Ok(0.0) => text.trim_start_matches('-').to_owned(),
            _ => text,
        }
    };
    format!("{} to {} {unit}", show(from), show(to))
}

fn middle((from, to): (f64, f64)) -> f64 {
    0.5 * (from + to)
}

pub fn by_plane(misses: &[Miss]) -> Vec<Level> {
    let sticks = |m: &Miss| m.contact_phase == ContactPhase::Stick;
    let rows = Intervals::over(misses.iter().map(|m| m.displacement), ROWS);
    let slips = misses.iter().filter(|m| !sticks(m));
    let columns = Intervals::over(slips.map(|m| m.relative_velocity), COLUMNS - 1);
    let slot = |m: &Miss| {
        let column = match sticks(m) {
            true => 0,
            false => 1 + columns.slot(m.relative_velocity)?,
        };
        Some(rows.slot(m.displacement)? * COLUMNS + column)
    };
    let sizes = misses.iter().map(|m| (slot(m), m.segment, m.size));
    let found = sorted(sizes, ROWS * COLUMNS);
    let place = |i: usize| {
        let w = range(rows.edges(i / COLUMNS), 1e3, "mm");
        match i % COLUMNS {
            0 => format!("in stick at a displacement of {w}"),
            c => format!(
                "at a relative velocity of {} and a displacement of {w}",
                range(columns.edges(c - 1), 1.0, "m/s")
            ),
        }
    };
    let level = |(i, b): (usize, &BySegment)| {
        let at = match i % COLUMNS {
            0 => 0.0,
            c => middle(columns.edges(c - 1)),
        };
        Level::new(place(i), at, 0, b)
    };
    found.iter().enumerate().map(level).collect()
}

/// Middles of the displacement's intervals in mm, for the picture of [`by_plane`].
pub fn rows_of_plane(misses: &[Miss]) -> Vec<f64> {
    let rows = Intervals::over(misses.iter().map(|m| m.displacement), ROWS);
    (0..ROWS).map(|i| 1e3 * middle(rows.edges(i))).collect()
}

pub fn by_place(problem: &Problem, misses: &[Miss]) -> Vec<Level> {
    let mut out = Vec::new();
    for (r, run) in problem.campaign.runs.iter().enumerate() {
        let here = || misses.iter().filter(|m| m.run == r);
        let segments: std::collections::BTreeSet<usize> = here().map(|m| m.segment).collect();
        // A prediction passes a part of the belt only, so that each interval must be left enough of them.
        let count = (segments.len() / LEAST).clamp(1, PLACES);
        let intervals = Intervals::over(here().map(|m| m.travel), count);
        let sizes = here().map(|m| (intervals.slot(m.travel), m.segment, m.size));
        for (i, found) in sorted(sizes, count).iter().enumerate() {
            let edges = intervals.edges(i);
            let place = format!("from {} of belt travel", range(edges, 1e3, "mm"));
            let level = Level::new(place, 1e3 * middle(edges), r, found);
            out.push(level.within(&run.name));
        }
    }
    out
}

pub fn by_time(misses: &[Miss]) -> Vec<Level> {
    let intervals = Intervals::over(misses.iter().map(|m| m.time), TIMES);
    let sizes = misses
        .iter()
        .map(|m| (intervals.slot(m.time), m.segment, m.size));
    let level = |(i, b): (usize, &BySegment)| {
        let edges = intervals.edges(i);
        let place = format!("from {} after the run began", range(edges, 1.0, "s"));
        Level::new(place, middle(edges), 0, b)
    };
    sorted(sizes, TIMES).iter().enumerate().map(level).collect()
}

pub fn by_operating_point(problem: &Problem, misses: &[Miss]) -> Vec<Level> {
    let runs = &problem.campaign.runs;
    let same = |a: usize, b: usize| {
        runs[a].belt_velocity == runs[b].belt_velocity
            && runs[a].normal_force == runs[b].normal_force
    };
    let first = |r: usize| (0..=r).find(|&q| same(q, r));
    let sizes = misses.iter().map(|m| (first(m.run), m.segment, m.size));
    let found = sorted(sizes, runs.len());
    let level = |(r, b): (usize, &BySegment)| {
        let (speed, force) = (runs[r].belt_velocity, runs[r].normal_force);
        let place = format!("at {} m/s and {} N", number(speed, 3), number(force, 3));
        Level::new(place, r as f64, 0, b)
    };
    found
        .iter()
        .enumerate()
        .filter(|(_, b)| !b.is_empty())
        .map(level)
        .collect()
}

/// Octaves from the lowest frequency that a prediction resolves.
pub fn by_frequency(problem: &Problem, replays: &BTreeMap<usize, Replay>) -> Vec<Level> {
    let lines = over_noise(problem, replays);
    let lowest = problem.horizon.recip();
    // The lines lie at whole multiples of the lowest; each interval ends below its upper edge.
    let slot = |f: f64| Some((f / lowest + 0.5).log2().floor().max(0.0) as usize);
    let sizes = lines
        .iter()
        .map(|l| (slot(l.frequency), l.segment, l.ratio));
    let highest = lines.iter().map(|l| l.frequency).fold(0.0, f64::max);
    let count = slot(highest).map_or(0, |s| s + 1);
    let level = |(i, b): (usize, &BySegment)| {
        let from = lowest * 2f64.powi(i as i32);
        let edges = (from, (2.0 * from).min(highest.max(from)));
        let place = format!("from {}", range(edges, 1.0, "Hz"));
        Level::new(place, middle(edges), 0, b)
    };
    sorted(sizes, count).iter().enumerate().map(level).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_of_intervals_have_the_decimals_that_tell_them_apart() {
        assert_eq!(range((0.0025, 0.003_07), 1e3, "mm"), "2.5 to 3.1 mm");
        assert_eq!(range((-0.485, -0.32), 1.0, "m/s"), "-0.48 to -0.32 m/s");
        assert_eq!(range((-1e-9, 0.05), 1.0, "s"), "0.00 to 0.05 s");
        assert_eq!(range((3200.0, 5000.0), 1.0, "Hz"), "3200 to 5000 Hz");
    }

    #[test]
    fn intervals_hold_what_they_cover() {
        let intervals = Intervals::over([1.0, 3.0, 2.0].into_iter(), 4);
        assert_eq!(intervals.slot(1.0), Some(0));
        assert_eq!(intervals.slot(3.0), Some(3));
        assert_eq!(intervals.edges(1), (1.5, 2.0));
        // Nothing to divide, and nothing at all.
        assert_eq!(Intervals::over([1.0].into_iter(), 4).slot(1.0), None);
        assert_eq!(Intervals::over(std::iter::empty(), 4).slot(1.0), None);
    }
}
