//! Speed of the smoother: `cargo bench -p stickslip --bench observer`.

use std::time::Instant;
use stickslip::observer::{Settings, Structure, smooth};

fn main() {
    let beam = Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap();
    for count in [100_000, 1_000_000] {
        // A sum of tones with a jump every 25 ms; the cost does not depend on the values.
        let signal: Vec<f64> = (0..count)
            .map(|k| {
                let t = k as f64 * 5e-5;
                1e-3 * (210.0 * t).sin()
                    + 1e-4 * (3200.0 * t).cos()
                    + 1e-6 * ((k * 7919) % 13) as f64
            })
            .collect();
        for (name, settings) in [
            (
                "noise levels estimated, converged gain",
                Settings::default(),
            ),
            (
                "noise levels given, every gain",
                Settings {
                    noise_std: Some(4e-6),
                    force_intensity: Some(1e5),
                    converged_gain: false,
                    ..Settings::default()
                },
            ),
        ] {
            let start = Instant::now();
            let found = smooth(&beam, 5e-5, &signal, &settings).unwrap();
            println!(
                "two modes, {count} samples, {name}: {:.3} s (noise {:.2e} m)",
                start.elapsed().as_secs_f64(),
                found.noise_std
            );
        }
    }
}
