//! Effects that a user writes as a formula: same motion as the catalogue's, and clear refusals.

use beam_physics::beam::Beam;
use beam_physics::belt::Inputs;
use beam_physics::effects::user_expression::{
    QUANTITIES, Target, UserEffect, UserParameter, UserState, UserTable,
};
use beam_physics::error::PhysicsError;
use beam_physics::integrate::MAX_STATES;
use beam_physics::model::Model;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start, StartContact};

fn effect(target: Target, formula: &str, parameters: &[(&str, f64)]) -> UserEffect {
    let parameter = |(name, value): &(&str, f64)| UserParameter {
        name: (*name).into(),
        unit: "1".into(),
        start: 0.0,
        min: -10.0,
        max: 1e10,
        value: *value,
    };
    UserEffect::new(
        "mine",
        target,
        formula,
        parameters.iter().map(parameter).collect(),
    )
}

fn with(user: UserEffect) -> ModelParameters {
    ModelParameters {
        user_effects: vec![user],
        ..ModelParameters::default()
    }
}

fn run(parameters: &ModelParameters) -> Result<Simulation, PhysicsError> {
    run_from(parameters, false)
}

/// `settled` says whether the effects' states are in equilibrium with the start.
fn run_from(parameters: &ModelParameters, settled: bool) -> Result<Simulation, PhysicsError> {
    let mut state = [0.0; MAX_STATES];
    state[0] = 8.3e-4;
    let start = Start {
        state,
        contact: StartContact::Stick,
        settled,
        ..Start::default()
    };
    Simulation::new(parameters, Inputs::constant(0.1, 100.0), &start, 1e-10)
}

fn motion(parameters: &ModelParameters) -> Vec<f64> {
    displacements(run(parameters).unwrap())
}

fn displacements(mut run: Simulation) -> Vec<f64> {
    (1..=40)
        .map(|i| {
            run.advance_to(1e-3 * f64::from(i)).unwrap();
            run.measured_displacement()
        })
        .collect()
}

#[test]
fn a_force_that_depends_on_the_place_is_the_same_in_every_stick() {
    // The tip starts at w = 2 q_1 on the place s = 0, so that s = 0.1 t - w + 0.00166.
    let force = |formula: &str| {
        let user = effect(Target::TipForce, formula, &[("k", 2e3)]);
        motion(&with(user))
    };
    let by_place = force("k*s");
    let by_time = force("k*(0.1*t - w + 0.00166)");
    for (a, b) in by_place.iter().zip(&by_time) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
}

