//! Parameter studies: Figure 6 as a whole, and the cost over points, cycles and modes. Reported, not tested.

use beam_physics::sweep::{Chain, Rule, StartRule, Task, Values, run};
use std::time::Instant;

/// Seconds for `points` points of Figure 6 with `cycles` peaks each, half of them settling, on `threads` threads.
fn seconds(points: usize, cycles: usize, modes: usize, lyapunov: bool, threads: usize) -> f64 {
    let chains: Vec<Chain> = (0..points)
        .map(|id| {
            let share = if points > 1 {
                id as f64 / (points - 1) as f64
            } else {
                0.5
            };
            let mut values = Values::default();
            values.set("normal_force", 100.0).expect("known");
            values.set("mode_count", modes as f64).expect("known");
            let velocity = 0.01 + 0.2 * share;
            values.set("belt_velocity", velocity).expect("known");
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
        settle: cycles / 2,
        cycles: cycles - cycles / 2,
        // Equal work for every point.
        patience: 0,
        lyapunov,
        ..Rule::default()
    };
    let begin = Instant::now();
    let mut section = 0;
    run(&chains, &rule, threads, |outcome| {
        section += outcome.motion.map_or(0, |m| m.section.len());
        true
    });
    let taken = begin.elapsed().as_secs_f64();
    assert!(section > 0);
    taken
}

fn main() {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!("threads: {threads}");
    for lyapunov in [false, true] {
        let best = (0..3)
            .map(|_| seconds(1000, 200, 2, lyapunov, threads))
            .fold(f64::INFINITY, f64::min);
        let what = if lyapunov {
            "with exponents"
        } else {
            "without exponents"
        };
        println!("1000 points x 200 cycles of Figure 6, {what}: {best:.2} s (best of 3)");
    }
    let one = seconds(200, 200, 2, true, 1);
    for points in [50, 100, 200, 400] {
        let s = seconds(points, 200, 2, true, 1);
        println!(
            "{points} points, 200 cycles, 2 modes: {:.1} us per point and cycle",
            1e6 * s / (points * 200) as f64
        );
    }
    for cycles in [100, 200, 400, 800] {
        let s = seconds(100, cycles, 2, true, 1);
        println!(
            "100 points, {cycles} cycles, 2 modes: {:.1} us per point and cycle",
            1e6 * s / (100 * cycles) as f64
        );
    }
    for modes in [1, 2, 4, 8] {
        let s = seconds(100, 200, modes, true, 1);
        println!(
            "100 points, 200 cycles, {modes} modes: {:.1} us per point and cycle",
            1e6 * s / (100 * 200) as f64
        );
    }
    println!(
        "one thread against {threads}: {:.2}",
        one / seconds(200, 200, 2, true, threads)
    );
}
