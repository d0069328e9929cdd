//! Sensors beside the first one: a vibrometer elsewhere on the beam and a load cell under the counterpart.
//!
//! Source of the motions: rig/, an independent simulation of the reference model, in which nothing is missing. Mode shapes at 0.7 of the
//! length as in sensor_place.rs.

mod rig;

use rig::Rig;
use rig::campaign::{POINTS, RATE, json, motions, stickslip, with_noise};
use std::fmt::Write as _;
use std::path::Path;
use stickslip::command::open_fmu;
use stickslip::diagnose::model::point::Point;
use stickslip::diagnose::model::problem::Problem;
use stickslip::diagnose::model::simulator::{Samples, Simulator, Turn};
use stickslip::measurement::Campaign;
use stickslip::provenance::Provenance;

/// Ratios of the first two modes at 0.7 of the length.
const RATIOS: [f64; 2] = [0.590_876_298_1, -0.317_051_798_8];
/// Factors by which the calibrations of vibrometer and load cell are off, and standard deviations of noise: m, m/s, N.
const FACTORS: [f64; 2] = [1.008, 0.985];
const NOISES: [f64; 3] = [3e-7, 1e-4, 0.1];
/// Zero of the load cell in N.
const ZERO: f64 = 0.4;
/// The two, as campaign.toml states them.
const SENSORS: &str = "[[further_sensor]]\nquantity = \"velocity\"\ncolumn = \"v\"\nposition = 0.7\n\
                       [[further_sensor]]\nquantity = \"friction_force\"\ncolumn = \"F [N]\"\nname = \"load cell\"\noffset_std = 1.0\n";

/// What the vibrometer reads of a record, without noise.
fn velocity(record: &rig::Record) -> Vec<f64> {
    let tips = Rig::default_case().tip_values;
    let at = |k: usize| -> f64 {
        let modes = RATIOS.iter().zip(&tips).zip(&record.q_dot);
        modes.map(|((ratio, tip), v)| ratio * tip * v[k]).sum()
    };
    (0..record.velocity.len()).map(at).collect()
}

/// What a sensor of displacement, the vibrometer and the load cell read of a motion, without noise, factor and zero.
type Readings = [Vec<f64>; 3];

/// A campaign with these lines of campaign.toml; the load cell reads `force` times the friction force, in every second sample.
fn write(folder: &Path, duration: f64, sensors: &str, force: f64) {
    let read = |record: &rig::Record| -> Readings {
        let force = record.force.clone();
        [record.displacement.clone(), velocity(record), force]
    };
    let runs: Vec<Readings> = motions(duration).iter().map(read).collect();
    write_readings(folder, sensors, force, &runs);
}

/// Readings of vibrometer and load cell that are late by so many tenths of a sample.
fn late_readings(duration: f64, late: [isize; 2]) -> Vec<Readings> {
    let (tenths, before) = (10, 100);
    let at = |(belt_velocity, normal_force): (f64, f64)| -> Readings {
        let rig = Rig {
            belt_velocity,
            normal_force,
            ..Rig::default_case()
        };
        let record = rig.run(0.5, duration + 0.02, RATE * tenths as f64);
        let samples = (duration * RATE) as usize;
        let late_by = |values: &[f64], by: isize| -> Vec<f64> {
            let places = (0..samples).map(|k| before + tenths * k);
            let earlier = |place: usize| place.checked_add_signed(-by).unwrap();
            places.map(|place| values[earlier(place)]).collect()
        };
        [
            late_by(&record.displacement, 0),
            late_by(&velocity(&record), late[0]),
            late_by(&record.force, late[1]),
        ]
    };
    POINTS.map(at).into()
}

