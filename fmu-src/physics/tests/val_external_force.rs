//! An external force at the tip: forced vibration in slip, and the break-away that it causes, in closed form.

use approx::assert_relative_eq;
use beam_physics::beam::{Beam, ModalOscillator};
use beam_physics::belt::Inputs;
use beam_physics::contact::ContactMode;
use beam_physics::friction::{Exponential, FrictionLaw};
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start, StartContact};
use std::f64::consts::TAU;

const MASS: f64 = 0.5;
const FREQUENCY: f64 = 40.0;
const DAMPING_RATIO: f64 = 0.02;
const PHI: f64 = -1.5;
const W: f64 = TAU * FREQUENCY;

/// One mode whose shape is not 1 at the tip.
fn oscillator(friction: FrictionLaw) -> ModelParameters {
    let mode = ModalOscillator {
        frequency: FREQUENCY,
        damping_ratio: DAMPING_RATIO,
        damping_rate: 0.0,
        mass: MASS,
        tip_value: PHI,
    };
    ModelParameters {
        beam: Beam::new(&[mode]).unwrap(),
        friction,
        ..ModelParameters::default()
    }
}

/// Laws with power series, and one that is integrated by its values.
fn laws() -> [FrictionLaw; 3] {
    [
        FrictionLaw::default(),
        FrictionLaw::Coulomb {
            mu_s: 0.6,
            mu_k: 0.4,
        },
        FrictionLaw::StelterAsPrinted(Exponential::default()),
    ]
}

/// Displacement q in m and velocity of `q'' + 2 D w q' + w^2 q = phi (F + r t)/m` from rest.
fn forced(force: f64, rate: f64, t: f64) -> (f64, f64) {
    let gain = PHI / MASS;
    let slope = gain * rate / (W * W);
    let shift = (gain * force - 2.0 * DAMPING_RATIO * W * slope) / (W * W);
    let decay = DAMPING_RATIO * W;
    let ringing = W * (1.0 - DAMPING_RATIO * DAMPING_RATIO).sqrt();
    let (s, c) = (ringing * t).sin_cos();
    let a = -shift;
    let b = (decay * a - slope) / ringing;
    let envelope = (-decay * t).exp();
    let q = shift + slope * t + envelope * (a * c + b * s);
    let v = slope + envelope * (ringing * (b * c - a * s) - decay * (a * c + b * s));
    (q, v)
}

#[test]
fn val_a_force_on_a_free_oscillator_gives_its_step_and_ramp_response() {
    // Source: closed form of the damped oscillator under F + r t, from rest.
    for law in laws() {
        // Without a belt the contact reverses at each turn, with a fast one never; no load, so no friction.
        for belt in [0.0, 50.0] {
            for (force, rate) in [(30.0, 0.0), (0.0, 900.0), (-20.0, 1500.0)] {
                let inputs = Inputs {
                    external_force: force,
                    external_force_rate: rate,
                    ..Inputs::constant(belt, 0.0)
                };
                let start = Start::default();
                let mut run = Simulation::new(&oscillator(law), inputs, &start, 1e-12).unwrap();
                for i in 1..=40 {
                    let t = 2.3e-3 * f64::from(i);
                    run.advance_to(t).unwrap();
                    let (q, v) = forced(force, rate, t);
                    let x = run.state();
                    let off = (x[0] - q).abs();
                    assert!(off < 1e-11, "{law:?}, {inputs:?} at {t} s: {} {q}", x[0]);
                    let off = (x[1] - v).abs();
                    assert!(off < 1e-8, "{law:?}, {inputs:?} at {t} s: {} {v}", x[1]);
                    assert_eq!(run.outputs().friction_force, 0.0);
                }
            }
        }
    }
}

/// Stick at rest on a belt, bent by nothing.
fn stuck(belt: f64) -> Start {
    let mut state = [0.0; MAX_STATES];
    state[1] = belt / PHI;
    Start {
        state,
        contact: StartContact::Stick,
        ..Start::default()
    }
}

#[test]
fn val_stick_holds_up_to_the_limit_and_breaks_where_the_forces_balance() {
    // Source: balance F_c = k v0 t + c v0 - F_0 - r t = +-mu_s (F_N + n t), k = m w^2/phi^2, c = 2 D w m/phi^2.
    let stiffness = MASS * W * W / (PHI * PHI);
    let damper = 2.0 * DAMPING_RATIO * W * MASS / (PHI * PHI);
    for law in laws() {
        let mu = law.static_coefficient();
        for (belt, load, load_rate) in [(0.0, 60.0, 0.0), (0.02, 60.0, 0.0), (0.02, 60.0, -90.0)] {
            for (force, rate) in [(-5.0, 400.0), (3.0, -700.0), (12.0, 0.0)] {
                let inputs = Inputs {
                    external_force: force,
                    external_force_rate: rate,
                    normal_force_rate: load_rate,
                    ..Inputs::constant(belt, load)
                };
                let law_run = oscillator(law);
                let mut run = Simulation::new(&law_run, inputs, &stuck(belt), 1e-12).unwrap();
                run.record_transitions();
                assert_eq!(run.contact_mode(), ContactMode::Stuck);
                let at_rest = run.outputs().friction_force;
                assert_relative_eq!(at_rest, damper * belt - force, max_relative = 1e-12);
                let sided = |side: f64| {
                    let rises = stiffness * belt - rate - side * mu * load_rate;
                    (side * mu * load - damper * belt + force) / rises
                };
                let leaves = [sided(1.0), sided(-1.0)]
                    .into_iter()
                    .filter(|t| *t > 0.0 && t.is_finite())
                    .fold(f64::INFINITY, f64::min);
                let name = format!("{law:?}, {inputs:?}");
                if leaves == f64::INFINITY {
                    // A constant push below the limit is held for ever.
                    run.advance_to(0.5).unwrap();
                    assert!(run.transitions().is_empty(), "{name}");
                    continue;
                }
                run.advance_to(leaves + 1e-4).unwrap();
                let first = run.transitions()[0];
                assert!(
                    (first.time - leaves).abs() < 1e-12,
                    "{name}: {first:?} {leaves}"
                );
                let force_there = stiffness * belt * leaves + damper * belt - force - rate * leaves;
                assert_eq!(first.to, ContactMode::slip_towards(-force_there), "{name}");
            }
        }
    }
}

#[test]
fn val_a_push_beyond_the_limit_ends_stick_at_once_and_one_below_does_not() {
    // Source: Coulomb's law, |F_c| <= mu_s F_N with F_c = -F_ext at rest.
    let law = FrictionLaw::Coulomb {
        mu_s: 0.6,
        mu_k: 0.4,
    };
    let rest = Inputs::constant(0.0, 50.0);
    for (push, to) in [
        (29.99, ContactMode::Stuck),
        (30.01, ContactMode::Forward),
        (-29.99, ContactMode::Stuck),
        (-30.01, ContactMode::Backward),
    ] {
        let mut run = Simulation::new(&oscillator(law), rest, &stuck(0.0), 1e-12).unwrap();
        run.advance_to(0.01).unwrap();
        let inputs = Inputs {
            external_force: push,
            ..rest
        };
        run.set_inputs(inputs).unwrap();
        assert_eq!(run.contact_mode(), to, "{push} N");
        let acceleration = run.outputs().acceleration;
        let expected = match to {
            ContactMode::Stuck => 0.0,
            // Kinetic friction is left to brake: 20 N.
            _ => (push - 20.0 * push.signum()) * PHI * PHI / MASS,
        };
        assert_relative_eq!(acceleration, expected, epsilon = 1e-12, max_relative = 1e-9);
    }
}