fn refusal(user: UserEffect) -> String {
    match Model::new(&with(user), Inputs::constant(0.1, 100.0)) {
        Ok(_) => panic!("accepted"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_formula_moves_as_the_catalogues_effect_does() {
    type Case = (&'static [(&'static str, f64)], Target, &'static str);
    let cases: [Case; 6] = [
        (
            &[
                ("belt_periodic_friction.amplitude", 0.1),
                ("belt_periodic_friction.wavelength", 0.01),
            ],
            Target::FrictionFactor,
            "1 + 0.1*cos(2*pi*s/0.01)",
        ),
        (
            &[("friction_drift.change", 0.2)],
            Target::FrictionFactor,
            "1 + 0.2*(1 - exp(-t/0.3))",
        ),
        (
            &[("normal_force_coupling.coefficient", 90.0)],
            Target::NormalForceFactor,
            "1 + 90*w",
        ),
        (
            &[("cubic_stiffness.coefficient", 6e8)],
            Target::TipForce,
            "-6e8*w^3",
        ),
        (
            &[("quadratic_drag.coefficient", 12.0)],
            Target::TipForce,
            "-12*w_dot*abs(w_dot)",
        ),
        (
            &[
                ("normal_force_modulation.amplitude", 0.1),
                ("normal_force_modulation.frequency", 70.0),
                ("normal_force_modulation.phase", 0.4),
            ],
            Target::NormalForceFactor,
            "1 + 0.1*cos(2*pi*70*t + 0.4)",
        ),
    ];
    for (values, target, formula) in cases {
        let mut catalogue = ModelParameters::default();
        for (name, value) in values {
            catalogue.effects.set_named(name, *value).unwrap();
        }
        let mine = motion(&with(effect(target, formula, &[])));
        for (a, b) in motion(&catalogue).iter().zip(&mine) {
            assert!((a - b).abs() < 1e-9, "{formula}: {a} {b}");
        }
    }
}

fn state(name: &str, start: &str, rate: &str) -> UserState {
    UserState {
        name: name.into(),
        unit: "1".into(),
        nominal: 1e-4,
        start: start.into(),
        rate: rate.into(),
        on_stick: None,
        on_break_away: None,
    }
}

#[test]
fn a_formula_with_states_moves_as_the_catalogues_effect_does() {
    type Case = (&'static [(&'static str, f64)], UserEffect);
    let drift = UserEffect {
        states: vec![state("warm", "0", "(1 - warm)/0.3")],
        ..effect(Target::FrictionFactor, "1 + 0.2*warm", &[])
    };
    let lag = UserEffect {
        states: vec![state("late", "w - 0.001*w_dot", "(w - late)/0.001")],
        ..effect(Target::Measurement, "late", &[])
    };
    let shaker = effect(Target::ClampAcceleration, "3*cos(2*pi*55*t + 0.3)", &[]);
    let cases: [Case; 3] = [
        (&[("friction_drift.change", 0.2)], drift),
        (&[("sensor_lag.time_constant", 1e-3)], lag),
        (
            &[
                ("base_excitation.amplitude", 3.0),
                ("base_excitation.frequency", 55.0),
                ("base_excitation.phase", 0.3),
            ],
            shaker,
        ),
    ];
    for (values, user) in cases {
        let mut catalogue = ModelParameters::default();
        for (name, value) in values {
            catalogue.effects.set_named(name, *value).unwrap();
        }
        let formula = user.expression.clone();
        let mut mine = with(user);
        // At the tip, and where the modes have other values.
        for ratios in [[1.0, 1.0], [0.6, -0.3]] {
            catalogue.sensor_ratios[..2].copy_from_slice(&ratios);
            mine.sensor_ratios = catalogue.sensor_ratios;
            let moved = settled_motion(&mine);
            for (a, b) in settled_motion(&catalogue).iter().zip(&moved) {
                assert!((a - b).abs() < 1e-9, "{formula}: {a} {b}");
            }
        }
    }
}

/// As [`motion`], with the effects' states in equilibrium with the start.
fn settled_motion(parameters: &ModelParameters) -> Vec<f64> {
    displacements(run_from(parameters, true).unwrap())
}

/// A formula of so many terms that it has no power series, and that is zero: beside another the motion is integrated by small steps
/// whose error is controlled.
fn too_long() -> String {
    let terms: Vec<String> = (1..=70).map(|i| format!("sin({i}*w)")).collect();
    format!(" + 0*({})", terms.join(" + "))
}

#[test]
fn steps_that_end_where_a_branch_does_move_as_small_ones() {
    let yields = "(w_dot - abs(w_dot)*z)/1e-4";
    for (force, rate) in [
        ("-0.3*z", yields),
        ("if(w_dot > 0, -0.4, 0.3) + 0*z", "0*w"),
        ("-9e4*max(w - 2e-4, 0) - 0.1*z", yields),
    ] {
        let with_tail = |tail: &str| {
            with(UserEffect {
                states: vec![state("z", "0", rate)],
                ..effect(Target::TipForce, &format!("{force}{tail}"), &[])
            })
        };
        let moved = motion(&with_tail(""));
        for (a, b) in moved.iter().zip(&motion(&with_tail(&too_long()))) {
            assert!((a - b).abs() < 2e-9, "{force}: {a} {b}");
        }
        let evaluations = |parameters: &ModelParameters| {
            let mut run = run(parameters).unwrap();
            run.advance_to(0.04).unwrap();
            run.statistics().evaluations
        };
        let (by_series, by_small_steps) = (
            evaluations(&with_tail("")),
            evaluations(&with_tail(&too_long())),
        );
        assert!(
            2 * by_series < by_small_steps,
            "{force}: {by_series} powers of series, {by_small_steps} evaluations"
        );
    }
}

