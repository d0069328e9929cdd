//! A clamp that accelerates: step and ramp response of a mass on a spring, and the stick that it breaks, in closed form.

use approx::assert_relative_eq;
use beam_physics::beam::{Beam, MAX_MODES, ModalOscillator, cantilever_clamp_share};
use beam_physics::belt::Inputs;
use beam_physics::contact::ContactMode;
use beam_physics::friction::FrictionLaw;
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start, StartContact};
use std::f64::consts::{PI, TAU};

const MASS: f64 = 0.8;
const W: f64 = TAU * 30.0;
const FRICTION: FrictionLaw = FrictionLaw::Coulomb {
    mu_s: 0.6,
    mu_k: 0.4,
};

/// A mass on a spring in a frame that shakes, its coordinate `1/phi` of the displacement.
fn mass_on_spring(phi: f64) -> ModelParameters {
    let mode = ModalOscillator {
        frequency: W / TAU,
        damping_ratio: 0.0,
        damping_rate: 0.0,
        mass: MASS * phi * phi,
        tip_value: phi,
    };
    let structure = Beam::new(&[mode]).unwrap();
    let beam = structure.with_clamp_shares([1.0; MAX_MODES]).unwrap();
    ModelParameters {
        beam,
        friction: FRICTION,
        ..ModelParameters::default()
    }
}

fn shaken(acceleration: f64, rate: f64, normal_force: f64) -> Inputs {
    Inputs {
        clamp_acceleration: acceleration,
        clamp_acceleration_rate: rate,
        ..Inputs::constant(0.0, normal_force)
    }
}

#[test]
fn val_a_mass_on_a_spring_lags_behind_its_frame() {
    // Source: closed form of m (x'' + a + r t) + k x = 0 from rest, x relative to the frame.
    for phi in [1.0, -2.5] {
        for (a, r) in [(3.0, 0.0), (0.0, 70.0), (-2.0, 150.0)] {
            let inputs = shaken(a, r, 0.0);
            let start = Start::default();
            let mut run = Simulation::new(&mass_on_spring(phi), inputs, &start, 1e-12).unwrap();
            for i in 1..=30 {
                let t = 3.1e-3 * f64::from(i);
                run.advance_to(t).unwrap();
                let (sin, cos) = (W * t).sin_cos();
                let x = (a * (cos - 1.0) + r * (sin / W - t)) / (W * W);
                let v = (r * (cos - 1.0) - a * W * sin) / (W * W);
                let state = run.state();
                let off = (phi * state[0] - x).abs();
                assert!(off < 1e-11, "{phi}, {inputs:?} at {t} s: {off:e}");
                let off = (phi * state[1] - v).abs();
                assert!(off < 1e-9, "{phi}, {inputs:?} at {t} s: {off:e}");
            }
        }
    }
}

#[test]
fn val_stick_on_a_belt_at_rest_breaks_where_inertia_exceeds_the_limit() {
    // Source: F_c = m (a + r t) at rest, Coulomb's law |F_c| <= mu_s F_N.
    let start = Start {
        state: [0.0; MAX_STATES],
        contact: StartContact::Stick,
        ..Start::default()
    };
    for phi in [1.0, -2.5] {
        for (a, r) in [(5.0, 400.0), (5.0, -900.0)] {
            let run = mass_on_spring(phi);
            let mut run = Simulation::new(&run, shaken(a, r, 20.0), &start, 1e-12).unwrap();
            run.record_transitions();
            assert_relative_eq!(run.outputs().friction_force, MASS * a, epsilon = 1e-12);
            let leaves = (0.6 * 20.0 * r.signum() / MASS - a) / r;
            run.advance_to(leaves + 1e-4).unwrap();
            let first = run.transitions()[0];
            assert!((first.time - leaves).abs() < 1e-12, "{first:?} {leaves}");
            // The mass stays behind the frame.
            assert_eq!(first.to, ContactMode::slip_towards(-r), "{first:?}");
        }
    }
}

#[test]
fn val_all_modes_of_a_cantilever_take_its_tip_along_with_the_clamp() {
    // Source: completeness of the modes (a beam that moves as one body has tip displacement 1), with the asymptote
    // 8/((2j - 1) pi) of the shares beyond those here, whose alternating sum over all j is 2.
    let shares: Vec<f64> = (0..MAX_MODES).map(cantilever_clamp_share).collect();
    let asymptotes = (0..MAX_MODES).map(|j| {
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        sign * 8.0 / ((2 * j + 1) as f64 * PI)
    });
    let beyond = 2.0 - asymptotes.sum::<f64>();
    let sum = shares.iter().sum::<f64>() + beyond;
    assert!((sum - 1.0).abs() < 1e-5, "{shares:?}: {sum}");
}
