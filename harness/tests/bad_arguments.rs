//! Every option of every command with values that no one means: no panic, a documented exit code, one line that says why.
//! Options are read off the command line's definition, so new ones join by themselves.

mod trial;

use std::any::TypeId;
use std::path::PathBuf;

use clap::{Arg, Command};
use stickslip::cli::{command, takes_numbers};
use trial::{Files, none_complains};

/// A good line of a command: its arguments' ids with their values.
type Base = Vec<(&'static str, String)>;

/// Good lines, short in time, for each command; an argument is spoilt in the last one that has it, or in the first.
fn bases(command: &str, files: &Files) -> Vec<Base> {
    let line = |entries: &[(&'static str, &str)]| -> Base {
        let fmu = command != "pack" && command != "observe";
        let of_fmu = fmu.then(|| ("fmu", files.path("beam.fmu")));
        let given = entries.iter().map(|(id, value)| (*id, (*value).to_owned()));
        let out = (command != "effects").then(|| ("output", "out".to_owned()));
        of_fmu.into_iter().chain(given).chain(out).collect()
    };
    let plain = || vec![vec![("output", "out".to_owned())]];
    let campaign = files.path("blind/01");
    let run = files.path("blind/01/run01.csv");
    let short = [("settle", "4"), ("cycles", "10"), ("threads", "1")];
    match command {
        "simulate" => vec![line(&[("duration", "1e-3"), ("step", "1e-3")])],
        "check" => vec![vec![("campaign", campaign)]],
        "compare" | "diagnose" => vec![line(&[("campaign", &campaign)])],
        "try" => vec![line(&[("campaign", &campaign), ("add", "third_mode")])],
        "studio" => {
            let given = [("campaign", &*campaign), ("end_after", "0"), ("port", "0")];
            vec![line(&given)]
        }
        "blind-test" => vec![line(&[("folder", &files.path("blind"))])],
        "observe" => {
            let load = [("belt_velocity", "0.04"), ("normal_force", "36")];
            let beam = ("beam", &*files.path("beam.toml"));
            let of =
                |entries: &[(&'static str, &str)]| line(&[&[("run", &*run)], entries].concat());
            vec![
                of(&[&[beam][..], &load, &[("method", "pole")]].concat()),
                of(&[("campaign", &campaign)]),
                of(&[&[beam][..], &load].concat()),
            ]
        }
        "dimension" => {
            let quick = [("surrogates", "19"), ("max_dimension", "4")];
            let path = files.path("series.csv");
            let series = [&[("series", &*path)][..], &quick].concat();
            let of_file = line(&series).into_iter().filter(|(id, _)| *id != "fmu");
            let simulated = [("samples", "600"), ("settle", "1e-2")];
            vec![of_file.collect(), line(&[&simulated[..], &quick].concat())]
        }
        "sweep" => {
            let first = [
                ("parameter", "belt_velocity"),
                ("from", "0.05"),
                ("to", "0.06"),
                ("points", "2"),
            ];
            let second = [
                ("second_parameter", "normal_force"),
                ("second_from", "50"),
                ("second_to", "60"),
                ("second_points", "2"),
            ];
            let strobe = [("section", "strobe"), ("strobe_period", "0.01")];
            let grid = [("start", "grid"), ("grid", "1x1")];
            vec![
                line(&[&first[..], &short].concat()),
                line(&[&first[..], &short, &second].concat()),
                line(&[&first[..], &short, &strobe].concat()),
                line(&[&first[..], &short, &grid].concat()),
            ]
        }
        "figures" => vec![line(&[("threads", "0")])],
        "effects" => vec![
            line(&[("id", "third_mode")]),
            line(&[("id", "third_mode"), ("output", "out")]),
        ],
        "pack" => vec![line(&[("effects", &files.path("effect.toml"))])],
        "import" => {
            let load = [("belt_velocity", "0.04"), ("normal_force", "36")];
            let given = [&[("files", &*run)][..], &load].concat();
            let given = line(&given).into_iter().filter(|(id, _)| *id != "fmu");
            vec![given.collect()]
        }
        "new" => vec![vec![
            ("output", "out".into()),
            ("template", "oscillator".into()),
        ]],
        "demo" | "system" | "cross-check" => plain(),
        other => panic!("give the command '{other}' a line here that ends within a second"),
    }
}

/// The line with the argument `id` set to `value`; what does not go with it is left out.
fn spoilt(sub: &Command, base: &Base, arg: &Arg, value: &str) -> Vec<String> {
    let conflicts = sub.get_arg_conflicts_with(arg);
    let mut line = vec![sub.get_name().to_owned()];
    let mut put = |arg: &Arg, value: &str| match arg.get_long() {
        Some(long) => line.push(format!("--{long}={value}")),
        None => line.push(value.to_owned()),
    };
    for (id, value) in base {
        let find = |a: &&Arg| a.get_id() == id;
        let of_base = sub.get_arguments().find(find);
        let of_base = of_base.unwrap_or_else(|| panic!("{} has no {id}", sub.get_name()));
        if of_base.get_id() != arg.get_id() && !conflicts.iter().any(|c| c.get_id() == id) {
            put(of_base, value);
        }
    }
    put(arg, value);
    line
}

const NUMBERS: [&str; 14] = [
    "",
    "0",
    "-1",
    "-1e-5",
    "1e308",
    "-1e308",
    "1e-320",
    "nan",
    "inf",
    "-inf",
    "1e18",
    "18446744073709551615",
    "99999999999999999999",
    "1,2,3",
];

const TEXTS: [&str; 17] = [
    "",
    " ",
    "-",
    "=",
    "@",
    "@nowhere",
    "@.",
    "a=b=c",
    "nan",
    "nan=nan",
    "belt_velocity=nan",
    "belt_velocity=1e308",
    "normal_force=-inf",
    "mode_count=1e308",
    "mode_count=-1",
    "q[1]=1e300",
    "tolerance=0",
];

/// Paths that lead to something else, or to nothing.
fn paths(files: &Files) -> Vec<String> {
    let half = |name: &str| {
        let bytes = std::fs::read(files.at(name)).unwrap();
        let cut = name.replace('/', "_");
        files.write(&format!("half_{cut}"), &bytes[..bytes.len() / 2])
    };
    let noise: Vec<u8> = (0..3000_u32)
        .map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8)
        .collect();
    let mut all = vec![
        String::new(),
        "nowhere".into(),
        "nowhere/deep/in".into(),
        "/dev/null".into(),
        ".".into(),
        files.write("empty", b""),
        files.write("noise", &noise),
        files.write("lines", b"\n\n,,,\n;\n\"\n"),
        files.path("blind/01/run01.csv"),
        files.path("blind/01/campaign.toml"),
        files.path("blind/01"),
        files.path("effect.toml"),
    ];
    let kinds = [
        "blind/01/campaign.toml",
        "blind/01/run01.csv",
        "effect.toml",
        "beam.fmu",
    ];
    all.extend(kinds.map(half));
    all
}

fn values(arg: &Arg, files: &Files) -> Vec<String> {
    let owned = |list: &[&str]| list.iter().map(|v| (*v).to_owned()).collect();
    if takes_numbers(arg) {
        owned(&NUMBERS)
    } else if arg.get_value_parser().type_id() == TypeId::of::<PathBuf>() {
        // A result may go anywhere, but where something else lies.
        if arg.get_id() == "output" {
            return vec![
                String::new(),
                files.write("taken", b"") + "/deep",
                files.path("taken"),
                ".".into(),
            ];
        }
        paths(files)
    } else {
        let mut texts: Vec<String> = owned(&TEXTS);
        texts.push("x".repeat(100_000));
        texts
    }
}

#[test]
fn no_option_of_any_command_panics() {
    let files = Files::new();
    let definition = command();
    let mut lines = Vec::new();
    for sub in definition.get_subcommands() {
        let bases = bases(sub.get_name(), &files);
        let takes_value = |arg: &&Arg| arg.get_action().takes_values();
        for arg in sub.get_arguments().filter(takes_value) {
            let has = |base: &&Base| base.iter().any(|(id, _)| arg.get_id() == id);
            let base = bases.iter().rfind(has).unwrap_or(&bases[0]);
            for value in values(arg, &files) {
                lines.push(spoilt(sub, base, arg, &value));
            }
        }
    }
    assert!(lines.len() > 500, "{}", lines.len());
    none_complains(lines);
}

#[test]
fn the_good_lines_are_good() {
    let files = Files::new();
    let definition = command();
    for sub in definition.get_subcommands() {
        // These end with the first thing that is wrong, on purpose: they would take long.
        if ["figures", "diagnose", "try", "blind-test"].contains(&sub.get_name()) {
            continue;
        }
        for base in bases(sub.get_name(), &files) {
            let (id, value) = &base[0];
            let arg = sub.get_arguments().find(|a| a.get_id() == id).unwrap();
            let line = spoilt(sub, &base, arg, value);
            let folder = tempfile::tempdir().unwrap();
            assert_eq!(trial::complaint(folder.path(), &line), None, "{line:?}");
            let said = std::fs::read_to_string(folder.path().join(".stderr")).unwrap();
            assert_eq!(said, "", "{line:?}");
        }
    }
}
