//! Tangencies: turning points and transitions that are only just met, or only just missed, against closed forms.

use beam_physics::beam::{Beam, ModalOscillator};
use beam_physics::belt::Inputs;
use beam_physics::contact::ContactMode;
use beam_physics::friction::FrictionLaw;
use beam_physics::integrate::MAX_STATES;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start, StartContact};
use beam_physics::sweep::{Motion, Rule, Section, StartRule, Status, Values, evaluate};
use std::f64::consts::{PI, TAU};

const W: f64 = TAU * 40.0;
const STIFFNESS: f64 = 0.5 * W * W;
const TOLERANCE: f64 = 1e-13;

fn motion(set: &[(&str, f64)], settle: usize, cycles: usize, section: Section) -> Motion {
    let mut values = Values::default();
    for (name, value) in set {
        values.set(name, *value).unwrap();
    }
    values.set("tolerance", TOLERANCE).unwrap();
    let rule = Rule {
        settle,
        cycles,
        patience: 0,
        section,
        lyapunov: false,
    };
    evaluate(&values.subject().unwrap(), &rule, &StartRule::Fixed, None).unwrap()
}

fn assert_near(found: f64, expected: f64, within: f64) {
    assert!(
        (found - expected).abs() <= within,
        "{found} instead of {expected}, {:e} apart",
        found - expected
    );
}

const SPEED: f64 = 0.1;

/// Free vibration with the tip's velocity `w' = SPEED (cos x + b cos 2x)`, x = W t. At x = pi it has a maximum of
/// SPEED (b - 1): for b = 1 the section w' = 0 is tangent to the motion there.
fn two_tones(b: f64) -> Motion {
    let set = [
        ("mode[1].frequency", 40.0),
        ("mode[2].frequency", 80.0),
        ("mode[1].damping_ratio", 0.0),
        ("mode[2].damping_ratio", 0.0),
        ("mode[1].tip_value", 1.0),
        ("mode[2].tip_value", 1.0),
        // No contact force, and a belt that the tip never is as fast as.
        ("normal_force", 0.0),
        ("belt_velocity", 10.0),
        ("q_dot[1]", SPEED),
        ("q_dot[2]", SPEED * b),
        ("start.contact", 2.0),
    ];
    motion(&set, 4, 12, Section::Peak)
}

/// x of the peak that is always there, and of the one beyond the tangency, if there is one.
fn turning(b: f64) -> (f64, Option<f64>) {
    let root = (1.0 + 8.0 * b * b).sqrt();
    let other = (-1.0 - root) / (4.0 * b);
    let second = (other >= -1.0).then(|| TAU - other.acos());
    (((root - 1.0) / (4.0 * b)).acos(), second)
}

// Source: the turning points of cos x + b cos 2x, roots of a quadratic in cos x.
#[test]
fn val_a_section_that_is_nearly_touched_is_not_met() {
    for missed in [1e-4, 1e-6, 1e-8] {
        let b = 1.0 - missed;
        let found = two_tones(b);
        let (x, _) = turning(b);
        assert_eq!(found.period, Some(1), "{missed:e}");
        for (i, point) in found.section.iter().enumerate() {
            let cycle = (4 + i) as f64;
            assert_near(point.time, (x + TAU * cycle) / W, 1e-11);
        }
    }
}

// Source: the same roots; beyond the tangency a trough and a peak lie 2 sqrt(2 (b - 1) / 3) apart.
#[test]
fn val_a_section_just_beyond_the_tangency_is_met_twice_more() {
    for beyond in [1e-4_f64, 1e-6, 1e-8] {
        let b = 1.0 + beyond;
        let found = two_tones(b);
        let (x, second) = turning(b);
        let second = second.unwrap();
        assert_near(
            second - PI,
            (2.0 * beyond / 3.0).sqrt(),
            1e-2 * beyond.sqrt(),
        );
        assert_eq!(found.period, Some(2), "{beyond:e}");
        for (i, point) in found.section.iter().enumerate() {
            // Four peaks in two cycles are discarded.
            let cycle = (2 + i / 2) as f64;
            let (x, steepness) = if i % 2 == 0 {
                (x, 1.0)
            } else {
                (second, second - PI)
            };
            // An error of the velocity moves a flat root further than a steep one.
            assert_near(point.time, (x + TAU * cycle) / W, 1e-14 / steepness + 1e-12);
            let displacement = (x.sin() + 0.5 * b * (2.0 * x).sin()) * SPEED / W;
            assert_near(point.displacement, displacement, 1e-14);
        }
    }
}

