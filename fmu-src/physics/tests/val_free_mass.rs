//! A mass without a spring (natural frequency 0): uniform acceleration, and the places where friction holds it.

use approx::assert_relative_eq;
use beam_physics::beam::{Beam, ModalOscillator};
use beam_physics::belt::Inputs;
use beam_physics::contact::ContactMode;
use beam_physics::effects::CATALOGUE;
use beam_physics::friction::{Exponential, FrictionLaw};
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start, StartContact};
use beam_physics::sweep::Values;

const MASS: f64 = 2.5;
const LOAD: f64 = 40.0;
const MU_S: f64 = 0.6;
const MU_K: f64 = 0.4;

fn free_mass() -> ModelParameters {
    let mode = ModalOscillator {
        frequency: 0.0,
        damping_ratio: 0.3,
        damping_rate: 0.0,
        mass: MASS,
        tip_value: 1.0,
    };
    ModelParameters {
        beam: Beam::new(&[mode]).unwrap(),
        friction: FrictionLaw::Coulomb {
            mu_s: MU_S,
            mu_k: MU_K,
        },
        ..ModelParameters::default()
    }
}

fn moving(velocity: f64, contact: StartContact) -> Start {
    let mut state = [0.0; MAX_STATES];
    state[1] = velocity;
    Start {
        state,
        contact,
        ..Start::default()
    }
}

fn pushed(belt: f64, force: f64) -> Inputs {
    Inputs {
        external_force: force,
        ..Inputs::constant(belt, LOAD)
    }
}

#[test]
fn val_a_pushed_mass_slides_uniformly_and_stops_when_the_push_ends() {
    // Source: Coulomb's law, a = (F - mu_k F_N)/m while it slides, -mu_k F_N/m after the push; it stops after v m/(mu_k F_N).
    let force = 30.0;
    let start = moving(0.0, StartContact::Automatic);
    let mut run = Simulation::new(&free_mass(), pushed(0.0, force), &start, 1e-12).unwrap();
    run.record_transitions();
    assert_eq!(run.contact_mode(), ContactMode::Forward);
    let a = (force - MU_K * LOAD) / MASS;
    run.advance_to(0.7).unwrap();
    let (v, w) = (a * 0.7, 0.5 * a * 0.49);
    assert_relative_eq!(run.state()[0], w, max_relative = 1e-12);
    assert_relative_eq!(run.state()[1], v, max_relative = 1e-12);
    // Less than static friction holds, but kinetic friction is what brakes.
    let rest = 10.0;
    run.set_inputs(pushed(0.0, rest)).unwrap();
    run.advance_to(5.0).unwrap();
    let brake = (MU_K * LOAD - rest) / MASS;
    let stops = 0.7 + v / brake;
    assert_relative_eq!(run.transitions()[0].time, stops, max_relative = 1e-12);
    assert_eq!(run.transitions().len(), 1);
    assert_eq!(run.contact_mode(), ContactMode::Stuck);
    let way = w + v * v / (2.0 * brake);
    assert_relative_eq!(run.state()[0], way, max_relative = 1e-12);
    assert_relative_eq!(run.outputs().friction_force, -rest, max_relative = 1e-12);
}

#[test]
fn val_a_viscous_guide_limits_the_velocity_of_a_pushed_mass() {
    // Source: linear equation of motion v' = a - d v from rest: v = a (1 - e^(-d t))/d, w = (a t - v)/d.
    let (force, rate) = (30.0, 2.1);
    let mut parameters = free_mass();
    let mode = ModalOscillator {
        damping_rate: rate,
        ..parameters.beam.modes()[0]
    };
    parameters.beam = Beam::new(&[mode]).unwrap();
    let start = moving(0.0, StartContact::Automatic);
    let mut run = Simulation::new(&parameters, pushed(0.0, force), &start, 1e-12).unwrap();
    run.advance_to(0.7).unwrap();
    let a = (force - MU_K * LOAD) / MASS;
    let v = a * (1.0 - (-rate * 0.7f64).exp()) / rate;
    assert_relative_eq!(run.state()[1], v, max_relative = 1e-10);
    assert_relative_eq!(run.state()[0], (a * 0.7 - v) / rate, max_relative = 1e-10);
    let message = Beam::new(&[ModalOscillator {
        damping_rate: -1.0,
        ..mode
    }])
    .unwrap_err()
    .to_string();
    assert!(
        message.contains("mode[1].damping_rate = -1 1/s"),
        "{message}"
    );
}

