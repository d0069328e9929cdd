//! Every power series against the rates that it must solve, over the whole catalogue.

use crate::belt::Inputs;
use crate::contact::ContactMode;
use crate::effects::CATALOGUE;
use crate::effects::user_expression::{Target, UserEffect, UserParameter, UserState, UserTable};
use crate::friction::FrictionLaw;
use crate::integrate::{MAX_STATES, Segment, State};
use crate::model::Model;
use crate::model::series::Workspace;
use crate::parameters::ModelParameters;
use crate::simulate::{Simulation, Start, StartContact};

/// Inputs that vary in time, so that their rates are seen too.
fn inputs() -> Inputs {
    Inputs {
        since: 0.01,
        belt_velocity: 0.1,
        belt_acceleration: 0.7,
        normal_force: 100.0,
        normal_force_rate: -250.0,
        external_force: 9.0,
        external_force_rate: -170.0,
        clamp_acceleration: -3.0,
        clamp_acceleration_rate: 410.0,
    }
}

const START: f64 = 0.023;

/// A moving state; `velocity` in m/s is that of the tip.
fn state(model: &Model, velocity: f64) -> State {
    let mut x = [0.0; MAX_STATES];
    for j in 0..model.beam().modes().len() {
        let share = 1.0 / (1 + j * j) as f64;
        x[2 * j] = 6e-4 * share * if j % 2 == 0 { 1.0 } else { -0.1 };
    }
    model.push(velocity, &mut x);
    for (i, value) in x[..model.dimension()]
        .iter_mut()
        .enumerate()
        .skip(2 * model.beam().modes().len())
    {
        *value += 1e-4 * (1 + i) as f64;
    }
    x
}

/// Largest difference between the slope of the polynomials and the rates, relative to the rates met.
fn residual(model: &Model, mode: ContactMode, segment: &Segment, reach: f64) -> f64 {
    let (mut worst, mut scale) = ([0.0_f64; MAX_STATES], [1e-12_f64; MAX_STATES]);
    for i in 0..=8 {
        // Near the reach the slope shows what was left out more than the value does.
        let theta = 0.7 * reach * f64::from(i) / 8.0;
        let t = segment.start + theta * segment.length;
        let (mut x, mut rates) = ([0.0; MAX_STATES], [0.0; MAX_STATES]);
        segment.state_at(theta, &mut x);
        model.rates(t, &x, mode, &mut rates);
        for s in 0..model.dimension() {
            let slope = (1..=segment.degree).rev().fold(0.0, |sum, k| {
                sum * theta + k as f64 * segment.coefficients[k][s]
            });
            worst[s] = worst[s].max((slope / segment.length - rates[s]).abs());
            scale[s] = scale[s].max(rates[s].abs());
        }
    }
    (0..model.dimension()).fold(0.0, |w, s| w.max(worst[s] / scale[s]))
}

fn build(parameters: &ModelParameters) -> Model {
    let mut model = Model::new(parameters, inputs()).unwrap();
    // Off the nodes of a track.
    model.travel_offset = 0.01;
    model.stick_since = 0.021;
    model
}

fn begin(model: &Model, velocity: f64) -> Segment {
    Segment::point(START, &state(model, velocity), model.dimension())
}

