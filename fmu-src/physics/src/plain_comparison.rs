//! The model against its plain twin ([`crate::plain`]), which shares no code with it.

use crate::beam::Beam;
use crate::belt::Inputs;
use crate::integrate::MAX_STATES;
use crate::parameters::ModelParameters;
use crate::plain::Plain;
use crate::simulate::{Simulation, Start, StartContact};

/// Eq. (7) with the exponent read as |v_r|/c1.
fn mu(v: f64) -> f64 {
    0.66 * (0.5 + 0.5 * (-v / 0.02).exp()) * (0.5 + 0.5 * (-0.25 * v).exp())
}

struct Case {
    beam: Beam,
    inputs: Inputs,
    /// Static tip force in N that bends the beam at the start.
    bend: f64,
}

impl Case {
    fn new(modes: usize, normal_force: f64, belt_velocity: f64) -> Self {
        Self {
            beam: Beam::from_frequencies(&[80.0, 510.0], &[1.5e-4, 8.5e-4], 0.427, modes).unwrap(),
            inputs: Inputs::constant(belt_velocity, normal_force),
            bend: 0.5 * 0.66 * normal_force * belt_velocity.signum(),
        }
    }

    fn plain<'a>(&self, [belt, normal, push, clamp]: [&'a dyn Fn(f64) -> f64; 4]) -> Plain<'a> {
        let mode = |m: &crate::beam::ModalOscillator| {
            let w = std::f64::consts::TAU * m.frequency;
            (w, m.damping_ratio, m.mass, m.tip_value)
        };
        Plain {
            modes: self.beam.modes().iter().map(mode).collect(),
            mu,
            mu_0: 0.66,
            belt,
            belt_rate: self.inputs.belt_acceleration,
            normal,
            push,
            clamp,
        }
    }

    /// In stick: bent by a static force, every mode with its share of the belt's velocity.
    fn start(&self) -> Vec<f64> {
        let modes = self.beam.modes();
        let mobility: f64 = modes.iter().map(|m| m.tip_value.powi(2) / m.mass).sum();
        modes
            .iter()
            .flat_map(|m| {
                let share = m.tip_value / m.mass;
                let w = std::f64::consts::TAU * m.frequency;
                [
                    share * self.bend / (w * w),
                    share / mobility * self.inputs.belt_velocity,
                ]
            })
            .collect()
    }

    fn simulation(&self, x: &[f64]) -> Simulation {
        let parameters = ModelParameters {
            beam: self.beam,
            ..ModelParameters::default()
        };
        let mut state = [0.0; MAX_STATES];
        state[..x.len()].copy_from_slice(x);
        let start = Start {
            state,
            contact: StartContact::Stick,
            ..Start::default()
        };
        let mut run = Simulation::new(&parameters, self.inputs, &start, 1e-13).unwrap();
        run.record_transitions();
        run
    }

    /// Both run to `end`, with new inputs at `change` if they are given; returns the mode then.
    fn compare(&self, end: f64, change: Option<(f64, Inputs)>) -> f64 {
        let mut x = self.start();
        let mut run = self.simulation(&x);
        let i = self.inputs;
        let belt = |t: f64| i.belt_velocity + i.belt_acceleration * t;
        let normal = |t: f64| i.normal_force + i.normal_force_rate * t;
        let push = |t: f64| i.external_force + i.external_force_rate * t;
        let first = change.map_or(end, |c| c.0);
        let clamp = |t: f64| i.clamp_acceleration + i.clamp_acceleration_rate * t;
        let plain = self.plain([&belt, &normal, &push, &clamp]);
        let (mut expected, mode) = plain.run(0.0, &mut x, 0.0, first);
        run.advance_to(first).unwrap();
        if let Some((t, inputs)) = change {
            let belt = |_: f64| inputs.belt_velocity;
            let normal = |_: f64| inputs.normal_force;
            let push = |_: f64| inputs.external_force;
            let clamp = |_: f64| inputs.clamp_acceleration;
            let plain = self.plain([&belt, &normal, &push, &clamp]);
            // A stick whose belt or load has changed goes on only if it still can.
            let moved = inputs.belt_velocity - i.belt_velocity;
            let next = match (mode, moved) {
                (0.0, 0.0) => plain.mode_at_rest(t, &x),
                (0.0, _) => -moved.signum(),
                _ => mode,
            };
            if next != mode {
                expected.push((t, mode));
            }
            expected.extend(plain.run(t, &mut x, next, end).0);
            run.set_inputs(inputs).unwrap();
            run.advance_to(end).unwrap();
        }
        let name = format!("{i:?}, {} modes, {change:?}", self.beam.modes().len());
        let found = run.transitions();
        assert_eq!(
            found.len(),
            expected.len(),
            "{name}: {found:?} {expected:?}"
        );
        for ((time, left), mine) in expected.iter().zip(found) {
            assert_eq!(mine.from.sign(), *left, "{name} at {time} s");
            assert!(
                (mine.time - time).abs() < 1e-9,
                "{name}: {time} {}",
                mine.time
            );
        }
        for (i, (mine, plain)) in run.state().iter().zip(&x).enumerate() {
            let tolerance = if i % 2 == 0 { 1e-11 } else { 3e-8 };
            assert!((mine - plain).abs() < tolerance, "{name}: {mine} {plain}");
        }
        assert!(!expected.is_empty(), "{name}: nothing happened");
        mode
    }
}

