//! Sections at release and stroboscopic ones against closed forms and against the model in plain lines.

#[allow(dead_code)]
#[path = "../src/plain.rs"]
mod plain;

use beam_physics::sweep::{Crossing, Motion, Rule, Section, StartRule, Status, Values, evaluate};
use plain::Plain;
use std::f64::consts::{PI, TAU};

const W: f64 = TAU * 40.0;
const STIFFNESS: f64 = 0.5 * W * W;
const V0: f64 = 0.08;
/// Half the way in m of a stick, and the middle of the slips: Coulomb's law at 50 N, 0.6 and 0.4.
const HALF: f64 = 0.2 * 50.0 / STIFFNESS;
const MIDDLE: f64 = 0.4 * 50.0 / STIFFNESS;

fn motion(set: &[(&str, f64)], settle: usize, cycles: usize, section: Section) -> Motion {
    let mut values = Values::default();
    for (name, value) in set {
        values.set(name, *value).unwrap();
    }
    let rule = Rule {
        settle,
        cycles,
        patience: 0,
        section,
        lyapunov: false,
    };
    evaluate(&values.subject().unwrap(), &rule, &StartRule::Fixed, None).unwrap()
}

/// A mass on a spring without damping under Coulomb's law, in stick from w = 0 on.
fn slider(section: Section) -> Motion {
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
        ("normal_force", 50.0),
        ("tolerance", 1e-12),
        ("q_dot[1]", V0),
        ("start.contact", 1.0),
    ];
    motion(&set, 5, 20, section)
}

/// When the slider is released first, and its period, in s.
fn slider_times() -> (f64, f64, f64) {
    let slip = (PI + 2.0 * (V0 / (W * HALF)).atan()) / W;
    ((MIDDLE + HALF) / V0, slip, slip + 2.0 * HALF / V0)
}

/// Displacement and velocity of the slider after its first release.
fn slider_at(t: f64) -> (f64, f64) {
    let (first, slip, cycle) = slider_times();
    let since = (t - first).rem_euclid(cycle);
    if since < slip {
        let (s, c) = (W * since).sin_cos();
        (MIDDLE + HALF * c + V0 / W * s, V0 * c - HALF * W * s)
    } else {
        (MIDDLE - HALF + V0 * (since - slip), V0)
    }
}

fn assert_near(found: f64, expected: f64, within: f64) {
    assert!(
        (found - expected).abs() <= within,
        "{found} instead of {expected}, {:e} apart",
        found - expected
    );
}

// Source: closed form of the limit cycle under Coulomb's law (Den Hartog 1931): stick ends at w = mu_s F_N / k with the
// belt's velocity, once in each cycle.
#[test]
fn val_release_points_of_the_slider_are_those_of_the_closed_form() {
    let found = slider(Section::Release);
    let (first, _, cycle) = slider_times();
    assert_eq!(found.period, Some(1));
    assert_near(found.duration.unwrap(), cycle, 1e-10);
    // 20 peaks, and one peak after each release.
    assert_eq!(found.section.len(), 20);
    for (i, point) in found.section.iter().enumerate() {
        assert_near(point.time, first + (5 + i) as f64 * cycle, 1e-10);
        assert_near(point.displacement, MIDDLE + HALF, 1e-11);
        assert_near(point.velocity, V0, 1e-11);
    }
}

// Source: the same closed form, looked at three times in two cycles: in stick and in slip.
#[test]
fn val_stroboscopic_points_of_the_slider_are_those_of_the_closed_form() {
    let (first, slip, cycle) = slider_times();
    let period = 2.0 * cycle / 3.0;
    let found = slider(Section::Stroboscopic { period });
    assert_eq!(found.period, Some(3));
    assert_near(found.duration.unwrap(), 2.0 * cycle, 1e-10);
    // 20 peaks are 19 cycles apart; where the stretch ends between two peaks is not fixed.
    assert!((28..=31).contains(&found.section.len()));
    let begin = (found.section[0].time / period).round();
    let mut in_stick = 0;
    for (i, point) in found.section.iter().enumerate() {
        assert_near(point.time, (begin + i as f64) * period, 1e-15);
        let (displacement, velocity) = slider_at(point.time);
        assert_near(point.displacement, displacement, 1e-11);
        assert_near(point.velocity, velocity, 1e-11 * W);
        in_stick += usize::from((point.time - first).rem_euclid(cycle) > slip);
    }
    assert!(in_stick > 0 && in_stick < found.section.len());
}

