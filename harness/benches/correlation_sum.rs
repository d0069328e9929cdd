//! Speed of the correlation sum: `cargo bench -p stickslip --bench correlation_sum`, against a plain double loop in f64 and, where
//! Python is there, scikit-learn and nolds (`benches/peers/correlation_sum.py`, installed into `target/bench-venv`).

#[path = "../tests/attractors/mod.rs"]
mod attractors;

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use stickslip::dimension::{CorrelationSum, Instructions, Norm, SumSettings};

const USUAL: SumSettings = SumSettings {
    delay: 8,
    dimensions: 10,
    theiler: 100,
    thin: 1,
    norm: Norm::Maximum,
    radii: 40,
    range: None,
    threads: 1,
    instructions: Instructions::Widest,
};

fn best(times: usize, mut work: impl FnMut()) -> f64 {
    (0..times)
        .map(|_| {
            let start = Instant::now();
            work();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

/// All dimensions in one pass, a logarithm for each new maximum: what one writes first, made reasonably.
fn double_loop(x: &[f64], s: &SumSettings, radii: &[f64]) -> Vec<u64> {
    let mut counts = vec![0_u64; radii.len() * s.dimensions];
    let (low, per_octave) = (radii[0].log2(), 4.0);
    for i in 0..x.len() {
        for j in i + s.theiler + 1..x.len() {
            let (mut largest, mut bin) = (0.0_f64, 0);
            for m in 0..s.dimensions {
                let at = m * s.delay;
                if j + at >= x.len() {
                    break;
                }
                let d = (x[i + at] - x[j + at]).abs();
                if d > largest {
                    largest = d;
                    let place = ((d.log2() - low) * per_octave).ceil().max(0.0);
                    bin = (place as usize).min(radii.len() - 1);
                }
                counts[bin * s.dimensions + m] += 1;
            }
        }
    }
    counts
}

fn main() {
    for (count, times) in [(15_000, 5), (50_000, 3), (200_000, 1)] {
        let x = attractors::lorenz(0, 0.02, count);
        let cases = [
            ("one thread", USUAL),
            (
                "AVX2 at most",
                SumSettings {
                    instructions: Instructions::Avx2,
                    ..USUAL
                },
            ),
            (
                "instructions of the build",
                SumSettings {
                    instructions: Instructions::Build,
                    ..USUAL
                },
            ),
            (
                "all threads",
                SumSettings {
                    threads: 0,
                    ..USUAL
                },
            ),
            (
                "one thread, thinned by the delay",
                SumSettings { thin: 8, ..USUAL },
            ),
            (
                "one thread, Euclidean norm",
                SumSettings {
                    norm: Norm::Euclidean,
                    ..USUAL
                },
            ),
        ];
        for (name, settings) in cases {
            let slow =
                settings.instructions == Instructions::Build || settings.norm == Norm::Euclidean;
            if count == 200_000 && slow {
                continue;
            }
            let seconds = best(times, || {
                std::hint::black_box(CorrelationSum::count(&x, &settings, &|_| true).unwrap());
            });
            println!("N = {count}, {name}: {seconds:.3} s");
        }
        if count == 15_000 {
            let sum = CorrelationSum::count(&x, &USUAL, &|_| true).unwrap();
            let seconds = best(1, || {
                std::hint::black_box(double_loop(&x, &USUAL, &sum.radii));
            });
            println!("N = {count}, double loop in f64: {seconds:.3} s");
            peers(&x);
        }
    }
}

/// Runs the Python peers on the same series, if they can be installed.
fn peers(x: &[f64]) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let venv = root.join("target/bench-venv");
    let python = venv.join("bin/python");
    let run = |program: &Path, arguments: &[&str]| {
        Command::new(program)
            .args(arguments)
            .status()
            .is_ok_and(|s| s.success())
    };
    let ready = python.is_file()
        || run(
            Path::new("python3"),
            &["-m", "venv", &venv.to_string_lossy()],
        );
    if !ready
        || !run(
            &python,
            &["-m", "pip", "install", "-q", "nolds==0.6.2", "scikit-learn"],
        )
    {
        println!("peers skipped: Python or its packages are not available");
        return;
    }
    let file = std::env::temp_dir().join(format!("lorenz-{}.txt", std::process::id()));
    let text: String = x.iter().map(|v| format!("{v}\n")).collect();
    std::fs::write(&file, text).expect("writable");
    let script = root.join("benches/peers/correlation_sum.py");
    run(
        &python,
        &[&script.to_string_lossy(), &file.to_string_lossy()],
    );
    let _ = std::fs::remove_file(file);
}
