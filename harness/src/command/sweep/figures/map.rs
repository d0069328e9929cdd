//! Figure 12: the kinds of motion over belt velocity and normal force.

use super::{Claim, PaperFigure, Verdict, Workshop};
use crate::command::sweep::pictures;
use crate::command::sweep::plan::StartKind;
use crate::command::sweep::terminal::kinds;
use crate::error::Error;
use crate::report::{Figure, number};

/// The figure.
pub fn figure(workshop: &Workshop) -> Result<PaperFigure, Error> {
    let axes = [
        ("belt_velocity", "m/s", 0.01, 0.31, workshop.points(31)),
        ("normal_force", "N", 5.0, 105.0, workshop.points(21)),
    ];
    let look = |s: &crate::command::sweep::Study| {
        let small = s.results.iter().filter(|r| {
            r.vibrates() && r.main_frequency.is_some_and(|f| f > 200.0)
        });
        (pictures::map(s), kinds(s), small.count(), s.rows.len())
    };
    let (plot, counts, fast, all) =
        workshop.study("figure12", &axes, &[], &[StartKind::Fixed], look)?;
    let of = |kind: &str| counts.iter().find(|(k, _)| k == kind).map_or(0, |(_, n)| *n);
    let listed: Vec<String> = counts.iter().map(|(k, n)| format!("{k}: {n}")).collect();
    let (one, none) = (of("period 1"), of("no vibration"));
    Ok(PaperFigure {
        number: "12",
        title: "Kinds of motion over belt velocity and normal force".into(),
        claims: vec![
            Claim {
                paper: "There are coherent areas with period-one solutions.".into(),
                model: format!("of {all} points from the fixed start: {}", listed.join(", ")),
                verdict: if one > 0 { Verdict::Agrees } else { Verdict::Differs },
            },
            Claim {
                paper: "In the hatched regions no self-sustained vibrations take place.".into(),
                model: format!(
                    "{none} of {all} points ({} %) are without vibration; at {fast} the motion is the small one near the second natural \
                     frequency",
                    number(100.0 * none as f64 / all as f64, 2)
                ),
                verdict: if none > 0 { Verdict::Agrees } else { Verdict::Differs },
            },
        ],
        pictures: vec![("figure12".into(), Box::new(plot) as Box<dyn Figure>)],
    })
}
