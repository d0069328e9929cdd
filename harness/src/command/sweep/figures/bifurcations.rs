//! Figures 5, 6 with its magnification, and 7: bifurcation diagrams.

use beam_physics::sweep::static_amplitude;

use super::claim::{Bound, Claim, Finding};
use super::second_frequency::SecondFrequency;
use super::{PaperFigure, Workshop};
use crate::command::sweep::pictures::bifurcation;
use crate::command::sweep::plan::StartKind;
use crate::command::sweep::study::Study;
use crate::command::sweep::terminal::name;
use crate::error::Error;
use crate::report::{Plot, number};

const STARTS: [StartKind; 4] = [
    StartKind::Fixed,
    StartKind::Up,
    StartKind::Down,
    StartKind::Grid,
];

/// What a diagram shows, counted over the rows of one kind of start.
struct Count {
    rows: usize,
    ones: usize,
    multiple: usize,
    irregular: usize,
    none: usize,
    /// Changes between period one and anything else along the parameter.
    changes: usize,
    /// Smallest and largest parameter with each period seen.
    periods: Vec<(usize, usize)>,
    frequencies: (f64, f64),
}

fn count(study: &Study, kind: StartKind) -> Count {
    let mut c = Count {
        rows: 0,
        ones: 0,
        multiple: 0,
        irregular: 0,
        none: 0,
        changes: 0,
        periods: Vec::new(),
        frequencies: (f64::INFINITY, f64::NEG_INFINITY),
    };
    let mut last = None;
    let rows = study.rows.iter().zip(&study.results);
    for (_, r) in rows.filter(|(row, _)| row.kind == kind) {
        c.rows += 1;
        let what = name(r);
        match what.as_str() {
            "period 1" => c.ones += 1,
            "no vibration" => c.none += 1,
            "irregular" => c.irregular += 1,
            _ => c.multiple += 1,
        }
        if let Some(p) = r.period.filter(|p| *p > 1 && r.status == "ok") {
            match c.periods.iter_mut().find(|(q, _)| *q == p) {
                Some((_, n)) => *n += 1,
                None => c.periods.push((p, 1)),
            }
        }
        if let Some(f) = r.main_frequency {
            c.frequencies = (c.frequencies.0.min(f), c.frequencies.1.max(f));
        }
        let one = what == "period 1";
        if last.is_some_and(|l| l != one) {
            c.changes += 1;
        }
        last = Some(one);
    }
    c.periods.sort_unstable();
    c
}

impl Count {
    /// Share of the points in %.
    fn share(&self, number: usize) -> f64 {
        100.0 * number as f64 / self.rows.max(1) as f64
    }

    /// Share in % of the points of neither period one nor rest.
    fn others(&self) -> f64 {
        self.share(self.multiple + self.irregular)
    }
}

fn said(c: &Count, from: &str) -> String {
    let periods: Vec<String> = c
        .periods
        .iter()
        .map(|(p, n)| format!("{p} ({n} times)"))
        .collect();
    format!(
        "Of {} points {from} {} are of period one, {} of longer periods, unresolved or still settling, {} irregular, {} without vibration; periods seen: {}",
        c.rows,
        c.ones,
        c.multiple,
        c.irregular,
        c.none,
        if periods.is_empty() {
            "none but one".into()
        } else {
            periods.join(", ")
        }
    )
}

/// Where, along the parameter, some start ends in a motion of 30 to 40 Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Main {
    /// Smallest and largest such parameter value.
    range: (f64, f64),
    /// Share of the points in %.
    share: f64,
}

fn main_range(study: &Study) -> Main {
    let mut points: Vec<(f64, bool)> = Vec::new();
    for (row, r) in study.rows.iter().zip(&study.results) {
        let is_main = r.vibrates() && r.main_frequency.is_some_and(|f| (30.0..=40.0).contains(&f));
        match points.last_mut() {
            Some((at, found)) if *at == row.at[0] => *found |= is_main,
            _ => points.push((row.at[0], is_main)),
        }
    }
    let with: Vec<f64> = points.iter().filter(|p| p.1).map(|p| p.0).collect();
    Main {
        range: with
            .iter()
            .fold((f64::NAN, f64::NAN), |(l, h), v| (v.min(l), v.max(h))),
        share: 100.0 * with.len() as f64 / points.len().max(1) as f64,
    }
}

