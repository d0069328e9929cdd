//! Values of effects on a machine of another size.
//!
//! The cards of the catalogue and the library give the strengths and times that are met on one machine: typical ones, and bounds that
//! set what is believed before any data. A machine that moves a hundred times as far, or weighs a thousandth, meets others: two
//! machines behave alike where all values agree in units of their own length, velocity and force (Buckingham, Phys. Rev. 4 (1914) 345),
//! so that each value is scaled as its unit says ([`Scales::factor`]); machines of about one size have the same beliefs ([`Scales::over`]).

use crate::diagnose::model::library::File;
use crate::diagnose::model::scales::Scales;
use crate::fmu::effect_card::{EffectCard, EffectParameter, Role};

/// The card of an effect of catalogue or library as it is met on a machine with other scales, by their ratios. Curves and formulas that
/// were found in the campaign hold for it already, as do effects that the user wrote.
pub fn on_machine(mut card: EffectCard, ratios: Scales) -> EffectCard {
    let file = File::of_library(&card.id);
    if card.is_own && file.is_none() {
        return card;
    }
    let repeats = card.repeats();
    let is_of_contact = file.is_some_and(|f| f.is_of_contact());
    for p in &mut card.parameters {
        match p.role {
            Role::Amplitude => scale(p, ratios.factor(&p.unit)),
            // Constants of the library's friction are those of asperities, which know nothing of the machine's size; nor does what is
            // printed on the track.
            Role::Shape if is_of_contact || (repeats && p.unit == "m") => {}
            Role::Shape => {
                // A sensor does not grow with the machine: what was met on the other one may be met here. On a linear scale that would
                // be believed most.
                let (least, most) = (p.min, p.max);
                scale(p, ratios.factor(&p.unit));
                if least > 0.0 {
                    (p.min, p.max) = (p.min.min(least), p.max.max(most));
                }
            }
            Role::Phase | Role::Node | Role::Setting => {}
        }
    }
    card
}

fn scale(p: &mut EffectParameter, factor: f64) {
    for value in [&mut p.typical, &mut p.min, &mut p.max] {
        *value *= factor;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(name: &str, unit: &str, role: Role) -> EffectParameter {
        EffectParameter {
            name: name.into(),
            description: String::new(),
            reference: 0,
            unit: unit.into(),
            start: 0.0,
            typical: 2.0,
            min: 1.0,
            max: 4.0,
            role,
        }
    }

    fn card(id: &str, is_own: bool, parameters: Vec<EffectParameter>) -> EffectCard {
        EffectCard {
            id: id.into(),
            title: String::new(),
            equation: String::new(),
            description: String::new(),
            source: String::new(),
            signature: String::new(),
            confounders: String::new(),
            parameters,
            states: Vec::new(),
            is_own,
        }
    }

    const RATIOS: Scales = Scales {
        length: 100.0,
        velocity: 10.0,
        force: 1e-3,
    };

    fn values(card: &EffectCard, index: usize) -> [f64; 3] {
        let p = &card.parameters[index];
        [p.typical, p.min, p.max]
    }

    #[test]
    fn strengths_are_scaled_and_shapes_hold_both_ranges() {
        let strength = parameter("k", "N/m", Role::Amplitude);
        let gap = parameter("g", "m", Role::Shape);
        let mut damper = parameter("c", "N.s/m", Role::Shape);
        damper.min = 0.0;
        let found = on_machine(card("stop", false, vec![strength, gap, damper]), RATIOS);
        for (value, expected) in values(&found, 0).into_iter().zip([2e-5, 1e-5, 4e-5]) {
            assert!((value / expected - 1.0).abs() < 1e-12, "{value}");
        }
        assert_eq!(values(&found, 1), [200.0, 1.0, 400.0]);
        for (value, expected) in values(&found, 2).into_iter().zip([2e-4, 0.0, 4e-4]) {
            assert!((value - expected).abs() < 1e-12, "{value}");
        }
    }

    #[test]
    fn the_contact_the_track_and_the_user_know_nothing_of_the_machine() {
        let length = || parameter("length", "m", Role::Shape);
        let as_stated = [2.0, 1.0, 4.0];
        let of_contact = card("term_slip_distance_lag", true, vec![length()]);
        assert_eq!(values(&on_machine(of_contact, RATIOS), 0), as_stated);
        let phase = parameter("phase", "rad", Role::Phase);
        let on_track = card("ribs", false, vec![length(), phase]);
        assert_eq!(values(&on_machine(on_track, RATIOS), 0), as_stated);
        let force = parameter("f", "N", Role::Amplitude);
        let of_user = card("mine", true, vec![force]);
        assert_eq!(values(&on_machine(of_user, RATIOS), 0), as_stated);
    }
}
