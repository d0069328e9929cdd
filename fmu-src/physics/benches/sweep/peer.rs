//! This project's side of the comparison with other integrators: lines in, times and section points out.
//!
//! A line `tolerance settle cycles v0 v0 ...` is answered by the seconds of processor time and then, for each belt
//! velocity v0 in m/s, by a line with its period and the time and displacement of every peak measured.

use crate::clock;
use beam_physics::sweep::{Motion, Rule, StartRule, Values, evaluate};
use std::fmt::Write;
use std::io::{BufRead, stdin};

fn study(line: &str) -> (f64, Vec<Motion>) {
    let mut numbers = line
        .split_whitespace()
        .map(|n| n.parse::<f64>().expect("a number"));
    let mut next = || numbers.next().expect("tolerance settle cycles");
    let (tolerance, settle, cycles) = (next(), next() as usize, next() as usize);
    let subjects: Vec<_> = numbers
        .map(|velocity| {
            let mut values = Values::default();
            values.set("belt_velocity", velocity).expect("known");
            values.set("normal_force", 100.0).expect("known");
            values.set("tolerance", tolerance).expect("known");
            values.subject().expect("valid")
        })
        .collect();
    let rule = Rule {
        settle,
        cycles,
        patience: 0,
        lyapunov: false,
        ..Rule::default()
    };
    let mut motions = Vec::new();
    let seconds = clock::per_run(|| {
        let moves = |s| evaluate(s, &rule, &StartRule::Fixed, None).expect("it moves");
        motions = subjects.iter().map(moves).collect();
    });
    (seconds, motions)
}

/// Answers until the input ends.
pub fn serve() {
    for line in stdin().lock().lines() {
        let (seconds, motions) = study(&line.expect("readable"));
        println!("{seconds:e}");
        for motion in motions {
            let mut out = format!("{}", motion.period.unwrap_or(0));
            for point in &motion.section {
                write!(out, " {:e} {:e}", point.time, point.displacement).expect("a string");
            }
            println!("{out}");
        }
    }
}
