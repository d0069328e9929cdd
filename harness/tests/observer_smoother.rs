//! The smoother against independent truths.

mod rig;

use rig::Rig;
use stickslip::observer::{Settings, Structure, smooth};

fn beam() -> Structure {
    Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap()
}

// Source: independent simulation (rig/), bounds: table of figures for the default case.
#[test]
fn val_random_walk_smoother_finds_the_force_of_the_default_case() {
    let record = Rig::default_case().run(0.5, 1.0, 20e3);
    for (decibel, bound) in [(80.0, 0.11), (60.0, 0.15)] {
        let y = rig::noisy(&record.displacement, decibel, 1);
        let found = smooth(&beam(), 5e-5, &y, &Settings::default()).unwrap();
        let noise = rig::std(&record.displacement) * 10_f64.powf(-decibel / 20.0);
        let error = rig::error(&found.force, &record.force);
        println!(
            "{decibel} dB: force {error:.4}, velocity {:.4}, acf {:.3}, peak {:.1} at {:.0} Hz, noise ratio {:.3}, transitions {}",
            rig::error(&found.velocity, &record.velocity),
            found.whiteness.largest_autocorrelation(),
            found.whiteness.peak_excess,
            found.whiteness.peak_frequency_hz,
            found.noise_std / noise,
            record.transitions.len(),
        );
        assert!(error <= bound, "{decibel} dB: {error}");
        assert!((found.noise_std / noise - 1.0).abs() < 0.05);
    }
}
