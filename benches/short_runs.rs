//! Short runs as a diagnosis makes them by the million, through the FMU's C interface: reset, start
//! from a given state, 20 ms sampled every 0.2 ms, tolerance 1e-7; for the reference model and for
//! each effect at its typical values. `cargo bench --bench short_runs`. Microseconds per run, median
//! over repetitions, mean over starts along the default motion.

use beam_physics::effects::CATALOGUE;
use std::hint::black_box;
use std::time::Instant;
use stickslip_tests::slave::{OK, Slave};
use stickslip_tests::variables::reference;

const SAMPLES: u32 = 100;
const INTERVAL: f64 = 2e-4;
const TOLERANCE: f64 = 1e-7;
const REPETITIONS: usize = 25;

/// Starts along the default motion (100 N, 0.10 m/s): q_1, q_1', q_2, q_2' every 3.7 ms.
fn starts(names: &[u32; 4]) -> Vec<[f64; 4]> {
    let slave = Slave::new();
    slave.set_all(
        names,
        &[
            1.162_331_347_770_524_6e-3,
            0.05,
            -2.860_023_308_624_127_7e-5,
            0.0,
        ],
    );
    slave.start_at(0.0);
    (0..9)
        .map(|i| {
            assert_eq!(slave.step(f64::from(i) * 3.7e-3, 3.7e-3), OK);
            let mut x = [0.0; 4];
            slave.get_into(names, &mut x);
            x
        })
        .collect()
}

/// Microseconds per run with these settings.
fn measure(slave: &Slave, names: &[u32; 4], starts: &[[f64; 4]], settings: &[(u32, f64)]) -> f64 {
    let (references, values): (Vec<u32>, Vec<f64>) = settings.iter().copied().unzip();
    let measured = [reference("measured_displacement")];
    let mut times: Vec<f64> = (0..REPETITIONS)
        .map(|_| {
            let begun = Instant::now();
            for x in starts {
                assert_eq!(slave.reset(), OK);
                slave.set_all(&references, &values);
                slave.set_all(names, x);
                slave.start_at(0.0);
                let mut value = [0.0];
                for i in 0..SAMPLES {
                    assert_eq!(slave.step(f64::from(i) * INTERVAL, INTERVAL), OK);
                    slave.get_into(&measured, &mut value);
                    black_box(&value);
                }
            }
            begun.elapsed().as_secs_f64() * 1e6 / starts.len() as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[REPETITIONS / 2]
}

fn main() {
    let names = ["q[1]", "q_dot[1]", "q[2]", "q_dot[2]"].map(reference);
    let starts = starts(&names);
    let slave = Slave::new();
    let tolerance = (reference("tolerance"), TOLERANCE);
    let base = measure(&slave, &names, &starts, &[tolerance]);
    println!("20 ms from a reset, sampled every 0.2 ms, tolerance 1e-7");
    println!("  {:<28} {base:8.1} us", "reference model");
    let mut sum = 0.0;
    for card in CATALOGUE {
        let settings: Vec<(u32, f64)> = card
            .parameters
            .iter()
            .map(|p| (reference(&format!("{}.{}", card.id, p.name)), p.typical))
            .chain([tolerance])
            .collect();
        let time = measure(&slave, &names, &starts, &settings);
        sum += time;
        println!("  {:<28} {time:8.1} us", card.id);
    }
    println!(
        "  {:<28} {:8.1} us",
        "mean over the effects",
        sum / CATALOGUE.len() as f64
    );
}
