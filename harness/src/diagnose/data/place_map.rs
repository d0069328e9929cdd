//! The force at break-away as a function of the place on the belt.

use crate::diagnose::data::break_away::BreakAways;
use crate::diagnose::data::break_away_events::Event;
use crate::diagnose::data::place_prediction::weights;

/// Break-away forces of a run along the belt, relative to their mean.
#[derive(Debug, Clone)]
pub struct PlaceMap {
    events: Vec<Event>,
    mean: f64,
    width: f64,
    /// Fall of the error of predicting each event from the others.
    pub fall: f64,
    /// That error, relative to the mean force (1).
    pub error: f64,
}

impl PlaceMap {
    /// From the break-aways of a run and what was found of them; `None` if they are too few to say anything.
    pub fn new(events: &[Event], found: &BreakAways) -> Option<Self> {
        found.fall_by_place.is_finite().then(|| Self {
            events: events.to_vec(),
            mean: found.mean,
            width: found.place_width_m,
            fall: found.fall_by_place,
            error: found.scatter * (1.0 - found.fall_by_place) / found.mean,
        })
    }

    /// The break-aways that it was made of.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Relative change (1) of the force at break-away at belt travel `place` in m.
    pub fn at(&self, place: f64) -> f64 {
        let weights = weights(&self.events, place, self.width, None);
        let near = weights.iter().zip(&self.events).map(|(w, e)| w * e.force);
        near.sum::<f64>() / self.mean - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::break_away::predict;
    use super::*;

    #[test]
    fn val_the_map_follows_thresholds_along_the_belt() {
        // Source: the thresholds themselves, 0.5 (1 + 0.2 sin(2 pi s/L)) over two wavelengths L.
        const LENGTH: f64 = 0.01;
        let wave = |s: f64| 0.2 * (std::f64::consts::TAU * s / LENGTH).sin();
        let events: Vec<Event> = (0..100)
            .map(|i| {
                let place = 2.0 * LENGTH * f64::from(i) / 100.0;
                Event {
                    force: 0.5 * (1.0 + wave(place)),
                    beginning: 0.3,
                    place,
                    dwell: 0.1,
                }
            })
            .collect();
        let map = PlaceMap::new(&events, &predict("run", &events)).unwrap();
        assert!(map.fall > 0.9, "{}", map.fall);
        for i in 5..95 {
            let place = 2.0 * LENGTH * (f64::from(i) + 0.5) / 100.0;
            let error = (map.at(place) - wave(place)).abs();
            assert!(error < 0.02, "{error} at {place} m");
        }
        let few = &events[..5];
        assert!(PlaceMap::new(few, &predict("few", few)).is_none());
    }
}
