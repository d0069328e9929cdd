//! `stickslip import` on files of independent writers, and what it writes.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use stickslip::measurement::{Campaign, Measurand, Run};
use tempfile::TempDir;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/import_files")
        .join(name)
}

/// Runs `import` on files of the folder, or on paths.
fn import(words: &[&str], folder: &Path) -> Output {
    let words = words.iter().map(|word| match file(word) {
        path if path.is_file() => path.to_str().unwrap().to_owned(),
        _ => (*word).to_owned(),
    });
    Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .arg("import")
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The runs of what is imported, and what was said.
fn imported(words: &[&str]) -> (Campaign, String, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let output = import(&[words, &["-o", "new"]].concat(), folder.path());
    assert!(output.status.success(), "{words:?}: {}", said(&output));
    let campaign = Campaign::load(&folder.path().join("new")).unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    (campaign, said, folder)
}

/// What is wrong with an import, which leaves nothing behind.
fn refused(words: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let output = import(&[words, &["-o", "new"]].concat(), folder.path());
    let text = said(&output);
    assert_eq!(output.status.code(), Some(2), "{words:?}: {text}");
    let left = std::fs::read_dir(folder.path()).unwrap().count();
    assert_eq!(left, 0, "{words:?}: something was left");
    text
}

/// Columns of truth.csv: time, displacement, normal force, belt velocity.
fn truth() -> [Vec<f64>; 4] {
    let text = std::fs::read_to_string(file("truth.csv")).unwrap();
    let mut columns: [Vec<f64>; 4] = Default::default();
    for line in text.lines().skip(1) {
        for (column, field) in columns.iter_mut().zip(line.split(',')) {
            column.push(field.parse().unwrap());
        }
    }
    assert_eq!(columns[0].len(), 200);
    columns
}

fn near(found: &[f64], expected: &[f64], error: f64, what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() <= error, "{what}: {f} for {e}");
    }
}

const POINT: [&str; 4] = ["--belt-velocity", "0.06", "--normal-force", "60"];

/// Imports one file at a stated operating point.
fn run_of(words: &[&str]) -> (Run, String) {
    let (mut campaign, said, _) = imported(&[words, &POINT].concat());
    let run = campaign.runs.remove(0);
    assert_eq!((run.belt_velocity, run.normal_force), (0.06, 60.0));
    (run, said)
}

#[test]
fn val_every_format_holds_the_values_that_its_writer_was_given() {
    // Source: tests/import_files, written by scipy, h5py, pyuff, soundfile, pyarrow and nptdms; values in truth.csv.
    let [time, displacement, ..] = truth();
    // Rounding of a product, of a single, of a 24-bit sample of 1 mm, of a text with 11 digits.
    let (exact, single, pcm, eleven) = (1e-18, 1e-10, 2e-10, 1e-14);
    let cases: [(&[&str], f64); 20] = [
        (&["truth.csv"], 0.0),
        (&["matlab5.mat"], 0.0),
        (&["matlab5_compressed.mat"], 0.0),
        (&["matlab5_struct.mat"], exact),
        (&["matlab5_types.mat"], 5.1e-7),
        (&["matlab73.mat"], 0.0),
        (&["hdf5.h5"], exact),
        (&["hdf5_rate.h5"], exact),
        (&["ascii.uff"], eleven),
        (&["binary.uff"], exact),
        (
            &["pcm24.wav", "--displacement", "channel1", "--scale", "1e-3"],
            pcm,
        ),
        (&["float.wav", "--unit", "mm"], single),
        (&["snappy.parquet"], exact),
        (&["zstd.parquet"], exact),
        (&["instants.parquet"], exact),
        (&["uneven.uff"], eleven),
        (&["uneven_binary.uff"], exact),
        (&["scaled.tdms"], 2.6e-7),
        (&["waveform.tdms"], exact),
        (&["waveform.tdms", "--rate", "2000"], exact),
    ];
    for (words, error) in cases {
        let (run, said) = run_of(words);
        near(
            &run.measured,
            &displacement,
            error,
            &format!("{words:?}: {said}"),
        );
        near(&run.time, &time, 1e-15, &format!("{words:?}: {said}"));
        // One line for the file, then where the campaign is and what is missing.
        assert_eq!(said.lines().count(), 3, "{said}");
    }
}

