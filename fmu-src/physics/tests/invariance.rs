//! What must not change the motion, and what must change it in a known way.

use approx::assert_relative_eq;
use beam_physics::belt::Inputs;
use beam_physics::contact::ContactMode;
use beam_physics::error::PhysicsError;
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{DEFAULT_TOLERANCE, Outputs, Simulation, Start, StartContact};

/// In stick, bent towards the belt's motion.
fn bent(sign: f64) -> Start {
    let mut state = [0.0; MAX_STATES];
    // Static deflection of both modes under 45 N: break-away comes after 8 ms at 0.1 m/s.
    state[0] = sign * 8.34e-4;
    state[2] = sign * -2.05e-5;
    Start {
        state,
        contact: StartContact::Stick,
        ..Start::default()
    }
}

fn run(inputs: Inputs, start: &Start) -> Simulation {
    let parameters = ModelParameters::default();
    let mut run = Simulation::new(&parameters, inputs, start, DEFAULT_TOLERANCE).unwrap();
    run.record_transitions();
    run
}

#[test]
fn the_callers_stops_are_invisible() {
    let times: Vec<f64> = (1..=40).map(|i| 0.0073 * f64::from(i)).collect();
    let through = |between: &dyn Fn(f64, f64) -> Vec<f64>| -> Vec<Outputs> {
        let mut run = run(Inputs::constant(0.1, 100.0), &bent(1.0));
        let mut before = 0.0;
        let mut out = Vec::new();
        for t in &times {
            for stop in between(before, *t) {
                run.advance_to(stop).unwrap();
            }
            run.advance_to(*t).unwrap();
            out.push(run.outputs());
            before = *t;
        }
        out
    };
    let straight = through(&|_, _| Vec::new());
    for pieces in [2, 7, 730] {
        let stops = |a: f64, b: f64| {
            (1..pieces)
                .map(|i| a + (b - a) * f64::from(i) / f64::from(pieces))
                .collect()
        };
        assert_eq!(through(&stops), straight, "{pieces} pieces");
    }
    // Stops exactly at a transition, and steps of no length or hardly any.
    let mut scout = run(Inputs::constant(0.1, 100.0), &bent(1.0));
    scout.advance_to(0.3).unwrap();
    let events: Vec<f64> = scout.transitions().iter().map(|e| e.time).collect();
    let stops = |a: f64, b: f64| {
        let inside = events.iter().copied().filter(|t| a < *t && *t < b);
        inside.flat_map(|t| [t, t, t + 2e-14]).collect()
    };
    assert_eq!(through(&stops), straight, "stops at transitions");
}

#[test]
fn a_reversed_belt_mirrors_the_motion() {
    let mut there = run(Inputs::constant(0.1, 100.0), &bent(1.0));
    let mut back = run(Inputs::constant(-0.1, 100.0), &bent(-1.0));
    for i in 1..=300 {
        let t = 1e-3 * f64::from(i);
        there.advance_to(t).unwrap();
        back.advance_to(t).unwrap();
        let (a, b) = (there.outputs(), back.outputs());
        assert_eq!(a.displacement, -b.displacement, "at {t} s");
        assert_eq!(a.friction_force, -b.friction_force, "at {t} s");
        assert_eq!(a.mode.sign(), -b.mode.sign(), "at {t} s");
    }
    assert!(there.transition_count() > 10);
}

#[test]
fn the_start_time_shifts_everything() {
    let mut zero = run(Inputs::constant(0.1, 100.0), &bent(1.0));
    let later = Start {
        time: 1024.0,
        ..bent(1.0)
    };
    let mut late = run(Inputs::constant(0.1, 100.0), &later);
    zero.advance_to(0.1).unwrap();
    late.advance_to(1024.1).unwrap();
    for (a, b) in zero.transitions().iter().zip(late.transitions()) {
        // 1e-13 s is the resolution of time at 1024 s.
        assert_relative_eq!(a.time, b.time - 1024.0, epsilon = 1e-11);
    }
    assert_eq!(zero.transition_count(), late.transition_count());
}

