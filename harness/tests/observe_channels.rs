//! `stickslip observe` of velocities, of accelerations and of a belt whose speed varies.

mod rig;

use rig::campaign::{POINTS, json, motions, stickslip, with_noise, write};
use std::path::Path;

/// Column of force.csv by its name; NaN where a cell is empty.
fn column(folder: &Path, name: &str) -> Vec<f64> {
    let csv = std::fs::read_to_string(folder.join("observer/force.csv")).unwrap();
    let names = csv.lines().next().unwrap().split(',');
    let at = names.clone().position(|n| n == name).unwrap();
    let cells = csv.lines().skip(1).map(|row| row.split(',').nth(at));
    cells
        .map(|cell| cell.unwrap().parse().unwrap_or(f64::NAN))
        .collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Median coefficient in slip of a motion of the rig under a normal force in N.
fn slip_coefficient(record: &rig::Record, load: f64) -> f64 {
    let samples = record.force.iter().zip(&record.mode);
    let slip = samples.filter(|(_, mode)| **mode != 0);
    median(slip.map(|(force, _)| force.abs() / load).collect())
}

// Source: independent simulation (rig/); noise as a vibrometer and an accelerometer have it. Of the four motions the last one slips
// 800 times in a second, so that a random walk does not describe its force.
#[test]
fn val_the_force_follows_from_a_velocity_or_an_acceleration_and_a_coefficient() {
    let runs = motions(0.8);
    let velocity: fn(&rig::Record) -> &Vec<f64> = |run| &run.velocity;
    let acceleration: fn(&rig::Record) -> &Vec<f64> = |run| &run.acceleration;
    for (key, signal, noise, bounds) in [
        ("velocity_column", velocity, 1e-4, [0.1, 0.25]),
        ("acceleration_column", acceleration, 0.1, [0.1, 0.2]),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let noisy = rig::campaign::disturbed(&runs, signal, 0.0, noise);
        write(folder.path(), key, "signal", &noisy);
        for (i, (run, (belt, load))) in runs.iter().zip(POINTS).enumerate() {
            let mu = slip_coefficient(run, load).to_string();
            let file = format!("run{i}.csv");
            let words = [
                "observe",
                &file,
                "--campaign",
                ".",
                "--json",
                "--friction-coefficient",
                &mu,
            ];
            let found = json(&stickslip(&words, folder.path()));
            let force = column(folder.path(), "force_n");
            let error = rig::error(&force, &run.force);
            println!("{key} {belt} m/s: force error {error:.3}");
            assert!(error < bounds[i / 3], "{key} {belt} m/s: {error}");
            let is_velocity = key == "velocity_column";
            let unit = if is_velocity {
                "noise_std_m_per_s"
            } else {
                "noise_std_m_per_s2"
            };
            let std = found[unit].as_f64().unwrap();
            // Jumps every few samples add to the noise of an acceleration.
            assert!(i == 3 || (std / noise - 1.0).abs() < 0.3, "{std}");
            assert!(found.get("noise_std_m").is_none());
            let remarks = found["remarks"].to_string();
            assert!(remarks.contains("does not show the level"), "{remarks}");
            if is_velocity {
                let belt_found = found["belt_velocity_in_stick"]["value_m_per_s"].as_f64();
                assert!((belt_found.unwrap() / belt - 1.0).abs() < 1e-4);
                let deviations = column(folder.path(), "force_std_n");
                let off = force.iter().zip(&run.force).zip(deviations);
                // Of a normal variable it would be 0.67.
                let typical = median(off.map(|((f, t), std)| ((f - t) / std).abs()).collect());
                assert!((0.1..1.2).contains(&typical), "{typical}");
            }
        }
        let page = std::fs::read_to_string(folder.path().join("observer/observer.html")).unwrap();
        let quantity = key.trim_end_matches("_column");
        assert!(page.contains(&format!("from the measured {quantity}")));
        assert!(page.contains(&format!("tip {quantity}")));
        assert!(!page.contains("The paper's observer beside it"));
    }
}

#[test]
fn what_a_channel_leaves_open_is_asked_for_and_nothing_else() {
    let runs = motions(0.2);
    let of = |key: &str, values: &[f64], words: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), key, "signal", &[values.to_vec()]);
        let all = [&["observe", "run0.csv", "--campaign", "."][..], words].concat();
        let output = stickslip(&all, folder.path());
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{words:?}: {said}");
        assert!(!folder.path().join("observer/force.csv").exists());
        said
    };
    let velocity = with_noise(&runs[0].velocity, 0.0, 1e-4, 1);
    let displacement = with_noise(&runs[0].displacement, 0.0, 1e-6, 1);
    for (key, values, words, parts) in [
        (
            "velocity_column",
            &velocity,
            &[][..],
            [
                "run 'run0' holds a tip velocity in m/s",
                "--friction-coefficient 0.3",
            ],
        ),
        (
            "velocity_column",
            &velocity,
            &["--friction-coefficient", "-0.2"],
            ["-0.2", "must be 0 or more"],
        ),
        (
            "velocity_column",
            &velocity,
            &["--friction-coefficient", "0.3", "--method", "pole"],
            ["pole", "stick-slip or kalman"],
        ),
        (
            "displacement_column",
            &displacement,
            &["--friction-coefficient", "0.3"],
            ["run 'run0' shows the level", "leave the option out"],
        ),
    ] {
        let said = of(key, values, words);
        for part in parts {
            assert!(said.contains(part), "'{part}' is not in: {said}");
        }
    }
}
