//! Speed of the smoother: `cargo bench -p stickslip --bench observer`.

use std::time::Instant;
use stickslip::observer::{Settings, Structure, smooth};

fn main() {
    let beam = Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap();
    for count in [125_000, 250_000, 500_000, 1_000_000] {
        // Tones and a little noise; the cost does not depend on the values.
        let signal: Vec<f64> = (0..count)
            .map(|k| {
                let t = f64::from(k) * 5e-5;
                1e-3 * (210.0 * t).sin()
                    + 1e-4 * (3200.0 * t).cos()
                    + 1e-6 * f64::from((k % 13) * 7919 % 13)
            })
            .collect();
        let given = Settings {
            noise_std: Some(4e-6),
            force_intensity: Some(1e5),
            ..Settings::default()
        };
        for (name, settings) in [
            ("noise levels estimated", Settings::default()),
            ("noise levels given", given.clone()),
            (
                "noise levels given, full recursion at every sample",
                Settings {
                    converged_gain: false,
                    ..given
                },
            ),
        ] {
            let times: [f64; 3] = std::array::from_fn(|_| {
                let start = Instant::now();
                std::hint::black_box(smooth(&beam, 5e-5, &signal, &settings).unwrap());
                start.elapsed().as_secs_f64()
            });
            let best = times.iter().copied().fold(f64::INFINITY, f64::min);
            println!(
                "two modes, {count} samples, {name}: {best:.3} s, {:.2} microseconds per sample (best of 3)",
                1e6 * best / f64::from(count)
            );
        }
    }
}
