//! Short runs with derivatives by 8 and by 16 directions (`stickslipTangents`) against the same runs by the standard's calls,
//! of which differences need one for each direction: 20 ms sampled every 0.2 ms, tolerance 1e-9; for the reference model and for
//! each effect at its typical values. `cargo bench --bench tangents`. Microseconds, median over repetitions, mean over starts
//! along the default motion; and how many plain runs the derivatives cost.

use beam_physics::effects::{CATALOGUE, Role};
use std::hint::black_box;
use std::time::Instant;
use stickslip_tests::slave::{OK, Slave};

const SAMPLES: u32 = 100;
const INTERVAL: f64 = 2e-4;
const TOLERANCE: f64 = 1e-9;
const REPETITIONS: usize = 25;
const STATES: [&str; 4] = ["q[1]", "q_dot[1]", "q[2]", "q_dot[2]"];
/// What is turned besides the start state.
const KNOBS: [&str; 12] = [
    "mode[1].frequency",
    "mode[2].frequency",
    "mode[1].damping_ratio",
    "mode[2].damping_ratio",
    "mode[1].mass",
    "mode[2].mass",
    "friction.mu_0",
    "friction.v1",
    "friction.a1",
    "friction.c2",
    "friction.level",
    "normal_force",
];

/// Starts along the default motion (100 N, 0.10 m/s), every 3.7 ms.
fn starts() -> Vec<[f64; 4]> {
    let slave = Slave::new();
    let first = [
        1.162_331_347_770_524_6e-3,
        0.05,
        -2.860_023_308_624_127_7e-5,
        0.0,
    ];
    for (name, value) in STATES.iter().zip(first) {
        assert_eq!(slave.set(name, value), OK);
    }
    slave.start_at(0.0);
    (0..9)
        .map(|i| {
            assert_eq!(slave.step(f64::from(i) * 3.7e-3, 3.7e-3), OK);
            STATES.map(|name| slave.get(name))
        })
        .collect()
}

fn begin(slave: &Slave, settings: &[(String, f64)], start: &[f64; 4]) {
    assert_eq!(slave.reset(), OK);
    let named = settings.iter().map(|(n, v)| (n.as_str(), *v));
    for (name, value) in named.chain(STATES.into_iter().zip(*start)) {
        assert_eq!(slave.set(name, value), OK, "{name}");
    }
    assert_eq!(slave.set_integer("start.effects", 1), OK);
}

/// Median time in us of `work` for all starts, for each of them.
fn median(starts: &[[f64; 4]], mut work: impl FnMut(&[f64; 4])) -> f64 {
    let mut times: Vec<f64> = (0..REPETITIONS)
        .map(|_| {
            let begun = Instant::now();
            starts.iter().for_each(&mut work);
            begun.elapsed().as_secs_f64() * 1e6 / starts.len() as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPETITIONS / 2]
}

fn measure(name: &str, settings: &[(String, f64)], starts: &[[f64; 4]]) -> [f64; 3] {
    let slave = Slave::new();
    let plain = median(starts, |start| {
        begin(&slave, settings, start);
        slave.start_at(0.0);
        for i in 0..SAMPLES {
            assert_eq!(slave.step(f64::from(i) * INTERVAL, INTERVAL), OK);
            black_box(slave.get("measured_displacement"));
        }
    });
    let times: Vec<f64> = (0..=SAMPLES).map(|i| f64::from(i) * INTERVAL).collect();
    let with = |count: usize| {
        let directions: Vec<Vec<(&str, f64)>> = STATES
            .iter()
            .chain(&KNOBS)
            .take(count)
            .map(|name| vec![(*name, 1.0)])
            .collect();
        median(starts, |start| {
            begin(&slave, settings, start);
            black_box(slave.tangents(&times, "measured_displacement", &directions)).expect(name);
        })
    };
    [plain, with(8), with(16)]
}

fn main() {
    let starts = starts();
    println!(
        "{:24} {:>8} {:>8} {:>8} {:>14}",
        "", "plain us", "8 dirs", "16 dirs", "16 dirs/plain"
    );
    let row = |name: &str, effect: &[(String, f64)]| {
        let mut settings = vec![("tolerance".to_owned(), TOLERANCE)];
        settings.extend_from_slice(effect);
        let [plain, eight, sixteen] = measure(name, &settings, &starts);
        println!(
            "{name:24} {plain:8.1} {eight:8.1} {sixteen:8.1} {:14.1}",
            sixteen / plain
        );
        sixteen / plain
    };
    let mut ratios = vec![row("reference model", &[])];
    for card in &CATALOGUE {
        let settings: Vec<(String, f64)> = card
            .parameters
            .iter()
            .filter(|p| p.role != Role::Node || p.name.len() == "node[1]".len())
            .map(|p| {
                (
                    format!("{}.{}", card.id, p.name),
                    if p.name == "count" { 9.0 } else { p.typical },
                )
            })
            .collect();
        ratios.push(row(card.id, &settings));
    }
    println!(
        "mean {:.1}",
        ratios.iter().sum::<f64>() / ratios.len() as f64
    );
}
