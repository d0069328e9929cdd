//! What the force at break-away depends on: the place on the belt, or the dwell before it.
//!
//! The events of a run are its break-aways after a whole stick, each with its force `b = |F|/F_N` (the force before the
//! transition carried on to it, as the smoother can't follow the jump), the place s on the belt and the dwell. Each
//! event is predicted from the others of its run (leave one out): by their mean; by their mean weighted with
//! `exp(-((s - s_i)/h)^2 / 2)`, h the best of a grid; by a straight line over the logarithm of the dwell; and by one over the
//! force `a = |F|/F_N` with which the stick began. What is reported is the fall of the root mean square error against the
//! mean.
//!
//! A dwell that predicts says nothing of ageing: where the belt pulls steadily, a threshold that is high for any
//! reason makes a long stick. The force at the beginning is known before the threshold is met, and a low one makes a long
//! stick too; ageing shows as a falling line over it. Where the runs pass each place once, place and time can't be told apart.

use super::session::Session;
use super::shot::Smoothing;
use crate::observer::PhaseMode;
use serde::Serialize;

/// Events without which nothing is said.
const FEWEST: usize = 8;
/// Time in s before a transition in which the smoothed force can't follow.
const CLEAR: f64 = 4e-4;
/// Time in s before that from which the force is carried on.
const BEFORE: f64 = 1.2e-3;
/// Widths of the weight that are tried, in units of the median distance of the events.
const WIDTHS: [f64; 6] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

/// What predicts the break-aways of a run.
#[derive(Debug, Clone, Serialize)]
pub struct BreakAways {
    /// File of the run.
    pub file: String,
    /// How many there are; where there are fewer than eight nothing else is said.
    pub events: usize,
    /// Their mean force over the normal force.
    pub mean: f64,
    /// Root mean square error of the mean of the others.
    pub scatter: f64,
    /// Fall of that error (1) where the place on the belt is known.
    pub fall_by_place: f64,
    /// Width of the weight in m with which that was reached.
    pub place_width_m: f64,
    /// Fall where the dwell is known, which high thresholds lengthen themselves.
    pub fall_by_dwell: f64,
    /// Fall where the force at the beginning of the stick is known, if the line falls as ageing has it; else 0.
    pub fall_by_dwell_foretold: f64,
}

/// A break-away after a whole stick.
#[derive(Debug, Clone, Copy)]
struct Event {
    force: f64,
    beginning: f64,
    place: f64,
    dwell: f64,
}

/// The break-aways of every run.
pub fn describe(session: &Session) -> Vec<BreakAways> {
    let runs = session.campaign.runs.iter().zip(&session.smoothings);
    runs.map(|(run, smoothing)| {
        let events = events(smoothing, run.belt_velocity, run.normal_force);
        predict(&run.name, &events)
    })
    .collect()
}

fn events(smoothing: &Smoothing, belt: f64, normal: f64) -> Vec<Event> {
    let smoothed = &smoothing.stick_slip.smoothed;
    let h = smoothed.sample_interval;
    let last = smoothed.force.len() - 1;
    // A line through the force over the samples from `from` to `to` in s, at `at` in s.
    let carried = |from: f64, to: f64, at: f64| -> Option<f64> {
        let (first, past) = ((from / h).ceil() as usize, (to / h).floor() as usize);
        let points: Vec<(f64, f64)> = (first..=past.min(last))
            .map(|k| (k as f64 * h - at, smoothed.force[k].abs() / normal))
            .collect();
        (points.len() > 1).then(|| line(&points).0)
    };
    let phases = &smoothing.stick_slip.phases;
    let sticks = phases.windows(3).filter(|w| {
        let modes = [0, 1, 2].map(|i| w[i].mode == PhaseMode::Stick);
        modes == [false, true, false]
    });
    sticks
        .filter_map(|w| {
            let (start, end) = (w[1].start, w[1].end);
            // Both ends need room.
            if end - start < 2.0 * (BEFORE + CLEAR) {
                return None;
            }
            let k = (((end - CLEAR) / h) as usize).min(last);
            let moved = smoothed.displacement[k] - smoothed.displacement[0];
            Some(Event {
                force: carried(end - BEFORE - CLEAR, end - CLEAR, end)?,
                beginning: carried(start + CLEAR, start + CLEAR + BEFORE, start)?,
                place: belt * k as f64 * h - moved,
                dwell: end - start,
            })
        })
        .collect()
}

