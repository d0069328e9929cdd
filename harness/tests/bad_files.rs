//! Spoilt files of every kind that a command reads: no panic, a documented exit code, one line that says why.

mod trial;

use std::io::Write as _;
use std::path::Path;

use trial::{Files, complaint, none_complains};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const NUMBERS: [&str; 9] = [
    "nan", "inf", "-1", "0", "1e308", "1e-308", "", "\"x\"", "[]",
];

/// A text cut off, emptied, shortened by a line, and with each of its numbers replaced.
fn spoilt(text: &str) -> Vec<String> {
    let mut all = vec![
        String::new(),
        "\u{feff}".to_owned() + text,
        text.replace('\n', "\r\n"),
    ];
    for part in 1..5 {
        all.push(text.chars().take(text.chars().count() * part / 5).collect());
    }
    let lines: Vec<&str> = text.lines().collect();
    for left_out in 0..lines.len().min(12) {
        let kept = lines.iter().enumerate().filter(|(i, _)| *i != left_out);
        all.push(kept.map(|(_, line)| format!("{line}\n")).collect());
    }
    let is_number = |word: &&str| word.parse::<f64>().is_ok();
    let mut words: Vec<&str> = text
        .split(|c: char| !(c.is_ascii_alphanumeric() || ".-+_".contains(c)))
        .filter(is_number)
        .collect();
    words.sort_unstable();
    words.dedup();
    for word in words.into_iter().take(8) {
        all.extend(NUMBERS.map(|number| text.replacen(word, number, 1)));
    }
    all
}

/// `count` spoilt texts of all, evenly.
fn some(all: Vec<String>, count: usize) -> impl Iterator<Item = (usize, String)> {
    let every = all.len().div_ceil(count);
    all.into_iter().step_by(every).enumerate()
}

fn words(line: &[&str]) -> Vec<String> {
    line.iter().map(|word| (*word).to_owned()).collect()
}

#[test]
fn no_spoilt_campaign_panics() {
    let files = Files::new();
    let (fmu, good) = (files.path("beam.fmu"), files.at("blind/01"));
    let read = |name: &str| std::fs::read_to_string(good.join(name)).unwrap();
    let (toml, first, second) = (read("campaign.toml"), read("run01.csv"), read("run02.csv"));
    let mut lines = Vec::new();
    let mut add = |name: &str, toml: &str, csv: &str| {
        let folder = files.at(name);
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("campaign.toml"), toml).unwrap();
        std::fs::write(folder.join("run01.csv"), csv).unwrap();
        std::fs::write(folder.join("run02.csv"), &second).unwrap();
        let run = files.path(&format!("{name}/run01.csv"));
        let folder = files.path(name);
        lines.push(words(&["compare", &folder, "--fmu", &fmu, "-o", "out"]));
        lines.push(words(&["diagnose", &folder, "--fmu", &fmu, "-o", "out"]));
        lines.push(words(&[
            "observe",
            &run,
            "--campaign",
            &folder,
            "-o",
            "out",
        ]));
    };
    let mut tomls = spoilt(&toml);
    tomls.push(toml.replace("run01.csv", ".."));
    tomls.push(toml.replace("[[run]]", "[[run]]\nrole = \"holdout\""));
    tomls.push(format!("[channels]\ndelimiter = \"\\n\"\n{toml}"));
    tomls.push(format!("[channels]\ntime_scale = 1e300\n{toml}"));
    tomls.push(format!("[channels]\ntime_scale = 1e-300\n{toml}"));
    tomls.push(format!("[channels]\ndisplacement_scale = 1e300\n{toml}"));
    for (i, text) in some(tomls, 40) {
        add(&format!("toml{i}"), &text, &first);
    }
    let column =
        |samples: usize, value: &dyn Fn(usize) -> f64, time: &dyn Fn(usize) -> f64| -> String {
            let rows = (0..samples).map(|i| format!("{},{:e}\n", time(i), value(i)));
            "time_s,tip_displacement_m\n".to_owned() + &rows.collect::<String>()
        };
    let even = |i: usize| i as f64 * 1e-4;
    let wave = |i: usize| 1e-4 * (i as f64 * 0.3).sin();
    type Course<'a> = &'a dyn Fn(usize) -> f64;
    let odd: [(Course, Course); 13] = [
        (&|_| 0.0, &even),
        (&|_| 1.0, &even),
        (&|_| 1e308, &even),
        (&|i| if i % 2 == 0 { 1e308 } else { -1e308 }, &even),
        (&|i| 1e-320 * i as f64, &even),
        (&|i| i as f64, &even),
        (&|i| if i == 100 { 1.0 } else { 0.0 }, &even),
        (&wave, &|i| (i as f64).powi(3)),
        (&wave, &|i| i as f64 * 1e300),
        (&wave, &|i| i as f64 * 1e-300),
        (&wave, &|i| 1e11 + i as f64 * 1e-3),
        (&wave, &|i| even(i) + if i > 100 { 1e9 } else { 0.0 }),
        (&wave, &|i| -1.0 / (i + 1) as f64),
    ];
    for (i, (value, time)) in odd.iter().enumerate() {
        add(&format!("odd{i}"), &toml, &column(250, value, time));
    }
    let head: Vec<&str> = first.lines().take(20).collect();
    let csvs = [spoilt(&head.join("\n")), spoilt(&first)].concat();
    for (i, text) in some(csvs, 30) {
        add(&format!("csv{i}"), &toml, &text);
    }
    let series = std::fs::read_to_string(files.at("series.csv")).unwrap();
    let long = odd.iter().map(|(value, time)| column(600, value, time));
    let all: Vec<String> = long
        .chain(some(spoilt(&series), 20).map(|(_, s)| s))
        .collect();
    for (i, text) in all.into_iter().enumerate() {
        let path = files.write(&format!("series{i}.csv"), text.as_bytes());
        let quick = ["--surrogates=19", "--max-dimension=4", "-o", "out"];
        lines.push(words(&[&["dimension", &path][..], &quick].concat()));
    }
    none_complains(lines);
}

