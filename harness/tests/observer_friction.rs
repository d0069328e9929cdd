//! Friction characteristic, break-away and laws against the law of the reference rig.

mod rig;

use rig::Rig;
use stickslip::observer::{
    BeltVelocity, Contact, FrictionLaw, NormalForce, StickSlip, Structure, break_away, fit_laws,
    friction_characteristic, smooth_stick_slip,
};

fn found(decibel: f64) -> StickSlip {
    let beam = Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap();
    let record = Rig::default_case().run(0.5, 1.0, 20e3);
    let y = rig::noisy(&record.displacement, decibel, 1);
    let belt = BeltVelocity::Constant(0.10);
    smooth_stick_slip(&beam, 5e-5, &y, belt, &Default::default()).unwrap()
}

fn contact(found: &StickSlip) -> Contact<'_> {
    Contact {
        relative_velocity: &found.relative_velocity,
        force: &found.smoothed.force,
        normal_force: NormalForce::Constant(100.0),
        phases: &found.phases,
    }
}

// Source: the friction law of the simulation (rig/), bound: item 4 of the table of figures.
#[test]
fn val_characteristic_is_the_law_of_the_rig() {
    let rig = Rig::default_case();
    for decibel in [60.0, 80.0] {
        let found = found(decibel);
        let bins = friction_characteristic(&contact(&found), &Default::default()).unwrap();
        let mut worst: f64 = 0.0;
        for bin in &bins {
            let speed = bin.relative_velocity.abs();
            let error = bin.mu / rig.mu(speed) - 1.0;
            println!(
                "{:.4} m/s: {:.4} +- {:.4} (std {:.4}, {} in {} phases), error {:+.2} %",
                bin.relative_velocity,
                bin.mu,
                bin.mu_error,
                bin.mu_std,
                bin.count,
                bin.phases,
                100.0 * error
            );
            if (0.02..0.5).contains(&speed) {
                worst = worst.max(error.abs());
            }
        }
        println!("{decibel} dB: worst {:.2} %", 100.0 * worst);
        assert!(worst < 0.02, "{decibel} dB: {worst}");
        assert!(bins.iter().any(|b| b.relative_velocity.abs() > 0.45));
    }
}

// Source: the friction law of the simulation (rig/): mu_0 = 0.66, a1 = 0.5, v1 = 0.02 m/s.
#[test]
fn val_law_of_the_rig_is_found_with_its_parameters() {
    let found = found(60.0);
    let contact = contact(&found);
    let bins = friction_characteristic(&contact, &Default::default()).unwrap();
    let dwell = break_away(&contact).unwrap();
    println!(
        "mu_s {:.4} +- {:.4}, slope {:.4} +- {:.4}, {}",
        dwell.mu_mean,
        dwell.mu_std,
        dwell.slope,
        dwell.slope_interval,
        dwell.verdict()
    );
    assert!((dwell.mu_mean / 0.66 - 1.0).abs() < 0.02);
    let error = dwell.mu_std / (dwell.events.len() as f64).sqrt();
    let fits = fit_laws(&bins, Some((dwell.mu_mean, error))).unwrap();
    for fit in &fits {
        println!(
            "{}: residual {:.4}, criterion {:.1}",
            fit.law.name(),
            fit.residual,
            fit.criterion
        );
        for p in &fit.parameters {
            println!(
                "    {} = {:.4} ({:.4} to {:.4}) {}",
                p.name, p.value, p.low, p.high, p.unit
            );
        }
    }
    let stelter = fits.iter().find(|f| f.law.name() == "Stelter").unwrap();
    for (name, truth) in [("mu_0", 0.66), ("a1", 0.5), ("v1", 0.02)] {
        let p = stelter.parameters.iter().find(|p| p.name == name).unwrap();
        assert!((p.value / truth - 1.0).abs() < 0.05, "{name} {}", p.value);
    }
    let coulomb = fits.iter().find(|f| f.law.name() == "Coulomb").unwrap();
    assert!(stelter.criterion < coulomb.criterion);
    // The table is ready for the model.
    let table = &fits.last().unwrap().law;
    let FrictionLaw::Table {
        velocity,
        coefficient,
    } = table
    else {
        panic!("no table")
    };
    assert!(velocity.len() <= 32 && velocity.len() == coefficient.len());
    assert!(velocity.windows(2).all(|w| w[0] < w[1]));
    assert!((table.mu(0.2) / Rig::default_case().mu(0.2) - 1.0).abs() < 0.02);
}
