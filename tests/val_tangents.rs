//! Derivatives along a motion (`stickslipTangents`): against differences of motions that the standard's own calls give, for the
//! reference model and every effect, through stick, slip and transitions.

use beam_physics::effects::{CATALOGUE, Role};
use stickslip_tests::slave::{DISCARD, ERROR, OK, Slave};
use stickslip_tests::tangent::Course;

/// Times at which motions are compared: every 0.2 ms, 40 ms long.
fn times() -> Vec<f64> {
    (0..=200).map(|i| f64::from(i) * 2e-4).collect()
}

/// What a motion is started with.
type Setting = Vec<(String, f64)>;

/// A motion in slip that sticks and slips several times.
fn setting() -> Setting {
    [
        ("tolerance", 1e-12),
        ("belt_velocity", 0.1),
        ("normal_force", 100.0),
        ("external_force", 0.0),
        ("clamp_acceleration", 0.0),
        ("mode[1].clamp_share", 1.6),
        ("mode[2].clamp_share", -0.9),
        ("q[1]", 1.1e-3),
        ("q_dot[1]", 0.02),
        ("q[2]", -3e-5),
        ("q_dot[2]", 0.01),
        ("mode[1].frequency", 80.0),
        ("mode[2].frequency", 510.0),
        ("mode[1].damping_ratio", 0.000_15),
        ("mode[1].damping_rate", 0.05),
        ("mode[1].mass", 0.427),
        ("friction.mu_0", 0.66),
        ("friction.v1", 0.02),
        ("friction.a1", 0.5),
        ("friction.level", 1.0),
    ]
    .map(|(name, value)| (name.to_owned(), value))
    .to_vec()
}

fn started(setting: &Setting) -> Slave {
    let slave = Slave::new();
    for (name, value) in setting {
        assert_eq!(slave.set(name, *value), OK, "{name}");
    }
    assert_eq!(slave.set_integer("start.effects", 1), OK);
    slave
}

/// The motion by the standard's calls.
fn motion(setting: &Setting, times: &[f64]) -> Vec<f64> {
    seen(setting, "measured_displacement", times)
}

/// The same of another output.
fn seen(setting: &Setting, output: &str, times: &[f64]) -> Vec<f64> {
    let slave = started(setting);
    slave.start_at(times[0]);
    let mut out = vec![slave.get(output)];
    for w in times.windows(2) {
        assert_eq!(slave.step(w[0], w[1] - w[0]), OK, "{:?}", slave.messages());
        out.push(slave.get(output));
    }
    out
}

fn moved(setting: &Setting, name: &str, by: f64) -> Setting {
    let mut out = setting.clone();
    let (_, value) = out
        .iter_mut()
        .find(|(n, _)| n == name)
        .expect("a value to move");
    *value += by;
    out
}

/// Fourth-order central differences over a step that shifts the motion by about a micrometre.
fn differences(setting: &Setting, name: &str, step: f64, times: &[f64]) -> Vec<f64> {
    let at = |k: f64| motion(&moved(setting, name, k * step), times);
    let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
    (0..times.len())
        .map(|i| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step))
        .collect()
}

/// Compares every direction with differences; `known` are names with sensible steps.
fn check(setting: &Setting, known: &[(&str, f64)], what: &str) {
    let times = times();
    let directions: Vec<Vec<(&str, f64)>> = known.iter().map(|(n, _)| vec![(*n, 1.0)]).collect();
    let slave = started(setting);
    let (values, slopes) = slave
        .tangents(&times, "measured_displacement", &directions)
        .unwrap_or_else(|status| panic!("{what}: status {status}: {:?}", slave.messages()));
    for (value, plain) in values.iter().zip(motion(setting, &times)) {
        assert!(
            (value - plain).abs() < 1e-13,
            "{what}: {value} against {plain} m"
        );
    }
    for ((name, step), slope) in known.iter().zip(&slopes) {
        let truth = differences(setting, name, *step, &times);
        let scale = truth.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let worst = slope
            .iter()
            .zip(&truth)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(
            worst <= 2e-4 * scale + 1e-300,
            "{what}, by {name}: off by {worst:e} of {scale:e}"
        );
    }
}