#[test]
fn no_spoilt_folder_of_a_sweep_panics() {
    let files = Files::new();
    let fmu = files.path("beam.fmu");
    let sweep = |out: &str| {
        words(&[
            "sweep",
            "--fmu",
            &fmu,
            "--parameter=belt_velocity",
            "--from=0.05",
            "--to=0.06",
            "--points=2",
            "--start=up",
            "--settle=4",
            "--cycles=10",
            "--threads=1",
            "-o",
            out,
        ])
    };
    assert_eq!(complaint(files.at("").as_path(), &sweep("good")), None);
    let names = ["sweep.json", "sweep.csv", "section.csv", "states.csv"];
    let mut lines = Vec::new();
    for spoils in names {
        let text = std::fs::read_to_string(files.at("good").join(spoils)).unwrap();
        // Half of the points are lost, so that the others must be carried on from what is there.
        let cut = |text: &str| {
            text.lines()
                .take(2)
                .map(|l| format!("{l}\n"))
                .collect::<String>()
        };
        for (i, wrong) in some(spoilt(&text), 24) {
            let folder = files.at(&format!("{spoils}{i}"));
            std::fs::create_dir(&folder).unwrap();
            for name in names {
                let text = std::fs::read_to_string(files.at("good").join(name)).unwrap();
                let text = if name == "sweep.csv" {
                    cut(&text)
                } else {
                    text
                };
                std::fs::write(folder.join(name), text).unwrap();
            }
            std::fs::write(folder.join(spoils), wrong).unwrap();
            lines.push(sweep(folder.to_str().unwrap()));
        }
        let folder = files.at(&format!("{spoils}-folder"));
        std::fs::create_dir_all(folder.join(spoils)).unwrap();
        lines.push(sweep(folder.to_str().unwrap()));
    }
    none_complains(lines);
}

/// The demonstration's campaign with its runs cut to `samples`; `change` alters campaign.toml.
fn short_demo(folder: &Path, samples: usize, change: impl Fn(String) -> String) {
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../reference-data/demo");
    std::fs::create_dir_all(folder).unwrap();
    for run in 1..5 {
        let name = format!("run0{run}.csv");
        let csv = std::fs::read_to_string(demo.join(&name)).unwrap();
        let lines: Vec<&str> = csv.lines().take(1 + samples).collect();
        std::fs::write(folder.join(name), lines.join("\n") + "\n").unwrap();
    }
    let toml = std::fs::read_to_string(demo.join("campaign.toml")).unwrap();
    std::fs::write(folder.join("campaign.toml"), change(toml)).unwrap();
}

#[test]
fn a_diagnosis_without_enough_to_learn_from_says_so() {
    let files = Files::new();
    let fmu = files.path("beam.fmu");
    let message = |name: &str| {
        let done = std::process::Command::new(env!("CARGO_BIN_EXE_stickslip"))
            .args(["diagnose", &files.path(name), "--fmu", &fmu, "-o"])
            .arg(files.at("out"))
            .output()
            .unwrap();
        let said = String::from_utf8(done.stderr).unwrap();
        assert_eq!(done.status.code(), Some(2), "{name}: {said}");
        said
    };
    for samples in [60, 100, 200, 300, 500] {
        let name = format!("short{samples}");
        short_demo(&files.at(&name), samples, |toml| toml);
        let said = message(&name);
        assert!(said.contains("measure longer"), "{samples}: {said}");
    }
    short_demo(&files.at("held"), 6000, |toml| {
        toml.replace("[[run]]", "[[run]]\nrole = \"holdout\"")
    });
    assert!(message("held").contains("holdout"));
}