#[test]
fn val_inputs_are_columns_in_si_units() {
    // Source: tests/import_files, as above.
    let [_, _, load, belt] = truth();
    for (name, error) in [
        ("matlab5.mat", 0.0),
        ("matlab73.mat", 0.0),
        ("truth.csv", 0.0),
    ] {
        let (campaign, said, _) = imported(&[name]);
        let inputs = &campaign.runs[0].inputs;
        let values = |series: &Option<stickslip::measurement::InputSeries>| {
            series.clone().unwrap_or_else(|| panic!("{said}")).values
        };
        near(&values(&inputs.normal_force), &load, error, &said);
        near(&values(&inputs.belt_velocity), &belt, error, &said);
    }
    let named = ["hdf5.h5", "--belt-velocity", "0", "--normal-force", "load"];
    let (campaign, said, _) = imported(&named);
    let series = campaign.runs[0].inputs.normal_force.clone().unwrap();
    near(&series.values, &load, 1e-13, &said);
    let mean = [
        "waveform.tdms",
        "--belt-velocity=-0.1",
        "--normal-force",
        "mean:load",
    ];
    let (campaign, said, _) = imported(&mean);
    let run = &campaign.runs[0];
    assert!(run.is_plain() && run.belt_velocity == -0.1, "{said}");
    assert!(
        (run.normal_force - load.iter().sum::<f64>() / 200.0).abs() < 1e-9,
        "{said}"
    );
}

#[test]
fn a_line_says_what_was_understood() {
    let line = |words: &[&str]| run_of(words).1;
    assert_eq!(
        line(&["hdf5.h5"]).lines().next().unwrap(),
        "hdf5.h5: HDF5; time 'rig/time' in ms taken to s; displacement 'rig/laser' in um taken to m; \
         belt velocity 0.06 m/s; normal force 60 N"
    );
    let text = line(&["waveform.tdms"]);
    assert!(
        text.contains("times from the file's sample rate 2000 Hz"),
        "{text}"
    );
    let text = line(&["matlab5_struct.mat"]);
    assert!(text.contains("times from 'rig/fs', 2000 Hz"), "{text}");
    let text = line(&["matlab5.mat"]);
    assert!(text.contains("'x' without a unit, taken as m"), "{text}");
}