const REFERENCE: [(&str, f64); 16] = [
    ("q[1]", 1e-8),
    ("q_dot[1]", 5e-6),
    ("q[2]", 1e-9),
    ("q_dot[2]", 5e-6),
    ("mode[1].frequency", 1e-3),
    ("mode[2].frequency", 1e-3),
    ("mode[1].damping_ratio", 1e-6),
    ("mode[1].damping_rate", 1e-3),
    ("mode[1].mass", 1e-6),
    ("friction.mu_0", 1e-6),
    ("friction.v1", 1e-6),
    ("friction.a1", 1e-6),
    ("friction.level", 1e-6),
    ("normal_force", 1e-4),
    ("external_force", 1e-4),
    ("clamp_acceleration", 1e-4),
];

#[test]
fn val_the_reference_model_is_differentiated_through_stick_and_slip() {
    // Truth: central differences of fourth order of motions by fmi2DoStep.
    let plain = setting();
    check(&plain, &REFERENCE, "reference model");
    let slave = started(&plain);
    slave.start_at(0.0);
    assert_eq!(slave.step(0.0, 0.04), OK);
    let transitions = slave.get_integer("transition_count");
    assert!(
        transitions >= 3,
        "the motion tests {transitions} transitions only"
    );
}

#[test]
fn val_every_effect_is_differentiated() {
    // Truth: central differences of fourth order of motions by fmi2DoStep.
    for card in &CATALOGUE {
        let mut with = setting();
        let mut known: Vec<(String, f64)> = vec![("q[1]".into(), 1e-8), ("q_dot[1]".into(), 5e-6)];
        for p in card.parameters {
            let name = format!("{}.{}", card.id, p.name);
            let value = match p.name {
                // A place that the tip passes.
                "length" => 0.01,
                "count" => 8.0,
                name if p.role == Role::Node && !name.ends_with(|c| ('1'..='8').contains(&c)) => {
                    continue;
                }
                _ if p.role == Role::Node && p.name.len() > "node[1]".len() => continue,
                _ => p.typical,
            };
            with.push((name.clone(), value));
            if p.role != Role::Setting {
                known.push((name, 1e-5 * value.abs().max(1e-3 * p.max.abs())));
            }
        }
        let known: Vec<(&str, f64)> = known.iter().map(|(n, s)| (n.as_str(), *s)).collect();
        check(&with, &known, card.id);
    }
}

#[test]
fn without_directions_the_motion_alone_comes_back() {
    let times = times();
    let slave = started(&setting());
    let (values, slopes) = slave.tangents(&times, "tip_displacement", &[]).unwrap();
    assert!(slopes.is_empty());
    for (value, plain) in values.iter().zip(motion(&setting(), &times)) {
        assert!((value - plain).abs() < 1e-13, "{value} against {plain} m");
    }
}

// Source: what a sensor reads is linear in its ratios, r_j phi_j q_j: motions by the standard's calls at two ratios.
#[test]
fn val_a_sensor_is_differentiated_by_where_it_looks_also_at_the_tip() {
    let times = times();
    for ratio in [1.0, -0.4] {
        let at = |ratio: f64| {
            let mut setting = setting();
            setting.push(("mode[2].sensor_ratio".into(), ratio));
            setting
        };
        let slave = started(&at(ratio));
        let directions = [vec![("mode[2].sensor_ratio", 1.0)]];
        for output in [
            "measured_displacement",
            "measured_velocity",
            "measured_acceleration",
        ] {
            let (values, slopes) = slave.tangents(&times, output, &directions).unwrap();
            let (here, there) = (
                seen(&at(ratio), output, &times),
                seen(&at(ratio + 0.5), output, &times),
            );
            let size = here.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
            for k in 0..times.len() {
                let slope = 2.0 * (there[k] - here[k]);
                assert!((values[k] - here[k]).abs() < 1e-6 * size, "{output}");
                assert!((slopes[0][k] - slope).abs() < 1e-6 * size, "{output}");
            }
            assert!(slopes[0].iter().any(|s| s.abs() > 1e-3 * size), "{output}");
        }
    }
}

