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

use crate::diagnose::data::break_away_events::Event;
use crate::diagnose::data::place_prediction::Places;
use crate::metric::line;
use nalgebra::DVector;
use serde::Serialize;

/// Events without which nothing is said.
const FEWEST: usize = 8;

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
    /// Probability of as large a fall by chance: share of the permutations of the forces over the places that reach it.
    pub fall_by_place_by_chance: f64,
    /// Width of the weight in m with which that was reached.
    pub place_width_m: f64,
    /// Fall where the dwell is known, which high thresholds lengthen themselves.
    pub fall_by_dwell: f64,
    /// Fall where the force at the beginning of the stick is known, if the line falls as ageing has it; else 0.
    pub fall_by_dwell_foretold: f64,
}

/// Fall of the error by the place that counts: what is measured of break-aways where nothing depends on the place falls so
/// far in single runs, but not in all of a campaign.
const TOLD: f64 = 0.3;
/// Probability by chance that counts as none.
const CHANCE: f64 = 0.01;
/// Events that one run must have.
const MANY: usize = 30;

/// Whether the break-aways tell that friction depends on the place: in every run that has enough of them the place takes
/// away at least 30 % of the error, which by chance happens once in a hundred permutations at most, and in one run there
/// are thirty of them.
pub fn place_is_told(runs: &[BreakAways]) -> bool {
    let enough: Vec<&BreakAways> = runs
        .iter()
        .filter(|b| b.fall_by_place.is_finite())
        .collect();
    enough.iter().any(|b| b.events >= MANY)
        && enough
            .iter()
            .all(|b| b.fall_by_place >= TOLD && b.fall_by_place_by_chance <= CHANCE)
}

/// What predicts the break-aways of a run from a file.
pub(crate) fn predict(file: &str, events: &[Event]) -> BreakAways {
    let mut out = BreakAways {
        file: file.to_owned(),
        events: events.len(),
        mean: f64::NAN,
        scatter: f64::NAN,
        fall_by_place: f64::NAN,
        fall_by_place_by_chance: f64::NAN,
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
    let scatter = out.scatter;
    let fall = |error: f64| 1.0 - error / scatter;
    let places = Places::new(events);
    let forces = DVector::from_iterator(events.len(), events.iter().map(force));
    let (width, error) = places.best(&forces);
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
    out.fall_by_place_by_chance = places.by_chance(&forces, error);
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
    fn the_place_is_told_only_if_it_is_in_every_run() {
        let along = |i: usize| 0.5 + 0.1 * (0.3 * i as f64).sin();
        let by_place = predict(
            "by place",
            &pulled(40, |i| 0.2 + 0.03 * random(i), |i, _| along(i)),
        );
        // A threshold drawn anew for each stick has no place.
        let drawn = |i: usize, _: f64| 0.5 + 0.1 * random(i + 1000);
        let at_random = predict("at random", &pulled(40, |i| 0.2 + 0.03 * random(i), drawn));
        assert!(by_place.fall_by_place_by_chance <= 0.01, "{by_place:?}");
        assert!(at_random.fall_by_place_by_chance > 0.05, "{at_random:?}");
        assert!(place_is_told(std::slice::from_ref(&by_place)));
        assert!(!place_is_told(std::slice::from_ref(&at_random)));
        assert!(!place_is_told(&[by_place, at_random]));
        let few = predict(
            "few",
            &pulled(20, |i| 0.2 + 0.03 * random(i), |i, _| along(i)),
        );
        assert!(!place_is_told(&[few]));
    }

    #[test]
    fn few_events_say_nothing() {
        let found = predict("run", &pulled(5, |_| 0.2, |_, _| 0.5));
        assert_eq!(found.events, 5);
        assert!(found.fall_by_place.is_nan());
    }
}
