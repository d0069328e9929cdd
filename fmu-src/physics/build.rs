//! Lists `src/effects/*.rs` into the catalogue, sorted by name, so that an effect is one file.

use std::fmt::Write as _;
use std::{env, fs, path::Path};

/// Files in the folder that are not effects.
const NOT_EFFECTS: [&str; 2] = ["mod", "series"];

fn main() {
    let folder =
        Path::new(&env::var("CARGO_MANIFEST_DIR").expect("set by cargo")).join("src/effects");
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut names: Vec<String> = fs::read_dir(&folder)
        .expect("the folder of effects exists")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|file| file.strip_suffix(".rs").map(str::to_owned))
        .filter(|name| !NOT_EFFECTS.contains(&name.as_str()))
        .collect();
    names.sort();
    let mut code = String::new();
    for name in &names {
        let path = folder.join(format!("{name}.rs"));
        writeln!(code, "#[path = {path:?}]\nmod {name};").expect("writing to a string");
    }
    let cards: Vec<String> = names.iter().map(|name| format!("&{name}::CARD")).collect();
    writeln!(
        code,
        "/// Every effect, sorted by id.\npub static CATALOGUE: [&Card; {}] = [{}];",
        cards.len(),
        cards.join(", ")
    )
    .expect("writing to a string");
    let out = Path::new(&env::var("OUT_DIR").expect("set by cargo")).join("catalogue.rs");
    fs::write(out, code).expect("the output folder is writable");
}