#[test]
fn motion_scales_with_the_normal_force_where_velocities_do() {
    // With Coulomb's law displacements scale with F_N if v0 does: the equations are homogeneous.
    let parameters = ModelParameters {
        friction: beam_physics::friction::FrictionLaw::Coulomb {
            mu_s: 0.6,
            mu_k: 0.4,
        },
        ..ModelParameters::default()
    };
    let scaled = |factor: f64| {
        let mut start = bent(1.0);
        start.state.iter_mut().for_each(|x| *x *= factor);
        let inputs = Inputs::constant(0.1 * factor, 100.0 * factor);
        let mut run = Simulation::new(&parameters, inputs, &start, DEFAULT_TOLERANCE).unwrap();
        run.advance_to(0.2).unwrap();
        run.outputs().displacement / factor
    };
    assert_relative_eq!(scaled(1.0), scaled(0.5), max_relative = 1e-6);
}

#[test]
fn long_advances_and_standing_belts_are_legal() {
    let mut standing = run(Inputs::constant(0.0, 100.0), &bent(1.0));
    standing.advance_to(1e3).unwrap();
    assert_eq!(standing.outputs().mode, ContactMode::Stuck);
    assert_eq!(standing.outputs().displacement.signum(), 1.0);
    let mut unloaded = run(Inputs::constant(0.0, 0.0), &Start::default());
    unloaded.advance_to(100.0).unwrap();
    assert_eq!(unloaded.outputs().displacement, 0.0);
    let mut long = run(Inputs::constant(0.1, 100.0), &bent(1.0));
    long.advance_to(60.0).unwrap();
    assert!(long.outputs().displacement.abs() < 0.01);
    assert!(long.transition_count() > 2_000);
}

#[test]
fn new_inputs_keep_position_velocity_and_place() {
    // Mid-stick and mid-slip.
    for (t, mode) in [(0.004, ContactMode::Stuck), (0.011, ContactMode::Backward)] {
        let mut run = run(Inputs::constant(0.1, 100.0), &bent(1.0));
        run.advance_to(t).unwrap();
        let before = run.outputs();
        assert_eq!(before.mode, mode);
        for inputs in [
            Inputs::constant(0.1, 20.0),
            Inputs::constant(-0.3, 20.0),
            Inputs::constant(0.0, 0.0),
        ] {
            run.set_inputs(inputs).unwrap();
            let after = run.outputs();
            assert_relative_eq!(after.displacement, before.displacement, epsilon = 1e-16);
            assert_relative_eq!(after.velocity, before.velocity, epsilon = 1e-13);
            assert_relative_eq!(after.belt_travel, before.belt_travel, epsilon = 1e-15);
        }
    }
}

#[test]
fn inputs_set_again_change_nothing() {
    let inputs = Inputs::constant(0.1, 100.0);
    let mut straight = run(inputs, &bent(1.0));
    let mut disturbed = run(inputs, &bent(1.0));
    for i in 1..=100 {
        disturbed.advance_to(1e-3 * f64::from(i)).unwrap();
        disturbed.set_inputs(inputs).unwrap();
    }
    straight.advance_to(0.1).unwrap();
    assert_eq!(straight.transition_count(), disturbed.transition_count());
    for (a, b) in straight.transitions().iter().zip(disturbed.transitions()) {
        assert_eq!((a.from, a.to), (b.from, b.to));
        assert_relative_eq!(a.time, b.time, epsilon = 1e-8);
    }
    let dwell = |run: &Simulation| run.outputs().dwell;
    assert_relative_eq!(dwell(&straight), dwell(&disturbed), epsilon = 1e-8);
}

