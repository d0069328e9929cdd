//! Runs by collocation against golden transitions, and against the event loop with its Taylor series.

use super::Collocated;
use crate::beam::{Beam, MAX_MODES, ModalOscillator};
use crate::belt::Inputs;
use crate::contact::{ContactMode, Transition};
use crate::friction::FrictionLaw;
use crate::integrate::MAX_STATES;
use crate::parameters::ModelParameters;
use crate::simulate::{DEFAULT_TOLERANCE, Simulation, Start, StartContact};
use serde_json::Value;

fn transitions(run: &Simulation, until: f64) -> Vec<Transition> {
    let mut run = Collocated::take_over(run).expect("covered");
    let mut found = Vec::new();
    while run.front().0 < until {
        assert!(
            run.next_piece().unwrap(),
            "too steep at {} s",
            run.front().0
        );
        found.extend(run.piece_transition());
    }
    found.retain(|t| t.time < until);
    found
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list").iter();
    list.map(|v| v.as_f64().expect("a number")).collect()
}

// Source: reference-data/computed/golden, where three independent integrators agree to 1e-10 s.
#[test]
fn val_golden_transitions() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../reference-data/computed/golden/events.json"
    );
    let cases: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for case in cases.as_array().unwrap() {
        for (tolerance, allowed) in [(DEFAULT_TOLERANCE, 1e-7), (1e-12, 1e-9)] {
            let mut state = [0.0; MAX_STATES];
            state[..4].copy_from_slice(&numbers(&case["initial_state"]));
            let number = |name: &str| case[name].as_f64().unwrap();
            let inputs =
                Inputs::constant(number("belt_velocity_m_per_s"), number("normal_force_n"));
            let start = Start {
                state,
                ..Start::default()
            };
            let parameters = ModelParameters::default();
            let run = Simulation::new(&parameters, inputs, &start, tolerance).unwrap();
            let found = transitions(&run, number("stop_time_s"));
            let golden = case["events"].as_array().unwrap();
            assert!(
                found.len() >= golden.len(),
                "{} of {}",
                found.len(),
                golden.len()
            );
            for (event, mine) in golden.iter().zip(found) {
                let event = numbers(event);
                let late = (mine.time - event[0]).abs();
                assert_eq!(mine.from.sign(), event[1], "mode left at {} s", event[0]);
                assert!(late < allowed, "{late:e} s at {} s, {inputs:?}", event[0]);
            }
        }
    }
}

/// Transitions up to `until` in s against those of the event loop at the tolerance `exact`.
fn compare(parameters: &ModelParameters, inputs: Inputs, start: &Start, until: f64, exact: f64) {
    let allowed = 1e-6;
    let mut exact = Simulation::new(parameters, inputs, start, exact).unwrap();
    exact.record_transitions();
    exact.advance_to(until).unwrap();
    let run = Simulation::new(parameters, inputs, start, DEFAULT_TOLERANCE).unwrap();
    let found = transitions(&run, until);
    let expected = exact.transitions();
    assert_eq!(found.len(), expected.len(), "{inputs:?} {start:?}");
    for (mine, other) in found.iter().zip(expected) {
        assert_eq!((mine.from, mine.to), (other.from, other.to), "{inputs:?}");
        let late = (mine.time - other.time).abs();
        assert!(late < allowed, "{late:e} s at {} s, {inputs:?}", other.time);
    }
}

// Source: the event loop with Taylor series at tolerance 1e-13, short motions from many starts, where the order of
// transitions tells of any arrival or break-away that is missed.
#[test]
fn val_no_transition_is_missed_or_feigned_from_any_start() {
    let parameters = ModelParameters::default();
    let mut number = 1u64;
    let mut draw = || {
        number = number
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (number >> 11) as f64 / (1u64 << 53) as f64
    };
    for _ in 0..200 {
        let (force, belt) = (5.0 + 100.0 * draw(), 0.01 + 0.2 * draw());
        let belt = if draw() < 0.2 { -belt } else { belt };
        let mut state = [0.0; MAX_STATES];
        for (x, size) in state.iter_mut().zip([1e-3, 0.2, 1e-4, 0.1]) {
            *x = size * (2.0 * draw() - 1.0);
        }
        let contact = if draw() < 0.5 {
            StartContact::Stick
        } else {
            StartContact::Slip
        };
        let start = Start {
            state,
            contact,
            ..Start::default()
        };
        compare(
            &parameters,
            Inputs::constant(belt, force),
            &start,
            0.03,
            1e-13,
        );
    }
}