/// Writes a campaign of these readings in each run.
fn write_readings(folder: &Path, sensors: &str, force: f64, runs: &[Readings]) {
    let mut toml = format!(
        "[beam]\nnatural_frequencies_hz = [80.0, 510.0]\ndamping_ratios = [0.00015, 0.00085]\nmass_kg = 0.427\n{sensors}\
         [channels]\ndisplacement_column = \"w\"\n"
    );
    for (i, ([w, v, f], (belt, load))) in runs.iter().zip(POINTS).enumerate() {
        let seed = 10 * i as u64;
        let scaled = |values: &[f64], by: f64| values.iter().map(|v| by * v).collect::<Vec<_>>();
        let w = with_noise(w, 0.0, NOISES[0], seed + 1);
        let v = scaled(v, FACTORS[0]);
        let v = with_noise(&v, 0.0, NOISES[1], seed + 2);
        let f = scaled(f, force * FACTORS[1]);
        let f = with_noise(&f, ZERO * force, NOISES[2] * force.abs(), seed + 3);
        let mut csv = String::from("t,w,v,F [N]\n");
        for k in 0..w.len() {
            let _ = write!(csv, "{:.4},{:.9e},{:.9e},", k as f64 / RATE, w[k], v[k]);
            let _ = match k % 2 {
                1 => writeln!(csv),
                _ => writeln!(csv, "{:.6e}", f[k]),
            };
        }
        std::fs::write(folder.join(format!("run{i}.csv")), csv).unwrap();
        let _ = write!(
            toml,
            "[[run]]\nfile = \"run{i}.csv\"\nbelt_velocity_m_per_s = {belt:?}\nnormal_force_n = {load:?}\n"
        );
    }
    std::fs::write(folder.join("campaign.toml"), toml).unwrap();
}

#[test]
fn val_all_sensors_enter_one_likelihood_and_show_how_far_off_they_are() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.3, SENSORS, 1.0);
    let found = json(&stickslip(
        &["diagnose", ".", "--json", "-o", "all"],
        folder.path(),
    ));
    assert_eq!(found["verdict"], "no_missing_effect", "{found:#}");
    let ladder = found["error_ladder"].as_array().unwrap();
    let sensors = found["further_sensors"].as_array().unwrap();
    assert_eq!(sensors.len(), 2);
    assert_eq!(sensors[1]["name"], "load cell");
    for (i, sensor) in sensors.iter().enumerate() {
        let left = ladder[1]["further_over_noise"][i].as_f64().unwrap();
        assert!(
            (0.8..1.2).contains(&left),
            "{left} times the noise of {sensor:#}"
        );
        let noise = sensor["noise_std"].as_f64().unwrap();
        assert!((noise / NOISES[1 + i] - 1.0).abs() < 0.2, "{sensor:#}");
    }
    let within = |estimate: &serde_json::Value, truth: f64, largest: f64| {
        let number = |key: &str| estimate[key].as_f64().unwrap();
        let (value, std) = (number("value"), number("std"));
        assert!(std < largest, "{std} of {estimate:#}");
        assert!((value - truth).abs() < 4.0 * std, "{truth}: {estimate:#}");
    };
    // The vibrometer is known by its place times its factor, far better than each.
    let product = sensors[0]["gain"]["value"].as_f64().unwrap()
        * sensors[0]["mode_ratios"][0]["value"].as_f64().unwrap();
    assert!(
        (product / (FACTORS[0] * RATIOS[0]) - 1.0).abs() < 1e-3,
        "{product}"
    );
    within(&sensors[1]["gain"], FACTORS[1], 0.011);
    // A displacement alone leaves the mass as it was believed, to 4 %: the load cell tells it to the 1 % of its own factor.
    within(&found["calibrated"]["mode[1].mass"], 0.427, 0.012 * 0.427);
    let report = std::fs::read_to_string(folder.path().join("all/report.html")).unwrap();
    assert!(report.contains("What the further sensor 'load cell' measured"));
}

// Source: the same motion, sampled later by the sensors' own clocks.
#[test]
fn val_clocks_that_are_late_by_parts_of_a_sample_are_found_and_nothing_else_is() {
    let folder = tempfile::tempdir().unwrap();
    let late = [6, -13];
    write_readings(folder.path(), SENSORS, 1.0, &late_readings(0.3, late));
    let found = json(&stickslip(
        &["diagnose", ".", "--json", "-o", "all"],
        folder.path(),
    ));
    assert_eq!(found["verdict"], "no_missing_effect", "{found:#}");
    let sensors = found["further_sensors"].as_array().unwrap();
    for (i, (sensor, tenths)) in sensors.iter().zip(late).enumerate() {
        let left = found["error_ladder"][1]["further_over_noise"][i].as_f64();
        assert!(
            left.is_some_and(|left| (0.8..1.2).contains(&left)),
            "{found:#}"
        );
        let number = |key: &str| sensor["delay"][key].as_f64().unwrap();
        let (value, std, truth) = (number("value"), number("std"), tenths as f64 * 1e-5);
        assert!(
            std < 2e-6 && (value - truth).abs() < 4.0 * std,
            "{sensor:#}"
        );
    }
}

