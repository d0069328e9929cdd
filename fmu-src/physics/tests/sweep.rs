//! Parameter studies and orbits against identities, closed forms and one another.

use beam_physics::sweep::orbit::{BranchKind, OrbitError, continue_branch, shoot};
use beam_physics::sweep::{
    Chain, Motion, Rule, StartRule, Status, Subject, Task, Values, evaluate, main_frequency, run,
    spectrum, static_amplitude, trace,
};

fn values(set: &[(&str, f64)]) -> Values {
    let mut values = Values::default();
    for (name, value) in set {
        values.set(name, *value).unwrap();
    }
    values
}

fn subject(set: &[(&str, f64)]) -> Subject {
    values(set).subject().unwrap()
}

fn motion(subject: &Subject) -> Motion {
    evaluate(subject, &Rule::default(), &StartRule::Fixed, None).unwrap()
}

// Source: the attractor itself, by direct simulation with another tolerance and no Newton steps.
#[test]
fn val_shooting_finds_the_attractor_of_period_one() {
    let subject = subject(&[("belt_velocity", 0.096), ("normal_force", 100.0)]);
    let found = evaluate(
        &subject,
        &Rule {
            settle: 400,
            ..Rule::default()
        },
        &StartRule::Fixed,
        None,
    )
    .unwrap();
    assert_eq!(found.period, Some(1));
    let orbit = shoot(&subject, &found.end.as_ref().unwrap().state, 1).unwrap();
    assert!(orbit.is_stable());
    let peak = found.section.last().unwrap().displacement;
    assert!((orbit.displacement - peak).abs() < 1e-9 * peak, "{peak}");
    let period = found.duration.unwrap();
    assert!((orbit.period - period).abs() < 1e-9 * period, "{period}");
}

// Source: the identity lambda = ln|mu| / T between a periodic motion's exponent and its largest multiplier; one comes
// from a second motion over 200 returns, the other from differences of single returns.
#[test]
fn val_the_exponent_of_a_period_one_motion_is_that_of_its_multiplier() {
    for velocity in [0.096, 0.099] {
        let subject = subject(&[("belt_velocity", velocity)]);
        let found = motion(&subject);
        let orbit = shoot(&subject, &found.end.as_ref().unwrap().state, 1).unwrap();
        let expected = orbit.largest().ln() / orbit.period;
        let exponent = found.lyapunov.unwrap();
        // A complex pair turns the difference on an ellipse; its axes enter at both ends of the 5.4 s measured.
        assert!(
            (exponent - expected).abs() < 0.03,
            "{exponent} /s against {expected} /s at {velocity} m/s"
        );
    }
}

// Source: two motions through their own transitions, which is how exponents of models with effects are found. An effect that
// does nothing here makes the model one of those.
#[test]
fn val_exponents_by_variation_are_those_of_a_second_motion() {
    let exponent = |set: &[(&str, f64)], cycles| {
        let rule = Rule {
            cycles,
            patience: 0,
            ..Rule::default()
        };
        let motion = evaluate(&subject(set), &rule, &StartRule::Fixed, None).unwrap();
        motion.lyapunov.unwrap()
    };
    // Two motions of period five, and an irregular one, of which no two runs are the same for long.
    for (velocity, cycles, allowed) in [(0.1045, 200, 0.1), (0.1088, 200, 0.1), (0.112, 6000, 0.5)]
    {
        let given = ("belt_velocity", velocity);
        let alone = exponent(&[given], cycles);
        let other = exponent(&[given, ("cubic_stiffness.coefficient", 1e-3)], cycles);
        assert!(
            (alone - other).abs() < allowed,
            "{alone} and {other} /s at {velocity} m/s"
        );
    }
}