/// A user's effect on each target, with states and a table.
fn users_effects() -> Vec<UserEffect> {
    let simple = |id: &str, target, formula: &str| UserEffect::new(id, target, formula, Vec::new());
    let state = |name: &str, rate: &str| UserState {
        name: name.into(),
        unit: "1".into(),
        nominal: 1e-2,
        start: "0".into(),
        rate: rate.into(),
        on_stick: None,
        on_break_away: None,
    };
    let mut all = vec![
        simple(
            "direction",
            Target::FrictionFactor,
            "1 + 0.1*tanh(w_dot/0.02)",
        ),
        simple(
            "by_place",
            Target::NormalForceFactor,
            "1 + 0.2*sin(300*s + t) + 40*w - 1e-4*F_N",
        ),
        simple(
            "force",
            Target::TipForce,
            "-6e8*w^3 - 3*w_dot*abs(w_dot) + t_stick",
        ),
        simple(
            "shaking_belt",
            Target::BeltVelocity,
            "0.02*sin(2*pi*40*t) + 0.1*v0 + 1e-5*F_N",
        ),
        simple("softening", Target::FrequencyFactor, "1 - 50*abs(w)"),
        simple("damper", Target::DampingFactor, "1 + exp(-w_dot^2)"),
        simple("shaking_clamp", Target::ClampAcceleration, "5*cos(300*t)"),
        simple("curved", Target::Measurement, "w + 3*w^2"),
    ];
    all.push(UserEffect {
        states: vec![
            state("heat", "abs(F*v_r) - heat/0.01"),
            state("creep", "if(stick, 0.3*heat, -creep)"),
        ],
        ..simple("heating", Target::FrictionFactor, "1 - 0.01*heat + creep^2")
    });
    all.push(UserEffect {
        states: vec![state("z", "w_dot - 0.5*abs(w_dot)*z - t*z")],
        mode: Some(1),
        ..simple("hysteresis", Target::FrequencyFactor, "1 + z")
    });
    let node = |i: usize, value| UserParameter {
        name: format!("g_{i}"),
        unit: "1".into(),
        start: 0.0,
        min: -1.0,
        max: 1.0,
        value,
    };
    all.push(UserEffect {
        parameters: (0..4).map(|i| node(i, [0.1, -0.05, 0.2, 0.1][i])).collect(),
        tables: vec![UserTable {
            name: "g".into(),
            at: vec![-0.3, -0.01, 0.17, 0.4],
            first_parameter: 0,
        }],
        ..simple("curve", Target::FrictionFactor, "1 + table(w_dot, g)")
    });
    all
}

/// The reference model, each effect at its typical values, and each with one other.
fn all_models() -> Vec<(String, ModelParameters)> {
    let mut all = vec![("reference".to_owned(), ModelParameters::default())];
    let switch_on = |parameters: &mut ModelParameters, card: usize| {
        for (i, p) in CATALOGUE[card].parameters.iter().enumerate() {
            parameters.effects.set(card, i, p.typical);
        }
    };
    for card in 0..CATALOGUE.len() {
        let mut parameters = ModelParameters::default();
        switch_on(&mut parameters, card);
        all.push((CATALOGUE[card].id.to_owned(), parameters.clone()));
        let other = (card + 5) % CATALOGUE.len();
        switch_on(&mut parameters, other);
        all.push((
            format!("{}, {}", CATALOGUE[card].id, CATALOGUE[other].id),
            parameters,
        ));
    }
    for (i, effect) in users_effects().into_iter().enumerate() {
        let mut parameters = ModelParameters::default();
        let name = effect.id.clone();
        parameters.user_effects.push(effect);
        all.push((name.clone(), parameters.clone()));
        let other = (3 * i) % CATALOGUE.len();
        switch_on(&mut parameters, other);
        all.push((format!("{name}, {}", CATALOGUE[other].id), parameters));
    }
    all
}

#[test]
fn val_slip_series_solve_the_equations() {
    // Source: Model::rates, at nine instants of a step.
    for (name, parameters) in all_models() {
        let model = build(&parameters);
        assert!(model.has_series(), "{name}");
        let mut room = Workspace::default();
        for (mode, velocity) in [(ContactMode::Backward, -0.05), (ContactMode::Forward, 0.16)] {
            let mut segment = begin(&model, velocity);
            let reach = model
                .expand_slip(mode, 1e-13, &model.state_scales(), &mut segment, &mut room)
                .unwrap_or_else(|| panic!("{name} has no series for {mode:?}"));
            let residual = residual(&model, mode, &segment, reach);
            assert!(residual < 1e-9, "{name}, {mode:?}: {residual:e}");
            let mut x = [0.0; MAX_STATES];
            let theta = 0.7 * reach;
            segment.state_at(theta, &mut x);
            let gap = room.sliding_speed()[..=segment.degree]
                .iter()
                .rev()
                .fold(0.0, |sum, c| sum * theta + c);
            let v_r = model.relative_velocity(START + theta * segment.length, &x);
            assert!((gap - mode.sign() * v_r).abs() < 1e-13, "{name}: {gap}");
        }
    }
}