#[test]
fn a_clock_that_is_known_exactly_has_no_delay() {
    let folder = tempfile::tempdir().unwrap();
    let sensors = SENSORS.replace("position = 0.7", "position = 0.7\ndelay_std_s = 0.0");
    write(folder.path(), 0.1, &sensors, 1.0);
    let fmu = open_fmu(None).unwrap();
    let campaign = Campaign::load(folder.path()).unwrap();
    let problem = Problem::new(&fmu, &campaign).unwrap();
    let h = problem.hypothesis(&[]).unwrap();
    assert_eq!(h.shared_index("further_sensor.v.delay"), None);
    let cell = h.shared_index("further_sensor.load cell.delay").unwrap();
    // Without a statement: an interval of the samples, and three of these at most.
    assert!((h.shared[cell].prior_std - 1.0 / RATE).abs() < 1e-12);
    assert!((h.shared[cell].max - 3.0 / RATE).abs() < 1e-12);
    // What may lie beyond an end of a segment does not count: none of the vibrometer's, three at each end of the load cell's.
    let [v, cell] = &problem.segments[0].further[..] else {
        panic!("two sensors");
    };
    assert!(v.trusted.iter().all(|&t| t));
    let last = cell.trusted.len() - 1;
    assert!((0..3).all(|k| !cell.trusted[k] && !cell.trusted[last - k]));
    assert!(cell.trusted[3..last - 3].iter().any(|&t| t));
}

#[test]
fn the_shortest_interval_of_all_runs_bounds_a_delay_and_what_leaves_no_reading_is_said() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.1, SENSORS, 1.0);
    let file = folder.path().join("run1.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let mut lines = text.lines();
    let mut halved = vec![lines.next().unwrap()];
    halved.extend(lines.step_by(2));
    std::fs::write(&file, halved.join("\n")).unwrap();
    let fmu = open_fmu(None).unwrap();
    let problem = Problem::new(&fmu, &Campaign::load(folder.path()).unwrap()).unwrap();
    assert!((problem.delays[0].most - 3.0 / RATE).abs() < 1e-12);
    let left_out = |run: usize| {
        let mut segments = problem.segments.iter();
        segments.find(|s| s.run == run).unwrap().further[0].most_delay
    };
    // 0.3 ms are three samples of 0.1 ms and, rounded up, two of 0.2 ms.
    assert_eq!((left_out(0), left_out(1)), (3, 2));
    assert!(problem.remarks.iter().all(|r| !r.contains("No reading")));
    // Of a clock that is hardly known, 20 samples at each end of every segment.
    let unknown = SENSORS.replace("position = 0.7", "position = 0.7\ndelay_std_s = 0.05");
    write(folder.path(), 0.1, &unknown, 1.0);
    let problem = Problem::new(&fmu, &Campaign::load(folder.path()).unwrap()).unwrap();
    assert_eq!(problem.segments[0].further[0].most_delay, 20);
}