#[test]
fn factors_on_frequencies_and_damping_are_those_of_another_structure() {
    let changed = |factor: f64, damping: f64, modes: &[usize]| {
        let mut all = Beam::default().modes().to_vec();
        for &j in modes {
            all[j].frequency *= factor;
            all[j].damping_ratio *= damping;
        }
        ModelParameters {
            beam: Beam::new(&all).unwrap(),
            ..ModelParameters::default()
        }
    };
    let second = UserEffect {
        mode: Some(2),
        ..effect(Target::DampingFactor, "3", &[])
    };
    let cases = [
        // What damping takes stays the same: 2 D w.
        (
            effect(Target::FrequencyFactor, "1.03", &[]),
            changed(1.03, 1.0 / 1.03, &[0, 1]),
        ),
        (
            effect(Target::DampingFactor, "3", &[]),
            changed(1.0, 3.0, &[0, 1]),
        ),
        (second, changed(1.0, 3.0, &[1])),
    ];
    for (user, structure) in cases {
        let mine = motion(&with(user));
        for (a, b) in mine.iter().zip(motion(&structure)) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }
}

#[test]
fn a_state_jumps_where_its_file_says() {
    let count = UserState {
        on_stick: Some("n + 1".into()),
        on_break_away: Some("n + 100".into()),
        ..state("n", "0", "0*t")
    };
    let user = UserEffect {
        states: vec![count],
        ..effect(Target::Measurement, "w + n", &[])
    };
    let mut run = run(&with(user)).unwrap();
    run.advance_to(0.2).unwrap();
    let outputs = run.outputs();
    let counted = outputs.measured_displacement - outputs.displacement;
    let transitions = run.transition_count();
    assert!(transitions > 8, "{transitions}");
    // It begins in stick; arrivals and departures alternate.
    let departures = transitions.div_ceil(2) as f64;
    let arrivals = (transitions / 2) as f64;
    assert!(
        (counted - 100.0 * departures - arrivals - 1.0).abs() < 1e-6,
        "{counted} {transitions}"
    );
}

#[test]
fn a_state_that_runs_away_ends_the_run_with_its_name() {
    let user = UserEffect {
        states: vec![state("x", "1", "1000*x")],
        ..effect(Target::TipForce, "0*x", &[])
    };
    let mut run = run_from(&with(user), true).unwrap();
    let message = run.advance_to(1.0).unwrap_err().to_string();
    assert!(
        message.contains("user effect 'mine': state x = "),
        "{message}"
    );
    assert!(message.contains("has run away"), "{message}");
}

#[test]
fn wrong_states_and_tables_are_refused_by_name() {
    let with_state = |s: UserState| UserEffect {
        states: vec![s],
        ..effect(Target::TipForce, "x", &[])
    };
    let text = refusal(with_state(state("x", "0", "y")));
    assert!(
        text.contains("state x, rate 'y', column 1: unknown name 'y'"),
        "{text}"
    );
    let text = refusal(with_state(state("F", "0", "0")));
    assert!(text.contains("'F' can't name a state"), "{text}");
    let text = refusal(effect(Target::TipForce, "table(w, g)", &[]));
    assert!(text.contains("unknown table 'g'; there is none"), "{text}");
    let with_table = |at: &[f64]| UserEffect {
        tables: vec![UserTable {
            name: "g".into(),
            at: at.to_vec(),
            first_parameter: 0,
        }],
        ..effect(
            Target::TipForce,
            "table(w, g)",
            &[("g_1", 0.0), ("g_2", 1.0)],
        )
    };
    let text = refusal(with_table(&[0.0, 0.0]));
    assert!(
        text.contains("table g: node 2 at 0 does not lie behind node 1 at 0"),
        "{text}"
    );
    assert!(refusal(with_table(&[0.0])).contains("at least 2"));
    assert!(refusal(with_table(&[0.0, 1.0, 2.0])).contains("more nodes than values"));
}

#[test]
fn a_steady_change_of_belt_velocity_is_another_belt_velocity() {
    let mut changed = run(&with(effect(Target::BeltVelocity, "0.2*v0", &[]))).unwrap();
    let mut faster = Simulation::new(
        &ModelParameters::default(),
        Inputs::constant(0.12, 100.0),
        &Start {
            state: {
                let mut state = [0.0; MAX_STATES];
                state[0] = 8.3e-4;
                state
            },
            contact: StartContact::Stick,
            ..Start::default()
        },
        1e-10,
    )
    .unwrap();
    for i in 1..=40 {
        changed.advance_to(1e-3 * f64::from(i)).unwrap();
        faster.advance_to(1e-3 * f64::from(i)).unwrap();
        let (a, b) = (changed.outputs(), faster.outputs());
        assert!((a.displacement - b.displacement).abs() < 1e-9);
        assert!((a.belt_travel - b.belt_travel).abs() < 1e-9);
        assert_eq!(a.mode, b.mode);
    }
}

