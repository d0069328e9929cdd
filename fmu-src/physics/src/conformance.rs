//! One suite over the whole catalogue: what every effect must do, present and future.

use crate::beam::{Beam, MAX_MODES};
use crate::belt::Inputs;
use crate::effects::{CATALOGUE, Card, Role};
use crate::error::PhysicsError;
use crate::friction::FrictionLaw;
use crate::integrate::MAX_STATES;
use crate::model::Model;
use crate::parameters::ModelParameters;
use crate::simulate::{DEFAULT_TOLERANCE, Outputs, Simulation, Start, StartContact};
use std::collections::HashSet;

/// Place of a card's states in its block of value references.
const FIRST_STATE_REFERENCE: usize = 60;

fn inputs() -> Inputs {
    Inputs::constant(0.1, 100.0)
}

/// In stick, deflected by 50 N, a few milliseconds before break-away.
fn start() -> Start {
    let mut state = [0.0; MAX_STATES];
    for (j, mode) in Beam::default().modes().iter().enumerate() {
        state[2 * j] = mode.tip_value * 50.0 / (mode.mass * mode.angular_frequency().powi(2));
    }
    Start {
        state,
        contact: StartContact::Stick,
        settled: true,
        ..Start::default()
    }
}

fn switch_on(parameters: &mut ModelParameters, card: usize) {
    for (i, p) in CATALOGUE[card].parameters.iter().enumerate() {
        parameters.effects.set(card, i, p.typical);
    }
}

fn typical(card: usize) -> ModelParameters {
    let mut parameters = ModelParameters::default();
    switch_on(&mut parameters, card);
    parameters
}

/// The parameter that keeps the effect off: the first whose start differs from a visible value.
fn switch(card: &Card) -> usize {
    card.parameters
        .iter()
        .position(|p| p.start == 0.0 && p.typical != 0.0)
        .unwrap_or_else(|| panic!("{} can't be off", card.id))
}

fn run(parameters: &ModelParameters, tolerance: f64) -> Simulation {
    Simulation::new(parameters, inputs(), &start(), tolerance).unwrap()
}

/// Measured displacements in m every 1 ms.
fn motion(parameters: &ModelParameters, milliseconds: u32, tolerance: f64) -> Vec<f64> {
    let mut run = run(parameters, tolerance);
    (0..=milliseconds)
        .map(|i| {
            run.advance_to(f64::from(i) * 1e-3).unwrap();
            run.measured_displacement()
        })
        .collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    let differences = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f64::max)
}

fn is_snake(name: &str) -> bool {
    !name.is_empty()
        && name
            .chars()
            .all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "_[]".contains(c))
}

#[test]
fn cards_are_complete() {
    for card in CATALOGUE {
        for text in [
            card.title,
            card.equation,
            card.description,
            card.source,
            card.signature,
            card.confounders,
        ] {
            assert!(text.len() > 5, "{}: a text is missing", card.id);
        }
        assert!(
            card.source.contains("19") || card.source.contains("20"),
            "{}: the source has no year",
            card.id
        );
        for p in card.parameters {
            assert!(p.description.len() > 5, "{}.{}", card.id, p.name);
        }
        for s in card.states {
            assert!(s.description.len() > 5 && s.nominal > 0.0, "{}", card.id);
        }
    }
}

#[test]
fn names_and_value_references_are_unique() {
    let mut ids = HashSet::new();
    let mut blocks = HashSet::new();
    for card in CATALOGUE {
        assert!(is_snake(card.id) && ids.insert(card.id), "{}", card.id);
        let first = card.first_value_reference;
        assert!(
            first.is_multiple_of(100) && blocks.insert(first),
            "{}: block {first}",
            card.id
        );
        // Without states the whole block is for the parameters.
        let room = match card.states.len() {
            0 => 100,
            _ => FIRST_STATE_REFERENCE,
        };
        assert!(
            card.parameters.len() <= room && FIRST_STATE_REFERENCE + card.states.len() <= 100,
            "{} does not fit into its block",
            card.id
        );
        let mut names = HashSet::new();
        for name in card.parameters.iter().map(|p| p.name) {
            assert!(is_snake(name) && names.insert(name), "{}.{name}", card.id);
        }
        let mut names = HashSet::new();
        for name in card.states.iter().map(|s| s.name) {
            assert!(is_snake(name) && names.insert(name), "{}.{name}", card.id);
        }
    }
    assert!(CATALOGUE.is_sorted_by_key(|card| card.id));
}

