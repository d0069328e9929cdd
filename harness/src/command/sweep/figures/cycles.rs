//! Figure 3: limit cycles with one to eight modes, and how far each is from the converged one.

use std::fmt::Write as _;

use beam_physics::sweep::{Motion, Sample, cycle_distance, trace};

use super::{Claim, PaperFigure, Verdict, Workshop};
use crate::command::sweep::table::Result as Row;
use crate::command::sweep::terminal::name;
use crate::error::Error;
use crate::report::{Axis, Colour, Figure, Plot, number};

/// Most modes of the model.
const MODES: usize = 8;
/// Samples of a cycle.
const SAMPLES: usize = 2000;
/// Operating points that are tried; the one at which most numbers of modes have a cycle of period one is shown. The
/// paper does not say its own.
const POINTS: [(f64, f64); 2] = [(36.0, 0.04), (100.0, 0.05)];

struct Cycle {
    motion: Motion,
    samples: Vec<Sample>,
}

/// Cycles with 1 to 8 modes at an operating point.
fn cycles(workshop: &Workshop, (force, velocity): (f64, f64)) -> Vec<Option<Cycle>> {
    (1..=MODES)
        .map(|n| {
            let values = workshop.values(&[
                ("normal_force", force),
                ("belt_velocity", velocity),
                ("mode_count", n as f64),
            ]);
            let subject = values.subject().ok()?;
            let motion = workshop.largest(&values)?;
            let end = motion.end.as_ref()?;
            // Of a motion that does not repeat, as long a piece as its main period.
            let duration = motion.duration.or(motion.main_frequency.map(|f| 1.0 / f))?;
            let samples = trace(&subject, end, duration, SAMPLES).ok()?;
            Some(Cycle { motion, samples })
        })
        .collect()
}

/// An operating point and, for each number of modes, the cycle reached there.
type Reached = ((f64, f64), Vec<Option<Cycle>>);

/// The figure.
pub fn figure(workshop: &Workshop) -> Result<PaperFigure, Error> {
    let period = |c: &Option<Cycle>| c.as_ref().and_then(|c| c.motion.period).unwrap_or(0);
    let mut best: Option<Reached> = None;
    for point in POINTS {
        workshop.begin("figure 3: limit cycles");
        let found = cycles(workshop, point);
        let ones = |all: &[Option<Cycle>]| all.iter().filter(|c| period(c) == 1).count();
        if best.as_ref().is_none_or(|(_, b)| ones(&found) > ones(b)) {
            best = Some((point, found));
        }
    }
    let (point, found) = best.expect("at least one operating point");
    let reference = found[MODES - 1].as_ref();
    let mut csv = String::from("modes,time_s,displacement_m,velocity_m_per_s,stuck\n");
    let mut table = String::from(
        "modes,period_number,period_s,main_frequency_hz,amplitude_m,distance_to_eight_modes\n",
    );
    let mut distances = Vec::new();
    let mut plot = Plot::new(
        Axis::linear("tip displacement", "mm"),
        Axis::linear("tip velocity", "m/s"),
    )
    .size(900.0, 460.0)
    .caption("Limit cycles of the tip with different numbers of modes.");
    let shown = [
        (1, Colour::Grey),
        (2, Colour::Blue),
        (3, Colour::Orange),
        (4, Colour::Green),
        (8, Colour::Ink),
    ];
    for (i, cycle) in found.iter().enumerate() {
        let Some(cycle) = cycle else {
            distances.push(f64::NAN);
            continue;
        };
        let distance = reference.map_or(f64::NAN, |r| cycle_distance(&cycle.samples, &r.samples));
        distances.push(distance);
        let m = &cycle.motion;
        let text = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        let _ = writeln!(
            table,
            "{},{},{},{},{},{distance}",
            i + 1,
            m.period.unwrap_or(0),
            text(m.duration),
            text(m.main_frequency),
            m.amplitude
        );
        for s in &cycle.samples {
            let (w, v, stuck) = (s.displacement, s.velocity, u8::from(s.stuck));
            let _ = writeln!(csv, "{},{},{w},{v},{stuck}", i + 1, s.time);
        }
        if let Some((n, colour)) = shown.iter().find(|(n, _)| *n == i + 1) {
            let w: Vec<f64> = cycle.samples.iter().map(|s| 1e3 * s.displacement).collect();
            let v: Vec<f64> = cycle.samples.iter().map(|s| s.velocity).collect();
            let label = if *n == 1 {
                "1 mode".into()
            } else {
                format!("{n} modes")
            };
            plot = plot.thin_line(&label, *colour, &w, &v);
        }
    }
    workshop.data("figure3.csv", &csv)?;
    workshop.data("figure3_convergence.csv", &table)?;
    let names: Vec<String> = (1..MODES).map(|n| n.to_string()).collect();
    let shares: Vec<f64> = distances[..MODES - 1].iter().map(|d| 100.0 * d).collect();
    let bars = convergence(&names, &shares);
    let irregular: Vec<String> = found
        .iter()
        .enumerate()
        .filter(|(_, c)| period(c) != 1)
        .map(|(i, c)| {
            let what = c
                .as_ref()
                .map_or("failed".into(), |c| name(&Row::of(&c.motion)));
            format!("{} modes: {what}", i + 1)
        })
        .collect();
    let listed: Vec<String> = distances[..MODES - 1]
        .iter()
        .enumerate()
        .map(|(i, d)| format!("{}: {} %", i + 1, number(100.0 * d, 2)))
        .collect();
    let settles = distances[3..MODES - 1].iter().all(|d| *d < 0.02);
    Ok(PaperFigure {
        number: "3",
        title: format!(
            "Limit cycles with 1 to 8 modes ({} N, {} m/s)",
            point.0, point.1
        ),
        claims: vec![Claim {
            paper: "With more mode shapes the limit cycle converges to its characteristic shape; two modes were used. (How many \
                    are needed is the paper's question.)"
                .into(),
            model: format!(
                "distance to the cycle with 8 modes, as share of its amplitude, by number of modes: {}{}",
                listed.join(", "),
                if irregular.is_empty() {
                    String::new()
                } else {
                    format!("; not of period one: {}", irregular.join(", "))
                }
            ),
            verdict: if settles && irregular.is_empty() {
                Verdict::Agrees
            } else {
                Verdict::InPart
            },
        }],
        pictures: vec![
            ("figure3".into(), Box::new(plot)),
            ("figure3_convergence".into(), bars),
        ],
    })
}

fn convergence(names: &[String], shares: &[f64]) -> Box<dyn Figure> {
    let places: Vec<f64> = (0..names.len()).map(|i| i as f64).collect();
    Box::new(
        Plot::new(
            Axis::places("number of modes", names),
            Axis::log("distance to 8 modes, of the amplitude", "%"),
        )
        .scatter("", Colour::Blue, &places, shares)
        .caption("Distance of the limit cycle to that with eight modes, over the number of modes."),
    )
}