// Source: central differences of the derivative of the velocity that the plain run gives at each time.
#[test]
fn val_an_acceleration_has_the_derivatives_of_the_motion() {
    let times = times();
    let slave = started(&setting());
    let directions = [vec![("q[1]", 1.0)], vec![("friction.mu_0", 1.0)]];
    let (values, slopes) = slave
        .tangents(&times, "tip_acceleration", &directions)
        .unwrap();
    // Away from transitions, at which it jumps, it is the rate of the velocity and so are its derivatives.
    let step = 1e-6;
    let beside: Vec<f64> = times[1..]
        .iter()
        .flat_map(|t| [t - step, t + step])
        .collect();
    let all: Vec<f64> = std::iter::once(times[0]).chain(beside).collect();
    let (velocity, rates) = slave.tangents(&all, "tip_velocity", &directions).unwrap();
    let rate = |of: &[f64], k: usize| (of[2 * k] - of[2 * k - 1]) / (2.0 * step);
    let size = values.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
    let is_near = |a: f64, b: f64, scale: f64| (a - b).abs() < 1e-3 * scale;
    let mut near = 0;
    for k in 1..times.len() {
        let agrees = is_near(values[k], rate(&velocity, k), size);
        near += usize::from(agrees);
        for (slopes, rates) in slopes.iter().zip(&rates) {
            let largest = slopes.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
            let (slope, rate) = (slopes[k], rate(rates, k));
            assert!(
                !agrees || is_near(slope, rate, largest),
                "{slope} {rate} at {}",
                times[k]
            );
        }
    }
    assert!(near + 4 > times.len(), "{near} of {}", times.len());
}

// Source: the outputs of steps, and differences of them between motions that start a little apart.
#[test]
fn val_several_outputs_are_seen_along_one_motion() {
    let times = times();
    let slave = started(&setting());
    let directions = [vec![("q[1]", 1.0)], vec![("friction.mu_0", 1.0)]];
    let steps = [1e-10, 1e-7];
    let linear = ["measured_displacement", "q[2]", "tip_velocity", "q_dot[1]"];
    let all = [linear.as_slice(), &["friction_force", "q[7]"]].concat();
    for outputs in [&linear[..], &all[..]] {
        let found = slave.output_tangents(&times, outputs, &directions).unwrap();
        for (output, (values, slopes)) in outputs.iter().zip(&found) {
            let here = seen(&setting(), output, &times);
            let size = here.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
            let off = |k: &usize| (values[*k] - here[*k]).abs() > 1e-6 * size;
            assert_eq!((0..times.len()).filter(off).count(), 0, "{output}");
            for ((slopes, direction), step) in slopes.iter().zip(&directions).zip(steps) {
                let (name, _) = direction[0];
                let there = seen(&moved(&setting(), name, step), output, &times);
                let largest = slopes.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
                let slope = |k: usize| (there[k] - here[k]) / step;
                let off = |k: &usize| (slopes[*k] - slope(*k)).abs() > 0.02 * largest;
                let off: Vec<usize> = (0..times.len()).filter(off).collect();
                // A force jumps where stick begins, here and there not at the same time.
                let jumps = if *output == "friction_force" { 3 } else { 0 };
                assert!(off.len() <= jumps, "{output} by {name}: {off:?}");
                assert_eq!(largest > 0.0, *output != "q[7]", "{output} by {name}");
            }
        }
    }
    assert_eq!(
        slave.output_tangents(&times, &[], &directions).unwrap_err(),
        ERROR
    );
}