#[test]
fn a_clock_that_is_off_reads_alike_at_every_second_sample() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.1, SENSORS, 1.0);
    let fmu = open_fmu(None).unwrap();
    let problem = Problem::new(&fmu, &Campaign::load(folder.path()).unwrap()).unwrap();
    let h = problem.hypothesis(&[]).unwrap();
    let mut point = Point::centre(&h, &problem.segments);
    for (name, delay) in [("v", -1.3e-4), ("load cell", 2.1e-4)] {
        let place = h.shared_index(&format!("further_sensor.{name}.delay"));
        point.shared[place.unwrap()] = delay;
    }
    let mut predictor = problem.predictor(&h).unwrap();
    let mut read = |count: usize, stride: usize| {
        let samples = Samples::of(count, stride).of_all_sensors();
        let (segment, mut out) = (&problem.segments[0], Vec::new());
        let values = point.values(0, 0);
        assert!(
            predictor
                .predict(segment, values, samples, &mut out)
                .unwrap()
        );
        out
    };
    let (all, some) = (read(60, 1), read(60, 2));
    assert_eq!((all.len(), some.len()), (180, 90));
    let largest = |values: &[f64]| values.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
    for (all, some) in all.chunks(60).zip(some.chunks(30)) {
        for (k, y) in some.iter().enumerate() {
            // Steps of the integrator end elsewhere.
            assert!((y - all[2 * k]).abs() < 1e-7 * largest(all), "{k}");
        }
    }
}

#[test]
fn val_a_comparison_shows_further_sensors_where_the_first_one_aligns_the_model() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.3, SENSORS, 1.0);
    let compared = json(&stickslip(
        &["compare", ".", "--json", "-o", "compared"],
        folder.path(),
    ));
    let number = |value: &serde_json::Value, key: &str| value[key].as_f64().unwrap();
    let runs = compared["runs"].as_array().unwrap();
    // The small motion of the last run is irregular: no start of the model leads to it.
    let met: Vec<_> = runs.iter().filter(|r| number(r, "nrmse") < 0.01).collect();
    assert_eq!(met.len(), 3);
    for run in met {
        let sensors = run["further_sensors"].as_array().unwrap();
        assert_eq!(sensors[1]["name"], "load cell");
        assert_eq!(sensors[1]["quantity"], "friction_force");
        for (sensor, factor) in sensors.iter().zip(FACTORS) {
            let off = number(sensor, "factor") / factor - 1.0;
            assert!(off.abs() < 0.005, "{sensor:#}");
            assert!(
                number(sensor, "nrmse") > number(sensor, "noise_floor"),
                "{sensor:#}"
            );
        }
        assert!(number(&sensors[0], "nrmse") < 0.02, "{:#}", sensors[0]);
        // What the model leaves of the force: zero and factor of the load cell.
        let largest = 0.66 * number(run, "normal_force_n");
        let spread = NOISES[2] / number(&sensors[1], "noise_floor");
        let most = 1.2 * (ZERO + (1.0 - FACTORS[1]) * largest) / spread;
        assert!(number(&sensors[1], "nrmse") < most, "{:#}", sensors[1]);
        // It reads every second sample, and does not count beside a transition.
        assert!(number(&sensors[1], "samples") < 0.5 * number(&sensors[0], "samples"));
    }
    let report = std::fs::read_to_string(folder.path().join("compared/report.html")).unwrap();
    assert!(report.contains("load cell: its readings"));
    let table = stickslip(&["compare", ".", "-o", "compared"], folder.path());
    let table = String::from_utf8_lossy(&table.stdout).into_owned();
    assert!(
        table.contains("load cell") && table.contains("factor"),
        "{table}"
    );
}

#[test]
fn a_sensor_that_reads_something_else_is_named_before_any_work() {
    let in_kilonewtons = 1e-3;
    for (factor, remedy) in [
        (-1.0, "turn the sign of its scale"),
        (in_kilonewtons, "correct its scale"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), 0.1, SENSORS, factor);
        let out = stickslip(&["diagnose", "."], folder.path());
        let said = String::from_utf8_lossy(&out.stderr);
        assert_eq!(out.status.code(), Some(2), "{said}");
        assert!(
            said.contains("'load cell'") && said.contains(remedy),
            "{said}"
        );
    }
    let folder = tempfile::tempdir().unwrap();
    let velocity_as_displacement = SENSORS.replace("\"velocity\"", "\"displacement\"");
    write(folder.path(), 0.1, &velocity_as_displacement, 1.0);
    let out = stickslip(&["diagnose", "."], folder.path());
    let said = String::from_utf8_lossy(&out.stderr);
    assert!(
        said.contains("state the quantity that its column holds"),
        "{said}"
    );
}