// Source: the decay of a disturbance, measured over 60 returns of a direct simulation.
#[test]
fn val_the_largest_multiplier_is_the_measured_decay() {
    let subject = subject(&[("belt_velocity", 0.097)]);
    let end = motion(&subject).end.unwrap();
    let orbit = shoot(&subject, &end.state, 1).unwrap();
    let mut disturbed = Subject {
        given: None,
        ..subject.clone()
    };
    disturbed.tolerance = 1e-13;
    let mut carry = end.clone();
    carry.state = orbit.state;
    carry.state[0] += 1e-4 * orbit.amplitude;
    let rule = Rule {
        settle: 4,
        cycles: 80,
        patience: 0,
        lyapunov: false,
        ..Rule::default()
    };
    let found = evaluate(&disturbed, &rule, &StartRule::Carried, Some(&carry)).unwrap();
    // A complex pair turns: the largest of some neighbouring distances does not see it.
    let away = |from: usize| {
        found.section[from..from + 10]
            .iter()
            .map(|p| (p.displacement - orbit.displacement).abs())
            .fold(0.0, f64::max)
    };
    let measured = (away(65) / away(5)).powf(1.0 / 60.0);
    assert!(
        (measured - orbit.largest()).abs() < 2e-3,
        "{measured} against {}",
        orbit.largest()
    );
}

// Source: counting dimensions: with one mode every stick ends in the same state, so that a disturbance is gone.
#[test]
fn val_one_mode_forgets_everything_in_stick() {
    let subject = subject(&[
        ("mode_count", 1.0),
        ("normal_force", 60.0),
        ("belt_velocity", 0.05),
    ]);
    let found = motion(&subject);
    assert_eq!(found.period, Some(1));
    assert_eq!(found.lyapunov, Some(f64::NEG_INFINITY));
    assert!(found.stick_fraction > 0.1, "{}", found.stick_fraction);
    let orbit = shoot(&subject, &found.end.unwrap().state, 1).unwrap();
    assert!(orbit.largest() < 1e-6, "{:?}", orbit.multipliers);
}

// Source: Stelter 1992, eqs. (7) and (8), worked out here for two modes.
#[test]
fn val_the_main_frequency_of_a_motion_that_repeats_is_that_of_a_long_record() {
    // Source: the spectrum of 6 s sampled by the event loop.
    for velocity in [0.096, 0.098, 0.104, 0.11] {
        let subject = subject(&[("belt_velocity", velocity), ("normal_force", 100.0)]);
        let motion = motion(&subject);
        assert!(motion.period.unwrap() >= 1);
        let (duration, count) = (6.0, 12_000);
        let record = trace(&subject, &motion.end.unwrap(), duration, count).unwrap();
        let samples: Vec<f64> = record.iter().map(|s| s.displacement).collect();
        let line = main_frequency(&spectrum(&samples, duration / count as f64)).unwrap();
        let found = motion.main_frequency.unwrap();
        assert!((found / line - 1.0).abs() < 1e-3, "{found} {line} Hz");
    }
}

#[test]
fn val_static_amplitude_is_equation_8() {
    let (force, velocity): (f64, f64) = (80.0, 0.06);
    let tau = std::f64::consts::TAU;
    let compliance: f64 = [80.0, 510.0]
        .iter()
        .map(|f| 4.0 / (0.427 * (tau * f).powi(2)))
        .sum();
    let mu = 0.66 * (0.5 + 0.5 * (-velocity / 0.02).exp()) * (0.5 + 0.5 * (-0.25 * velocity).exp());
    let expected = force * compliance * (0.66 - mu);
    let model = values(&[("normal_force", force), ("belt_velocity", velocity)])
        .model()
        .unwrap();
    assert!((static_amplitude(&model) - expected).abs() < 1e-12 * expected);
}

// Source: without friction, without a belt that moves, and with a friction that rises with speed (eq. 7 as printed)
// nothing feeds a vibration.
#[test]
fn val_points_without_motion_are_named() {
    for (set, expected) in [
        (
            &[("normal_force", 0.0)][..],
            &[Status::DiesOut, Status::Rest][..],
        ),
        (&[("belt_velocity", 0.0)], &[Status::Rest]),
        (&[("friction.law", 2.0)], &[Status::DiesOut, Status::Rest]),
    ] {
        let found = motion(&subject(set));
        assert!(
            expected.contains(&found.status),
            "{set:?}: {:?}",
            found.status
        );
    }
}

