//! The smoother against independent truths.

mod rig;

use rig::Rig;
use stickslip::observer::{
    BeltVelocity, Settings, StickSlipSettings, Structure, estimate_frequencies, smooth,
    smooth_stick_slip,
};

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

// Source: independent simulation (rig/), bounds: table of figures for the default case.
#[test]
fn val_stick_slip_smoother_finds_force_and_phases_of_the_default_case() {
    let record = Rig::default_case().run(0.5, 1.0, 20e3);
    for (decibel, bound) in [(80.0, 0.05), (60.0, 0.085)] {
        let y = rig::noisy(&record.displacement, decibel, 1);
        let belt = BeltVelocity::Constant(0.10);
        let found = smooth_stick_slip(&beam(), 5e-5, &y, belt, &Default::default()).unwrap();
        let error = rig::error(&found.smoothed.force, &record.force);
        println!(
            "{decibel} dB: force {error:.4}, stick misfit {:.2}",
            found.stick_misfit
        );
        assert!(error <= bound, "{decibel} dB: {error}");
        assert!(found.stick_misfit < 1.0);
        assert_eq!(found.phases.len(), record.transitions.len() + 1);
        for (phase, (time, mode)) in found.phases.iter().zip(&record.transitions) {
            assert_eq!(phase.mode.number(), *mode);
            // Arrival is sharp; the velocity leaves zero gradually at break-away.
            let late = phase.end - time;
            let bound = if *mode == 0 { 4e-4 } else { 1.5e-4 };
            assert!(
                late.abs() < bound,
                "mode {mode} left at {time} s, found {late:e} s late"
            );
        }
    }
}

// Source: independent simulation (rig/) with 80 and 510 Hz; the estimate starts 0.3 and 0.4 % off.
#[test]
fn val_frequencies_are_found_together_with_the_force() {
    let record = Rig::default_case().run(0.5, 0.7, 20e3);
    let y = rig::noisy(&record.displacement, 80.0, 1);
    let off = beam()
        .with_frequencies(&[80.0 * 0.997, 510.0 * 1.004])
        .unwrap();
    let belt = BeltVelocity::Constant(0.10);
    let settings = StickSlipSettings::default();
    let found = estimate_frequencies(&off, 5e-5, &y, belt, &settings, 0.01).unwrap();
    println!("{:?}", found.modes);
    assert!((found.modes[1].found_hz / 510.0 - 1.0).abs() < 1e-3);
    let error = |structure: &Structure| {
        let found = smooth_stick_slip(structure, 5e-5, &y, belt, &settings).unwrap();
        rig::error(&found.smoothed.force, &record.force)
    };
    let (before, after) = (error(&off), error(&found.structure));
    println!("force error {before:.3} before, {after:.3} after");
    assert!(after < 0.06 && before > 4.0 * after);
}
