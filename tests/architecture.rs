//! Who may know whom: the inner import rules of ARCHITECTURE.md, read off the sources. The outer ones
//! (which crate may use which) are facts of the compiler, except for the two files named below.

use std::fs;
use std::path::{Path, PathBuf};
use stickslip_tests::root;

/// A source file as code alone: comments and texts blanked, so that prose may name what it likes.
struct Source {
    /// Path from the top folder, with forward slashes.
    path: String,
    code: String,
}

impl Source {
    fn words(&self) -> impl Iterator<Item = &str> {
        self.code
            .split(|c: char| !(c.is_alphanumeric() || c == '_'))
            .filter(|word| !word.is_empty())
    }

    fn has_word(&self, word: &str) -> bool {
        self.words().any(|w| w == word)
    }

    /// The names that follow `prefix` in paths, also within braces: `crate::{a, b::c}` gives a and b.
    fn names_after(&self, prefix: &str) -> Vec<String> {
        let mut names = Vec::new();
        for (at, _) in self.code.match_indices(prefix) {
            let before = self.code[..at].chars().next_back();
            if before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
                continue;
            }
            let rest = self.code[at + prefix.len()..].trim_start();
            match rest.strip_prefix('{') {
                Some(list) => names.extend(first_names(list)),
                None => names.extend(leading_name(rest)),
            }
        }
        names
    }
}

fn leading_name(text: &str) -> Option<String> {
    let text = text.trim_start();
    let end = text
        .find(|c: char| !(c.is_alphanumeric() || c == '_'))
        .unwrap_or(text.len());
    (end > 0).then(|| text[..end].to_owned())
}

/// The first name of every entry of a `{...}` list whose opening brace is already gone.
fn first_names(list: &str) -> Vec<String> {
    let mut names = Vec::new();
    let (mut depth, mut entry) = (0, 0);
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                names.extend(leading_name(&list[entry..at]));
                entry = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    names
}

/// Blanks comments, texts and characters; keeps everything else where it is.
fn code_of(text: &str) -> String {
    let bytes = text.as_bytes();
    let mut code = bytes.to_vec();
    let mut i = 0;
    let starts = |i: usize, s: &str| text.as_bytes()[i..].starts_with(s.as_bytes());
    while i < bytes.len() {
        let from = i;
        if starts(i, "//") {
            while i < bytes.len() && bytes[i] != b'\n' {
                i += 1;
            }
        } else if starts(i, "/*") {
            let mut depth = 0;
            loop {
                if starts(i, "/*") {
                    (depth, i) = (depth + 1, i + 2);
                } else if starts(i, "*/") {
                    (depth, i) = (depth - 1, i + 2);
                } else {
                    i += 1;
                }
                if depth == 0 || i >= bytes.len() {
                    break;
                }
            }
        } else if bytes[i] == b'r'
            && (i == 0 || !(bytes[i - 1].is_ascii_alphanumeric() || bytes[i - 1] == b'_'))
            && bytes[i + 1..].iter().find(|b| **b != b'#') == Some(&b'"')
        {
            let hashes = bytes[i + 1..].iter().take_while(|b| **b == b'#').count();
            let close = format!("\"{}", "#".repeat(hashes));
            i += hashes + 2;
            i = text[i..]
                .find(&close)
                .map_or(bytes.len(), |end| i + end + close.len());
        } else if bytes[i] == b'"' {
            i += 1;
            while i < bytes.len() && bytes[i] != b'"' {
                i += if bytes[i] == b'\\' { 2 } else { 1 };
            }
            i += 1;
        } else if bytes[i] == b'\'' && starts(i + 1, "\\") {
            i += 3;
            while i < bytes.len() && bytes[i] != b'\'' {
                i += 1;
            }
            i += 1;
        } else if bytes[i] == b'\'' && bytes.get(i + 2) == Some(&b'\'') {
            i += 3;
        } else {
            i += 1;
            continue;
        }
        let to = i.min(code.len());
        for byte in &mut code[from..to] {
            if *byte != b'\n' {
                *byte = b' ';
            }
        }
    }
    String::from_utf8(code).expect("only whole characters are blanked")
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap_or_else(|e| panic!("{}: {e}", folder.display()))
        .map(|entry| entry.expect("readable").path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            collect(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path);
        }
    }
}

/// The sources below a folder, at least one.
fn sources(folder: &str) -> Vec<Source> {
    let mut paths = Vec::new();
    collect(&root().join(folder), &mut paths);
    assert!(!paths.is_empty(), "no sources in {folder}");
    paths
        .into_iter()
        .map(|path| Source {
            code: code_of(&fs::read_to_string(&path).expect("readable")),
            path: path
                .strip_prefix(root())
                .expect("below the top folder")
                .to_string_lossy()
                .replace('\\', "/"),
        })
        .collect()
}

/// Fails with every breach at once.
fn none(rule: &str, breaches: Vec<String>) {
    assert!(breaches.is_empty(), "{rule}:\n  {}", breaches.join("\n  "));
}