// Source: as above, for the other laws of exponentials and for one to eight modes, some of them damped strongly.
#[test]
fn val_other_laws_and_structures() {
    let stribeck = |exponent| FrictionLaw::Stribeck {
        mu_s: 0.66,
        mu_k: 0.35,
        velocity: 0.03,
        exponent,
        viscous: 0.05,
    };
    let coulomb = FrictionLaw::Coulomb {
        mu_s: 0.6,
        mu_k: 0.4,
    };
    for friction in [
        FrictionLaw::default(),
        coulomb,
        stribeck(1.0),
        stribeck(2.0),
    ] {
        for modes in [1, 2, 3, MAX_MODES] {
            for damping in [0.001, 0.4] {
                let list: Vec<_> = (0..modes)
                    .map(|j| ModalOscillator {
                        frequency: 80.0 + 230.0 * j as f64,
                        damping_ratio: damping,
                        damping_rate: 0.0,
                        mass: 0.5 + 0.1 * j as f64,
                        tip_value: if j % 2 == 0 { 2.0 } else { -1.5 },
                    })
                    .collect();
                let parameters = ModelParameters {
                    beam: Beam::new(&list).unwrap(),
                    friction,
                    ..ModelParameters::default()
                };
                let inputs = Inputs::constant(0.08, 60.0);
                // The longer series of tolerance 1e-13 does not see exp(-u^2) grow within a step.
                let exact = if friction == stribeck(2.0) {
                    1e-10
                } else {
                    1e-13
                };
                let start = Start {
                    contact: StartContact::Stick,
                    ..Start::default()
                };
                compare(&parameters, inputs, &start, 0.05, exact);
            }
        }
    }
}

// Source: the state of the event loop at the same instants, in stick and slip.
#[test]
fn val_states_within_the_pieces() {
    let start = Start {
        contact: StartContact::Stick,
        ..Start::default()
    };
    let inputs = Inputs::constant(0.1, 100.0);
    let parameters = ModelParameters::default();
    let mut exact = Simulation::new(&parameters, inputs, &start, 1e-13).unwrap();
    let run = Simulation::new(&parameters, inputs, &start, DEFAULT_TOLERANCE).unwrap();
    let mut run = Collocated::take_over(&run).unwrap();
    let mut modes = [false; 2];
    while run.front().0 < 0.1 {
        assert!(run.next_piece().unwrap());
        let (from, to, mode) = (run.piece().start, run.piece().end, run.piece().mode);
        modes[usize::from(mode == ContactMode::Stuck)] = true;
        for share in [0.1, 0.5, 0.9] {
            let t = from + share * (to - from);
            exact.advance_to(t).unwrap();
            let (mine, other) = (run.state_at(t), exact.state());
            for i in 0..4 {
                let size = if i % 2 == 0 { 1e-9 } else { 1e-6 };
                assert!((mine[i] - other[i]).abs() < size, "state {i} at {t} s");
            }
        }
    }
    assert_eq!(modes, [true, true]);
}

#[test]
fn models_that_are_not_covered_are_left_to_the_event_loop() {
    let inputs = Inputs::constant(0.1, 100.0);
    let covered = |friction, inputs, tolerance| {
        let parameters = ModelParameters {
            friction,
            ..ModelParameters::default()
        };
        let run = Simulation::new(&parameters, inputs, &Start::default(), tolerance).unwrap();
        Collocated::take_over(&run).is_some()
    };
    let law = FrictionLaw::default();
    assert!(covered(law, inputs, 1e-10));
    assert!(!covered(law, inputs, 1e-14));
    assert!(!covered(law, Inputs::constant(0.0, 100.0), 1e-10));
    let ramp = Inputs {
        normal_force_rate: 1.0,
        ..inputs
    };
    assert!(!covered(law, ramp, 1e-10));
    let pushed = Inputs {
        external_force: 1.0,
        ..inputs
    };
    assert!(!covered(law, pushed, 1e-10));
    let pushed_more = Inputs {
        external_force_rate: 1.0,
        ..inputs
    };
    assert!(!covered(law, pushed_more, 1e-10));
    let shaken = Inputs {
        clamp_acceleration: 1.0,
        ..inputs
    };
    assert!(!covered(law, shaken, 1e-10));
    let printed = FrictionLaw::StelterAsPrinted(crate::friction::Exponential::default());
    assert!(!covered(printed, inputs, 1e-10));
}

// Source: the event loop with Taylor series at tolerance 1e-13. The motion settles on period one, so that late slips follow
// earlier ones and need no exponential of their own.
#[test]
fn val_slips_that_follow_others_are_as_exact() {
    let inputs = Inputs::constant(0.0963, 100.0);
    let (parameters, start, until) = (ModelParameters::default(), Start::default(), 4.0);
    let mut exact = Simulation::new(&parameters, inputs, &start, 1e-13).unwrap();
    exact.record_transitions();
    exact.advance_to(until).unwrap();
    let run = Simulation::new(&parameters, inputs, &start, DEFAULT_TOLERANCE).unwrap();
    let mut run = Collocated::take_over(&run).unwrap();
    let mut found = Vec::new();
    while run.front().0 < until {
        assert!(run.next_piece().unwrap());
        found.extend(run.piece_transition());
    }
    found.retain(|t| t.time < until);
    assert_eq!(found.len(), exact.transitions().len());
    for (mine, other) in found.iter().zip(exact.transitions()) {
        let late = (mine.time - other.time).abs();
        assert!(late < 1e-10, "{late:e} s at {} s", other.time);
    }
    let (slips, remembered) = (found.len() / 2, run.memory.remembered());
    assert!(remembered < slips / 2 + 20, "{remembered} of {slips}");
}

