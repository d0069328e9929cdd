//! The equations handed to an integrator from outside: classical Runge-Kutta steps and bisection on the event
//! functions meet the golden transition times (reference-data/computed/golden: three independent integrators).

use beam_physics::belt::Inputs;
use beam_physics::contact::ContactMode;
use beam_physics::hybrid::{Hybrid, Rates};
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{DEFAULT_TOLERANCE, Simulation, Start, StartContact};
use serde_json::Value;

/// Step in s.
const H: f64 = 2e-6;

fn hybrid(inputs: Inputs, state: &[f64], parameters: &ModelParameters) -> Hybrid {
    let mut start = Start {
        contact: StartContact::Stick,
        ..Start::default()
    };
    start.state[..state.len()].copy_from_slice(state);
    let run = Simulation::new(parameters, inputs, &start, DEFAULT_TOLERANCE).unwrap();
    Hybrid::start(&run)
}

/// The instant `h` s after `from` if the rates were `rates` all along.
fn ahead(from: &Hybrid, rates: &Rates, h: f64) -> Hybrid {
    let mut next = from.clone();
    next.set_time(from.time() + h);
    for i in 0..MAX_STATES {
        next.set_state(i, from.state()[i] + h * rates.state[i]);
    }
    next.set_belt_distance(from.belt_distance() + h * rates.belt_distance);
    for i in 0..3 {
        next.set_energy(i, from.energy()[i] + h * rates.energy[i]);
    }
    next
}

/// One step of the classical Runge-Kutta method.
fn step(from: &Hybrid, h: f64) -> Hybrid {
    let k1 = from.rates().unwrap();
    let k2 = ahead(from, &k1, h / 2.0).rates().unwrap();
    let k3 = ahead(from, &k2, h / 2.0).rates().unwrap();
    let k4 = ahead(from, &k3, h).rates().unwrap();
    let mean = |f: &dyn Fn(&Rates) -> f64| (f(&k1) + 2.0 * (f(&k2) + f(&k3)) + f(&k4)) / 6.0;
    let rates = Rates {
        state: std::array::from_fn(|i| mean(&|k| k.state[i])),
        belt_distance: mean(&|k| k.belt_distance),
        energy: std::array::from_fn(|i| mean(&|k| k.energy[i])),
    };
    ahead(from, &rates, h)
}

fn has_event(a: &Hybrid, b: &Hybrid) -> bool {
    let (a, b) = (a.event_functions(), b.event_functions());
    a.iter().zip(b).any(|(a, b)| (*a > 0.0) != (b > 0.0))
}

/// Runs to `end` in s; gives the transitions (time, mode left).
fn run(mut now: Hybrid, end: f64) -> (Vec<(f64, ContactMode)>, Hybrid) {
    let mut transitions = Vec::new();
    while now.time() < end {
        let mut next = step(&now, H);
        if has_event(&now, &next) {
            let (mut low, mut high) = (0.0, H);
            while high - low > 1e-16 {
                let middle = 0.5 * (low + high);
                if has_event(&now, &step(&now, middle)) {
                    high = middle;
                } else {
                    low = middle;
                }
            }
            next = step(&now, high);
            let left = next.mode();
            let count = next.transition_count();
            next.update();
            assert!(!has_event(&next, &next.clone()));
            if next.transition_count() != count {
                transitions.push((next.time(), left));
            }
        }
        now = next;
    }
    (transitions, now)
}

#[test]
fn val_transitions_of_the_golden_cases_are_met_to_1e_8_s() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../reference-data/computed/golden/events.json"
    );
    let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for case in &cases {
        let number = |key: &str| case[key].as_f64().unwrap();
        let state: Vec<f64> = case["initial_state"]
            .as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect();
        let inputs = Inputs::constant(number("belt_velocity_m_per_s"), number("normal_force_n"));
        let golden: Vec<(f64, f64)> = case["events"]
            .as_array()
            .unwrap()
            .iter()
            .map(|e| (e[0].as_f64().unwrap(), e[1].as_f64().unwrap()))
            .take(40)
            .collect();
        let end = golden.last().unwrap().0 + 1e-5;
        let (mine, _) = run(hybrid(inputs, &state, &ModelParameters::default()), end);
        assert_eq!(mine.len(), golden.len());
        let mut worst: f64 = 0.0;
        for ((t, left), (time, mode)) in mine.iter().zip(&golden) {
            assert_eq!(left.sign(), *mode, "mode left at {time} s");
            worst = worst.max((t - time).abs());
        }
        println!("{inputs:?}: worst {worst:.1e} s in {end} s");
        assert!(worst < 1e-8, "{worst:e} s");
    }
}

#[test]
fn val_energies_and_belt_distance_are_those_of_the_run_from_inside() {
    // Truth: the balance belt work = stored + dissipated, and distance = velocity * time.
    let start = hybrid(
        Inputs::constant(0.1, 100.0),
        &[],
        &ModelParameters::default(),
    );
    let begin = start.belt_distance();
    let before = start.model().stored_energy(start.state());
    let (_, end) = run(start, 0.05);
    let [work, contact, structure, pushed] = end.energy();
    assert_eq!(pushed, 0.0);
    let stored = end.model().stored_energy(end.state()) - before;
    assert!(work > 0.05 && contact > 0.01 && structure > 0.0);
    assert!((work - contact - structure - stored).abs() < 1e-8 * work);
    assert!((end.belt_distance() - begin - 0.1 * end.time()).abs() < 1e-12);
}

#[test]
fn an_event_leaves_every_function_off_zero_and_a_second_look_changes_nothing() {
    for normal_force in [0.0, 1e-9, 100.0] {
        let mut h = hybrid(
            Inputs::constant(0.1, normal_force),
            &[1e-4, 0.05, 0.0, 0.0],
            &ModelParameters::default(),
        );
        for _ in 0..50 {
            h = step(&h, H);
            h.update();
            let (mode, state) = (h.mode(), *h.state());
            assert!(
                h.event_functions().iter().all(|z| *z > 0.0),
                "{normal_force}"
            );
            h.update();
            assert_eq!((h.mode(), *h.state()), (mode, state), "{normal_force}");
        }
    }
}

#[test]
fn stick_leads_a_small_relative_velocity_back_and_a_jump_of_the_belt_ends_it() {
    let mut h = hybrid(
        Inputs::constant(0.1, 100.0),
        &[],
        &ModelParameters::default(),
    );
    h.set_inputs([0.1 + 1e-6, 100.0, 0.0, 0.0], false).unwrap();
    for _ in 0..500 {
        h = step(&h, H);
    }
    assert_eq!(h.mode(), ContactMode::Stuck);
    let v_r = h.model().relative_velocity(h.time(), h.state());
    assert!(v_r.abs() < 1e-12, "{v_r}");
    h.set_inputs([0.2, 100.0, 0.0, 0.0], true).unwrap();
    h.update();
    assert_eq!(h.mode(), ContactMode::Backward);
    assert_eq!(h.transition_count(), 1);
    assert!(h.set_inputs([0.2, -1.0, 0.0, 0.0], true).is_err());
}
