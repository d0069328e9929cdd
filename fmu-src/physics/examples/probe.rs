//! Timings and differences to the golden times, printed.
use beam_physics::{
    belt::Inputs,
    integrate::MAX_STATES,
    parameters::ModelParameters,
    simulate::{Simulation, Start},
};
use std::time::Instant;
fn main() {
    let cases: serde_json::Value = serde_json::from_str(
        &std::fs::read_to_string("/work/shared/design/golden_events.json").unwrap(),
    )
    .unwrap();
    for tol in [1e-9] {
        for i in [4, 7] {
            let c = &cases[i];
            let mut state = [0.0; MAX_STATES];
            for (k, v) in c["initial_state"].as_array().unwrap().iter().enumerate() {
                state[k] = v.as_f64().unwrap();
            }
            let mut run = Simulation::new(
                &ModelParameters::default(),
                Inputs::constant(
                    c["belt_velocity_m_per_s"].as_f64().unwrap(),
                    c["normal_force_n"].as_f64().unwrap(),
                ),
                &Start {
                    state,
                    ..Start::default()
                },
                tol,
            )
            .unwrap();
            run.record_transitions();
            run.advance_to(c["stop_time_s"].as_f64().unwrap()).unwrap();
            let g = c["events"].as_array().unwrap();
            let d: Vec<f64> = g
                .iter()
                .zip(run.transitions())
                .map(|(g, m)| (g[0].as_f64().unwrap() - m.time).abs())
                .collect();
            print!("tol {tol:e} case {i}:");
            for k in (0..d.len()).step_by(12) {
                print!(" {:.1e}", d[k]);
            }
            println!(" last {:.1e}", d.last().unwrap());
        }
    }
    let c = &cases[0];
    let mut state = [0.0; MAX_STATES];
    for (k, v) in c["initial_state"].as_array().unwrap().iter().enumerate() {
        state[k] = v.as_f64().unwrap();
    }
    for tol in [1e-9, 1e-7] {
        let mut best = f64::MAX;
        let mut st = Default::default();
        for _ in 0..200 {
            let t0 = Instant::now();
            let mut run = Simulation::new(
                &ModelParameters::default(),
                Inputs::constant(0.1, 100.0),
                &Start {
                    state,
                    ..Start::default()
                },
                tol,
            )
            .unwrap();
            run.advance_to(2.0).unwrap();
            best = best.min(t0.elapsed().as_secs_f64());
            st = run.statistics();
        }
        println!("tol {tol:e} default 2 s: {:.3} ms {:?}", best * 1e3, st);
        let mut best = f64::MAX;
        for _ in 0..200 {
            let t0 = Instant::now();
            let mut run = Simulation::new(
                &ModelParameters::default(),
                Inputs::constant(0.1, 100.0),
                &Start {
                    state,
                    ..Start::default()
                },
                tol,
            )
            .unwrap();
            let mut s = 0.0;
            for i in 1..=20000 {
                run.advance_to(i as f64 * 1e-4).unwrap();
                s += run.measured_displacement();
            }
            best = best.min(t0.elapsed().as_secs_f64());
            std::hint::black_box(s);
        }
        println!("   with 20000 outputs {:.3} ms", best * 1e3);
    }
    let t0 = Instant::now();
    for _ in 0..10000 {
        std::hint::black_box(
            Simulation::new(
                &ModelParameters::default(),
                Inputs::constant(0.1, 100.0),
                &Start {
                    state,
                    ..Start::default()
                },
                1e-9,
            )
            .unwrap(),
        );
    }
    println!("new {:.2} us", t0.elapsed().as_secs_f64() * 1e2);
}
