//! Figure 3: limit cycles with one to eight modes, and how far each is from the converged one.

use std::fmt::Write as _;

use beam_physics::sweep::{Motion, Sample, cycle_distance, trace};

use super::claim::{Bound, Claim, Finding};
use super::{PaperFigure, Workshop};
use crate::command::sweep::table::Result as Row;
use crate::command::sweep::terminal::name;
use crate::error::Error;
use crate::report::{Axis, Colour, Plot, number};

/// Most modes of the model.
const MODES: usize = 8;
/// Samples of a cycle.
const SAMPLES: usize = 2000;
/// Operating points that are tried; the one at which most numbers of modes have a cycle of period one is shown. The
/// paper does not say its own.
const POINTS: [(f64, f64); 2] = [(36.0, 0.04), (100.0, 0.05)];

/// Where the cycles converge: damping ratio of all modes but the first, and operating point.
const DAMPED: (f64, (f64, f64)) = (0.03, (100.0, 0.1));
/// Distance to the cycle with eight modes below which a cycle counts as converged.
const CONVERGED: f64 = 0.01;

struct Cycle {
    motion: Motion,
    samples: Vec<Sample>,
}

/// Cycles with 1 to 8 modes at an operating point; `damping` is that of all modes but the first, where it is not the
/// model's own.
fn cycles(
    workshop: &Workshop,
    (force, velocity): (f64, f64),
    damping: Option<f64>,
) -> Vec<Option<Cycle>> {
    let damped: Vec<(String, f64)> = damping
        .iter()
        .flat_map(|d| (2..=MODES).map(|j| (format!("mode[{j}].damping_ratio"), *d)))
        .collect();
    (1..=MODES)
        .map(|n| {
            let mut set = vec![
                ("normal_force", force),
                ("belt_velocity", velocity),
                ("mode_count", n as f64),
            ];
            set.extend(damped.iter().map(|(name, d)| (name.as_str(), *d)));
            let values = workshop.values(&set);
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

/// Distance of each cycle to the one with all modes, as share of its amplitude, and a table of the cycles.
fn distances(found: &[Option<Cycle>]) -> (Vec<f64>, String) {
    let reference = found[MODES - 1].as_ref();
    let mut table = String::from(
        "modes,period_number,period_s,main_frequency_hz,amplitude_m,distance_to_eight_modes\n",
    );
    let mut out = Vec::new();
    for (i, cycle) in found.iter().enumerate() {
        let distance = match (cycle, reference) {
            (Some(c), Some(r)) => cycle_distance(&c.samples, &r.samples),
            _ => f64::NAN,
        };
        out.push(distance);
        let Some(cycle) = cycle else { continue };
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
    }
    (out, table)
}

/// Distances in words, by number of modes.
fn listed(distances: &[f64]) -> String {
    let each = distances[..MODES - 1].iter().enumerate();
    let each = each.map(|(i, d)| format!("{}: {} %", i + 1, number(100.0 * d, 2)));
    each.collect::<Vec<String>>().join(", ")
}

fn period(cycle: &Option<Cycle>) -> usize {
    let motion = cycle.as_ref().map(|c| &c.motion);
    motion.and_then(|m| m.period).unwrap_or(0)
}

/// An operating point and, for each number of modes, the cycle reached there.
type Reached = ((f64, f64), Vec<Option<Cycle>>);

/// The figure.
pub fn figure(workshop: &Workshop) -> Result<PaperFigure, Error> {
    let mut best: Option<Reached> = None;
    for point in POINTS {
        workshop.begin("figure 3: limit cycles");
        let found = cycles(workshop, point, None);
        let ones = |all: &[Option<Cycle>]| all.iter().filter(|c| period(c) == 1).count();
        if best.as_ref().is_none_or(|(_, b)| ones(&found) > ones(b)) {
            best = Some((point, found));
        }
    }
    let (point, found) = best.expect("at least one operating point");
    workshop.begin("figure 3: limit cycles");
    let damped = cycles(workshop, DAMPED.1, Some(DAMPED.0));
    let (far, table) = distances(&found);
    let (near, damped_table) = distances(&damped);
    let mut csv = String::from("modes,time_s,displacement_m,velocity_m_per_s,stuck\n");
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
        let Some(cycle) = cycle else { continue };
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
    workshop.data("figure3_convergence_damped.csv", &damped_table)?;
    let bars = convergence(point, &far, &near);
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
    let ones = |all: &[Option<Cycle>]| all.iter().filter(|c| period(c) == 1).count();
    let given = format!(
        "{} N and {} m/s, damping as measured; by number of modes {}{}",
        point.0,
        point.1,
        listed(&far),
        if irregular.is_empty() {
            String::new()
        } else {
            format!("; not of period one: {}", irregular.join(", "))
        }
    );
    let raised = format!(
        "{} N and {} m/s, {} % of critical damping in all modes but the first; by number of modes {}",
        DAMPED.1.0,
        DAMPED.1.1,
        100.0 * DAMPED.0,
        listed(&near)
    );
    Ok(PaperFigure {
        number: "3",
        title: format!(
            "Limit cycles with 1 to 8 modes ({} N, {} m/s)",
            point.0, point.1
        ),
        claims: vec![
            claim(
                "With more mode shapes the limit cycle converges to its characteristic shape.",
                given,
                &far,
                ones(&found),
            ),
            claim(
                "The same, where the modes above the first are damped more than the paper measured on the beam without belt (not a claim of the paper).",
                raised,
                &near,
                ones(&damped),
            ),
        ],
        pictures: vec![
            ("figure3".into(), plot),
            ("figure3_convergence".into(), bars),
        ],
    })
}

fn claim(paper: &str, model: String, distances: &[f64], ones: usize) -> Claim {
    // A distance that is not known is none below the bound.
    let worst = |d: &[f64]| {
        d.iter()
            .copied()
            .reduce(|a, b| if a >= b || a.is_nan() { a } else { b })
    };
    Claim::new(
        paper,
        model,
        vec![
            Finding::new(
                "largest distance to the cycle with eight modes, of those with four to seven, as share of the amplitude",
                100.0 * worst(&distances[3..MODES - 1]).unwrap_or(f64::NAN),
                "%",
                Bound::AtMost(100.0 * CONVERGED),
                "a line's width of the figure: cycles that differ by less coincide in print",
            ),
            Finding::new(
                "numbers of modes, of eight, that have a cycle of period one",
                ones as f64,
                "",
                Bound::AtLeast(MODES as f64),
                "a motion that does not close has no shape to converge to",
            ),
        ],
    )
}

fn convergence(point: (f64, f64), far: &[f64], near: &[f64]) -> Plot {
    let names: Vec<String> = (1..MODES).map(|n| n.to_string()).collect();
    let places: Vec<f64> = (0..names.len()).map(|i| i as f64).collect();
    let percent = |d: &[f64]| -> Vec<f64> { d[..MODES - 1].iter().map(|d| 100.0 * d).collect() };
    let as_given = format!("damping as measured, {} N, {} m/s", point.0, point.1);
    let damped = format!(
        "{} % in all modes but the first, {} N, {} m/s",
        100.0 * DAMPED.0,
        DAMPED.1.0,
        DAMPED.1.1
    );
    Plot::new(
            Axis::places("number of modes", &names),
            Axis::log("distance to 8 modes, of the amplitude", "%"),
        )
        .scatter(&as_given, Colour::Blue, &places, &percent(far))
        .scatter(&damped, Colour::Orange, &places, &percent(near))
        .caption("Distance of the limit cycle to that with eight modes, over the number of modes: with the damping measured the higher modes make the motion irregular, with more it converges.")
}

#[cfg(test)]
mod tests {
    use super::super::claim::Verdict;
    use super::*;

    #[test]
    fn verdicts_come_out_both_ways() {
        let of = |d: f64, ones| claim("", String::new(), &[d; MODES], ones).verdict();
        assert_eq!(of(0.005, 8), Verdict::Agrees);
        assert_eq!(of(0.005, 7), Verdict::InPart);
        assert_eq!(of(0.02, 7), Verdict::Differs);
        let unknown = [0.0, 0.0, 0.0, 0.001, f64::NAN, 0.001, 0.001, 0.0];
        assert_eq!(
            claim("", String::new(), &unknown, 7).verdict(),
            Verdict::Differs
        );
    }
}
