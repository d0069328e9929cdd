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
        ("belt_velocity", "m/s", 0.01, 0.25, workshop.points(25)),
        ("normal_force", "N", 5.0, 125.0, workshop.points(17)),
    ];
    let starts = [StartKind::Fixed, StartKind::Grid];
    let look = |s: &Study| {
        (
            starts.map(|kind| pictures::map(s, kind)),
            starts.map(|kind| count(s, kind)),
        )
    };
    let (plots, [fixed, largest]) = workshop.study("figure12", &axes, &[], &starts, look)?;
    let [fixed_plot, largest_plot] = plots;
    let one = fixed.one.min(largest.one);
    let none = fixed.none.max(largest.none);
    let share = |n: usize| number(100.0 * n as f64 / fixed.all as f64, 2);
    Ok(PaperFigure {
        number: "12",
        title: "Kinds of motion over belt velocity and normal force".into(),
        claims: vec![
            Claim {
                paper: "There are coherent areas with period-one solutions.".into(),
                model: format!(
                    "of {} points {} are of period one from the fixed start, {} where the largest motion of six starts is taken; \
                     irregular or settling: {} and {}; longer periods: {} and {}",
                    fixed.all,
                    fixed.one,
                    largest.one,
                    fixed.irregular,
                    largest.irregular,
                    fixed.longer,
                    largest.longer
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
                    "{} % of the points from the fixed start and {} % of the largest motions of six starts are without vibration; at {} and {} % the motion is the small \
                     one near the second natural frequency",
                    share(fixed.none),
                    share(largest.none),
                    share(fixed.fast),
                    share(largest.fast)
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
            ("figure12_largest".into(), Box::new(largest_plot)),
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
    let rows = pictures::representative(study, kind);
    let here: Vec<_> = rows.into_iter().map(|(_, r)| (name(r), r)).collect();
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
