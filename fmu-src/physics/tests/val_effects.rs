//! Independent truth: reference-data/computed/effects/motions.json, every effect and pairs of effects
//! integrated by the Python simulation of reference-data/computed/generator (RK4, bisection).

use beam_physics::belt::Inputs;
use beam_physics::contact::ContactMode;
use beam_physics::effects::CATALOGUE;
use beam_physics::effects::user_expression::{Target, UserEffect, UserParameter};
use beam_physics::integrate::MAX_STATES;
use beam_physics::model::Model;
use beam_physics::parameters::ModelParameters;
use beam_physics::simulate::{Simulation, Start, StartContact};
use serde_json::Value;

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// The parameters of one effect under the catalogue's names.
fn set(parameters: &mut ModelParameters, id: &str, values: &Value) {
    let mut set = |name: &str, value: f64| {
        parameters
            .effects
            .set_named(&format!("{id}.{name}"), value)
            .unwrap();
    };
    if id == "belt_friction_profile" {
        let nodes = values["node_values"].as_array().unwrap();
        let spacing = number(&values["node_distance"]);
        set("count", nodes.len() as f64);
        set("length", spacing * (nodes.len() - 1) as f64);
        set("start", -number(&values["start"]));
        for (i, g) in nodes.iter().enumerate() {
            set(&format!("node[{}]", i + 1), number(g));
        }
        return;
    }
    for (name, value) in values.as_object().unwrap() {
        let form = value.as_str().map(|form| f64::from(form == "log"));
        set(name, form.unwrap_or_else(|| number(value)));
    }
}

/// Effects outside the catalogue of which there are motions, as formulas.
const FORMULAS: &[(&str, Target, &str)] = &[
    ("quadratic_stiffness", Target::TipForce, "-coefficient*w^2"),
    (
        "impact_stop",
        Target::TipForce,
        "-if(w > gap, stiffness*(w - gap), 0)",
    ),
    (
        "direction_dependent_friction",
        Target::FrictionFactor,
        "1 + asymmetry*tanh(w_dot/velocity_scale)",
    ),
    ("cubic_damping", Target::TipForce, "-coefficient*w_dot^3"),
    (
        "belt_speed_ripple",
        Target::BeltVelocity,
        "amplitude*v0*cos(2*pi*frequency*t + phase)",
    ),
    (
        "asymmetric_damping",
        Target::TipForce,
        "-coefficient*w_dot*(1 + tanh(w/deflection_scale))/2",
    ),
    (
        "parametric_stiffness",
        Target::TipForce,
        "-stiffness*cos(2*pi*frequency*t + phase)*w",
    ),
    (
        "normal_force_speed_coupling",
        Target::NormalForceFactor,
        "1 + coefficient*w_dot",
    ),
];

/// One effect outside the catalogue.
fn add_formula(parameters: &mut ModelParameters, name: &str, values: &Value) {
    let &(id, target, formula) = FORMULAS.iter().find(|f| f.0 == name).unwrap();
    let parameter = |(name, value): (&String, &Value)| UserParameter {
        name: name.clone(),
        unit: "SI".into(),
        start: 0.0,
        min: -1e9,
        max: 1e9,
        value: number(value),
    };
    parameters.user_effects.push(UserEffect::new(
        id,
        target,
        formula,
        values.as_object().unwrap().iter().map(parameter).collect(),
    ));
}

fn start_state(model: &Model, start: &Value) -> [f64; MAX_STATES] {
    let mut x = [0.0; MAX_STATES];
    for (j, q) in start["q"].as_array().unwrap().iter().enumerate() {
        x[2 * j] = number(q);
        x[2 * j + 1] = number(&start["q_dot"][j]);
    }
    for (card, entry) in CATALOGUE.iter().enumerate() {
        let name = match entry.id {
            "frictional_lag" => "lagged_speed",
            "presliding_compliance" => "bristle",
            "sensor_lag" => "sensor",
            _ => continue,
        };
        if let Some((first, _)) = model.effect_states(card) {
            x[first] = number(&start[name]);
        }
    }
    x
}

fn compare(case: &Value) {
    let mut parameters = ModelParameters {
        friction_level: number(&case["friction_level"]),
        ..ModelParameters::default()
    };
    for (id, values) in case["effects"].as_object().unwrap() {
        match id.strip_prefix("outside:") {
            Some(name) => add_formula(&mut parameters, name, values),
            None => set(&mut parameters, id, values),
        }
    }
    let inputs = Inputs::constant(
        number(&case["belt_velocity_m_per_s"]),
        number(&case["normal_force_n"]),
    );
    let model = Model::new(&parameters, inputs).unwrap();
    let start = Start {
        state: start_state(&model, &case["start"]),
        contact: StartContact::Stick,
        ..Start::default()
    };
    let mut run = Simulation::new(&parameters, inputs, &start, 1e-12).unwrap();
    run.record_transitions();
    let spacing = number(&case["spacing_s"]);
    let samples = case["measured_displacement_m"].as_array().unwrap();
    let mut worst: f64 = 0.0;
    for (i, sample) in samples.iter().enumerate() {
        run.advance_to(i as f64 * spacing).unwrap();
        worst = worst.max((run.measured_displacement() - number(sample)).abs());
    }
    let name = case["effects"].to_string();
    assert!(worst < 1e-10, "{name}: {worst:e} m");
    for (event, mine) in case["transitions"]
        .as_array()
        .unwrap()
        .iter()
        .zip(run.transitions())
    {
        let difference = (mine.time - number(&event[0])).abs();
        assert!(
            difference < 1e-8,
            "{name}: transition at {} s off by {difference:e} s",
            mine.time
        );
        let left = match mine.from {
            ContactMode::Backward => -1.0,
            ContactMode::Stuck => 0.0,
            ContactMode::Forward => 1.0,
        };
        assert_eq!(
            left,
            number(&event[1]),
            "{name}: mode left at {}",
            mine.time
        );
    }
    println!("{worst:.1e} m  {name:.80}");
}

#[test]
fn val_every_effect_and_pairs_move_as_in_the_independent_simulation() {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../reference-data/computed/effects/motions.json"
    );
    let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    for case in &cases {
        compare(case);
    }
    let ids = CATALOGUE.iter().map(|card| card.id.to_owned());
    for id in ids.chain(FORMULAS.iter().map(|f| format!("outside:{}", f.0))) {
        assert!(
            cases.iter().any(|c| c["effects"].get(&id).is_some()),
            "{id} has no independent motion"
        );
    }
}
