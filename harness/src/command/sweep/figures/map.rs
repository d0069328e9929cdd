//! Figure 12: the kinds of motion over belt velocity and normal force.

use super::{Claim, PaperFigure, Verdict, Workshop};
use crate::command::sweep::Study;
use crate::command::sweep::pictures;
use crate::command::sweep::plan::StartKind;
use crate::command::sweep::table::Result as Row;
use crate::command::sweep::terminal::name;
use crate::error::Error;
use crate::report::{Figure, number};

/// The figure.
pub fn figure(workshop: &Workshop) -> Result<PaperFigure, Error> {
    let axes = [
        ("belt_velocity", "m/s", 0.01, 0.31, workshop.points(31)),
        ("normal_force", "N", 5.0, 105.0, workshop.points(21)),
    ];
    let starts = [StartKind::Fixed, StartKind::Up];
    let look = |s: &Study| {
        (
            starts.map(|kind| pictures::map(s, kind)),
            starts.map(|kind| count(s, kind)),
        )
    };
    let (plots, [fixed, up]) = workshop.study("figure12", &axes, &[], &starts, look)?;
    let [fixed_plot, up_plot] = plots;
    let one = fixed.one.min(up.one);
    let none = fixed.none.max(up.none);
    let share = |n: usize| number(100.0 * n as f64 / fixed.all as f64, 2);
    Ok(PaperFigure {
        number: "12",
        title: "Kinds of motion over belt velocity and normal force".into(),
        claims: vec![
            Claim {
                paper: "There are coherent areas with period-one solutions.".into(),
                model: format!(
                    "of {} points {} are of period one from the fixed start, {} by continuation upwards in v0 from 10 mm/s; \
                     irregular or settling: {} and {}; longer periods: {} and {}",
                    fixed.all,
                    fixed.one,
                    up.one,
                    fixed.irregular,
                    up.irregular,
                    fixed.longer,
                    up.longer
                ),
                verdict: if one > 0 {
                    Verdict::Agrees
                } else {
                    Verdict::Differs
                },
            },
            Claim {
                paper: "In the hatched regions no self-sustained vibrations take place.".into(),
                model: format!(
                    "{} % of the points from the fixed start and {} % upwards are without vibration; at {} and {} % the motion is the small \
                     one near the second natural frequency",
                    share(fixed.none),
                    share(up.none),
                    share(fixed.fast),
                    share(up.fast)
                ),
                verdict: if none > 0 {
                    Verdict::Agrees
                } else {
                    Verdict::Differs
                },
            },
        ],
        pictures: vec![
            ("figure12".into(), Box::new(fixed_plot) as Box<dyn Figure>),
            ("figure12_upwards".into(), Box::new(up_plot)),
        ],
    })
}

/// Frequency in Hz above which a motion is the small one.
const FAST: f64 = 200.0;

/// How often each kind of motion occurs.
struct Count {
    all: usize,
    one: usize,
    longer: usize,
    irregular: usize,
    none: usize,
    fast: usize,
}

fn count(study: &Study, kind: StartKind) -> Count {
    let rows = study.rows.iter().zip(&study.results);
    let here: Vec<_> = rows
        .filter(|(row, _)| row.kind == kind)
        .map(|(_, r)| (name(r), r))
        .collect();
    let many = |f: &dyn Fn(&str) -> bool| here.iter().filter(|(n, _)| f(n)).count();
    let is_fast = |r: &Row| r.vibrates() && r.main_frequency.is_some_and(|f| f > FAST);
    Count {
        all: here.len(),
        one: many(&|n| n == "period 1"),
        longer: many(&|n| n.starts_with("period ") && n != "period 1"),
        irregular: many(&|n| n == "irregular" || n == "settling"),
        none: many(&|n| n == "no vibration"),
        fast: here.iter().filter(|(_, r)| is_fast(r)).count(),
    }
}