#[test]
fn several_changes_make_one_direction() {
    let times = times();
    let slave = started(&setting());
    let one = |name: &'static str| vec![(name, 1.0)];
    let both = vec![("q[1]", 2.0), ("friction.mu_0", -3e-3)];
    let directions = [one("q[1]"), one("friction.mu_0"), both];
    let (_, slopes) = slave
        .tangents(&times, "tip_displacement", &directions)
        .unwrap();
    for k in 0..times.len() {
        let sum = 2.0 * slopes[0][k] - 3e-3 * slopes[1][k];
        assert!(
            (slopes[2][k] - sum).abs() <= 1e-9 * sum.abs() + 1e-12,
            "at {} s",
            times[k]
        );
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let slave = started(&setting());
    let q = [vec![("q[1]", 1.0)]];
    let refused = |times: &[f64], output: &str, directions: &[Vec<(&str, f64)>]| {
        slave.tangents(times, output, directions).unwrap_err()
    };
    assert_eq!(refused(&[0.0, -1.0], "tip_displacement", &q), ERROR);
    assert_eq!(refused(&[], "tip_displacement", &q), ERROR);
    assert_eq!(refused(&[0.0, 1e-3], "relative_velocity", &q), ERROR);
    assert_eq!(
        refused(
            &[0.0, 1e-3],
            "tip_displacement",
            &[vec![("mode_count", 1.0)]]
        ),
        ERROR
    );
    let mut impossible = setting();
    impossible.push(("normal_force_modulation.amplitude".into(), 2.0));
    let impossible = started(&impossible);
    let status = impossible
        .tangents(&[0.0, 1e-3], "tip_displacement", &q)
        .unwrap_err();
    assert_eq!(status, DISCARD);
}

/// The motion by the standard's calls, `input` being `scale (a + b (t - t_0))` from piece to piece.
fn driven_motion(setting: &Setting, course: &Course, times: &[f64]) -> Vec<f64> {
    let (_, scale) = setting
        .iter()
        .find(|(name, _)| name == course.input)
        .unwrap();
    let of =
        |k: usize, t: f64| scale * (course.factors[k] + course.rates[k] * (t - course.begins[k]));
    let first = course.begins.partition_point(|b| *b <= times[0]) - 1;
    let slave = started(setting);
    assert_eq!(slave.set(course.input, of(first, times[0])), OK);
    slave.start_at(times[0]);
    let mut out = vec![slave.get("measured_displacement")];
    let mut now = times[0];
    for &next in &times[1..] {
        while now < next {
            let k = course.begins.partition_point(|b| *b <= now + 1e-12) - 1;
            let end = course.begins.get(k + 1).map_or(next, |b| b.min(next));
            assert_eq!(slave.set(course.input, of(k, now)), OK);
            assert_eq!(slave.set_rate(course.input, 1, scale * course.rates[k]), OK);
            assert_eq!(slave.step(now, end - now), OK, "{:?}", slave.messages());
            now = end;
        }
        out.push(slave.get("measured_displacement"));
    }
    out
}

#[test]
fn val_motions_that_inputs_drive_are_differentiated() {
    // Truth: motions by fmi2SetRealInputDerivatives and fmi2DoStep, and central differences of fourth order of these.
    let times = times();
    let begins: Vec<f64> = (0..40).map(|k| -1e-3 + f64::from(k) * 1.3e-3).collect();
    let wave = |t: f64| 1.0 + 0.3 * (400.0 * t).sin();
    let factors: Vec<f64> = begins.iter().map(|t| wave(*t)).collect();
    let rates: Vec<f64> = begins
        .iter()
        .map(|t| (wave(t + 1.3e-3) - wave(*t)) / 1.3e-3)
        .collect();
    for (input, step) in [
        ("normal_force", 1e-4),
        ("external_force", 1e-4),
        ("clamp_acceleration", 1e-4),
        ("belt_velocity", 1e-7),
    ] {
        let course = Course {
            input,
            begins: &begins,
            factors: &factors,
            rates: &rates,
        };
        let mut plain = setting();
        if ["external_force", "clamp_acceleration"].contains(&input) {
            plain = moved(&plain, input, 8.0);
        }
        let known: Vec<(&str, f64)> = REFERENCE
            .into_iter()
            .filter(|(name, _)| *name != input)
            .chain([(input, step)])
            .collect();
        let directions: Vec<Vec<(&str, f64)>> =
            known.iter().map(|(n, _)| vec![(*n, 1.0)]).collect();
        let slave = started(&plain);
        let (values, slopes) = slave
            .driven_tangents(&times, "measured_displacement", &directions, &course)
            .unwrap_or_else(|status| panic!("{input}: {status}: {:?}", slave.messages()));
        for (value, truth) in values.iter().zip(driven_motion(&plain, &course, &times)) {
            assert!(
                (value - truth).abs() < 1e-12,
                "{input}: {value} against {truth} m"
            );
        }
        for ((name, step), slope) in known.iter().zip(&slopes) {
            let at = |k: f64| driven_motion(&moved(&plain, name, k * step), &course, &times);
            let (a, b, c, d) = (at(-2.0), at(-1.0), at(1.0), at(2.0));
            let difference = |i: usize| (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step);
            let scale = (0..times.len()).fold(0.0, |m: f64, i| m.max(difference(i).abs()));
            let pairs = slope.iter().enumerate();
            let worst = pairs.fold(0.0, |m: f64, (i, s)| m.max((s - difference(i)).abs()));
            assert!(
                worst <= 2e-4 * scale,
                "{input}, by {name}: off by {worst:e} of {scale:e}"
            );
        }
    }
    let course = Course {
        input: "friction.v1",
        begins: &[0.0],
        factors: &[1.0],
        rates: &[0.0],
    };
    let slave = started(&setting());
    let refused = slave.driven_tangents(&times, "measured_displacement", &[], &course);
    assert_eq!(refused.unwrap_err(), ERROR, "a parameter has no course");
}
