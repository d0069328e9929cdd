//! Branches of periodic motions through what a study has found: `--orbits`.

use std::fmt::Write as _;

use beam_physics::sweep::Carry;
use beam_physics::sweep::orbit::{Branch, BranchEnd, BranchKind, BranchPoint, continue_branch};

use super::plan::{Plan, Row};
use super::table::Result;
use crate::watch::Watch;

/// Agreement of period and peak, as a share, from which on a motion lies on a branch that is known.
const SAME: f64 = 1e-4;

/// The branches of a study with one parameter.
#[derive(Debug, Default)]
pub struct Branches {
    /// The branches.
    pub all: Vec<Branch>,
    /// Motions through which no branch could be found, with reasons.
    pub problems: Vec<String>,
}

/// Follows every period-one motion found that no branch passes through yet.
pub fn find(
    plan: &Plan,
    rows: &[Row],
    results: &[Option<Result>],
    ends: &[Option<Carry>],
    watch: &dyn Watch,
) -> Branches {
    let mut found = Branches::default();
    let values = &plan.axes[0].values;
    let range = (
        values.iter().copied().fold(f64::INFINITY, f64::min),
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    );
    if !(range.1 > range.0) {
        return found;
    }
    let at = |value: f64| plan.values(&[value]).subject();
    for (i, row) in rows.iter().enumerate() {
        watch.step("branches of periodic motions", i, rows.len());
        if watch.stop() {
            break;
        }
        let (Some(result), Some(end)) = (&results[i], &ends[i]) else {
            continue;
        };
        if result.period != Some(1) || result.status != "ok" {
            continue;
        }
        let amplitude = result.amplitude.unwrap_or_default();
        if found
            .all
            .iter()
            .any(|b| passes(b, row.at[0], amplitude, range.1 - range.0))
        {
            continue;
        }
        match continue_branch(&at, row.at[0], &end.state, 1, range) {
            Ok(branch) => found.all.push(branch),
            Err(error) => found.problems.push(format!("{}: {error}", row.key())),
        }
    }
    found
}

/// Whether a branch passes a motion of this amplitude at this value.
fn passes(branch: &Branch, value: f64, amplitude: f64, width: f64) -> bool {
    branch.points.windows(2).any(|pair| {
        let (a, b) = (&pair[0], &pair[1]);
        let (low, high) = (a.parameter.min(b.parameter), a.parameter.max(b.parameter));
        let margin = 1e-9 * width;
        if value < low - margin || value > high + margin {
            return false;
        }
        let span = b.parameter - a.parameter;
        let share = if span == 0.0 {
            0.0
        } else {
            (value - a.parameter) / span
        };
        let there = a.orbit.amplitude + share * (b.orbit.amplitude - a.orbit.amplitude);
        // Between two orbits the branch bends by less than they differ.
        let bend = 0.1 * (b.orbit.amplitude - a.orbit.amplitude).abs();
        (there - amplitude).abs() < SAME * amplitude + bend
    })
}

/// orbits.csv: every orbit of every branch.
pub fn orbits_csv(plan: &Plan, branches: &Branches) -> String {
    let mut csv = format!(
        "branch,{},stable,period_s,displacement_m,amplitude_m,stick_fraction,largest_multiplier,multiplier_re,multiplier_im,sequence\n",
        plan.axes[0].name
    );
    for (k, branch) in branches.all.iter().enumerate() {
        for p in &branch.points {
            let o = &p.orbit;
            let (re, im) = o.multipliers.first().map_or((0.0, 0.0), |m| (m.re, m.im));
            let _ = writeln!(
                csv,
                "{},{},{},{},{},{},{},{},{re},{im},{}",
                k + 1,
                p.parameter,
                u8::from(o.is_stable()),
                o.period,
                o.displacement,
                o.amplitude,
                o.stick_fraction,
                o.largest(),
                o.sequence
            );
        }
    }
    csv
}

/// bifurcations.csv.
pub fn bifurcations_csv(plan: &Plan, branches: &Branches) -> String {
    let mut csv = format!(
        "branch,{},within,kind,displacement_m,changes_stability,sequence_before,sequence_after\n",
        plan.axes[0].name
    );
    for (k, branch) in branches.all.iter().enumerate() {
        for b in &branch.bifurcations {
            let (changes, from, to) = match &b.kind {
                BranchKind::Grazing {
                    from,
                    to,
                    changes_stability,
                } => (*changes_stability, from.as_str(), to.as_str()),
                _ => (true, "", ""),
            };
            let _ = writeln!(
                csv,
                "{},{},{},{},{},{},{from},{to}",
                k + 1,
                b.parameter,
                b.within,
                b.kind.word(),
                b.displacement,
                u8::from(changes)
            );
        }
    }
    csv
}

/// Stretches of a branch that are stable or not, as parameter and peak in mm.
pub fn stretches(branch: &Branch, stable: bool) -> (Vec<f64>, Vec<f64>) {
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let mut push = |p: &BranchPoint| {
        x.push(p.parameter);
        y.push(1e3 * p.orbit.displacement);
    };
    let mut open = false;
    for pair in branch.points.windows(2) {
        // A step belongs to what it starts from, so that the two kinds of stretches meet.
        if pair[0].orbit.is_stable() == stable {
            if !open {
                push(&pair[0]);
            }
            push(&pair[1]);
            open = true;
        } else if open {
            push(&BranchPoint {
                parameter: f64::NAN,
                ..pair[0].clone()
            });
            open = false;
        }
    }
    (x, y)
}

/// A kind of bifurcation for people.
pub fn words(kind: &BranchKind) -> String {
    match kind {
        BranchKind::Fold => "fold (multiplier +1)".into(),
        BranchKind::Flip => "flip, period doubling (multiplier -1)".into(),
        BranchKind::NeimarkSacker => "Neimark-Sacker (complex pair on the unit circle)".into(),
        BranchKind::Grazing {
            from,
            to,
            changes_stability,
        } => format!(
            "grazing: the sequence of modes changes from {} to {}{}",
            sequence(from),
            sequence(to),
            if *changes_stability {
                ", and stability with it"
            } else {
                ""
            }
        ),
    }
}

fn sequence(text: &str) -> &str {
    if text.is_empty() { "slip alone" } else { text }
}

/// Why a branch ends, for people.
pub fn end(end: &BranchEnd) -> &'static str {
    match end {
        BranchEnd::Range => "end of the range",
        BranchEnd::BreaksOff => "breaks off at a border of stick (no orbit found beyond)",
        BranchEnd::Long => "not followed further",
    }
}
