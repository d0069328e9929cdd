//! `stickslip check` on machines without contact, good and spoilt.

mod rig;

use rig::{Noise, runge_kutta};
use std::f64::consts::TAU;
use std::fmt::Write as _;
use stickslip::check::{Quality, Severity, check};
use stickslip::measurement::Campaign;

/// An oscillator: kg, Hz, 1, N/m^3.
const MASS: f64 = 1.4;
const FREQUENCY: f64 = 13.0;
const DAMPING: f64 = 0.01;
const CUBIC: f64 = 2e9;
/// Samples per s, and how many.
const RATE: f64 = 500.0;
const SAMPLES: usize = 3000;
const NOISE: f64 = 3e-6;

/// Sines of 2 to 40 Hz.
fn multisine(t: f64) -> f64 {
    let sines = (2..40).map(|i| (TAU * f64::from(i) * t + f64::from(i * i)).sin());
    sines.sum()
}

/// What a run says, and the factors by which its columns are wrong.
struct Spoilt {
    /// Of the column of displacements or absolute accelerations, and of that of the drive.
    scales: [f64; 2],
    beam: String,
    drive: Drive,
}

#[derive(Clone, Copy, PartialEq)]
enum Drive {
    None,
    Force,
    Clamp,
}

fn beam(frequency: f64, mass: f64) -> String {
    format!(
        "natural_frequencies_hz = [{frequency}]\ndamping_ratios = [{DAMPING}]\nmass_kg = {mass}\ntip_values = [1.0]\nclamp_shares = [1.0]\n"
    )
}

/// The campaign of runs of time, reading and drive, with these keys of the beam and of the channels.
fn of_rows(beam: &str, channels: &str, runs: &[Vec<[f64; 3]>]) -> Quality {
    let folder = tempfile::tempdir().unwrap();
    let mut toml = format!("[beam]\n{beam}{channels}");
    for (run, rows) in runs.iter().enumerate() {
        let mut csv = String::from("t,read,drive\n");
        for [t, read, drive] in rows {
            let _ = writeln!(csv, "{t:.5},{read:.9e},{drive:.9e}");
        }
        std::fs::write(folder.path().join(format!("run{run}.csv")), csv).unwrap();
        let _ = write!(
            toml,
            "[[run]]\nfile = \"run{run}.csv\"\nbelt_velocity_m_per_s = 0\nnormal_force_n = 0\n"
        );
    }
    std::fs::write(folder.path().join("campaign.toml"), toml).unwrap();
    check(&Campaign::load(folder.path()).unwrap())
}

const FORCE: &str =
    "[channels]\ndisplacement_column = \"read\"\nexternal_force_column = \"drive\"\n";

/// The campaign as it is spoilt, integrated by the classical method of Runge and Kutta.
fn checked(spoilt: &Spoilt) -> Quality {
    let by = |t: f64| match spoilt.drive {
        Drive::None => 0.0,
        Drive::Force => multisine(t),
        Drive::Clamp => -0.3 * MASS * multisine(t),
    };
    let w = TAU * FREQUENCY;
    let rates = |t: f64, [x, v]: [f64; 2]| {
        let spring = w * w * x + CUBIC / MASS * x.powi(3);
        [v, by(t) / MASS - 2.0 * DAMPING * w * v - spring]
    };
    let channels = match spoilt.drive {
        Drive::None => "[channels]\ndisplacement_column = \"read\"\n",
        Drive::Force => FORCE,
        Drive::Clamp => {
            "[channels]\nacceleration_column = \"read\"\nclamp_acceleration_column = \"drive\"\n"
        }
    };
    let mut random = Noise::new(2);
    let mut runs = Vec::new();
    for (run, start) in [1e-3, 5e-4].into_iter().enumerate() {
        let mut state = match spoilt.drive {
            Drive::None => [start, 0.0],
            _ => [0.0, 0.0],
        };
        let mut rows = Vec::new();
        for k in 0..SAMPLES {
            let t = k as f64 / RATE + 10.0 * run as f64;
            let (read, drive) = match spoilt.drive {
                // What an accelerometer reads of a mass on a spring is the force of both on it.
                Drive::Clamp => (rates(t, state)[1] - by(t) / MASS, -by(t) / MASS),
                _ => (state[0] + NOISE * random.normal(), by(t)),
            };
            let [of_read, of_drive] = spoilt.scales;
            rows.push([t, of_read * read, of_drive * drive]);
            for step in 0..20 {
                let h = 1.0 / (20.0 * RATE);
                state = runge_kutta::step(rates, t + h * f64::from(step), state, h);
            }
        }
        runs.push(rows);
    }
    of_rows(&spoilt.beam, channels, &runs)
}

/// The linear oscillator under a force that is held from sample to sample.
fn held(force: impl Fn(usize) -> f64, noise: f64) -> Vec<[f64; 3]> {
    let mut random = Noise::new(7);
    let w = TAU * FREQUENCY;
    let (mut state, h) = ([0.0, 0.0], 1.0 / (10.0 * RATE));
    let mut rows = Vec::new();
    for k in 0..SAMPLES {
        let f = force(k);
        rows.push([k as f64 / RATE, state[0] + noise * random.normal(), f]);
        for _ in 0..10 {
            let rates =
                |_: f64, [x, v]: [f64; 2]| [v, f / MASS - 2.0 * DAMPING * w * v - w * w * x];
            state = runge_kutta::step(rates, 0.0, state, h);
        }
    }
    rows
}