/// The FMU with another description.
fn with_description(fmu: &Path, xml: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(std::fs::File::open(fmu).unwrap()).unwrap();
    let mut out = ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for i in 0..archive.len() {
        let entry = archive.by_index_raw(i).unwrap();
        if entry.name().unwrap() != "modelDescription.xml" {
            out.raw_copy_file(entry).unwrap();
        }
    }
    out.start_file("modelDescription.xml", SimpleFileOptions::default())
        .unwrap();
    out.write_all(xml.as_bytes()).unwrap();
    out.finish().unwrap().into_inner()
}

#[test]
fn no_spoilt_fmu_panics() {
    let files = Files::new();
    let fmu = files.at("beam.fmu");
    let mut archive = zip::ZipArchive::new(std::fs::File::open(&fmu).unwrap()).unwrap();
    let mut xml = String::new();
    let mut entry = archive.by_name("modelDescription.xml").unwrap();
    std::io::Read::read_to_string(&mut entry, &mut xml).unwrap();
    let mut texts = Vec::new();
    for attribute in [
        "fmiVersion=\"",
        "guid=\"",
        "modelIdentifier=\"",
        "valueReference=\"",
        "causality=\"",
        "variability=\"",
        "start=\"",
        "min=\"",
        "max=\"",
        "unit=\"",
        "name=\"",
        "role=\"",
        "typical=\"",
        "off=\"",
        "variable=\"",
        "stepSize=\"",
        "id=\"",
    ] {
        for value in ["", "nan", "-1", "1e308", "99999999999999999999"] {
            let Some(at) = xml.find(attribute).map(|at| at + attribute.len()) else {
                continue;
            };
            let end = at + xml[at..].find('"').unwrap();
            texts.push(format!("{}{value}{}", &xml[..at], &xml[end..]));
        }
    }
    texts.push(xml.replace("start=\"", "start=\"nan"));
    texts.push(xml.replace("typical=\"", "typical=\"1e308"));
    texts.push(xml.replace("<Parameter ", "<Other "));
    texts.push(xml.replace("causality=\"output\"", "causality=\"local\""));
    texts.push(xml.replace("tip_displacement", "other"));
    texts.push(xml[..xml.len() / 2].to_owned());
    let campaign = files.path("blind/01");
    let mut lines = Vec::new();
    for (i, text) in texts.iter().enumerate() {
        let path = files.write(&format!("spoilt{i}.fmu"), &with_description(&fmu, text));
        let commands: [&[&str]; 4] = [
            &["effects", "--json"],
            &[
                "simulate",
                "--duration=1e-3",
                "--step=1e-3",
                "-o",
                "out.csv",
            ],
            &["diagnose", &campaign, "-o", "out"],
            &[
                "sweep",
                "--parameter=belt_velocity",
                "--values=0.05",
                "--settle=4",
                "--cycles=10",
                "--threads=1",
                "-o",
                "out",
            ],
        ];
        // In turn, and the first for all.
        for line in [commands[0], commands[1 + i % 3]] {
            lines.push([words(line), words(&["--fmu", &path])].concat());
        }
    }
    none_complains(lines);
}

#[test]
fn no_spoilt_effect_answer_or_value_file_panics() {
    let files = Files::new();
    let mut lines = Vec::new();
    let read = |name: &str| std::fs::read_to_string(files.at(name)).unwrap();
    for (i, text) in some(spoilt(&read("effect.toml")), 20) {
        let path = files.write(&format!("effect{i}.toml"), text.as_bytes());
        lines.push(words(&["pack", "--effect", &path, "-o", "own.fmu"]));
    }
    let fmu = files.path("beam.fmu");
    let set = "# friction\nmode_count=2\nmode[1].frequency=80\nfriction.count=3\n";
    for (i, text) in some(spoilt(set), 20) {
        let path = files.write(&format!("{i}.set"), text.as_bytes());
        let at = format!("--set=@{path}");
        lines.push(words(&[
            "simulate",
            "--duration=1e-3",
            "--step=1e-3",
            &at,
            "--fmu",
            &fmu,
            "-o",
            "out.csv",
        ]));
    }
    for (i, text) in some(spoilt(&read("beam.toml")), 20) {
        let path = files.write(&format!("beam{i}.toml"), text.as_bytes());
        let run = files.path("blind/01/run01.csv");
        lines.push(words(&[
            "observe",
            &run,
            "--beam",
            &path,
            "--belt-velocity=0.04",
            "--normal-force=36",
            "-o",
            "out",
        ]));
    }
    for (i, text) in [
        "",
        "[]",
        "{}",
        "[{}]",
        "[1]",
        "[null]",
        "[[[[",
        "[{\"campaign\": \"nowhere\"}]",
        "[{\"campaign\": 3}]",
        "[{\"campaign\": \"01\", \"effects\": 7, \"parameters\": []}]",
    ]
    .iter()
    .enumerate()
    {
        let folder = files.at(&format!("truth{i}"));
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(folder.join("truth.json"), text).unwrap();
        let folder = folder.to_str().unwrap();
        lines.push(words(&["blind-test", folder, "--fmu", &fmu, "-o", "out"]));
    }
    none_complains(lines);
}