// Source: the definition: what a point gives depends on the point alone.
#[test]
fn val_results_do_not_depend_on_the_number_of_threads() {
    let rule = Rule {
        settle: 20,
        cycles: 20,
        patience: 0,
        ..Rule::default()
    };
    let chains: Vec<Chain> = (0..6)
        .map(|id| Chain {
            carried: None,
            tasks: vec![Task {
                id,
                values: values(&[("belt_velocity", 0.1 + 0.002 * id as f64)]),
                start: StartRule::Fixed,
            }],
        })
        .collect();
    let all = |threads| {
        let mut found = Vec::new();
        run(&chains, &rule, threads, |outcome| {
            found.push((outcome.id, outcome.motion.unwrap()));
            true
        });
        found.sort_by_key(|(id, _)| *id);
        found
    };
    assert_eq!(all(1), all(3));
}

// Source: the orbits before and after: a motion of period one that is stable at 0.097 m/s and not at 0.106 m/s has lost
// its stability between; by a complex pair, because direct simulation shows an irregular motion with an exponent near 0 there.
#[test]
fn val_the_branch_of_period_one_loses_its_stability_by_a_complex_pair() {
    let at = |v: f64| values(&[("belt_velocity", v)]).subject();
    let end = motion(&at(0.097).unwrap()).end.unwrap();
    let branch = continue_branch(&at, 0.097, &end.state, 1, (0.097, 0.106)).unwrap();
    let stable: Vec<_> = branch.points.iter().map(|p| p.orbit.is_stable()).collect();
    assert!(stable[0] && !stable[stable.len() - 1]);
    assert_eq!(branch.bifurcations.len(), 1, "{:?}", branch.bifurcations);
    let found = &branch.bifurcations[0];
    assert_eq!(found.kind, BranchKind::NeimarkSacker);
    assert!((0.1003..0.101).contains(&found.parameter), "{found:?}");
    // An unstable orbit is an orbit: it closes, though nothing stays on it.
    let last = branch.points.last().unwrap();
    let mut carry = end.clone();
    carry.state = last.orbit.state;
    let curve = trace(&at(last.parameter).unwrap(), &carry, last.orbit.period, 10).unwrap();
    assert!((curve[10].displacement - curve[0].displacement).abs() < 1e-9 * curve[0].displacement);
}

#[test]
fn driven_models_have_no_orbits_and_say_so() {
    let subject = subject(&[
        ("normal_force_modulation.amplitude", 0.1),
        ("normal_force_modulation.frequency", 20.0),
    ]);
    let found = motion(&subject);
    let error = shoot(&subject, &found.end.unwrap().state, 1).unwrap_err();
    assert_eq!(error, OrbitError::Driven);
}

#[test]
fn unknown_names_are_refused() {
    let error = Values::default().set("belt_velocty", 1.0).unwrap_err();
    assert!(error.to_string().contains("belt_velocty"), "{error}");
}

// Source: the definition of chaos: neighbours part, so the largest exponent is positive. At 0.102 m/s period one has just lost
// its stability by a complex pair (continued branches say so), and what follows neither repeats nor parts; at 0.112 m/s neighbours part.
#[test]
fn val_what_does_not_repeat_is_irregular_only_if_neighbours_part() {
    let mut kinds = Vec::new();
    for velocity in [0.102, 0.106, 0.112] {
        let found = motion(&subject(&[("belt_velocity", velocity)]));
        println!(
            "{velocity} m/s: {:?} {:?} {:?}",
            found.period, found.lyapunov, found.status
        );
        let exponent = found.lyapunov.unwrap();
        if found.period == Some(0) && found.status == Status::Settled {
            assert!(exponent > 0.0, "{velocity} m/s: {exponent} /s");
        }
        kinds.push(found.status);
    }
    assert_eq!(kinds[0], Status::Unresolved);
    assert_eq!(kinds[2], Status::Settled);
    // Without an exponent nothing is said.
    let rule = Rule {
        lyapunov: false,
        ..Rule::default()
    };
    let blind = evaluate(
        &subject(&[("belt_velocity", 0.112)]),
        &rule,
        &StartRule::Fixed,
        None,
    );
    assert_eq!(blind.unwrap().status, Status::Unresolved);
}