#[test]
fn val_a_rate_damps_a_spring_as_its_ratio_does() {
    // Source: 2 D w q' of the equation of motion, D = d/(2 w).
    let (frequency, ratio) = (7.0, 0.02);
    let velocity = |damping_ratio: f64, damping_rate: f64| {
        let mode = ModalOscillator {
            frequency,
            damping_ratio,
            damping_rate,
            mass: MASS,
            tip_value: 1.0,
        };
        let parameters = ModelParameters {
            beam: Beam::new(&[mode]).unwrap(),
            ..free_mass()
        };
        let start = moving(0.4, StartContact::Automatic);
        let mut run = Simulation::new(&parameters, pushed(0.1, 0.0), &start, 1e-12).unwrap();
        run.advance_to(0.5).unwrap();
        run.state()[1]
    };
    let rate = 2.0 * ratio * std::f64::consts::TAU * frequency;
    assert_relative_eq!(
        velocity(0.0, rate),
        velocity(ratio, 0.0),
        max_relative = 1e-9
    );
    assert!((velocity(0.0, rate) - velocity(0.0, 0.0)).abs() > 1e-3);
}

#[test]
fn val_a_ramp_breaks_the_mass_away_at_the_static_limit() {
    // Source: Coulomb's law: away at F = mu_s F_N, then w'' = (F_0 + r t - mu_k F_N)/m.
    let rate = 8.0;
    let inputs = Inputs {
        external_force_rate: rate,
        ..pushed(0.0, 0.0)
    };
    let start = moving(0.0, StartContact::Automatic);
    let mut run = Simulation::new(&free_mass(), inputs, &start, 1e-12).unwrap();
    run.record_transitions();
    run.advance_to(4.0).unwrap();
    let away = MU_S * LOAD / rate;
    assert_relative_eq!(run.transitions()[0].time, away, max_relative = 1e-12);
    let (t, jump) = (4.0 - away, (MU_S - MU_K) * LOAD);
    let v = (jump * t + 0.5 * rate * t * t) / MASS;
    let w = (0.5 * jump * t * t + rate * t.powi(3) / 6.0) / MASS;
    assert_relative_eq!(run.state()[1], v, max_relative = 1e-10);
    assert_relative_eq!(run.state()[0], w, max_relative = 1e-10);
}

#[test]
fn val_a_belt_takes_the_mass_along() {
    // Source: Coulomb's law: w' = mu_k F_N t/m up to the belt's velocity, then carried along.
    let (belt, start) = (0.8, moving(0.0, StartContact::Automatic));
    let mut run = Simulation::new(&free_mass(), pushed(belt, 0.0), &start, 1e-12).unwrap();
    run.record_transitions();
    run.advance_to(2.0).unwrap();
    let caught = belt * MASS / (MU_K * LOAD);
    assert_relative_eq!(run.transitions()[0].time, caught, max_relative = 1e-12);
    assert_eq!(run.transitions().len(), 1);
    let w = belt * (2.0 - 0.5 * caught);
    assert_relative_eq!(run.state()[0], w, max_relative = 1e-12);
    assert_relative_eq!(run.outputs().friction_force, 0.0, epsilon = 1e-12);
}

#[test]
fn free_masses_run_with_every_law_and_effect_and_beside_modes_with_springs() {
    let with_spring = |laws: FrictionLaw| {
        let mut parameters = free_mass();
        parameters.friction = laws;
        parameters
            .beam
            .push(ModalOscillator {
                frequency: 90.0,
                damping_ratio: 0.01,
                damping_rate: 0.0,
                mass: 1.0,
                tip_value: 0.7,
            })
            .unwrap();
        parameters
    };
    let coulomb = free_mass().friction;
    let mut all = vec![
        with_spring(coulomb),
        with_spring(FrictionLaw::StelterAsPrinted(Exponential::default())),
    ];
    for law in [
        FrictionLaw::default(),
        FrictionLaw::StelterAsPrinted(Exponential::default()),
    ] {
        all.push(ModelParameters {
            friction: law,
            ..free_mass()
        });
    }
    for (card, entry) in CATALOGUE.iter().enumerate() {
        let mut parameters = free_mass();
        for (i, p) in entry.parameters.iter().enumerate() {
            parameters.effects.set(card, i, p.typical);
        }
        all.push(parameters);
    }
    for parameters in all {
        let start = moving(0.2, StartContact::Automatic);
        let inputs = pushed(0.05, 3.0);
        let mut run = Simulation::new(&parameters, inputs, &start, 1e-9).unwrap();
        run.advance_to(0.6).unwrap();
        let now = run.outputs();
        assert!(
            now.displacement.is_finite() && now.velocity.abs() < 10.0,
            "{parameters:?}"
        );
    }
}

#[test]
fn parameter_studies_of_free_masses_are_refused_with_the_mode() {
    let mut values = Values::default();
    values.set("mode[2].frequency", 0.0).unwrap();
    let message = values.subject().err().unwrap().to_string();
    assert!(message.contains("mode[2].frequency = 0 Hz"), "{message}");
    assert!(message.contains("static deflection"), "{message}");
    values.set("mode[2].frequency", -1.0).unwrap();
    let message = values.subject().err().unwrap().to_string();
    assert!(message.contains("mode[2].frequency = -1 Hz"), "{message}");
}