fn predict(file: &str, events: &[Event]) -> BreakAways {
    let mut out = BreakAways {
        file: file.to_owned(),
        events: events.len(),
        mean: f64::NAN,
        scatter: f64::NAN,
        fall_by_place: f64::NAN,
        place_width_m: f64::NAN,
        fall_by_dwell: f64::NAN,
        fall_by_dwell_foretold: f64::NAN,
    };
    if events.len() < FEWEST {
        return out;
    }
    let force = |e: &Event| e.force;
    out.mean = events.iter().map(force).sum::<f64>() / events.len() as f64;
    out.scatter = left_out(events, |others, _| {
        others.iter().map(force).sum::<f64>() / others.len() as f64
    });
    let fall = |error: f64| 1.0 - error / out.scatter;
    let spacing = median_distance(events);
    let (width, error) = WIDTHS
        .iter()
        .map(|w| w * spacing)
        .map(|width| {
            (
                width,
                left_out(events, |others, e| near(others, e.place, width)),
            )
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .expect("widths are tried");
    let over = |read: fn(&Event) -> f64| {
        left_out(events, |others, e| {
            let points: Vec<(f64, f64)> = others
                .iter()
                .map(|o| (read(o) - read(e), o.force))
                .collect();
            line(&points).0
        })
    };
    let all: Vec<(f64, f64)> = events.iter().map(|e| (e.beginning, e.force)).collect();
    let falls_with_beginning = line(&all).1 < 0.0;
    out.fall_by_place = fall(error);
    out.place_width_m = width;
    out.fall_by_dwell = fall(over(|e| e.dwell.ln()));
    out.fall_by_dwell_foretold = if falls_with_beginning {
        fall(over(|e| e.beginning)).max(0.0)
    } else {
        0.0
    };
    out
}

/// Root mean square error of each event's force predicted from the others.
fn left_out(events: &[Event], predict: impl Fn(&[Event], &Event) -> f64) -> f64 {
    let squares = (0..events.len()).map(|i| {
        let others: Vec<Event> = [&events[..i], &events[i + 1..]].concat();
        (events[i].force - predict(&others, &events[i])).powi(2)
    });
    (squares.sum::<f64>() / events.len() as f64).sqrt()
}

/// Mean force of events near a place.
fn near(events: &[Event], place: f64, width: f64) -> f64 {
    let nearest = events
        .iter()
        .map(|e| ((e.place - place) / width).powi(2))
        .fold(f64::INFINITY, f64::min);
    let (mut sum, mut weights) = (0.0, 0.0);
    for e in events {
        // Relative to the nearest one, so that a lonely event is predicted by its neighbour.
        let weight = (-0.5 * (((e.place - place) / width).powi(2) - nearest)).exp();
        sum += weight * e.force;
        weights += weight;
    }
    sum / weights
}

fn median_distance(events: &[Event]) -> f64 {
    let mut places: Vec<f64> = events.iter().map(|e| e.place).collect();
    places.sort_by(f64::total_cmp);
    let mut distances: Vec<f64> = places.windows(2).map(|w| w[1] - w[0]).collect();
    super::unexplained::median(&mut distances).max(1e-12)
}

/// Intercept and slope of the line through points.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let (x, y) = points
        .iter()
        .fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let (mut xx, mut xy) = (0.0, 0.0);
    for p in points {
        xx += (p.0 - x).powi(2);
        xy += (p.0 - x) * (p.1 - y);
    }
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    (y - slope * x, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Events pulled at a steady rate, from a beginning `beginning(i)` to a threshold `threshold(i, dwell)`.
    fn pulled(
        count: usize,
        beginning: impl Fn(usize) -> f64,
        threshold: impl Fn(usize, f64) -> f64,
    ) -> Vec<Event> {
        const RATE: f64 = 0.5;
        (0..count)
            .map(|i| {
                let begin = beginning(i);
                // The threshold and the line of pull meet: found by bisection.
                let (mut low, mut high) = (1e-6, 10.0);
                for _ in 0..80 {
                    let t = 0.5 * (low + high);
                    if begin + RATE * t < threshold(i, t) {
                        low = t;
                    } else {
                        high = t;
                    }
                }
                Event {
                    force: begin + RATE * low,
                    beginning: begin,
                    place: 1e-3 * i as f64,
                    dwell: low,
                }
            })
            .collect()
    }

    /// Reproducible numbers in -1 .. 1 without a pattern.
    fn random(i: usize) -> f64 {
        let x = ((i * 7919 + 13) as f64 * 12.9898).sin() * 43_758.547;
        2.0 * (x - x.floor()) - 1.0
    }

    #[test]
    fn a_threshold_that_varies_along_the_belt_is_told_from_ageing() {
        let along = |i: usize| 0.5 + 0.1 * (0.3 * i as f64).sin();
        let found = predict(
            "run",
            &pulled(80, |i| 0.2 + 0.03 * random(i), |i, _| along(i)),
        );
        assert!(found.fall_by_place > 0.7, "{found:?}");
        // Dwell predicts, though nothing ages; what is known before the break-away does not.
        assert!(found.fall_by_dwell > 0.3, "{found:?}");
        assert!(found.fall_by_dwell_foretold < 0.05, "{found:?}");
    }

    #[test]
    fn ageing_shows_in_what_is_known_before_the_break_away() {
        let aged = |_: usize, t: f64| 0.4 + 0.1 * (1.0 + t / 0.05).ln();
        let found = predict("run", &pulled(80, |i| 0.2 + 0.1 * random(i), aged));
        assert!(found.fall_by_dwell_foretold > 0.7, "{found:?}");
        assert!(found.fall_by_place < 0.1, "{found:?}");
    }

    #[test]
    fn few_events_say_nothing() {
        let found = predict("run", &pulled(5, |_| 0.2, |_, _| 0.5));
        assert_eq!(found.events, 5);
        assert!(found.fall_by_place.is_nan());
    }
}
