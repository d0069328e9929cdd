//! Exact cases: what pencil and paper say about the base model.

use approx::assert_relative_eq;
use beam_physics::beam::{Beam, ModalOscillator};
use beam_physics::belt::Inputs;
use beam_physics::contact::ContactMode;
use beam_physics::friction::FrictionLaw;
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start, StartContact};
use std::f64::consts::{PI, TAU};

const MASS: f64 = 0.5;
const FREQUENCY: f64 = 40.0;
const W: f64 = TAU * FREQUENCY;
const STIFFNESS: f64 = MASS * W * W;

/// A mass on a spring: one mode, tip value 1.
fn slider(damping_ratio: f64, mu_s: f64, mu_k: f64) -> ModelParameters {
    ModelParameters {
        beam: Beam::new(&[ModalOscillator {
            frequency: FREQUENCY,
            damping_ratio,
            damping_rate: 0.0,
            mass: MASS,
            tip_value: 1.0,
        }])
        .unwrap(),
        friction: FrictionLaw::Coulomb { mu_s, mu_k },
        ..ModelParameters::default()
    }
}

fn start(values: &[f64], contact: StartContact) -> Start {
    let mut state = [0.0; MAX_STATES];
    state[..values.len()].copy_from_slice(values);
    Start {
        state,
        contact,
        ..Start::default()
    }
}

#[test]
fn val_free_vibration_without_contact_follows_the_cosine() {
    // Source: closed form q = a cos(w t) + b sin(w t)/w of an undamped oscillator.
    let parameters = ModelParameters {
        beam: Beam::from_frequencies(&[80.0, 510.0], &[0.0], 0.427, 2).unwrap(),
        ..ModelParameters::default()
    };
    let x0 = [1e-3, 0.02, -2e-4, 0.1];
    let inputs = Inputs::constant(0.1, 0.0);
    let mut run =
        Simulation::new(&parameters, inputs, &start(&x0, StartContact::Slip), 1e-13).unwrap();
    for i in 1..=50 {
        let t = 0.02 * f64::from(i);
        run.advance_to(t).unwrap();
        let x = run.state();
        for (j, f) in [80.0, 510.0].iter().enumerate() {
            let (s, c) = (TAU * f * t).sin_cos();
            let exact = x0[2 * j] * c + x0[2 * j + 1] * s / (TAU * f);
            assert_relative_eq!(x[2 * j], exact, epsilon = 1e-12);
        }
        assert_eq!(run.outputs().friction_force, 0.0);
    }
}

#[test]
fn val_damped_free_vibration_decays_as_it_should() {
    // Source: closed form q = exp(-D w t) [a cos(w_d t) + (b + D w a)/w_d sin(w_d t)], w_d = w sqrt(1 - D^2).
    let d = 0.03;
    let inputs = Inputs::constant(0.2, 0.0);
    let begin = start(&[1e-3, 0.05], StartContact::Slip);
    let mut run = Simulation::new(&slider(d, 0.5, 0.3), inputs, &begin, 1e-13).unwrap();
    run.advance_to(0.1).unwrap();
    let wd = W * (1.0 - d * d).sqrt();
    let (s, c) = (wd * 0.1).sin_cos();
    let exact = (-d * W * 0.1).exp() * (1e-3 * c + (0.05 + d * W * 1e-3) / wd * s);
    assert_relative_eq!(run.state()[0], exact, epsilon = 1e-13);
}

#[test]
fn val_stick_drifts_with_the_belt_until_spring_and_damper_win() {
    // Source: balance k w + d v0 = mu_s F_N at w = w0 + v0 t.
    let (v0, load, mu_s, damping_ratio) = (0.05, 40.0, 0.5, 0.02);
    let begin = start(&[-5e-4, v0], StartContact::Stick);
    let mut run = Simulation::new(
        &slider(damping_ratio, mu_s, 0.3),
        Inputs::constant(v0, load),
        &begin,
        1e-10,
    )
    .unwrap();
    run.record_transitions();
    run.advance_to(0.005).unwrap();
    let now = run.outputs();
    assert_relative_eq!(now.displacement, -5e-4 + v0 * 0.005, max_relative = 1e-14);
    assert_eq!(now.mode, ContactMode::Stuck);
    assert_eq!(now.relative_velocity, 0.0);
    let damper = 2.0 * damping_ratio * W * MASS;
    assert_relative_eq!(
        now.friction_force,
        STIFFNESS * now.displacement + damper * v0,
        max_relative = 1e-12
    );
    run.advance_to(0.1).unwrap();
    let leaves = ((mu_s * load - damper * v0) / STIFFNESS + 5e-4) / v0;
    assert_relative_eq!(run.transitions()[0].time, leaves, max_relative = 1e-13);
    assert_eq!(run.transitions()[0].to, ContactMode::Backward);
}