#[test]
fn a_check_sees_that_a_load_cell_reads_against_the_belt() {
    for (factor, is_turned) in [(1.0, false), (-1.0, true)] {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), 0.1, SENSORS, factor);
        let out = stickslip(&["check", "."], folder.path());
        let said = String::from_utf8_lossy(&out.stdout);
        assert_eq!(said.contains("load_cell_sign"), is_turned, "{said}");
        assert_eq!(
            said.contains("turn the sign of the scale of 'load cell'"),
            is_turned,
            "{said}"
        );
    }
}

#[test]
fn an_empty_cell_is_no_reading_and_leaves_the_others() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.1, SENSORS, 1.0);
    let campaign = Campaign::load(folder.path()).unwrap();
    let run = &campaign.runs[0];
    let cell = run.further[1].as_ref().unwrap();
    assert_eq!(run.time.len(), run.measured.len());
    assert_eq!(cell.values.len(), run.time.len());
    assert!(cell.values[2].is_finite() && cell.values[3].is_nan());
    assert_eq!(campaign.further_sensors[1].offset_std, Some(1.0));
    assert!(
        run.further[0]
            .as_ref()
            .unwrap()
            .values
            .iter()
            .all(|v| v.is_finite())
    );
}

#[test]
fn a_sensor_that_read_nothing_in_a_run_is_left_out_there() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.1, SENSORS, 1.0);
    let file = folder.path().join("run1.csv");
    let text = std::fs::read_to_string(&file).unwrap();
    let without = |line: &str| match line.starts_with('t') {
        true => line.to_owned(),
        false => line[..=line.rfind(',').unwrap()].to_owned(),
    };
    let lines: Vec<String> = text.lines().map(without).collect();
    std::fs::write(&file, lines.join("\n")).unwrap();
    let campaign = Campaign::load(folder.path()).unwrap();
    let silent: Vec<bool> = campaign
        .runs
        .iter()
        .map(|run| run.further[1].is_none())
        .collect();
    assert_eq!(silent, [false, true, false, false]);
    let fmu = open_fmu(None).unwrap();
    let problem = Problem::new(&fmu, &campaign).unwrap();
    assert!(
        problem
            .remarks
            .iter()
            .any(|r| r.contains("run1: 'load cell' read nothing")),
        "{:?}",
        problem.remarks
    );
    // All runs have the same constants, so that effects' own ones are found at the same places.
    let h = problem.hypothesis(&[]).unwrap();
    assert!(h.per_run.iter().all(|own| own.len() == h.per_run[0].len()));
    let read = |run: usize| {
        problem
            .segments
            .iter()
            .filter(|s| s.run == run)
            .map(|s| s.further.len())
            .max()
    };
    assert_eq!((read(0), read(1)), (Some(2), Some(1)));
}

#[test]
fn what_no_sensor_can_be_is_refused_with_its_line_and_what_to_do() {
    let one = |lines: &str| format!("[[further_sensor]]\n{lines}\n");
    for (sensors, said) in [
        (
            one("quantity = \"torque\"\ncolumn = \"v\""),
            "friction_force",
        ),
        (one("quantity = \"velocity\""), "missing field `column`"),
        (
            one("quantity = \"velocity\"\ncolumn = \"u\""),
            "no column 'u'",
        ),
        (
            one("quantity = \"velocity\"\ncolumn = \"F [N]\""),
            "a velocity is needed",
        ),
        (
            one("quantity = \"velocity\"\ncolumn = \"v\"\ngain_std = 2.0"),
            "at most 0.5",
        ),
        (
            one("quantity = \"velocity\"\ncolumn = \"v\"\noffset_std = 0.0"),
            "greater than zero",
        ),
        (
            one("quantity = \"velocity\"\ncolumn = \"v\"\ndelay_std_s = -1e-4"),
            "must not be negative",
        ),
        (
            one("quantity = \"velocity\"\ncolumn = \"v\"\nposition = 7"),
            "to 1",
        ),
        (
            one("quantity = \"acceleration\"\ncolumn = \"v\"\nposition = 0.7"),
            "away from the contact",
        ),
        (
            one("quantity = \"velocity\"\ncolumn = \"v\"\ncolour = 7"),
            "unknown field `colour`",
        ),
        (
            one("quantity = \"velocity\"\ncolumn = \"v\"").repeat(2),
            "another name",
        ),
        (
            one("quantity = \"displacement\"\ncolumn = \"w\""),
            "count once",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), 0.1, &sensors, 1.0);
        let error = Campaign::load(folder.path()).unwrap_err().to_string();
        assert!(error.contains(said), "{sensors}: {error}");
    }
}