#[test]
fn stops_of_the_caller_change_nothing() {
    let ripple = effect(Target::BeltVelocity, "0.02*sin(2*pi*40*t)", &[]);
    let stops = |count: u32| {
        let mut run = run(&with(ripple.clone())).unwrap();
        for i in 1..=count {
            run.advance_to(0.05 * f64::from(i) / f64::from(count))
                .unwrap();
        }
        run.outputs()
    };
    assert_eq!(stops(1), stops(173));
}

#[test]
fn parameters_are_bounded_and_used() {
    let formula = "1 + a*tanh(w_dot/b)";
    let good = effect(Target::FrictionFactor, formula, &[("a", 0.1), ("b", 0.05)]);
    assert_ne!(
        motion(&with(good.clone())),
        motion(&ModelParameters::default())
    );
    let mut outside = good.clone();
    outside.parameters[0].value = -11.0;
    assert!(refusal(outside).contains("parameter a = -11 1 lies outside its bounds -10 .. "));
    let mut nan = good.clone();
    nan.parameters[1].value = f64::NAN;
    assert!(refusal(nan).contains("parameter b = NaN"));
    let mut unused = good.clone();
    unused.parameters[1].name = "c".into();
    assert!(refusal(unused).contains("unknown name 'b'"));
    let mut extra = good.clone();
    extra.parameters.push(UserParameter {
        name: "c".into(),
        ..good.parameters[0].clone()
    });
    assert!(refusal(extra).contains("parameter 'c' is not in the formula"));
    for name in ["w", "sin", "pi", "a", "2x", "x y", ""] {
        let mut taken = good.clone();
        taken.parameters[1].name = name.into();
        assert!(refusal(taken).contains("can't name a parameter"), "{name}");
    }
}

#[test]
fn formulas_that_cannot_be_read_are_refused() {
    let text = refusal(effect(Target::TipForce, "-k*w^3", &[]));
    assert!(
        text.contains("user effect 'mine': '-k*w^3', column 2: unknown name 'k'"),
        "{text}"
    );
    let text = refusal(effect(Target::BeltVelocity, "0.1*w_dot", &[]));
    assert!(text.contains("may depend on t, F_N and v0 only"), "{text}");
    let mut known = effect(Target::TipForce, "w", &[]);
    known.id = "third_mode".into();
    assert!(refusal(known).contains("no catalogue effect has"));
    let twice = ModelParameters {
        user_effects: vec![effect(Target::TipForce, "w", &[]); 2],
        ..ModelParameters::default()
    };
    let error = Model::new(&twice, Inputs::constant(0.1, 100.0))
        .err()
        .unwrap();
    assert!(error.to_string().contains("same id"), "{error}");
}

#[test]
fn values_that_are_not_finite_end_the_run_with_the_formula_named() {
    // At the start, in stick, and in slip.
    for (target, formula) in [
        (Target::FrictionFactor, "1/v_r"),
        (Target::FrictionFactor, "sqrt(0.002 - t)"),
        (Target::NormalForceFactor, "ln(0.003 - t)"),
        (Target::TipForce, "1/(t - t)"),
        (Target::BeltVelocity, "0/(t*0)"),
        (Target::FrictionFactor, "if(v_abs > 0.05, 0/0, 1)"),
    ] {
        let failed =
            run(&with(effect(target, formula, &[]))).and_then(|mut run| run.advance_to(0.1));
        let message = failed.expect_err(formula).to_string();
        assert!(
            message.contains("user effect 'mine': the formula gives"),
            "{formula}: {message}"
        );
    }
}

#[test]
fn targets_and_quantities_have_names() {
    for (name, target) in Target::ALL {
        assert_eq!(Target::from_name(name), Some(target));
        assert_eq!(target.name(), name);
    }
    assert_eq!(Target::from_name("friction"), None);
    let all: Vec<String> = QUANTITIES.iter().map(|q| format!("0*{}", q.0)).collect();
    let formula = format!("1 + {}", all.join(" + "));
    assert!(run(&with(effect(Target::FrictionFactor, &formula, &[]))).is_ok());
}