// Source: central differences of runs by the event loop at tolerance 1e-13, over some slips and sticks.
#[test]
fn val_a_difference_is_carried_through_slip_stick_and_transitions() {
    let law = FrictionLaw::default();
    let jumps = FrictionLaw::Coulomb {
        mu_s: 0.6,
        mu_k: 0.4,
    };
    for (modes, friction, belt, force) in [
        (2, law, 0.0963, 100.0),
        (2, law, -0.05, 60.0),
        (4, law, 0.112, 100.0),
        (2, jumps, 0.08, 60.0),
    ] {
        let parameters = ModelParameters {
            friction,
            beam: Beam::nominal(modes),
            ..ModelParameters::default()
        };
        let inputs = Inputs::constant(belt, force);
        let mut origin = Simulation::new(&parameters, inputs, &Start::default(), 1e-13).unwrap();
        origin.advance_to(0.2).unwrap();
        // A slip that is well under way, so that its neighbours start in slip as well.
        while origin.contact_mode() == ContactMode::Stuck {
            let t = origin.time() + 1e-3;
            origin.advance_to(t).unwrap();
        }
        let (begin, end) = (origin.time(), origin.time() + 0.1);
        let from = |state| Start {
            time: begin,
            state,
            contact: StartContact::Slip,
            ..Start::default()
        };
        let x = origin.state();
        let mut direction = [0.0; MAX_STATES];
        for j in 0..modes {
            let size = 1e-3 / (1.0 + j as f64);
            (direction[2 * j], direction[2 * j + 1]) = (size, -300.0 * size);
        }
        let at_end = |step: f64| {
            let state = std::array::from_fn(|i| x[i] + step * direction[i]);
            let mut run = Simulation::new(&parameters, inputs, &from(state), 1e-13).unwrap();
            run.record_transitions();
            run.advance_to(end).unwrap();
            (run.state(), run.transitions().len())
        };
        let h = 1e-5;
        let ((above, transitions), (below, _)) = (at_end(h), at_end(-h));
        assert!(transitions >= 3, "{transitions} transitions");
        let run = Simulation::new(&parameters, inputs, &from(x), 1e-12).unwrap();
        let mut run = Collocated::take_over(&run).unwrap();
        run.vary(&direction);
        while run.front().0 < end {
            assert!(run.next_piece().unwrap());
        }
        let found = run.difference_at(end).unwrap();
        let scales = run.model().state_scales();
        let expected: [f64; MAX_STATES] =
            std::array::from_fn(|i| (above[i] - below[i]) / (2.0 * h));
        let size = (0..2 * modes).map(|i| (expected[i] / scales[i]).abs());
        let size = size.fold(0.0, f64::max);
        for i in 0..2 * modes {
            let error = (found[i] - expected[i]).abs() / scales[i];
            assert!(error < 1e-4 * size, "state {i}: {found:?} {expected:?}");
        }
    }
}

// Source: classical Runge-Kutta in 200 000 steps. The motion is so fast at first that the fast exponential of friction, e^-80, is
// not there for a Taylor series of degree 20, and slow in the end, where it is all that counts. The event loop was 9e-7 m/s off
// before its steps were shortened for that.
#[test]
fn val_fast_slip_that_comes_to_rest() {
    let (t, steps) = (0.001_092_23, 200_000);
    let mut state = [0.0; MAX_STATES];
    state[..4].copy_from_slice(&[-1.989_813e-3, -0.918_045, -1.963_21e-4, -3.101e-4]);
    let start = Start {
        state,
        contact: StartContact::Stick,
        ..Start::default()
    };
    let parameters = ModelParameters::default();
    let inputs = Inputs::constant(0.405_914, 175.882_508);
    let run = Simulation::new(&parameters, inputs, &start, DEFAULT_TOLERANCE).unwrap();
    let mut by_series = run.clone();
    let mut run = Collocated::take_over(&run).unwrap();
    let (model, mut x, mode) = (run.model().clone(), *run.front().1, run.front().2);
    assert_eq!(mode, ContactMode::Backward);
    while run.front().0 < t {
        assert!(run.next_piece().unwrap());
    }
    let h = t / f64::from(steps);
    let ahead = |x: &[f64; MAX_STATES], k: &[f64; MAX_STATES], h: f64| {
        std::array::from_fn(|i| x[i] + h * k[i])
    };
    let rates = |x: &[f64; MAX_STATES]| {
        let mut rates = [0.0; MAX_STATES];
        model.rates(0.0, x, mode, &mut rates);
        rates
    };
    for _ in 0..steps {
        let a = rates(&x);
        let b = rates(&ahead(&x, &a, 0.5 * h));
        let c = rates(&ahead(&x, &b, 0.5 * h));
        let d = rates(&ahead(&x, &c, h));
        x = std::array::from_fn(|i| x[i] + h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]));
    }
    by_series.advance_to(t).unwrap();
    for (found, bound) in [(run.state_at(t), 1e-11), (by_series.state(), 1e-10)] {
        for i in 0..4 {
            assert!((found[i] - x[i]).abs() < bound, "{found:?} {x:?}");
        }
    }
}