#[test]
fn the_channels_of_a_file_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let output = import(&["--list", "waveform.tdms", "ascii.uff"], folder.path());
    assert!(output.status.success(), "{}", said(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    for part in [
        "TDMS, 3 channel(s)",
        "rig/laser        um               200       2000",
        "rig/temperature  -                  4          -  21 ... 22",
        "laser at the tip  mm",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_campaign_of_several_files_has_a_run_for_each() {
    let two = [
        "matlab5.mat",
        "hdf5.h5",
        "--belt-velocity",
        "0.06,0.1",
        "--normal-force",
        "60,mean:load",
    ];
    let (campaign, _, folder) = imported(&two);
    let found: Vec<_> = campaign
        .runs
        .iter()
        .map(|r| (r.name.as_str(), r.belt_velocity))
        .collect();
    assert_eq!(found, [("matlab5", 0.06), ("hdf5", 0.1)]);
    let toml = std::fs::read_to_string(folder.path().join("new/campaign.toml")).unwrap();
    assert!(toml.contains("# natural_frequencies_hz ="), "{toml}");
    // The same file twice has names of its own; a beam may come from another campaign.
    let beam = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo/campaign.toml");
    let words = [
        "matlab5.mat",
        "matlab5.mat",
        "--beam",
        beam.to_str().unwrap(),
        "--name",
        "a \"b\"",
    ];
    let (campaign, _, _) = imported(&[&words[..], &POINT].concat());
    assert_eq!(campaign.beam.natural_frequencies_hz, [80.0, 510.0]);
    assert_eq!(
        (campaign.name.as_str(), campaign.runs[1].name.as_str()),
        ("a \"b\"", "matlab5_2")
    );
}

#[test]
fn a_part_of_a_file_is_taken_and_missing_samples_are_gaps() {
    let (run, _) = run_of(&["matlab5.mat", "--start", "0.02", "--end", "0.06"]);
    assert_eq!((run.time[0], run.time.len()), (0.02, 81));
    let text = refused(&[&["gap.parquet"][..], &POINT].concat());
    for part in ["channel 'x'", "sample 51", "NaN", "--skip-missing"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let (run, said) = run_of(&["gap.parquet", "--skip-missing"]);
    assert_eq!((run.time.len(), run.sampling.gaps.len()), (198, 1));
    assert!(said.contains("2 of 200 samples missing"), "{said}");
}

#[test]
fn what_does_not_fit_is_refused_with_what_to_do() {
    let with = |words: &[&str]| refused(&[words, &POINT].concat());
    let cases: [(&[&str], &[&str]); 11] = [
        (
            &["hdf5.h5", "--displacement", "acceleration"],
            &[
                "'rig/acceleration'",
                "m/s^2, an acceleration",
                "--displacement",
            ],
        ),
        (
            &["acceleration.uff"],
            &["laser at the tip", "an acceleration"],
        ),
        (&["float.wav"], &["'channel1'", "full scale", "--scale"]),
        (
            &["waveform.tdms", "--displacement", "lasr"],
            &["no channel 'lasr'", "'rig/laser'"],
        ),
        (
            &["matlab5.mat", "--displacement", "F_N", "--unit", "N"],
            &["a force"],
        ),
        (
            &[
                "waveform.tdms",
                "--displacement",
                "laser",
                "--external-force",
                "temperature",
                "--unit",
                "temperature=N",
            ],
            &["'rig/temperature'", "4 samples", "has 200"],
        ),
        (
            &["matlab5.mat", "--time", "x"],
            &["does not come after", "--time"],
        ),
        (&["matlab5.mat", "--start", "5"], &["0 samples"]),
        (
            &["matlab5.mat", "--unit", "furlong"],
            &["--unit", "furlong"],
        ),
        (&["matlab5.mat", "--scale", "0"], &["--scale"]),
        (&["matlab5.mat", "--rate", "0"], &["--rate"]),
    ];
    for (words, parts) in cases {
        let text = with(words);
        for part in parts {
            assert!(text.contains(part), "{words:?}: {part}: {text}");
        }
    }
    let text = refused(&["hdf5_rate.h5"]);
    assert!(
        text.contains("--belt-velocity") && text.contains("0 without a belt"),
        "{text}"
    );
    let three = [
        "hdf5_rate.h5",
        "--belt-velocity",
        "1,2,3",
        "--normal-force",
        "1",
    ];
    assert!(
        refused(&three).contains("3 values for 1 file"),
        "{}",
        refused(&three)
    );
    assert!(
        refused(&["hdf5_rate.h5", "--belt-velocity", "0", "--normal-force=-1"])
            .contains("not be negative")
    );
}

#[test]
fn nothing_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let words = [&["matlab5.mat", "-o", "new"][..], &POINT].concat();
    assert!(import(&words, folder.path()).status.success());
    let before = std::fs::read(folder.path().join("new/matlab5.csv")).unwrap();
    let output = import(&words, folder.path());
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("new or empty"), "{}", said(&output));
    assert_eq!(
        std::fs::read(folder.path().join("new/matlab5.csv")).unwrap(),
        before
    );
    // An empty folder is taken.
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let words = [&["matlab5.mat", "-o", "empty"][..], &POINT].concat();
    assert!(import(&words, folder.path()).status.success());
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn every_file_is_what_meta_toml_says() {
    use sha2::{Digest as _, Sha256};
    let meta: toml::Table = std::fs::read_to_string(file("meta.toml"))
        .unwrap()
        .parse()
        .unwrap();
    let digests = meta["sha256"].as_table().unwrap();
    for entry in std::fs::read_dir(file("")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if ["make.py", "meta.toml"].contains(&name) {
            continue;
        }
        let digest = Sha256::digest(std::fs::read(&path).unwrap());
        let found: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
        let stated = digests.get(name).and_then(toml::Value::as_str);
        assert_eq!(stated, Some(found.as_str()), "{name}");
    }
}

#[test]
fn a_velocity_is_imported_where_it_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("t [ms];vibrometer [mm/s];belt [m/s]\n");
    for i in 0..64 {
        text += &format!("{};{};0.06\n", 0.1 * f64::from(i), 10 * ((7 * i) % 11 - 5));
    }
    std::fs::write(folder.path().join("v.csv"), text).unwrap();
    let words = [
        "v.csv",
        "--velocity",
        "vibrometer",
        "--belt-velocity",
        "mean:belt",
    ];
    let words = [&words[..], &["--normal-force", "60", "-o", "new"]].concat();
    let output = import(&words, folder.path());
    assert!(output.status.success(), "{}", said(&output));
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(
        told.contains("velocity 'vibrometer' in mm/s taken to m/s"),
        "{told}"
    );
    let campaign = Campaign::load(&folder.path().join("new")).unwrap();
    assert_eq!(campaign.measurand(), Measurand::Velocity);
    let run = &campaign.runs[0];
    assert!(
        (run.measured[1] - 0.02).abs() < 1e-15,
        "{}",
        run.measured[1]
    );
    assert!((run.belt_velocity - 0.06).abs() < 1e-15);
    let toml = std::fs::read_to_string(folder.path().join("new/campaign.toml")).unwrap();
    assert!(
        toml.contains("velocity_column = \"tip_velocity_m_per_s\""),
        "{toml}"
    );
}