#[test]
fn val_the_plain_twin_agrees() {
    // Source: src/plain.rs, an independent statement of the equations.
    Case::new(2, 100.0, 0.1).compare(0.15, None);
    Case::new(2, 60.0, 0.06).compare(0.1, None);
    Case::new(1, 100.0, 0.1).compare(0.15, None);
    Case::new(3, 80.0, 0.05).compare(0.1, None);
    Case::new(2, 41.0, -0.03).compare(0.1, None);
}

#[test]
fn val_the_plain_twin_agrees_with_ramps() {
    // Source: src/plain.rs, an independent statement of the equations.
    let mut case = Case::new(2, 100.0, 0.1);
    case.inputs.normal_force_rate = -300.0;
    case.compare(0.1, None);
    case.inputs.normal_force_rate = 0.0;
    case.inputs.belt_acceleration = -1.5;
    case.compare(0.12, None);
    case.inputs.normal_force_rate = 200.0;
    case.compare(0.1, None);
    // Eases off faster than the beam can follow: stick ends although the belt stands nearly still.
    let mut case = Case::new(1, 60.0, 0.01);
    case.inputs.normal_force_rate = -2000.0;
    case.compare(0.025, None);
}

#[test]
fn val_the_plain_twin_agrees_under_an_external_force() {
    // Source: src/plain.rs, an independent statement of the equations.
    let mut case = Case::new(2, 100.0, 0.1);
    case.inputs.external_force = 20.0;
    case.compare(0.1, None);
    case.inputs.external_force_rate = -700.0;
    case.compare(0.1, None);
    case.inputs.normal_force_rate = -300.0;
    case.compare(0.1, None);
    // Pulled off a belt that stands still, and with one mode against the belt.
    let mut case = Case::new(2, 60.0, 0.0);
    case.bend = 0.0;
    case.inputs.external_force_rate = 2000.0;
    case.compare(0.06, None);
    let mut case = Case::new(1, 60.0, 0.05);
    case.inputs.external_force = -15.0;
    case.compare(0.1, None);
    // A push that begins during stick, one that breaks it and one that does not, and during slip.
    let case = Case::new(2, 100.0, 0.1);
    for (t, mode) in [(0.004, 0.0), (0.012, -1.0)] {
        for force in [-90.0, -10.0, 30.0, 140.0] {
            let inputs = Inputs {
                external_force: force,
                ..case.inputs
            };
            assert_eq!(case.compare(0.06, Some((t, inputs))), mode);
        }
    }
}

#[test]
fn val_the_plain_twin_agrees_on_a_clamp_that_accelerates() {
    // Source: src/plain.rs, an independent statement of the equations.
    for modes in [1, 2, 3] {
        let mut case = Case::new(modes, 80.0, 0.07);
        case.inputs.clamp_acceleration = 25.0;
        case.compare(0.1, None);
        case.inputs.clamp_acceleration_rate = -900.0;
        case.compare(0.1, None);
        case.inputs.external_force = 12.0;
        case.inputs.normal_force_rate = -200.0;
        case.compare(0.1, None);
    }
    // Shaken off a belt that stands still.
    let mut case = Case::new(2, 60.0, 0.0);
    case.bend = 0.0;
    case.inputs.clamp_acceleration_rate = 20_000.0;
    case.compare(0.08, None);
    // A clamp that jerks during stick and during slip.
    let case = Case::new(2, 100.0, 0.1);
    for (t, mode) in [(0.004, 0.0), (0.012, -1.0)] {
        for clamp_acceleration in [-250.0, -20.0, 60.0, 400.0] {
            let inputs = Inputs {
                clamp_acceleration,
                ..case.inputs
            };
            assert_eq!(case.compare(0.06, Some((t, inputs))), mode);
        }
    }
}

#[test]
fn val_the_plain_twin_agrees_where_inputs_jump() {
    // Source: src/plain.rs, an independent statement of the equations.
    let case = Case::new(2, 100.0, 0.1);
    // In stick, and in the slip after it.
    for (t, mode) in [(0.004, 0.0), (0.012, -1.0)] {
        for (belt, normal) in [
            (0.1, 45.0),
            (0.1, 140.0),
            (0.05, 100.0),
            (0.13, 100.0),
            (0.1003, 100.0),
            (-0.1, 60.0),
        ] {
            let inputs = Inputs::constant(belt, normal);
            assert_eq!(case.compare(0.06, Some((t, inputs))), mode);
        }
    }
}