/// Ids of the catalogue: the names of its files.
fn effects() -> Vec<String> {
    const FOLDER: &str = "fmu-src/physics/src/effects";
    sources(FOLDER)
        .iter()
        .filter_map(|s| {
            s.path
                .strip_prefix(FOLDER)?
                .strip_prefix('/')?
                .strip_suffix(".rs")
                .map(str::to_owned)
        })
        .filter(|name| !name.contains('/') && !["mod", "series"].contains(&name.as_str()))
        .collect()
}

#[test]
fn the_reader_sees_code_and_not_prose() {
    let text = "use crate::{fmu::Fmu, report}; // crate::observer\nlet s = \"crate::observer\"; let c = '\"'; \
                let r = r#\"unsafe \"x\" \"#; fn f<'a>(x: &'a str) {} /* unsafe /* nested */ */ crate::metric::nrmse();";
    let source = Source {
        path: String::new(),
        code: code_of(text),
    };
    assert_eq!(source.names_after("crate::"), ["fmu", "report", "metric"]);
    assert!(!source.has_word("unsafe"));
    assert!(source.has_word("str"));
}

#[test]
fn effects_do_not_name_each_other() {
    let ids = effects();
    assert!(ids.len() >= 16, "{ids:?}");
    let mut breaches = Vec::new();
    for source in sources("fmu-src/physics/src/effects") {
        for id in &ids {
            if !source.path.ends_with(&format!("/{id}.rs")) && source.has_word(id) {
                breaches.push(format!("{} names {id}", source.path));
            }
        }
    }
    none(
        "an effect knows effects/mod.rs and plain values only",
        breaches,
    );
}

#[test]
fn effects_know_only_their_interface_and_plain_values() {
    let allowed = ["beam", "error", "real", "unit"];
    let ids = effects();
    let mut breaches = Vec::new();
    for source in sources("fmu-src/physics/src/effects") {
        if !ids
            .iter()
            .any(|id| source.path.ends_with(&format!("/{id}.rs")))
        {
            continue;
        }
        for name in source.names_after("crate::") {
            if !allowed.contains(&name.as_str()) {
                breaches.push(format!("{} uses crate::{name}", source.path));
            }
        }
    }
    none("an effect uses beam, error, real and unit", breaches);
}

#[test]
fn no_one_names_an_effect_outside_the_catalogue() {
    let ids = effects();
    let mut breaches = Vec::new();
    for folder in [
        "fmu-src/physics/src",
        "fmu-src/fmi2/src",
        "modelDescription/src",
        "harness/src",
    ] {
        for source in sources(folder) {
            if source.path.contains("/effects/") {
                continue;
            }
            for id in &ids {
                if source.has_word(id) {
                    breaches.push(format!("{} names {id}", source.path));
                }
            }
        }
    }
    none("effects are known by their cards alone", breaches);
}

#[test]
fn the_integrators_know_only_their_own_trait() {
    let mut breaches = Vec::new();
    for source in sources("fmu-src/physics/src/integrate") {
        for name in source.names_after("crate::") {
            if name != "integrate" && name != "real" {
                breaches.push(format!("{} uses crate::{name}", source.path));
            }
        }
    }
    none(
        "integrate/ knows its traits and the number type only",
        breaches,
    );
}

#[test]
fn the_harness_knows_the_model_by_its_fmu_alone() {
    let mut breaches = Vec::new();
    for source in sources("harness/src") {
        let packs = source.path.starts_with("harness/src/command/pack")
            || source.path == "harness/src/command/repaired_model.rs";
        for name in ["beam_model_description", "beam_fmu", "stickslip_tests"] {
            if source.has_word(name) && !packs {
                breaches.push(format!("{} names {name}", source.path));
            }
        }
        if source.has_word("beam_physics") {
            let sweeps = source.path.starts_with("harness/src/command/sweep");
            let only_sweep = source
                .names_after("beam_physics::")
                .iter()
                .all(|name| name == "sweep");
            if !(sweeps && only_sweep) {
                breaches.push(format!("{} names beam_physics", source.path));
            }
        }
    }
    none(
        "only command/pack and command/repaired_model know what is packed",
        breaches,
    );
}

#[test]
fn imports_within_the_harness_go_one_way() {
    let lowest = ["measurement", "fmu"];
    let middle = [
        "smoothing",
        "observer",
        "dimension",
        "diagnose",
        "check",
        "metric",
        "report",
    ];
    let mut breaches = Vec::new();
    let mut check = |room: &str, forbidden: &[&str]| {
        if !root().join("harness/src").join(room).is_dir() {
            return;
        }
        for source in sources(&format!("harness/src/{room}")) {
            for name in source.names_after("crate::") {
                if forbidden.contains(&name.as_str()) {
                    breaches.push(format!("{} uses crate::{name}", source.path));
                }
            }
        }
    };
    let above_lowest: Vec<&str> = middle.iter().copied().chain(["command", "cli"]).collect();
    for room in lowest {
        check(room, &above_lowest);
    }
    for room in middle {
        check(room, &["command", "cli"]);
    }
    // Numbers about motions, and pictures, stand alone.
    check(
        "metric",
        &["observer", "dimension", "diagnose", "report", "fmu"],
    );
    check(
        "report",
        &["observer", "dimension", "diagnose", "fmu", "measurement"],
    );
    check("observer", &["smoothing", "diagnose", "report", "fmu"]);
    check(
        "smoothing",
        &["dimension", "diagnose", "check", "report", "fmu"],
    );
    check(
        "check",
        &["observer", "dimension", "diagnose", "report", "fmu"],
    );
    check(
        "dimension",
        &[
            "observer",
            "diagnose",
            "metric",
            "report",
            "fmu",
            "measurement",
        ],
    );
    none(
        "command -> {diagnose, smoothing, observer, dimension, check, metric, report} -> {measurement, fmu}",
        breaches,
    );
}