#[test]
fn bounds_hold_the_typical_and_are_accepted() {
    for (index, card) in CATALOGUE.iter().enumerate() {
        for (i, p) in card.parameters.iter().enumerate() {
            assert!(
                p.min <= p.typical && p.typical <= p.max && p.min < p.max,
                "{}.{}: {} in {} .. {}",
                card.id,
                p.name,
                p.typical,
                p.min,
                p.max
            );
            if p.role == Role::Amplitude {
                assert!(
                    p.start == 0.0 && p.min <= 0.0,
                    "{}.{}: an amplitude is zero where it is off",
                    card.id,
                    p.name
                );
            }
            for value in [p.min, p.max] {
                let mut parameters = typical(index);
                parameters.effects.set(index, i, value);
                let built = Model::new(&parameters, inputs());
                assert!(
                    built.is_ok() || p.role == Role::Setting,
                    "{}.{} = {value}",
                    card.id,
                    p.name
                );
            }
        }
    }
}

#[test]
fn off_is_bit_identical_to_absent() {
    let absent = motion(&ModelParameters::default(), 100, DEFAULT_TOLERANCE);
    for (index, card) in CATALOGUE.iter().enumerate() {
        let mut off = typical(index);
        let switch = switch(card);
        off.effects
            .set(index, switch, card.parameters[switch].start);
        assert_eq!(
            motion(&off, 100, DEFAULT_TOLERANCE),
            absent,
            "{} is not off",
            card.id
        );
    }
}

#[test]
fn typical_values_are_visible() {
    let absent = motion(&ModelParameters::default(), 60, DEFAULT_TOLERANCE);
    for (index, card) in CATALOGUE.iter().enumerate() {
        let present = motion(&typical(index), 60, DEFAULT_TOLERANCE);
        let difference = largest_difference(&absent, &present);
        // Ten times the noise of a coarse sensor.
        assert!(difference > 1e-5, "{}: {difference:e} m", card.id);
    }
}

#[test]
fn the_response_is_linear_in_a_small_amplitude() {
    // With the default law friction does not jump at break-away, and slip grows from a state of rest: what
    // only raises the static limit changes the time of that growth by a logarithm. Coulomb's law jumps.
    let coulomb = ModelParameters {
        friction: FrictionLaw::Coulomb {
            mu_s: 0.66,
            mu_k: 0.5,
        },
        ..ModelParameters::default()
    };
    let absent = motion(&coulomb, 14, 1e-13);
    for (index, card) in CATALOGUE.iter().enumerate() {
        let scaled = |factor: f64| {
            let mut parameters = coulomb.clone();
            switch_on(&mut parameters, index);
            for (i, p) in card.parameters.iter().enumerate() {
                if matches!(p.role, Role::Amplitude | Role::Node) {
                    parameters.effects.set(index, i, factor * p.typical);
                }
            }
            largest_difference(&motion(&parameters, 14, 1e-13), &absent)
        };
        let is_scalable = |role| matches!(role, Role::Amplitude | Role::Node);
        if card.parameters.iter().any(|p| is_scalable(p.role)) {
            let ratio = scaled(1e-3) / scaled(5e-4);
            assert!((ratio - 2.0).abs() < 0.02, "{}: ratio {ratio}", card.id);
        }
    }
}

#[test]
fn states_are_as_many_as_on_the_card() {
    for (index, card) in CATALOGUE.iter().enumerate() {
        let model = Model::new(&typical(index), inputs()).unwrap();
        assert_eq!(model.dimension(), 4 + card.states.len(), "{}", card.id);
        let (first, count) = model.effect_states(index).unwrap();
        assert_eq!((first, count), (4, card.states.len()), "{}", card.id);
    }
}

#[test]
fn values_that_are_no_numbers_are_refused_by_name() {
    for (index, card) in CATALOGUE.iter().enumerate() {
        for (i, p) in card.parameters.iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY] {
                let mut parameters = typical(index);
                parameters.effects.set(index, i, value);
                let Err(error) = Model::new(&parameters, inputs()) else {
                    panic!("{}.{} = {value} was accepted", card.id, p.name);
                };
                let expected = format!("{}.{} = {value} {}", card.id, p.name, p.unit.symbol);
                assert!(error.to_string().contains(&expected), "{error}");
            }
        }
    }
}