#[test]
fn val_stick_series_solve_the_equations() {
    // Source: Model::rates, Model::constraint_force and Model::static_limit.
    for (name, parameters) in all_models() {
        let model = build(&parameters);
        if model.has_memory() {
            continue;
        }
        let mut segment = begin(&model, 0.06);
        let stick = model
            .expand_stick(
                1e-13,
                &model.state_scales(),
                &mut segment,
                &mut Workspace::default(),
            )
            .unwrap_or_else(|| panic!("{name} has no series"));
        let residual = residual(&model, ContactMode::Stuck, &segment, stick.reach);
        assert!(residual < 1e-9, "{name}: {residual:e}");
        let at = |c: &[f64], theta: f64| c.iter().rev().fold(0.0, |sum, c| sum * theta + c);
        for theta in [0.0, 0.4 * stick.reach, stick.reach] {
            let mut x = [0.0; MAX_STATES];
            segment.state_at(theta, &mut x);
            let t = START + theta * segment.length;
            let force = at(&stick.force[..=segment.degree], theta);
            let limit = at(&stick.limit[..=segment.degree], theta);
            let (f, l) = (model.constraint_force(t, &x), model.static_limit(t, &x));
            assert!((force - f).abs() < 1e-9 * l, "{name}: F_c {force} {f}");
            assert!((limit - l).abs() < 1e-10 * l, "{name}: limit {limit} {l}");
        }
    }
}

#[test]
fn laws_that_are_no_sums_of_exponentials_are_integrated_otherwise() {
    let parameters = ModelParameters {
        friction: FrictionLaw::StelterAsPrinted(Default::default()),
        ..ModelParameters::default()
    };
    assert!(!Model::new(&parameters, inputs()).unwrap().has_series());
}

/// Displacements in m every 1 ms with a Stribeck law of this exponent, as long as there are any.
fn motion(id: &str, value: f64, exponent: f64) -> Vec<f64> {
    let mut parameters = ModelParameters {
        friction: FrictionLaw::Stribeck {
            mu_s: 0.66,
            mu_k: 0.4,
            velocity: 0.05,
            exponent,
            viscous: 0.0,
        },
        ..ModelParameters::default()
    };
    let switch = CATALOGUE.iter().position(|c| c.id == id).unwrap();
    for (i, p) in CATALOGUE[switch].parameters.iter().enumerate() {
        let value = if i == 0 { value } else { p.typical };
        parameters.effects.set(switch, i, value);
    }
    let start = Start {
        contact: StartContact::Stick,
        ..Start::default()
    };
    let inputs = Inputs::constant(0.1, 100.0);
    let mut run = Simulation::new(&parameters, inputs, &start, 1e-12).unwrap();
    (0..60)
        .map_while(|i| {
            run.advance_to(f64::from(i) * 1e-3).ok()?;
            Some(run.measured_displacement())
        })
        .collect()
}

#[test]
fn steps_in_which_a_regime_changes_are_no_less_exact() {
    // The next number above 1 has no series, and is integrated by the rates alone.
    for card in CATALOGUE {
        let first = &card.parameters[0];
        // Strong: open contacts, crossed nodes, drag that matters.
        for value in [first.min, first.typical, first.max] {
            if value == 0.0 {
                continue;
            }
            let by_series = motion(card.id, value, 1.0);
            let by_rates = motion(card.id, value, 1.0_f64.next_up());
            for (i, (a, b)) in by_series.iter().zip(&by_rates).enumerate() {
                assert!(
                    (a - b).abs() < 1e-9,
                    "{} = {value} at {i} ms: {a} {b}",
                    card.id
                );
            }
        }
    }
}