#[test]
fn val_break_away_under_a_ramp_of_the_normal_force() {
    // Source: balance k (w0 + v0 t) = mu_s (F_0 + r t).
    let (v0, mu_s, load, ramp) = (0.05, 0.5, 60.0, -150.0);
    let inputs = Inputs {
        normal_force_rate: ramp,
        ..Inputs::constant(v0, load)
    };
    let begin = start(&[0.0, v0], StartContact::Stick);
    let mut run = Simulation::new(&slider(0.0, mu_s, 0.3), inputs, &begin, 1e-10).unwrap();
    run.record_transitions();
    run.advance_to(0.2).unwrap();
    let leaves = mu_s * load / (STIFFNESS * v0 - mu_s * ramp);
    assert_relative_eq!(run.transitions()[0].time, leaves, max_relative = 1e-12);
}

#[test]
fn val_one_mode_limit_cycle_of_coulombs_law() {
    // Source: closed form for mu_s, mu_k constant and D = 0 (Den Hartog 1931 builds it from the same arcs):
    // slip is an arc of u = w - mu_k F_N/k from (D, v0) to (-D, v0), D = (mu_s - mu_k) F_N/k, lasting
    // (pi + 2 atan(v0/(w D)))/w; stick goes back at v0 in 2 D/v0. Largest u is sqrt(D^2 + (v0/w)^2).
    let (v0, load, mu_s, mu_k) = (0.08, 50.0, 0.6, 0.4);
    let begin = start(&[0.0, v0], StartContact::Stick);
    let mut run = Simulation::new(
        &slider(0.0, mu_s, mu_k),
        Inputs::constant(v0, load),
        &begin,
        1e-12,
    )
    .unwrap();
    run.record_transitions();
    run.advance_to(1.0).unwrap();
    let half = (mu_s - mu_k) * load / STIFFNESS;
    let middle = mu_k * load / STIFFNESS;
    let phase = (v0 / (W * half)).atan();
    let (slip, stick) = ((PI + 2.0 * phase) / W, 2.0 * half / v0);
    let transitions = run.transitions();
    assert!(transitions.len() > 20);
    let first = (middle + half) / v0;
    for (i, transition) in transitions.iter().enumerate() {
        let cycles = (i / 2) as f64;
        let (time, left) = if i % 2 == 0 {
            (first + cycles * (slip + stick), ContactMode::Stuck)
        } else {
            (
                first + cycles * (slip + stick) + slip,
                ContactMode::Backward,
            )
        };
        assert_relative_eq!(transition.time, time, epsilon = 1e-10);
        assert_eq!(transition.from, left);
    }
    let turn = first + 10.0 * (slip + stick) + phase / W;
    let mut run = Simulation::new(&slider(0.0, mu_s, mu_k), run.inputs(), &begin, 1e-12).unwrap();
    run.advance_to(turn).unwrap();
    let top = middle + half.hypot(v0 / W);
    assert_relative_eq!(run.outputs().displacement, top, epsilon = 1e-12);
    assert_relative_eq!(run.outputs().velocity, 0.0, epsilon = 1e-9);
}

#[test]
fn val_sliding_to_rest_on_a_standing_belt() {
    // Source: Coulomb damping takes 2 mu_k F_N/k from the amplitude in each half cycle (Den Hartog 1931);
    // rest where the spring is weaker than static friction.
    let (mu_s, mu_k, load) = (0.6, 0.4, 50.0);
    let loss = 2.0 * mu_k * load / STIFFNESS;
    let w0 = 3.3 * loss;
    let begin = start(&[w0, 0.0], StartContact::Slip);
    let mut run = Simulation::new(
        &slider(0.0, mu_s, mu_k),
        Inputs::constant(0.0, load),
        &begin,
        1e-12,
    )
    .unwrap();
    run.record_transitions();
    run.advance_to(1.0).unwrap();
    // Turning points 3.3, -2.3, 1.3, -0.3 losses; 0.3 losses are held by mu_s.
    let now = run.outputs();
    assert_relative_eq!(now.displacement, -0.3 * loss, epsilon = 1e-12);
    assert_eq!((now.mode, now.velocity), (ContactMode::Stuck, 0.0));
    for (i, transition) in run.transitions().iter().enumerate() {
        assert_relative_eq!(transition.time, (i + 1) as f64 * PI / W, epsilon = 1e-11);
    }
    assert_eq!(run.transition_count(), 3);
}

#[test]
fn val_forced_slip_vibrates_about_the_friction_force() {
    // Source: steady slip under constant friction: w = mu_k F_N/k + free vibration, as long as v_r < 0.
    let (v0, load, mu_k) = (1.0, 50.0, 0.4);
    let rest = mu_k * load / STIFFNESS;
    let begin = start(&[rest + 1e-3, 0.0], StartContact::Slip);
    let mut run = Simulation::new(
        &slider(0.0, 0.6, mu_k),
        Inputs::constant(v0, load),
        &begin,
        1e-13,
    )
    .unwrap();
    run.advance_to(0.3).unwrap();
    let exact = rest + 1e-3 * (W * 0.3).cos();
    assert_relative_eq!(run.outputs().displacement, exact, epsilon = 1e-12);
    assert_eq!(run.outputs().friction_force, mu_k * load);
}
