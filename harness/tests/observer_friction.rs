//! Friction characteristic, break-away and laws against the law of the reference rig.

mod rig;

use rig::Rig;
use stickslip::observer::{
    BeltVelocity, Contact, FrictionLaw, LawPoints, NormalForce, StickSlip, Structure, break_away,
    fit_laws, friction_characteristic, friction_curve, smooth_stick_slip,
};

fn beam() -> Structure {
    Structure::cantilever(&[80.0, 510.0], &[0.00015, 0.00085], 0.427).unwrap()
}

fn found(decibel: f64) -> (Vec<f64>, StickSlip) {
    let record = Rig::default_case().run(0.5, 1.0, 20e3);
    let y = rig::noisy(&record.displacement, decibel, 1);
    let belt = BeltVelocity::Constant(0.10);
    let found = smooth_stick_slip(&beam(), 5e-5, &y, belt, &Default::default()).unwrap();
    (y, found)
}

fn contact(found: &StickSlip) -> Contact<'_> {
    Contact {
        relative_velocity: &found.relative_velocity,
        force: &found.smoothed.force,
        normal_force: NormalForce::Constant(100.0),
        phases: &found.phases,
    }
}

// Source: the friction law of the simulation (rig/), bound: item 4 of the table of figures (2 %
// from 0.02 to 0.5 m/s at 60 dB); the bins hold it from 0.1 m/s, where samples are many.
#[test]
fn val_characteristic_is_the_law_of_the_rig() {
    let rig = Rig::default_case();
    let beam = beam();
    for decibel in [60.0, 80.0] {
        let (y, found) = found(decibel);
        let contact = contact(&found);
        let bins = friction_characteristic(&contact, &Default::default()).unwrap();
        for bin in bins
            .iter()
            .filter(|b| (0.1..0.5).contains(&b.relative_velocity.abs()))
        {
            let error = bin.mu / rig.mu(bin.relative_velocity.abs()) - 1.0;
            assert!(
                error.abs() < 0.02,
                "{decibel} dB, {}: {error}",
                bin.relative_velocity
            );
        }
        let belt = BeltVelocity::Constant(0.10);
        let curve = friction_curve(&beam, &y, belt, &contact, &found, &Default::default()).unwrap();
        let worst = (0..200)
            .map(|i| 0.02 * 25_f64.powf(f64::from(i) / 199.0))
            .map(|v| (curve.at(v) / rig.mu(v) - 1.0).abs())
            .fold(0.0, f64::max);
        println!(
            "{decibel} dB: worst {:.2} %, misfit {:.3}",
            100.0 * worst,
            curve.misfit
        );
        assert!(worst < 0.02, "{decibel} dB: {worst}");
        assert!((curve.misfit - 1.0).abs() < 0.05);
        let truths = curve.speed.iter().map(|v| rig.mu(*v));
        let inside = truths
            .zip(curve.mu.iter().zip(&curve.mu_std))
            .filter(|(truth, (mu, std))| (*mu - truth).abs() < 3.0 * *std)
            .count();
        assert!(
            inside >= 17,
            "{inside} of 20 nodes within three standard deviations"
        );
    }
}

// Source: the friction law of the simulation (rig/): mu_0 = 0.66, a1 = 0.5, v1 = 0.02 m/s.
#[test]
fn val_law_of_the_rig_is_found_with_its_parameters() {
    let (y, found) = found(60.0);
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
    let rough = fit_laws(&LawPoints::from_bins(&bins, Some((dwell.mu_mean, error)))).unwrap();
    assert_eq!(rough.len(), 4);
    let belt = BeltVelocity::Constant(0.10);
    let curve = friction_curve(&beam(), &y, belt, &contact, &found, &Default::default()).unwrap();
    let fits = fit_laws(&LawPoints::from_curve(&curve)).unwrap();
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

// Source: the friction law of the simulation (rig/); 95 % intervals must hold the truth about as
// often as they say.
#[test]
fn val_intervals_of_the_law_hold_the_truth() {
    let record = Rig::default_case().run(0.5, 1.0, 20e3);
    let belt = BeltVelocity::Constant(0.10);
    let truths = [("mu_0", 0.66), ("a1", 0.5), ("v1", 0.02), ("c2", 0.25)];
    let (mut inside, mut asked) = (0, 0);
    for seed in 1..=8 {
        let y = rig::noisy(&record.displacement, 60.0, seed);
        let found = smooth_stick_slip(&beam(), 5e-5, &y, belt, &Default::default()).unwrap();
        let contact = contact(&found);
        let curve =
            friction_curve(&beam(), &y, belt, &contact, &found, &Default::default()).unwrap();
        let fits = fit_laws(&LawPoints::from_curve(&curve)).unwrap();
        let stelter = fits.iter().find(|f| f.law.name() == "Stelter").unwrap();
        for (name, truth) in truths {
            let p = stelter.parameters.iter().find(|p| p.name == name).unwrap();
            let width = (p.high - p.low) / truth;
            println!(
                "seed {seed}: {name} {:.4} [{:.4}, {:.4}]",
                p.value, p.low, p.high
            );
            assert!(width < 0.5, "{name}: an interval this wide says nothing");
            asked += 1;
            inside += usize::from((p.low..=p.high).contains(&truth));
        }
    }
    println!("{inside} of {asked} intervals hold the truth");
    assert!(inside as f64 >= 0.85 * f64::from(asked));
}
