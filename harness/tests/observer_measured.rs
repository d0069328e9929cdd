//! The observer on measured data that nobody here made; skipped where the data are absent.
//!
//! Colas, Pustelnik, Oliver, Abry, Geminard, Vidal, Phys. Rev. E 2019: a slider of 30.7 g pulled
//! over paper through a leaf spring. In the frame of the puller it is one mode on a belt:
//! displacement m g F/k, belt velocity v.

use std::path::Path;

use stickslip::observer::{
    BeltVelocity, Contact, NormalForce, PhaseMode, Settings, Structure, UniformRecord, break_away,
    smooth, smooth_stick_slip,
};

const FOLDER: &str = "/work/shared/real/ens-lyon-stickslip";
const MASS: f64 = 0.0307;
const WEIGHT: f64 = MASS * 9.81;

fn record(stiffness: f64, name: &str) -> Option<UniformRecord> {
    let folder = std::env::var("STICKSLIP_ENS_LYON").unwrap_or_else(|_| FOLDER.into());
    let path = Path::new(&folder).join(name);
    let Ok(text) = std::fs::read_to_string(&path) else {
        println!("SKIPPED: {} is not there", path.display());
        return None;
    };
    let (mut time, mut displacement) = (Vec::new(), Vec::new());
    for line in text.lines().skip(1) {
        let (t, share) = line.split_once(',').unwrap();
        time.push(t.parse().unwrap());
        displacement.push(WEIGHT / stiffness * share.parse::<f64>().unwrap());
    }
    Some(UniformRecord::of(&time, &displacement, None).unwrap())
}

// Source: the data; README there: mean mu 0.29 to 0.50 from run to run.
#[test]
fn val_one_mode_slider_sticks_and_slips() {
    let runs = [
        (168.0, 1100e-6, "k168_v1100.csv"),
        (1002.0, 1100e-6, "k1002_v1100.csv"),
    ];
    for (stiffness, belt, name) in runs {
        let Some(record) = record(stiffness, name) else {
            return;
        };
        let frequency = (stiffness / MASS).sqrt() / (2.0 * std::f64::consts::PI);
        let slider = Structure::single(frequency, 1e-3, MASS).unwrap();
        let y = &record.displacement;
        let plain = smooth(&slider, record.interval, y, &Settings::default()).unwrap();
        let mean = plain.force.iter().sum::<f64>() / plain.force.len() as f64 / WEIGHT;
        let belt = BeltVelocity::Constant(belt);
        let found =
            smooth_stick_slip(&slider, record.interval, y, belt, &Default::default()).unwrap();
        let contact = Contact {
            relative_velocity: &found.relative_velocity,
            force: &found.smoothed.force,
            normal_force: NormalForce::Constant(WEIGHT),
            phases: &found.phases,
        };
        let dwell = break_away(&contact).unwrap();
        println!(
            "{name}: mean mu {mean:.3}, static {:.3} +- {:.3} in {} sticks, in stick {:.2}, noise {:.2e} m, autocorrelation {:.2}; {}",
            dwell.mu_mean,
            dwell.mu_std,
            dwell.events.len(),
            found.stick_fraction(),
            plain.noise_std,
            plain.whiteness.largest_autocorrelation(),
            dwell.verdict()
        );
        assert!((0.25..0.55).contains(&mean));
        assert!(dwell.mu_mean > mean && dwell.mu_mean < 0.6);
        assert!(
            found
                .phases
                .iter()
                .any(|p| p.mode == PhaseMode::BackwardSlip)
        );
        // Steady stick-slip cannot show ageing; the verdict says so.
        assert!(dwell.verdict().contains("no "));
    }
}
