//! Independent truth: reference-data/computed/limit_cycles, by the Python generator make_limit_cycles.py, which shares no
//! code with the project. The FMU runs from the same stick start and is compared sample by sample, contact mode
//! included; what its cycles look like is kept as a snapshot.

use std::path::Path;
use stickslip::command::pack;
use stickslip::fmu::Fmu;
use stickslip_tests::root;

/// Natural frequencies in Hz, tip values and mass of the default model.
const FREQUENCIES: [f64; 2] = [80.0, 510.0];
const TIP_VALUES: [f64; 2] = [2.0, -2.0];
const MASS: f64 = 0.427;
/// Static friction in units of the normal force, and the share of it that bends the beam at the start.
const MU_0: f64 = 0.66;
const SHARE: f64 = 0.95;
/// Samples this near a transition of the reference, in samples, may lie on its other side.
const NEAR: usize = 1;

struct Sample {
    time: f64,
    values: [f64; 3],
    mode: f64,
}

fn reference(file: &Path) -> Vec<Sample> {
    std::fs::read_to_string(file)
        .unwrap()
        .lines()
        .skip(1)
        .map(|line| {
            let row: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            Sample {
                time: row[0],
                values: [row[1], row[2], row[3]],
                mode: row[4],
            }
        })
        .collect()
}

/// The FMU's samples at the reference's times.
fn motion(fmu: &Fmu, force: f64, velocity: f64, times: &[f64]) -> Vec<Sample> {
    let mut instance = fmu.instantiate("limit cycle").unwrap();
    let inputs = [
        "belt_velocity",
        "normal_force",
        "q[1]",
        "q_dot[1]",
        "q[2]",
        "q_dot[2]",
    ];
    let names = fmu.real_references(&inputs).unwrap();
    let bend = SHARE * MU_0 * force;
    let static_deflection = |j: usize| {
        let omega = std::f64::consts::TAU * FREQUENCIES[j];
        TIP_VALUES[j] * bend / (MASS * omega * omega)
    };
    let start = [
        velocity,
        force,
        static_deflection(0),
        velocity / 2.0,
        static_deflection(1),
        0.0,
    ];
    instance.set_real(&names, &start).unwrap();
    instance.initialize(0.0, None, None).unwrap();
    let outputs = fmu
        .real_references(&[
            "tip_displacement",
            "tip_velocity",
            "friction_force",
            "relative_velocity",
        ])
        .unwrap();
    let mode = fmu.variable("contact_mode").unwrap().reference;
    let mut now = 0.0;
    times
        .iter()
        .map(|&time| {
            instance.do_step(now, time - now).unwrap();
            now = time;
            let mut values = [0.0; 4];
            instance.get_real(&outputs, &mut values).unwrap();
            let mut contact = [0];
            instance.get_integer(&[mode], &mut contact).unwrap();
            Sample {
                time,
                values: [values[0], values[1], values[2]],
                mode: if contact[0] == 0 {
                    0.0
                } else {
                    values[3].signum()
                },
            }
        })
        .collect()
}

/// Number of transitions, share of stick, and range of the displacement in micrometres.
fn shape(samples: &[Sample]) -> String {
    let changes = samples
        .windows(2)
        .filter(|w| w[0].mode != w[1].mode)
        .count();
    let stick = samples.iter().filter(|s| s.mode == 0.0).count() as f64 / samples.len() as f64;
    let low = samples
        .iter()
        .map(|s| s.values[0])
        .fold(f64::INFINITY, f64::min);
    let high = samples
        .iter()
        .map(|s| s.values[0])
        .fold(f64::NEG_INFINITY, f64::max);
    format!(
        "{changes} transitions, {:.2} in stick, {:.2} to {:.2} um",
        stick,
        1e6 * low,
        1e6 * high
    )
}

#[test]
fn val_limit_cycles_agree_with_the_independent_integration_in_motion_force_and_contact_mode() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(pack::FILE_NAME);
    pack::pack(&path).unwrap();
    let fmu = Fmu::load(&path).unwrap();
    let mut shapes = Vec::new();
    for (name, force, velocity) in [
        ("36N_40mm_per_s", 36.0, 0.04),
        ("41N_210mm_per_s", 41.0, 0.21),
        ("60N_60mm_per_s", 60.0, 0.06),
        ("100N_100mm_per_s", 100.0, 0.1),
    ] {
        let file = root().join(format!("reference-data/computed/limit_cycles/{name}.csv"));
        let expected = reference(&file);
        let times: Vec<f64> = expected.iter().map(|s| s.time).collect();
        let found = motion(&fmu, force, velocity, &times);
        // As far as the reference is good (its meta.toml), away from transitions.
        let bounds = [1e-8, 1e-6, 1e-4];
        for (k, (mine, theirs)) in found.iter().zip(&expected).enumerate() {
            let around = &expected[k.saturating_sub(NEAR)..(k + NEAR + 1).min(expected.len())];
            if around.iter().any(|s| s.mode != theirs.mode) {
                continue;
            }
            assert_eq!(
                mine.mode, theirs.mode,
                "{name}: contact mode at {} s",
                theirs.time
            );
            for (i, bound) in bounds.into_iter().enumerate() {
                let difference = (mine.values[i] - theirs.values[i]).abs();
                assert!(
                    difference <= bound,
                    "{name}: value {i} at {} s is {} off, more than {bound}",
                    theirs.time,
                    difference
                );
            }
        }
        shapes.push(format!("{name}: {}", shape(&found)));
    }
    insta::assert_snapshot!("limit_cycles", shapes.join("\n"));
}