fn wide_claim(main: Main, unit: &str) -> Claim {
    Claim::new(
        "The main frequency is about 40 Hz (section 4), and model and measurement coincide within a wide parameter range.",
        format!(
            "In this diagram a motion of 30 to 40 Hz exists, from any of the starts, only between {} and {} {unit}",
            number(main.range.0, 3),
            number(main.range.1, 3)
        ),
        vec![Finding::new(
            "share of the points of this diagram with a motion of 30 to 40 Hz from some start",
            main.share,
            "%",
            Bound::AtLeast(50.0),
            "a wide range is at least half of what the paper draws",
        )],
    )
}

/// How many points have different motions for different starts.
fn coexisting(study: &Study) -> (usize, usize) {
    let groups = crate::command::sweep::terminal::coexisting(study);
    let mut points: Vec<(&[f64], usize)> = Vec::new();
    for g in &groups {
        match points.last_mut() {
            Some((at, n)) if *at == g.at.as_slice() => *n += 1,
            _ => points.push((&g.at, 1)),
        }
    }
    (points.iter().filter(|(_, n)| *n > 1).count(), points.len())
}

fn picture(study: &Study) -> Plot {
    bifurcation(study)
}

/// The figures.
pub fn figures(workshop: &Workshop) -> Result<Vec<PaperFigure>, Error> {
    let frequency = SecondFrequency::new(workshop)?;
    Ok(vec![
        over_force(workshop)?,
        over_velocity(workshop, &frequency)?,
        magnified(workshop, frequency)?,
    ])
}

fn over_force(workshop: &Workshop) -> Result<PaperFigure, Error> {
    let axis = ("normal_force", "N", 5.0, 150.0, workshop.points(146));
    let set = [("belt_velocity", 0.06)];
    let ratio = |force: f64| {
        let values = workshop.values(&[("belt_velocity", 0.06), ("normal_force", force)]);
        values
            .model()
            .map_or(f64::NAN, |m| static_amplitude(&m) / force)
    };
    let (low, high) = (ratio(5.0), ratio(150.0));
    let (plot, count, both, main) = workshop.study("figure5", &[axis], &set, &STARTS, |s| {
        (
            picture(s),
            count(s, StartKind::Fixed),
            coexisting(s),
            main_range(s),
        )
    })?;
    Ok(PaperFigure {
        number: "5",
        title: "Bifurcations over the normal force (v0 = 60 mm/s)".into(),
        claims: vec![
            linear_claim(low, high),
            interrupted_claim(
                count.others(),
                count.changes,
                format!(
                    "{}; at {} of {} points the motion depends on the start. Whether a scenario is usual is not judged",
                    said(&count, "from the fixed start"),
                    both.0,
                    both.1
                ),
            ),
            wide_claim(main, "N"),
        ],
        pictures: vec![("figure5".into(), plot)],
    })
}

fn over_velocity(workshop: &Workshop, frequency: &SecondFrequency) -> Result<PaperFigure, Error> {
    let axis = ("belt_velocity", "m/s", 0.01, 0.21, workshop.points(161));
    let set = [("normal_force", 100.0)];
    let (plot, whole, both, main) = workshop.study("figure6", &[axis], &set, &STARTS, |s| {
        (
            picture(s),
            count(s, StartKind::Fixed),
            coexisting(s),
            main_range(s),
        )
    })?;
    // w_A over what eq. (8) has of the friction characteristic.
    let ratio = |v: f64| {
        let values = workshop.values(&[("normal_force", 100.0), ("belt_velocity", v)]);
        let mu = |v| values.friction_coefficient(v).unwrap_or(f64::NAN);
        let w = values.model().map_or(f64::NAN, |m| static_amplitude(&m));
        (w, w / (mu(0.0) - mu(v)))
    };
    let all: Vec<(f64, f64)> = (1..=21).map(|i| ratio(0.01 * f64::from(i))).collect();
    let axis = ("belt_velocity", "m/s", 0.06, 0.09, workshop.points(91));
    let (inset, near) = workshop.study("figure6_magnification", &[axis], &set, &STARTS, |s| {
        (picture(s), count(s, StartKind::Fixed))
    })?;
    Ok(PaperFigure {
        number: "6",
        title: "Bifurcations over the belt velocity (F_N = 100 N), and 60 to 90 mm/s".into(),
        claims: vec![
            characteristic_claim(
                &all,
                format!(
                    "{}; at {} of {} points the motion depends on the start",
                    said(&whole, "from the fixed start"),
                    both.0,
                    both.1
                ),
            ),
            strange_claim(
                near.others(),
                near.changes,
                frequency.share_strange(),
                format!(
                    "{}. {}",
                    said(&near, "from the fixed start"),
                    frequency.of_magnification()
                ),
            ),
            wide_claim(main, "m/s"),
        ],
        pictures: vec![
            ("figure6".into(), plot),
            ("figure6_magnification".into(), inset),
        ],
    })
}

