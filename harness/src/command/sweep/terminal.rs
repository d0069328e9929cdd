//! The table on the terminal, and which motions coexist.

use std::fmt::Write as _;

use super::study::Study;
use super::table::Result;
use crate::report::{number, with_unit};

/// Points of a study that the terminal lists in full.
const LISTED: usize = 60;

/// Starts at one point that end in the same motion.
#[derive(Debug, Clone)]
pub struct Group {
    /// Parameter values.
    pub at: Vec<f64>,
    /// Share of the starts.
    pub share: f64,
    /// In words.
    pub name: String,
    /// Its period, if it moves.
    pub period: Option<usize>,
    /// Its main frequency, Hz.
    pub frequency: Option<f64>,
    /// Its amplitude, m.
    pub amplitude: Option<f64>,
}

/// `period 5`, `irregular`, `unresolved`, `no vibration`, `settling`, `failed`.
///
/// Irregular is what does not repeat and parts from its neighbours: its exponent is positive beyond the standard error. What
/// does not repeat and is not shown to do so is unresolved: quasi-periodic, or a long transient.
pub fn name(r: &Result) -> String {
    match (r.status.as_str(), r.period) {
        ("rest" | "dies_out", _) => "no vibration".into(),
        ("settling", _) => "settling".into(),
        ("no_section", _) => "does not meet the section".into(),
        // Tables of earlier versions call all that does not repeat ok.
        ("ok", Some(0)) if r.lyapunov.is_some_and(|l| l > 0.0) => "irregular".into(),
        ("unresolved", _) | ("ok", Some(0)) => "unresolved".into(),
        ("ok", Some(p)) => format!("period {p}"),
        _ => "failed".into(),
    }
}

/// Whether two results are the same motion: the same kind, main frequency within 1 %, amplitude within 1 % (within
/// 20 % where it is irregular, since its extremes are found only in time).
fn same(a: &Result, b: &Result) -> bool {
    let near = |a: Option<f64>, b: Option<f64>, share: f64| match (a, b) {
        (Some(a), Some(b)) => (a - b).abs() <= share * a.abs().max(b.abs()),
        (None, None) => true,
        _ => false,
    };
    let loose = if a.period == Some(0) { 20.0 } else { 1.0 };
    name(a) == name(b)
        && (name(a) == "no vibration"
            || near(a.main_frequency, b.main_frequency, 0.01 * loose)
                && near(a.amplitude, b.amplitude, 0.01 * loose))
}

/// The motions at each point with the share of its starts that reach them, the largest first.
pub fn coexisting(study: &Study) -> Vec<Group> {
    let mut all = Vec::new();
    let mut points: Vec<&[f64]> = Vec::new();
    for row in study.rows {
        if points.last() != Some(&row.at.as_slice()) {
            points.push(&row.at);
        }
    }
    for at in points {
        let here: Vec<&Result> = study
            .rows
            .iter()
            .zip(&study.results)
            .filter(|(row, _)| row.at == at)
            .map(|(_, r)| r)
            .collect();
        let mut groups: Vec<(&Result, usize)> = Vec::new();
        for r in &here {
            match groups.iter_mut().find(|(g, _)| same(g, r)) {
                Some((_, count)) => *count += 1,
                None => groups.push((r, 1)),
            }
        }
        groups.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
        all.extend(groups.into_iter().map(|(r, count)| Group {
            at: at.to_vec(),
            share: count as f64 / here.len() as f64,
            name: name(r),
            period: r.period,
            frequency: r.main_frequency,
            amplitude: r.amplitude,
        }));
    }
    all
}

/// A line per row, or for large studies how often each kind of motion occurs.
pub fn summary(study: &Study) -> String {
    let mut text = String::new();
    if study.rows.len() <= LISTED {
        for axis in &study.plan.axes {
            let _ = write!(text, "{:>16}  ", axis.name);
        }
        text +=
            "start                 motion            main freq.   amplitude   stick   exponent\n";
        for (row, r) in study.rows.iter().zip(&study.results) {
            for (axis, value) in study.plan.axes.iter().zip(&row.at) {
                let _ = write!(text, "{:>16}  ", format!("{value} {}", axis.unit));
            }
            let or_dash =
                |v: Option<f64>, unit: &str| v.map_or("–".into(), |v| with_unit(v, unit));
            let _ = writeln!(
                text,
                "{:<20}  {:<16} {:>11} {:>11} {:>7} {:>10}",
                row.start,
                name(r),
                or_dash(r.main_frequency, "Hz"),
                or_dash(r.amplitude, "m"),
                r.stick_fraction.map_or("–".into(), |s| number(s, 3)),
                r.lyapunov.map_or("–".into(), exponent),
            );
        }
    } else {
        for (kind, count) in kinds(study) {
            let _ = writeln!(text, "{count:>8}  {kind}");
        }
    }
    for (row, r) in study.rows.iter().zip(&study.results) {
        if r.is_failed() {
            let _ = writeln!(text, "{}: {}", row.key(), r.status);
        }
    }
    text
}

/// An exponent in 1/s.
pub fn exponent(value: f64) -> String {
    if value == f64::NEG_INFINITY {
        "-inf".into()
    } else {
        format!("{} /s", number(value, 3))
    }
}

/// How often each kind of motion occurs, the most frequent first.
pub fn kinds(study: &Study) -> Vec<(String, usize)> {
    let mut kinds: Vec<(String, usize)> = Vec::new();
    for r in &study.results {
        let kind = name(r);
        match kinds.iter_mut().find(|(k, _)| *k == kind) {
            Some((_, count)) => *count += 1,
            None => kinds.push((kind, 1)),
        }
    }
    kinds.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    kinds
}