#[test]
fn absurd_values_give_a_message_or_a_motion() {
    for (index, card) in CATALOGUE.iter().enumerate() {
        for (i, p) in card.parameters.iter().enumerate().take(4) {
            for value in [-1e30, -1.5, 1e-30, 1e-9, 1e9, 1e30] {
                let mut parameters = typical(index);
                parameters.effects.set(index, i, value);
                let ran = Simulation::new(&parameters, inputs(), &start(), 1e-6)
                    .and_then(|mut run| run.advance_to(2e-3).map(|()| run.outputs()));
                match ran {
                    Ok(outputs) => assert!(
                        outputs.displacement.is_finite(),
                        "{}.{} = {value}",
                        card.id,
                        p.name
                    ),
                    Err(PhysicsError::OutOfRange { name, .. }) => {
                        assert_eq!(name, format!("{}.{}", card.id, p.name));
                    }
                    Err(other) => assert!(!other.to_string().is_empty()),
                }
            }
        }
    }
}

#[test]
fn effects_combine_freely() {
    for (a, card) in CATALOGUE.iter().enumerate() {
        for (b, other) in CATALOGUE.iter().enumerate().take(a) {
            let mut both = typical(a);
            switch_on(&mut both, b);
            let moved = motion(&both, 50, 1e-8);
            assert!(
                moved.iter().all(|w| w.abs() < 0.05),
                "{} with {}",
                card.id,
                other.id
            );
        }
    }
}

#[test]
fn all_effects_at_once_run_on_the_largest_structure() {
    let mut parameters = ModelParameters::default();
    for card in 0..CATALOGUE.len() {
        switch_on(&mut parameters, card);
    }
    let beam = |modes| Beam::from_frequencies(&[80.0, 510.0], &[1e-3], 0.427, modes).unwrap();
    parameters.beam = beam(MAX_MODES - 1);
    let model = Model::new(&parameters, inputs()).unwrap();
    assert!(model.dimension() <= MAX_STATES);
    assert!(motion(&parameters, 10, 1e-6).iter().all(|w| w.is_finite()));
    parameters.beam = beam(MAX_MODES);
    assert!(matches!(
        Model::new(&parameters, inputs()),
        Err(PhysicsError::ModeCount { .. })
    ));
}

fn end_of(mut run: Simulation, stops: impl Iterator<Item = f64>) -> (Outputs, u64) {
    for t in stops {
        run.advance_to(t).unwrap();
    }
    run.advance_to(0.08).unwrap();
    (run.outputs(), run.transition_count())
}

#[test]
fn stops_and_restarts_of_the_caller_change_nothing() {
    for (index, card) in CATALOGUE.iter().enumerate() {
        let new = || run(&typical(index), 1e-8);
        let straight = end_of(new(), std::iter::empty());
        let often = end_of(new(), (1..1140).map(|i| f64::from(i) * 7e-5));
        assert_eq!(straight, often, "{}", card.id);
        let mut used = new();
        used.advance_to(0.0333).unwrap();
        used.restart(inputs(), &start(), 1e-8).unwrap();
        let again = end_of(used, std::iter::empty());
        assert_eq!(straight, again, "{}", card.id);
    }
}

#[test]
fn inputs_set_again_change_nothing() {
    for (index, card) in CATALOGUE.iter().enumerate() {
        let new = || {
            let begin = Start {
                belt_travel: 0.0123,
                ..start()
            };
            Simulation::new(&typical(index), inputs(), &begin, 1e-11).unwrap()
        };
        let mut straight = new();
        let mut disturbed = new();
        for i in 1..=30 {
            let t = f64::from(i) * 1e-3;
            disturbed.advance_to(t).unwrap();
            disturbed.set_inputs(inputs()).unwrap();
            straight.advance_to(t).unwrap();
            let (a, b) = (disturbed.outputs(), straight.outputs());
            assert_eq!(a.mode, b.mode, "{} at {t} s", card.id);
            for (a, b) in [
                (a.displacement, b.displacement),
                (a.belt_travel, b.belt_travel),
                (a.dwell, b.dwell),
            ] {
                assert!((a - b).abs() < 1e-8, "{} at {t} s: {a} {b}", card.id);
            }
        }
    }
}

#[test]
fn contact_and_structure_only_take_energy() {
    for (index, card) in CATALOGUE.iter().enumerate() {
        let mut run = run(&typical(index), 1e-8);
        run.account_energy();
        let stores = run.model().has_memory();
        let (mut heat, mut damped) = (0.0, 0.0);
        for i in 1..=60 {
            run.advance_to(f64::from(i) * 1e-3).unwrap();
            let energy = run.energy().unwrap();
            // A bristle gives back what it has stored elastically.
            assert!(
                stores || energy.contact_dissipation >= heat - 1e-12,
                "{}: the contact gives energy",
                card.id
            );
            assert!(energy.structural_dissipation >= damped, "{}", card.id);
            heat = energy.contact_dissipation;
            damped = energy.structural_dissipation;
        }
        assert!(heat > 0.0, "{}", card.id);
    }
}
