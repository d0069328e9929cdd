//! What README.md says that commands print is what they print, figures included.
//! `UPDATE_README=1 cargo test --release -p stickslip --test readme_outputs` writes it anew.
//!
//! An output stands between two marks, `<!-- output of: COMMAND -->` and `<!-- end of output -->`, as an indented block, and
//! nothing else does. Lines longer than `WIDTH` are wrapped, since summaries are.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

const BEGIN: &str = "<!-- output of: ";
const END: &str = "<!-- end of output -->";
/// Characters in a line of an output.
const WIDTH: usize = 130;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// One output that README.md shows.
struct Shown {
    command: String,
    /// Where its block stands in the text.
    block: std::ops::Range<usize>,
}

fn outputs(readme: &str) -> Vec<Shown> {
    readme
        .match_indices(BEGIN)
        .map(|(at, _)| {
            let command = at + BEGIN.len();
            let closes = command + readme[command..].find(" -->").expect("a mark is closed");
            let begin = closes + " -->\n".len();
            let end = begin + readme[begin..].find(END).expect("an output has an end");
            Shown {
                command: readme[command..closes].to_owned(),
                block: begin..end,
            }
        })
        .collect()
}

/// A folder as a user has it: with the demonstration and the effect that README.md describes.
fn workplace(readme: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let demo = folder.path().join("reference-data/demo");
    std::fs::create_dir_all(&demo).unwrap();
    for entry in std::fs::read_dir(root().join("reference-data/demo")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, demo.join(path.file_name().unwrap())).unwrap();
    }
    let begin = readme.find("```toml\n").expect("the effect of one's own") + 8;
    let end = begin + readme[begin..].find("```").expect("its end");
    std::fs::write(folder.path().join("belt_ribs.toml"), &readme[begin..end]).unwrap();
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

/// What a library needs of the system is the builder's, and not for the README to say.
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

/// A line in pieces of `WIDTH` characters at most where it has spaces.
fn wrapped(line: &str) -> Vec<String> {
    let mut out = vec![String::new()];
    for word in line.split_inclusive(' ') {
        let last = out.last_mut().expect("there is one");
        let length = last.chars().count() + word.trim_end().chars().count();
        if length > WIDTH && !last.trim().is_empty() {
            out.push(word.to_owned());
        } else {
            last.push_str(word);
        }
    }
    out.into_iter().map(|l| l.trim_end().to_owned()).collect()
}

#[test]
fn outputs_in_the_readme_are_what_the_commands_print() {
    let path = root().join("README.md");
    // Held against other tests that write the README, in this process or another.
    let lock = File::open(&path).unwrap();
    lock.lock().unwrap();
    let readme = std::fs::read_to_string(&path).unwrap();
    drop(lock);
    let folder = workplace(&readme);
    let shown = outputs(&readme);
    assert!(shown.len() > 4, "{} outputs", shown.len());
    let real: Vec<String> = shown
        .iter()
        .map(|s| block(&printed(&s.command, folder.path())))
        .collect();
    if std::env::var_os("UPDATE_README").is_some() {
        return update(&path, &shown, &real);
    }
    let differing: Vec<String> = shown
        .iter()
        .zip(&real)
        .filter(|(s, real)| readme[s.block.clone()] != ***real)
        .map(|(s, real)| {
            format!(
                "{}\nprints{real}README.md has{}",
                s.command,
                &readme[s.block.clone()]
            )
        })
        .collect();
    assert!(
        differing.is_empty(),
        "{}\nIf the new output is right: UPDATE_README=1 cargo test --release -p stickslip --test readme_outputs",
        differing.join("\n")
    );
}

/// Puts the real outputs in place of those shown, in the README as it is by now.
fn update(path: &Path, shown: &[Shown], real: &[String]) {
    let lock = File::open(path).unwrap();
    lock.lock().unwrap();
    let mut readme = std::fs::read_to_string(path).unwrap();
    for (s, real) in shown.iter().zip(real).rev() {
        let now = outputs(&readme);
        let place = now.iter().rfind(|o| o.command == s.command);
        let place = place.expect("README.md lost an output meanwhile");
        readme.replace_range(place.block.clone(), real);
    }
    std::fs::write(path, readme).unwrap();
}
