//! Figures 5, 6 with its magnification, and 7: bifurcation diagrams.

use beam_physics::sweep::static_amplitude;

use super::second_frequency::SecondFrequency;
use super::{Claim, PaperFigure, Verdict, Workshop};
use crate::command::sweep::Study;
use crate::command::sweep::pictures::bifurcation;
use crate::command::sweep::plan::StartKind;
use crate::command::sweep::terminal::name;
use crate::error::Error;
use crate::report::{Figure, number};

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

fn said(c: &Count) -> String {
    let periods: Vec<String> = c
        .periods
        .iter()
        .map(|(p, n)| format!("{p} ({n} times)"))
        .collect();
    format!(
        "of {} points from the fixed start {} are of period one, {} of longer periods or still settling, {} irregular, {} without vibration; \
         period one and others change places {} times; periods seen: {}",
        c.rows,
        c.ones,
        c.multiple,
        c.irregular,
        c.none,
        c.changes,
        if periods.is_empty() {
            "none but one".into()
        } else {
            periods.join(", ")
        }
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

fn picture(study: &Study) -> Box<dyn Figure> {
    Box::new(bifurcation(study))
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
    let (plot, count, both) = workshop.study("figure5", &[axis], &set, &STARTS, |s| {
        (picture(s), count(s, StartKind::Fixed), coexisting(s))
    })?;
    let interrupted = count.ones > 0 && count.multiple + count.irregular > 0 && count.changes > 1;
    Ok(PaperFigure {
        number: "5",
        title: "Bifurcations over the normal force (v0 = 60 mm/s)".into(),
        claims: vec![
            Claim {
                paper: "The static amplitude w_A, eq. (8), depends linearly on the normal force.".into(),
                model: format!(
                    "w_A is drawn in (dashed, black): {} µm/N at 5 N and {} µm/N at 150 N",
                    number(1e6 * low, 4),
                    number(1e6 * high, 4)
                ),
                verdict: if (low - high).abs() < 1e-9 * high {
                    Verdict::Agrees
                } else {
                    Verdict::Differs
                },
            },
            Claim {
                paper: "Period-one solutions are interrupted by multiperiodic solutions; no usual scenario (period doubling \
                        cascade, intermittency) fits."
                    .into(),
                model: format!(
                    "{}; at {} of {} points the motion depends on the start",
                    said(&count),
                    both.0,
                    both.1
                ),
                verdict: if interrupted { Verdict::Agrees } else { Verdict::Differs },
            },
        ],
        pictures: vec![("figure5".into(), plot)],
    })
}

fn over_velocity(workshop: &Workshop, frequency: &SecondFrequency) -> Result<PaperFigure, Error> {
    let axis = ("belt_velocity", "m/s", 0.01, 0.21, workshop.points(161));
    let set = [("normal_force", 100.0)];
    let (plot, whole, both) = workshop.study("figure6", &[axis], &set, &STARTS, |s| {
        (picture(s), count(s, StartKind::Fixed), coexisting(s))
    })?;
    let axis = ("belt_velocity", "m/s", 0.06, 0.09, workshop.points(91));
    let (inset, near) = workshop.study("figure6_magnification", &[axis], &set, &STARTS, |s| {
        (picture(s), count(s, StartKind::Fixed))
    })?;
    let strange = near.multiple + near.irregular > 0 && near.changes > 1;
    Ok(PaperFigure {
        number: "6",
        title: "Bifurcations over the belt velocity (F_N = 100 N), and 60 to 90 mm/s".into(),
        claims: vec![
            Claim {
                paper: "The static amplitude w_A depends on the friction characteristic.".into(),
                model: format!(
                    "w_A is drawn in (dashed, black) and rises as mu(v0) falls; {}; at {} of {} points the motion depends on the start",
                    said(&whole),
                    both.0,
                    both.1
                ),
                verdict: Verdict::Agrees,
            },
            Claim {
                paper: "The magnification from 60 to 90 mm/s shows strange bifurcation behaviour."
                    .into(),
                model: format!("{}; {}", said(&near), frequency.of_magnification()),
                verdict: match (strange, frequency.is_strange_somewhere()) {
                    (true, _) => Verdict::Agrees,
                    (false, true) => Verdict::InPart,
                    (false, false) => Verdict::Differs,
                },
            },
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
    let four = count.periods.iter().any(|(p, _)| *p == 4);
    let all = count.ones > 0 && count.irregular > 0;
    Ok(PaperFigure {
        number: "7",
        title: "Magnification 96 to 112 mm/s (F_N = 100 N)".into(),
        claims: vec![Claim {
            paper: "Period-one, period-four and irregular-looking motions, and other multiperiodic ones.".into(),
            model: format!(
                "upwards, period one up to {} m/s; {}; main frequency {} to {} Hz (paper, measured: about 40 Hz){}",
                number(ends, 4),
                said(&count).replace("from the fixed start", "upwards"),
                number(count.frequencies.0, 3),
                number(count.frequencies.1, 3),
                if four {
                    String::new()
                } else {
                    format!("; the multiperiodic windows are of other periods than the paper's four, but {}", frequency.of_figure_7())
                }
            ),
            verdict: match (all, four) {
                (true, true) => Verdict::Agrees,
                (true, false) => Verdict::InPart,
                _ => Verdict::Differs,
            },
        }],
        pictures: vec![
            ("figure7".into(), plot),
            ("second_frequency".into(), frequency.picture),
        ],
    })
}
