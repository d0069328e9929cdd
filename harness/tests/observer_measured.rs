//! The observer on measured data that nobody here made; run by name where the data are.
//!
//! Colas, Pustelnik, Oliver, Abry, Geminard, Vidal, Phys. Rev. E 2019: a slider of 30.7 g pulled
//! over paper through a leaf spring. In the frame of the puller it is one mode on a belt:
//! displacement m g F/k, belt velocity v.

use std::path::PathBuf;
use std::process::Command;

use stickslip::observer::{
    BeltVelocity, Contact, NormalForce, PhaseMode, Settings, Structure, UniformRecord, break_away,
    smooth, smooth_stick_slip,
};

/// Beside the repository, or where the environment variable STICKSLIP_ENS_LYON says.
const FOLDER: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../shared/real/ens-lyon-stickslip"
);
const MASS: f64 = 0.0307;
const WEIGHT: f64 = MASS * 9.81;

fn folder() -> PathBuf {
    std::env::var("STICKSLIP_ENS_LYON")
        .unwrap_or_else(|_| FOLDER.into())
        .into()
}

fn record(stiffness: f64, name: &str) -> UniformRecord {
    let path = folder().join(name);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let (mut time, mut displacement) = (Vec::new(), Vec::new());
    for line in text.lines().skip(1) {
        let (t, share) = line.split_once(',').unwrap();
        time.push(t.parse().unwrap());
        displacement.push(WEIGHT / stiffness * share.parse::<f64>().unwrap());
    }
    UniformRecord::of(&time, &displacement, None).unwrap()
}

// Source: the data; README there: mean mu 0.29 to 0.50 from run to run.
#[test]
#[ignore = "needs the measured slider, a folder named by STICKSLIP_ENS_LYON or ../shared/real/ens-lyon-stickslip"]
fn val_one_mode_slider_sticks_and_slips() {
    let runs = [
        (168.0, 1100e-6, "k168_v1100.csv"),
        (1002.0, 1100e-6, "k1002_v1100.csv"),
    ];
    for (stiffness, belt, name) in runs {
        let record = record(stiffness, name);
        let frequency = (stiffness / MASS).sqrt() / (2.0 * std::f64::consts::PI);
        let slider = Structure::single(frequency, 1e-3, MASS).unwrap();
        let y = &record.measured;
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

/// One mode: the slider on its spring; the column is the spring force over the weight.
fn campaign(stiffness: f64) -> String {
    format!(
        "[beam]
natural_frequencies_hz = [{}]
damping_ratios = [0.001]
mass_kg = {MASS}
tip_values = [1.0]
[channels]
displacement_column = \"spring_force_over_weight\"
displacement_scale = {}
",
        (stiffness / MASS).sqrt() / (2.0 * std::f64::consts::PI),
        WEIGHT / stiffness
    )
}

// Source: the data; the README beside them gives the range of the mean coefficient, 0.29 to 0.50.
#[test]
#[ignore = "needs the measured slider, a folder named by STICKSLIP_ENS_LYON or ../shared/real/ens-lyon-stickslip"]
fn val_command_observes_every_measured_slider() {
    let data = folder();
    for (stiffness, micrometres_per_s) in [(168, 42), (168, 1100), (168, 4300), (1002, 1100)] {
        let name = format!("k{stiffness}_v{micrometres_per_s}.csv");
        let scratch = tempfile::tempdir().unwrap();
        let mut toml = campaign(f64::from(stiffness));
        toml += &format!(
            "[[run]]\nfile = '{}'\nbelt_velocity_m_per_s = {}\nnormal_force_n = {WEIGHT}\n",
            data.join(&name).display(),
            f64::from(micrometres_per_s) * 1e-6
        );
        std::fs::write(scratch.path().join("campaign.toml"), toml).unwrap();
        let out = scratch.path().join("out");
        let done = Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .arg("observe")
            .arg(data.join(&name))
            .arg("--campaign")
            .arg(scratch.path())
            .arg("-o")
            .arg(&out)
            .arg("--json")
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&done.stderr);
        assert!(done.status.success(), "{name}: {text}");
        let summary: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
        println!(
            "{name}: stick {:.2} in {} phases, noise {:.2e} m, autocorrelation {:.2}, static {:.3} +- {:.3}, curve misfit {:.1}, {}",
            summary["stick_fraction"].as_f64().unwrap(),
            summary["complete_stick_phases"],
            summary["noise_std_m"].as_f64().unwrap(),
            summary["innovation"]["largest_autocorrelation"]
                .as_f64()
                .unwrap(),
            summary["break_away"]["mu_mean"]
                .as_f64()
                .unwrap_or(f64::NAN),
            summary["break_away"]["mu_std"].as_f64().unwrap_or(f64::NAN),
            summary["friction_curve"]["misfit"]
                .as_f64()
                .unwrap_or(f64::NAN),
            summary["remarks"]
        );
        let force = std::fs::read_to_string(out.join("force.csv")).unwrap();
        let forces: Vec<f64> = force
            .lines()
            .skip(1)
            .map(|l| l.split(',').nth(1).unwrap().parse().unwrap())
            .collect();
        let mean = forces.iter().sum::<f64>() / forces.len() as f64 / WEIGHT;
        println!("    mean coefficient {mean:.3}");
        assert!((0.25..0.55).contains(&mean), "{name}: {mean}");
    }
}