fn magnified(workshop: &Workshop, frequency: SecondFrequency) -> Result<PaperFigure, Error> {
    let axis = ("belt_velocity", "m/s", 0.096, 0.112, workshop.points(81));
    let set = [("normal_force", 100.0)];
    let (plot, count, ends) = workshop.study("figure7", &[axis], &set, &STARTS, |s| {
        let ones = s.rows.iter().zip(&s.results);
        let ones = ones.filter(|(row, r)| row.kind == StartKind::Up && r.period == Some(1));
        let last = ones.map(|(row, _)| row.at[0]).fold(f64::NAN, f64::max);
        (picture(s), count(s, StartKind::Up), last)
    })?;
    let four = count.periods.iter().find(|(p, _)| *p == 4);
    let shares = [count.ones, four.map_or(0, |f| f.1), count.irregular].map(|n| count.share(n));
    let context = format!(
        "Upwards, period one up to {} m/s; main frequency {} to {} Hz (paper, measured: about 40 Hz). {}. {}",
        number(ends, 4),
        number(count.frequencies.0, 3),
        number(count.frequencies.1, 3),
        said(&count, "upwards"),
        frequency.of_figure_7()
    );
    Ok(PaperFigure {
        number: "7",
        title: "Magnification 96 to 112 mm/s (F_N = 100 N)".into(),
        claims: vec![magnified_claim(shares, context)],
        pictures: vec![
            ("figure7".into(), plot),
            ("second_frequency".into(), frequency.picture),
        ],
    })
}

/// Share of points in % from which on a kind of motion is a part of a diagram and no chance hit.
const PART: f64 = 5.0;
const PART_REASON: &str = "one point in twenty is a stretch that the eye sees, no chance hit";
/// Changes that make an interruption.
const CHANGES: f64 = 2.0;
const CHANGES_REASON: &str = "an interruption begins and ends";

fn linear_claim(low: f64, high: f64) -> Claim {
    Claim::new(
        "The static amplitude w_A, eq. (8), depends linearly on the normal force.",
        format!(
            "w_A is drawn in (dashed, black): {} µm/N at 5 N and {} µm/N at 150 N",
            number(1e6 * low, 4),
            number(1e6 * high, 4)
        ),
        vec![Finding::new(
            "relative difference of w_A/F_N at 5 and at 150 N",
            (low - high).abs() / high.abs(),
            "",
            Bound::AtMost(1e-9),
            "a million times the rounding of the computation",
        )],
    )
}

fn interruptions(others: f64, changes: usize) -> Vec<Finding> {
    vec![
        Finding::new(
            "share of the points of longer periods, irregular or unresolved",
            others,
            "%",
            Bound::AtLeast(PART),
            PART_REASON,
        ),
        Finding::new(
            "changes between period one and anything else along the parameter",
            changes as f64,
            "",
            Bound::AtLeast(CHANGES),
            CHANGES_REASON,
        ),
    ]
}

fn interrupted_claim(others: f64, changes: usize, context: String) -> Claim {
    Claim::new(
        "Period-one solutions are interrupted by multiperiodic solutions.",
        context,
        interruptions(others, changes),
    )
}

