//! Parameter studies: Figure 6 as a whole, and the cost over points, cycles and modes. Reported, not tested.
//!
//! With the argument `peer` it answers the driver of the comparison, benches/peers/sweep.py.

mod clock;
mod growth;
mod peer;

use beam_physics::sweep::{Chain, Rule, StartRule, Task, Values, run};
use std::time::Instant;

/// Belt velocities in m/s of Figure 6.
const FIGURE_6: (f64, f64) = (0.096, 0.112);
const REPETITIONS: usize = 3;

/// 1000 points x 200 cycles of Figure 6 on all cores: seconds on the clock, and of processor time over all threads.
fn figure_6(lyapunov: bool, threads: usize) -> (f64, f64) {
    let chains: Vec<Chain> = (0..1000)
        .map(|id| {
            let share = id as f64 / 999.0;
            let mut values = Values::default();
            let velocity = FIGURE_6.0 + (FIGURE_6.1 - FIGURE_6.0) * share;
            values.set("belt_velocity", velocity).expect("known");
            values.set("normal_force", 100.0).expect("known");
            Chain {
                carried: None,
                tasks: vec![Task {
                    id,
                    values,
                    start: StartRule::Fixed,
                }],
            }
        })
        .collect();
    let rule = Rule {
        settle: 100,
        cycles: 100,
        // Equal work for every point.
        patience: 0,
        lyapunov,
        ..Rule::default()
    };
    let (begun, busy) = (Instant::now(), clock::process());
    let mut points = 0;
    run(&chains, &rule, threads, |outcome| {
        points += outcome.motion.map_or(0, |m| m.section.len());
        true
    });
    let taken = (begun.elapsed().as_secs_f64(), clock::process() - busy);
    assert!(points >= 100_000, "{points} section points");
    taken
}

fn main() {
    if std::env::args().any(|a| a == "peer") {
        return peer::serve();
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    for lyapunov in [false, true] {
        let times: Vec<_> = (0..REPETITIONS)
            .map(|_| figure_6(lyapunov, threads))
            .collect();
        let least = |f: fn(&(f64, f64)) -> f64| times.iter().map(f).fold(f64::INFINITY, f64::min);
        println!(
            "1000 points x 200 cycles of Figure 6, {} exponents, {threads} threads, best of {REPETITIONS}: \
             {:.2} s on the clock, {:.2} s of processor time",
            if lyapunov { "with" } else { "without" },
            least(|t| t.0),
            least(|t| t.1)
        );
    }
    growth::report();
}