// Source: differences of predictions.
#[test]
fn val_readings_of_all_sensors_have_the_derivatives_of_the_motion() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), 0.1, SENSORS, 1.0);
    let fmu = open_fmu(None).unwrap();
    let problem = Problem::new(&fmu, &Campaign::load(folder.path()).unwrap()).unwrap();
    let h = problem.hypothesis(&[]).unwrap();
    let mut predictor = problem.predictor(&h).unwrap();
    let mut point = Point::centre(&h, &problem.segments);
    let index = |name: &str| h.shared_index(name).unwrap();
    let own = |name: &str| h.per_run[0].iter().position(|p| p.name == name).unwrap();
    let turns = [
        Turn::Shared(index("further_sensor.v.gain")),
        Turn::Shared(index("friction.mu_0")),
        Turn::PerRun(own("further_sensor.load cell.offset")),
        Turn::Shared(index("further_sensor.v.mode_ratio[2]")),
        Turn::State(3),
        Turn::Shared(index("further_sensor.load cell.gain")),
        Turn::Shared(index("further_sensor.v.delay")),
        Turn::Shared(index("further_sensor.load cell.delay")),
    ];
    // Clocks that read between the samples.
    point.shared[index("further_sensor.v.delay")] = 4.3e-5;
    point.shared[index("further_sensor.load cell.delay")] = -1.6e-4;
    let segment = &problem.segments[0];
    assert_eq!((segment.run, segment.further.len()), (0, 2));
    let count = 40;
    let samples = Samples::of(count, 1).of_all_sensors();
    let (mut slopes, mut here) = (Vec::new(), Vec::new());
    let values = point.values(0, 0);
    assert!(
        predictor
            .predict(segment, values, samples, &mut here)
            .unwrap()
    );
    assert!(predictor.differentiate(segment, values, &turns, samples, &mut slopes));
    assert_eq!(here.len(), 3 * count);
    assert_eq!(slopes.len(), turns.len() * here.len());
    for (turn, slopes) in turns.iter().zip(slopes.chunks(here.len())) {
        let mut moved = point.clone();
        // Of a delay another step than the derivatives take.
        let is_delay = |c: usize| h.shared[c].name.ends_with(".delay");
        let step = match *turn {
            Turn::Shared(c) if is_delay(c) => 2e-7,
            _ => 1e-7,
        };
        match *turn {
            Turn::Shared(c) => moved.shared[c] += step,
            Turn::PerRun(c) => moved.per_run[0][c] += step,
            Turn::State(i) => moved.states[0][i] += step,
        }
        let mut there = Vec::new();
        let values = moved.values(0, 0);
        assert!(
            predictor
                .predict(segment, values, samples, &mut there)
                .unwrap()
        );
        let largest = slopes.iter().fold(0.0, |a: f64, s| a.max(s.abs()));
        assert!(largest > 0.0, "{turn:?}");
        for (k, slope) in slopes.iter().enumerate() {
            let difference = (there[k] - here[k]) / step;
            assert!(
                (slope - difference).abs() < 1e-3 * largest,
                "{turn:?} at {k}: {slope} {difference}"
            );
        }
    }
}