#[test]
fn a_lighter_load_breaks_the_contact_at_once() {
    let mut run = run(Inputs::constant(0.1, 100.0), &bent(1.0));
    run.advance_to(0.004).unwrap();
    assert_eq!(run.outputs().mode, ContactMode::Stuck);
    run.set_inputs(Inputs::constant(0.1, 20.0)).unwrap();
    assert_eq!(run.outputs().mode, ContactMode::Backward);
    let event = run.transitions()[0];
    assert_eq!((event.time, event.from), (0.004, ContactMode::Stuck));
}

#[test]
fn impossible_inputs_leave_the_run_as_it_was() {
    let mut disturbed = run(Inputs::constant(0.1, 100.0), &bent(1.0));
    let mut straight = disturbed.clone();
    disturbed.advance_to(0.01).unwrap();
    for inputs in [
        Inputs::constant(0.1, -1.0),
        Inputs::constant(f64::NAN, 1.0),
        Inputs::constant(0.1, f64::INFINITY),
    ] {
        let error = disturbed.set_inputs(inputs).unwrap_err();
        assert!(matches!(error, PhysicsError::OutOfRange { .. }), "{error}");
    }
    disturbed.advance_to(0.1).unwrap();
    straight.advance_to(0.1).unwrap();
    assert_eq!(disturbed.outputs(), straight.outputs());
}

/// A run of which only w and v0 t are known at a later instant, as of a measured one that is cut into pieces: begun anew there
/// with the place under a belt that does not give way, it must pass the same places as the run in one piece.
#[test]
fn a_piece_of_a_run_on_a_belt_that_gives_way_passes_the_same_places() {
    const DISPLACEMENT: usize = 4;
    let mut parameters = ModelParameters::default();
    let mut set = |name: &str, value: f64| parameters.effects.set_named(name, value).unwrap();
    set("belt_drive_compliance.mass", 0.5);
    set("belt_drive_compliance.stiffness", 3e4);
    set("belt_drive_compliance.damping", 70.0);
    set("belt_periodic_friction.amplitude", 0.13);
    set("belt_periodic_friction.wavelength", 5e-3);
    let inputs = Inputs::constant(0.1, 100.0);
    let begin = |start: &Start| Simulation::new(&parameters, inputs, start, 1e-12).unwrap();
    let at_start = Start {
        settled: true,
        ..bent(1.0)
    };
    for (number, cut) in [0.021, 0.037, 0.055].into_iter().enumerate() {
        let mut whole = begin(&at_start);
        let (began, given) = (whole.outputs(), whole.state()[DISPLACEMENT]);
        whole.advance_to(cut).unwrap();
        let there = whole.outputs();
        // As a rigid belt would have carried the tip, but for what the drive had given at the start, which is a constant.
        let known =
            began.belt_travel - given + 0.1 * cut - (there.displacement - began.displacement);
        let mut piece = Start {
            time: cut,
            settled: true,
            belt_travel: known,
            contact: match there.mode {
                ContactMode::Stuck => StartContact::Stick,
                _ => StartContact::Slip,
            },
            ..at_start
        };
        piece.state[..DISPLACEMENT].copy_from_slice(&whole.state()[..DISPLACEMENT]);
        // The drive's states count from equilibrium, which a start there tells; friction in slip depends on them in turn.
        for _ in 0..20 {
            let reached = begin(&piece).state();
            for i in DISPLACEMENT..DISPLACEMENT + 2 {
                piece.state[i] += whole.state()[i] - reached[i];
            }
        }
        let mut piece = begin(&piece);
        assert!(
            (whole.state()[DISPLACEMENT] - given).abs() > 1e-5,
            "cut {number}"
        );
        for later in [0.0, 0.01, 0.02] {
            whole.advance_to(cut + later).unwrap();
            piece.advance_to(cut + later).unwrap();
            let (a, b) = (whole.outputs(), piece.outputs());
            assert_relative_eq!(a.belt_travel, b.belt_travel, epsilon = 1e-8);
            assert_relative_eq!(a.displacement, b.displacement, epsilon = 1e-8);
        }
    }
}
