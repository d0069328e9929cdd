//! The outputs of commands shown in README.md and in docs/ are what the commands print, figures included.
//! `UPDATE_README=1 cargo test --release -p stickslip --test readme_outputs` rewrites them.
//!
//! An output stands between two marks, `<!-- output of: COMMAND -->` and `<!-- end of output -->`, as an indented block, and
//! nothing else does. Prose longer than `WIDTH` is wrapped; rows of tables are not.

#[path = "../../tests/src/pages.rs"]
mod pages;

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

const BEGIN: &str = "<!-- output of: ";
const END: &str = "<!-- end of output -->";
/// Characters in a line of prose in an output: 100 with the indentation.
const WIDTH: usize = 96;
/// The page with the user-defined effect that commands use.
const OWN_EFFECT: &str = "docs/own-effects.md";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// One output that a page shows.
struct Shown {
    command: String,
    /// Its block in the text of the page.
    block: std::ops::Range<usize>,
}

fn outputs(page: &str) -> Vec<Shown> {
    page.match_indices(BEGIN)
        .map(|(at, _)| {
            let command = at + BEGIN.len();
            let closes = command + page[command..].find(" -->").expect("a mark is closed");
            let begin = closes + " -->\n".len();
            let end = begin + page[begin..].find(END).expect("an output has an end");
            Shown {
                command: page[command..closes].to_owned(),
                block: begin..end,
            }
        })
        .collect()
}

/// A page of the documentation and its text.
struct Page {
    path: PathBuf,
    text: String,
}

/// The pages that show an output. Each is locked while it is read, against other tests that write it, in this process
/// or another.
fn pages_with_outputs() -> Vec<Page> {
    let mut found = Vec::new();
    for path in pages::pages(&root()) {
        let lock = File::open(&path).unwrap();
        lock.lock().unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        if !outputs(&text).is_empty() {
            found.push(Page { path, text });
        }
    }
    found
}

/// A folder as a user has it: with the demonstration and the user-defined effect of the documentation.
fn workplace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let demo = folder.path().join("reference-data/demo");
    std::fs::create_dir_all(&demo).unwrap();
    for entry in std::fs::read_dir(root().join("reference-data/demo")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, demo.join(path.file_name().unwrap())).unwrap();
    }
    let page = std::fs::read_to_string(root().join(OWN_EFFECT)).unwrap();
    let effect = pages::toml_example(&page);
    std::fs::write(folder.path().join("belt_ribs.toml"), effect).unwrap();
    folder
}

/// Runs commands joined by `&&` and returns what they printed.
fn printed(commands: &str, folder: &Path) -> String {
    commands
        .split(" && ")
        .map(|c| printed_by(c, folder))
        .collect()
}

fn printed_by(command: &str, folder: &Path) -> String {
    let mut words = command.split_whitespace();
    assert_eq!(words.next(), Some("stickslip"), "{command}");
    let output = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args(words)
        .current_dir(folder)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command}: {message}");
    String::from_utf8(output.stdout).unwrap()
}

/// What a library needs of the system depends on the builder, so no page shows it.
const OF_THE_MACHINE: &str = "needs glibc";

/// A text as an indented block.
fn block(text: &str) -> String {
    let lines = text.trim_matches('\n').lines();
    let lines = lines
        .filter(|l| !l.contains(OF_THE_MACHINE))
        .flat_map(wrapped);
    let indented = lines.map(|line| format!("    {line}").trim_end().to_owned() + "\n");
    format!("\n{}\n", indented.collect::<String>())
}

/// A line in pieces of `WIDTH` characters at most where it has spaces; a row of a table, which aligns its columns with
/// three spaces or more, as it is.
fn wrapped(line: &str) -> Vec<String> {
    if line.trim().contains("   ") {
        return vec![line.to_owned()];
    }
    let indent = &line[..line.len() - line.trim_start().len()];
    let mut out = vec![String::new()];
    for word in line.split_inclusive(' ') {
        let last = out.last_mut().expect("there is one");
        let length = last.chars().count() + word.trim_end().chars().count();
        if length > WIDTH && !last.trim().is_empty() {
            out.push(format!("{indent}{word}"));
        } else {
            last.push_str(word);
        }
    }
    out.into_iter().map(|l| l.trim_end().to_owned()).collect()
}

#[test]
fn outputs_in_the_documentation_are_what_the_commands_print() {
    let folder = workplace();
    let (mut differing, mut count) = (Vec::new(), 0);
    for Page { path, text } in pages_with_outputs() {
        let shown = outputs(&text);
        count += shown.len();
        let real: Vec<String> = shown
            .iter()
            .map(|s| block(&printed(&s.command, folder.path())))
            .collect();
        if std::env::var_os("UPDATE_README").is_some() {
            update(&path, &shown, &real);
            continue;
        }
        for (s, real) in shown.iter().zip(&real) {
            let has = &text[s.block.clone()];
            if has != real {
                let (command, page) = (&s.command, path.display());
                differing.push(format!("{command}\nprints{real}{page} has{has}"));
            }
        }
    }
    assert!(count > 6, "{count} outputs");
    assert!(
        differing.is_empty(),
        "{}\nIf the new output is right: UPDATE_README=1 cargo test --release -p stickslip --test readme_outputs",
        differing.join("\n")
    );
}

/// Replaces the outputs shown by the real ones, in the page as it is by now.
fn update(path: &Path, shown: &[Shown], real: &[String]) {
    let lock = File::open(path).unwrap();
    lock.lock().unwrap();
    let mut page = std::fs::read_to_string(path).unwrap();
    for (s, real) in shown.iter().zip(real).rev() {
        let now = outputs(&page);
        let place = now.iter().rfind(|o| o.command == s.command);
        let place = place.expect("the page lost an output meanwhile");
        page.replace_range(place.block.clone(), real);
    }
    std::fs::write(path, page).unwrap();
}