const V0: f64 = 0.08;
const LOAD: f64 = 50.0;
const REST: f64 = 0.4 * LOAD / STIFFNESS;

/// A mass on a spring that slips under constant friction, `w = REST + a cos W t` with `a W = share V0`: for share = 1 the
/// tip's velocity touches the belt's once in each cycle.
fn slipping(share: f64) -> Simulation {
    let parameters = ModelParameters {
        beam: Beam::new(&[ModalOscillator {
            frequency: 40.0,
            damping_ratio: 0.0,
            damping_rate: 0.0,
            mass: 0.5,
            tip_value: 1.0,
        }])
        .unwrap(),
        friction: FrictionLaw::Coulomb {
            mu_s: 0.6,
            mu_k: 0.4,
        },
        ..ModelParameters::default()
    };
    let mut state = [0.0; MAX_STATES];
    state[0] = REST + share * V0 / W;
    let start = Start {
        state,
        contact: StartContact::Slip,
        ..Start::default()
    };
    let inputs = Inputs::constant(V0, LOAD);
    let mut run = Simulation::new(&parameters, inputs, &start, TOLERANCE).unwrap();
    run.record_transitions();
    run
}

// Source: closed form w' = -a W sin W t, whose largest value is below the belt's velocity.
#[test]
fn val_a_belt_velocity_that_is_nearly_reached_ends_no_slip() {
    for missed in [1e-4, 1e-6, 1e-9] {
        let mut run = slipping(1.0 - missed);
        run.advance_to(10.0 * TAU / W).unwrap();
        assert_eq!(run.transition_count(), 0, "{missed:e}");
        let back = REST + (1.0 - missed) * V0 / W;
        assert_near(run.outputs().displacement, back, 1e-14);
    }
}

// Source: the same closed form reaches V0 where sin W t = -1 / share, just before three quarters of the cycle, at
// w = REST + a cos W t; there the spring is weaker than static friction, so that the tip sticks.
#[test]
fn val_a_belt_velocity_that_is_just_reached_ends_the_slip() {
    for beyond in [1e-4, 1e-6, 1e-9] {
        let share = 1.0 + beyond;
        let mut run = slipping(share);
        let phase = PI + (1.0_f64 / share).asin();
        let flat = (share * share - 1.0).sqrt();
        run.advance_to((1.5 * PI + 0.1) / W).unwrap();
        let transitions = run.transitions();
        assert_eq!(transitions.len(), 1, "{beyond:e}");
        assert_eq!(transitions[0].to, ContactMode::Stuck);
        // The slope of the velocity there is V0 W sqrt(share^2 - 1).
        assert_near(transitions[0].time, phase / W, 1e-14 / flat);
        let landed = REST - flat * V0 / W;
        let since = run.time() - transitions[0].time;
        assert_near(run.outputs().displacement, landed + V0 * since, 1e-13);
    }
}

// Source: both closed forms as a sweep sees them: without stick no release; with it the limit cycle of Den Hartog (1931),
// released at w = mu_s F_N / k.
#[test]
fn val_a_sweep_tells_the_two_sides_of_a_grazing_slip_apart() {
    let at = |share: f64| {
        let set = [
            ("mode_count", 1.0),
            ("mode[1].frequency", 40.0),
            ("mode[1].damping_ratio", 0.0),
            ("mode[1].mass", 0.5),
            ("mode[1].tip_value", 1.0),
            ("friction.law", 3.0),
            ("friction.mu_s", 0.6),
            ("friction.mu_k", 0.4),
            ("belt_velocity", V0),
            ("normal_force", LOAD),
            ("q[1]", REST + share * V0 / W),
            ("start.contact", 2.0),
        ];
        motion(&set, 5, 20, Section::Release)
    };
    let missed = at(1.0 - 1e-9);
    assert_eq!(missed.status, Status::NoSection);
    assert_near(missed.amplitude, V0 / W, 1e-12);
    assert_eq!(missed.stick_fraction, 0.0);
    let met = at(1.0 + 1e-9);
    assert_eq!(met.section.len(), 20);
    let half = 0.2 * LOAD / STIFFNESS;
    assert_near(met.amplitude, half.hypot(V0 / W), 1e-12);
    for point in &met.section {
        assert_near(point.displacement, REST + half, 1e-12);
    }
}