/// The nominal beam under 100 N, which begins in stick; no two cycles of its first ones are alike.
fn beam(section: Section) -> (Motion, Vec<f64>) {
    let start = [1.1e-3, 0.04875, -2e-5, 0.0];
    let mut set = vec![
        ("belt_velocity", 0.0975),
        ("normal_force", 100.0),
        ("tolerance", 1e-12),
    ];
    let names = ["q[1]", "q_dot[1]", "q[2]", "q_dot[2]"];
    set.extend(names.into_iter().zip(start));
    (motion(&set, 4, 6, section), start.to_vec())
}

fn plainly<R>(use_it: impl FnOnce(&Plain<'_>) -> R) -> R {
    use_it(&Plain {
        modes: vec![
            (TAU * 80.0, 0.00015, 0.427, 2.0),
            (TAU * 510.0, 0.00085, 0.427, -2.0),
        ],
        mu: |v| 0.66 * (0.5 + 0.5 * (-v / 0.02).exp()) * (0.5 + 0.5 * (-0.25 * v).exp()),
        mu_0: 0.66,
        belt: &|_| 0.0975,
        belt_rate: 0.0,
        normal: &|_| 100.0,
        push: &|_| 0.0,
        clamp: &|_| 0.0,
    })
}

fn tip(x: &[f64]) -> (f64, f64) {
    (2.0 * x[0] - 2.0 * x[2], 2.0 * x[1] - 2.0 * x[3])
}

/// Goes on in the plain model from one point's time to the next and compares; the integration there is by steps of 1e-6 s,
/// good to about 1e-8 of the amplitude over these cycles.
fn compare_with_plain(points: &[Crossing], start: Vec<f64>) {
    plainly(|plain| {
        let (mut t, mut x, mut mode) = (0.0, start, 0.0);
        for point in points {
            (_, mode) = plain.run(t, &mut x, mode, point.time);
            t = point.time;
            let (displacement, velocity) = tip(&x);
            assert_near(point.displacement, displacement, 1e-9);
            assert_near(point.velocity, velocity, 1e-6);
        }
    });
}

// Source: direct simulation of the same equations in plain.rs, which shares no code with the integrators, stopped at each
// multiple of the period.
#[test]
fn val_stroboscopic_points_of_the_beam_are_those_of_a_plain_simulation() {
    let (found, start) = beam(Section::Stroboscopic { period: 0.0071 });
    assert!(found.section.len() > 20, "{}", found.section.len());
    for pair in found.section.windows(2) {
        assert_near(pair[1].time - pair[0].time, 0.0071, 1e-14);
    }
    compare_with_plain(&found.section, start);
}

// Source: direct simulation of the same equations in plain.rs: the ends of its sticks, each by bisection.
#[test]
fn val_release_points_of_the_beam_are_those_of_a_plain_simulation() {
    let (found, start) = beam(Section::Release);
    let last = found.section.last().unwrap().time;
    let mut x = start.clone();
    let (transitions, _) = plainly(|plain| plain.run(0.0, &mut x, 0.0, last + 1e-4));
    let releases: Vec<f64> = transitions
        .iter()
        .filter(|(_, left)| *left == 0.0)
        .map(|(t, _)| *t)
        .collect();
    assert!(found.section.len() >= 5);
    // The first ones belong to the transient.
    let measured = &releases[releases.len() - found.section.len()..];
    for (point, t) in found.section.iter().zip(measured) {
        assert_near(point.time, *t, 1e-8);
        assert_near(point.velocity, 0.0975, 1e-12);
    }
    compare_with_plain(&found.section, start);
}

// Source: the definition: a tip that never sticks, because the belt is faster than it ever moves, is never released.
#[test]
fn val_a_section_that_is_never_met_is_named() {
    let set = [
        ("normal_force", 0.0),
        ("belt_velocity", 10.0),
        ("q[1]", 1e-3),
        ("start.contact", 2.0),
    ];
    let found = motion(&set, 5, 20, Section::Release);
    assert_eq!(found.status, Status::NoSection);
    assert!(found.section.is_empty() && found.amplitude > 1e-3);
}