// Source: the same motion sampled at the times of the first sensor.
#[test]
fn val_a_load_cell_with_a_file_and_a_clock_of_its_own_reads_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (rate, delay, noise) = (25_600.0, 0.012_345, 0.05);
    let (belt, load) = POINTS[0];
    let rig = Rig {
        belt_velocity: belt,
        normal_force: load,
        ..Rig::default_case()
    };
    let (record, fast) = (rig.run(0.5, 0.2, RATE), rig.run(0.5, 0.2, rate));
    let table = |head: &str, values: &[f64], rate: f64, from: f64| {
        let mut text = format!("t,{head}\n");
        for (k, v) in values.iter().enumerate() {
            let _ = writeln!(text, "{:.9},{v:.9e}", from + k as f64 / rate);
        }
        text
    };
    let force = with_noise(&fast.force, 0.0, noise, 3);
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("run.csv", &table("w", &record.displacement, RATE, 0.0));
    write("force.csv", &table("F [N]", &force, rate, delay));
    let toml = |files: &str| {
        format!(
            "[[further_sensor]]\nquantity = \"friction_force\"\ncolumn = \"F [N]\"\ndelay_s = {delay}\n\
             [channels]\ndisplacement_column = \"w\"\n\
             [[run]]\nfile = \"run.csv\"\nbelt_velocity_m_per_s = {belt}\nnormal_force_n = {load}\n{files}\n"
        )
    };
    write("campaign.toml", &toml("further_files = [\"force.csv\"]"));
    let campaign = Campaign::load(folder.path()).unwrap();
    let run = &campaign.runs[0];
    let read = run.further[0].as_ref().unwrap();
    assert!(
        (read.noise_std / noise - 1.0).abs() < 0.2,
        "{}",
        read.noise_std
    );
    // Two samples of its own to either side of a jump are drawn over it.
    assert!(
        (read.beside_jump - (1.5 + 2.0 * RATE / rate)).abs() < 1e-6,
        "{}",
        read.beside_jump
    );
    let off = |k: &usize| !((read.values[*k] - record.force[*k]).abs() < 5.0 * noise);
    let off: Vec<usize> = (0..record.force.len()).filter(off).collect();
    let transition = |t: &f64| (t * RATE).round() as usize;
    let transitions: Vec<usize> = record
        .transitions
        .iter()
        .map(|(t, _)| transition(t))
        .collect();
    let is_beside = |k: &usize| transitions.iter().any(|t| t.abs_diff(*k) <= 2);
    let last = record.force.len() - 1;
    assert!(
        off.iter().all(|k| is_beside(k) || *k >= last),
        "{off:?} {transitions:?}"
    );
    // A file that is not named is not looked into, and its contents are part of what a result rests on.
    write("campaign.toml", &toml(""));
    let error = Campaign::load(folder.path()).unwrap_err().to_string();
    assert!(error.contains("no column 'F [N]'"), "{error}");
    let provenance = Provenance::of_campaign(&campaign, None).unwrap();
    assert!(
        provenance
            .inputs
            .iter()
            .any(|i| i.file.ends_with("force.csv"))
    );
}

/// Source: times that the test itself shifts.
#[test]
fn val_a_clock_that_is_later_than_stated_is_told_with_its_delay() {
    let fmu = open_fmu(None).unwrap();
    let told = |message: &str| -> f64 {
        let (_, number) = message.split_once("delay_s = ").expect(message);
        number.trim_end_matches('.').parse().expect(message)
    };
    // Fits look for a delay of three standard deviations themselves; where the clocks differ by a part of the period, the campaign is
    // refused.
    for (stated, std, is_told, is_refused) in [
        (0.0, 1e-4, false, false),
        (1.5e-4, 1e-4, false, false),
        (1.5e-4, 2e-5, true, false),
        (2e-3, 1e-4, true, true),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let sensors = SENSORS.replace(
            "position = 0.7\n",
            &format!("position = 0.7\ndelay_s = {stated:?}\ndelay_std_s = {std:?}\n"),
        );
        write(folder.path(), 0.3, &sensors, 1.0);
        let campaign = Campaign::load(folder.path()).unwrap();
        match Problem::new(&fmu, &campaign) {
            Ok(problem) => {
                assert!(!is_refused);
                let late = problem.remarks.iter().find(|r| r.contains("delay_s"));
                assert_eq!(late.is_some(), is_told, "{:?}", problem.remarks);
                if let Some(late) = late {
                    assert!(late.starts_with("'v'") && told(late).abs() < 5e-5, "{late}");
                }
            }
            Err(error) => {
                let message = error.to_string();
                assert!(is_refused && told(&message).abs() < 5e-5, "{message}");
            }
        }
    }
}