// Source: the integration above; beyond the resonance of a force that has every frequency there is noise alone, and the window of a
// spectrum hides a blow at the start of a record.
#[test]
fn val_lines_without_a_signal_and_blows_are_no_findings() {
    let mut random = Noise::new(11);
    let white: Vec<f64> = (0..SAMPLES).map(|_| 5.0 * random.normal()).collect();
    let interpolated = format!("{FORCE}input_interpolation = \"held\"\n");
    for (what, rows) in [
        ("white", held(|k| white[k], 4e-5)),
        (
            "blow",
            held(|k| if (5..9).contains(&k) { 80.0 } else { 0.0 }, 2e-6),
        ),
    ] {
        let quality = of_rows(&beam(FREQUENCY, MASS), &interpolated, &[rows]);
        assert!(
            quality.findings.is_empty(),
            "{what}: {:?}",
            quality.findings
        );
    }
}

/// A free swing of a cantilever's first two modes as an accelerometer reads it: the second rules, 6.27 times as fast as the first.
fn two_modes(second: f64) -> Vec<[f64; 3]> {
    let mut random = Noise::new(3);
    let row = |k: usize| {
        let t = k as f64 / RATE;
        let mode = |f: f64, a: f64| -a * (TAU * f).powi(2) * (-0.1 * t).exp() * (TAU * f * t).cos();
        let noise = 1e-3 * random.normal();
        [t, mode(8.0, 1e-3) + mode(6.267 * 8.0, second) + noise, 0.0]
    };
    (0..SAMPLES).map(row).collect()
}

// Source: mode frequencies of a clamped beam, (4.694 / 1.875)^2 = 6.267, which is 2 pi to 0.3 %.
#[test]
fn val_a_second_mode_that_nobody_stated_is_no_confusion_with_angular_frequencies() {
    let channels = "[channels]\nacceleration_column = \"read\"\n";
    for second in [1e-4, 1e-3] {
        let quality = of_rows(&beam(8.0, MASS), channels, &[two_modes(second)]);
        assert!(quality.findings.is_empty(), "{:?}", quality.findings);
    }
    let quality = of_rows(&beam(8.0 * TAU, MASS), channels, &[two_modes(0.0)]);
    let ids: Vec<&str> = quality.errors().map(|e| e.id).collect();
    assert_eq!(ids, ["natural_frequencies"], "{:?}", quality.findings);
}

// Source: the integration above; a stiffness that hardens, masses off by 30 % and frequencies by 5 % are what rigs have.
#[test]
fn val_driven_and_free_runs_as_rigs_have_them_are_no_findings() {
    for drive in [Drive::None, Drive::Force, Drive::Clamp] {
        for beam in [beam(FREQUENCY, MASS), beam(1.05 * FREQUENCY, 1.3 * MASS)] {
            let quality = checked(&Spoilt {
                scales: [1.0, 1.0],
                beam,
                drive,
            });
            assert!(quality.findings.is_empty(), "{:?}", quality.findings);
        }
    }
}

// Source: the integration above.
#[test]
fn val_units_and_frequencies_of_driven_and_free_runs_that_cannot_be_meant_are_errors() {
    let response = "driven_response";
    let cases = [
        (
            "mm as m",
            Drive::Force,
            [1e3, 1.0],
            FREQUENCY,
            MASS,
            response,
        ),
        (
            "kN as N",
            Drive::Force,
            [1.0, 1e-3],
            FREQUENCY,
            MASS,
            response,
        ),
        (
            "g as kg",
            Drive::Force,
            [1.0, 1.0],
            FREQUENCY,
            1e3 * MASS,
            response,
        ),
        (
            "mm/s2 as m/s2",
            Drive::Clamp,
            [1e3, 1.0],
            FREQUENCY,
            MASS,
            response,
        ),
        (
            "rad/s as Hz",
            Drive::None,
            [1.0, 1.0],
            TAU * FREQUENCY,
            MASS,
            "natural_frequencies",
        ),
        (
            "doubled",
            Drive::None,
            [1.0, 1.0],
            2.0 * FREQUENCY,
            MASS,
            "natural_frequencies",
        ),
    ];
    for (what, drive, scales, frequency, mass, id) in cases {
        let quality = checked(&Spoilt {
            scales,
            beam: beam(frequency, mass),
            drive,
        });
        let errors: Vec<&str> = quality.errors().map(|e| e.id).collect();
        assert_eq!(errors, [id], "{what}: {:?}", quality.findings);
    }
}

// Source: the integration above; m/s2 in place of g are 9.81 times as many.
#[test]
fn val_a_response_that_is_ten_times_off_is_a_warning() {
    let quality = checked(&Spoilt {
        scales: [9.81, 1.0],
        beam: beam(FREQUENCY, MASS),
        drive: Drive::Clamp,
    });
    let [finding] = &quality.findings[..] else {
        panic!("{:?}", quality.findings)
    };
    assert_eq!(
        (finding.id, finding.severity),
        ("driven_response", Severity::Warning)
    );
    assert_eq!(finding.runs.len(), 2);
    assert!(
        finding.remedy.contains("clamp_acceleration_scale"),
        "{finding:?}"
    );
}