/// The rooms of the diagnosis, each with those that it may import from besides itself.
const DIAGNOSE: [(&str, &[&str]); 8] = [
    ("data", &[]),
    ("model", &["data"]),
    ("estimation", &["data", "model"]),
    ("initialisation", &["data", "model", "estimation"]),
    ("validation", &["data", "model", "estimation"]),
    (
        "explanation",
        &[
            "data",
            "model",
            "estimation",
            "initialisation",
            "validation",
        ],
    ),
    (
        "selection",
        &[
            "data",
            "model",
            "estimation",
            "initialisation",
            "validation",
        ],
    ),
    (
        "result",
        &[
            "data",
            "model",
            "estimation",
            "validation",
            "explanation",
            "selection",
        ],
    ),
];

#[test]
fn the_rooms_of_the_diagnosis_import_one_way() {
    let mut breaches = Vec::new();
    for (room, below) in DIAGNOSE {
        for source in sources(&format!("harness/src/diagnose/{room}")) {
            for name in source.names_after("crate::diagnose::") {
                let known = DIAGNOSE.iter().any(|(other, _)| *other == name);
                if known && name != room && !below.contains(&name.as_str()) {
                    breaches.push(format!("{} uses diagnose::{name}", source.path));
                }
            }
        }
    }
    none(
        "data <- model <- estimation <- {initialisation, validation} <- {explanation, selection} <- result",
        breaches,
    );
    let rooms = fs::read_dir(root().join("harness/src/diagnose")).expect("a folder");
    let folders = rooms.filter(|entry| entry.as_ref().expect("readable").path().is_dir());
    assert_eq!(folders.count(), DIAGNOSE.len(), "a room without a rule");
}

/// A room of the diagnosis and one of its files.
type RoomAndFile = (String, String);

#[test]
fn files_of_the_diagnosis_do_not_import_each_other_in_circles() {
    let stem = |path: &str| {
        let inside = path.trim_start_matches("harness/src/diagnose/");
        let mut parts = inside.trim_end_matches(".rs").split('/');
        let room = parts.next().unwrap_or_default().to_owned();
        (room, parts.next().unwrap_or("mod").to_owned())
    };
    // A folder within a room counts as one file.
    let mut imports: Vec<(RoomAndFile, Vec<RoomAndFile>)> = Vec::new();
    for source in sources("harness/src/diagnose") {
        let file = stem(&source.path);
        let mut uses = Vec::new();
        for (room, _) in DIAGNOSE {
            let names = source.names_after(&format!("crate::diagnose::{room}::"));
            uses.extend(names.into_iter().map(|name| (room.to_owned(), name)));
        }
        uses.retain(|used| *used != file);
        match imports.iter_mut().find(|(known, _)| *known == file) {
            Some((_, known)) => known.extend(uses),
            None => imports.push((file, uses)),
        }
    }
    assert!(imports.len() > 40, "{} files were read", imports.len());
    // Files that import none of those left are taken away, until only circles and what leads to them are left.
    loop {
        let left: Vec<RoomAndFile> = imports.iter().map(|(file, _)| file.clone()).collect();
        imports.retain(|(_, uses)| uses.iter().any(|used| left.contains(used)));
        if imports.len() == left.len() {
            break;
        }
    }
    none(
        "no circle of imports within the diagnosis",
        imports
            .into_iter()
            .map(|((room, file), _)| format!("{room}/{file}"))
            .collect(),
    );
}

#[test]
fn unsafe_code_lives_at_the_c_interface_only() {
    let mut breaches = Vec::new();
    for folder in ["fmu-src/physics", "modelDescription", "harness"] {
        for source in sources(folder) {
            if source.has_word("unsafe") && !source.path.starts_with("harness/src/fmu/") {
                breaches.push(source.path);
            }
        }
    }
    none(
        "`unsafe` belongs to fmu-src/fmi2 and harness/src/fmu",
        breaches,
    );
    for lib in ["fmu-src/physics/src/lib.rs", "modelDescription/src/lib.rs"] {
        let code = code_of(&fs::read_to_string(root().join(lib)).expect("readable"));
        assert!(code.contains("#![forbid(unsafe_code)]"), "{lib}");
    }
}