/// From w_A and w_A/(mu_0 - mu(v0)) at several belt velocities.
fn characteristic_claim(all: &[(f64, f64)], context: String) -> Claim {
    let range = |f: &dyn Fn(&(f64, f64)) -> f64| {
        let (low, high) = all
            .iter()
            .map(f)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
                (v.min(l), v.max(h))
            });
        100.0 * (high - low) / high.abs()
    };
    Claim::new(
        "The static amplitude w_A depends on the friction characteristic, eq. (8).",
        context,
        vec![
            Finding::new(
                "change of w_A from 0.01 to 0.21 m/s, of its largest value",
                range(&|a| a.0),
                "%",
                Bound::AtLeast(PART),
                "less would look level in the figure",
            ),
            Finding::new(
                "change of w_A/(mu_0 - mu(v0)) over the same range",
                range(&|a| a.1),
                "%",
                Bound::AtMost(1e-6),
                "eq. (8) has nothing else in it that depends on the belt velocity; rounding alone is left",
            ),
        ],
    )
}

fn strange_claim(others: f64, changes: usize, frequencies: f64, context: String) -> Claim {
    let mut findings = interruptions(others, changes);
    findings.push(Finding::new(
        "share of the second natural frequencies from 505 to 530 Hz at which a tenth of this range or more is no period one",
        frequencies,
        "%",
        Bound::AtLeast(PART),
        "the paper rounds 510 Hz; behaviour that rests on more than one frequency is no chance hit",
    ));
    Claim::new(
        "The magnification from 60 to 90 mm/s shows strange bifurcation behaviour.",
        context,
        findings,
    )
}

/// Shares in % of period one, period four and irregular motions.
fn magnified_claim(shares: [f64; 3], context: String) -> Claim {
    let names = ["of period one", "of period four", "irregular"];
    let findings = names.iter().zip(shares).map(|(name, share)| {
        Finding::new(
            format!("share of the points upwards that are {name}"),
            share,
            "%",
            Bound::AtLeast(PART),
            PART_REASON,
        )
    });
    Claim::new(
        "There are period-one, period-four and irregular-looking motions.",
        context,
        findings.collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::super::claim::Verdict;
    use super::*;

    #[test]
    fn verdicts_come_out_both_ways() {
        let text = String::new;
        assert_eq!(linear_claim(1.0, 1.0).verdict(), Verdict::Agrees);
        assert_eq!(linear_claim(1.0, 1.1).verdict(), Verdict::Differs);
        assert_eq!(
            interrupted_claim(20.0, 6, text()).verdict(),
            Verdict::Agrees
        );
        assert_eq!(interrupted_claim(2.0, 6, text()).verdict(), Verdict::InPart);
        assert_eq!(
            interrupted_claim(0.0, 1, text()).verdict(),
            Verdict::Differs
        );
        let law = [(1.0, 2.0), (1.5, 2.0)];
        assert_eq!(
            characteristic_claim(&law, text()).verdict(),
            Verdict::Agrees
        );
        let other = [(1.0, 2.0), (1.01, 2.5)];
        assert_eq!(
            characteristic_claim(&other, text()).verdict(),
            Verdict::Differs
        );
        assert_eq!(
            strange_claim(20.0, 6, 30.0, text()).verdict(),
            Verdict::Agrees
        );
        assert_eq!(
            strange_claim(0.0, 0, 30.0, text()).verdict(),
            Verdict::InPart
        );
        assert_eq!(
            strange_claim(0.0, 0, 0.0, text()).verdict(),
            Verdict::Differs
        );
        assert_eq!(
            magnified_claim([50.0, 10.0, 20.0], text()).verdict(),
            Verdict::Agrees
        );
        assert_eq!(
            magnified_claim([50.0, 0.0, 20.0], text()).verdict(),
            Verdict::InPart
        );
        assert_eq!(
            magnified_claim([0.0; 3], text()).verdict(),
            Verdict::Differs
        );
        let main = |share| Main {
            range: (0.07, 0.13),
            share,
        };
        assert_eq!(wide_claim(main(60.0), "m/s").verdict(), Verdict::Agrees);
        assert_eq!(wide_claim(main(26.0), "m/s").verdict(), Verdict::Differs);
    }
}
