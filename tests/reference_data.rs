//! Every set of reference data says where it comes from, what it is for, who uses it, and is what it was.

use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use stickslip_tests::root;

/// Folders that hold scripts and no data.
const TOOLS: [&str; 1] = ["reference-data/computed/generator"];
/// What may lie beside the data without a digest: scripts and their surroundings.
const NOT_DATA: [&str; 3] = ["py", "txt", "md"];

/// A folder with a meta.toml.
struct Set {
    folder: PathBuf,
    meta: toml::Table,
}

impl Set {
    fn name(&self) -> String {
        name(&self.folder)
    }

    fn text(&self, key: &str) -> String {
        let value = self.meta.get(key).and_then(toml::Value::as_str);
        value.unwrap_or_default().trim().to_owned()
    }

    /// Digests by file, in either of the two ways of writing them: `[sha256]` and `[[file]]`.
    fn digests(&self) -> BTreeMap<String, String> {
        let mut digests = BTreeMap::new();
        let table = self.meta.get("sha256").and_then(toml::Value::as_table);
        for (file, digest) in table.into_iter().flatten() {
            digests.insert(file.clone(), digest.as_str().unwrap_or_default().to_owned());
        }
        let list = self.meta.get("file").and_then(toml::Value::as_array);
        for file in list.into_iter().flatten() {
            let text = |key: &str| file.get(key).and_then(toml::Value::as_str);
            let digest = text("sha256").unwrap_or_default();
            digests.insert(text("name").unwrap_or_default().into(), digest.into());
        }
        digests
    }
}

fn name(path: &Path) -> String {
    let path = path.strip_prefix(root()).expect("below the top folder");
    path.to_string_lossy().replace('\\', "/")
}

/// Folders and files below a folder, hidden ones and caches left out.
fn walk(folder: &Path, folders: &mut Vec<PathBuf>, files: &mut Vec<PathBuf>) {
    let entries = fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    for entry in entries {
        let path = entry.expect("readable").path();
        let file_name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if file_name.starts_with(['.', '_']) {
            continue;
        }
        if path.is_dir() {
            folders.push(path.clone());
            walk(&path, folders, files);
        } else {
            files.push(path);
        }
    }
}

fn sets() -> (Vec<Set>, Vec<PathBuf>) {
    let (mut folders, mut files) = (Vec::new(), Vec::new());
    walk(&root().join("reference-data"), &mut folders, &mut files);
    let sets: Vec<Set> = folders
        .into_iter()
        .filter(|folder| folder.join("meta.toml").is_file())
        .map(|folder| {
            let text = fs::read_to_string(folder.join("meta.toml")).expect("readable");
            let meta = text
                .parse()
                .unwrap_or_else(|e| panic!("{}: {e}", name(&folder)));
            Set { folder, meta }
        })
        .collect();
    assert!(sets.len() >= 4, "only {} sets", sets.len());
    (sets, files)
}

fn none(rule: &str, breaches: Vec<String>) {
    assert!(breaches.is_empty(), "{rule}:\n  {}", breaches.join("\n  "));
}

#[test]
fn every_set_says_source_licence_role_and_channels() {
    let mut breaches = Vec::new();
    for set in sets().0 {
        for key in ["title", "source", "licence", "role"] {
            if set.text(key).is_empty() {
                breaches.push(format!("{}: no {key}", set.name()));
            }
        }
        let channels = set.meta.get("channel").and_then(toml::Value::as_array);
        let channels = channels.map_or(&[][..], Vec::as_slice);
        if channels.is_empty() {
            breaches.push(format!("{}: no [[channel]]", set.name()));
        }
        for channel in channels {
            for key in ["name", "unit"] {
                let value = channel.get(key).and_then(toml::Value::as_str);
                if value.unwrap_or_default().is_empty() {
                    breaches.push(format!("{}: a channel without {key}", set.name()));
                }
            }
        }
    }
    none("meta.toml", breaches);
}

#[test]
fn every_set_has_a_consumer_that_exists() {
    let mut breaches = Vec::new();
    for set in sets().0 {
        let consumers = set.meta.get("consumers").and_then(toml::Value::as_array);
        let consumers = consumers.map_or(&[][..], Vec::as_slice);
        if consumers.is_empty() {
            breaches.push(format!(
                "{}: no consumers; data that nothing reads rot",
                set.name()
            ));
        }
        for consumer in consumers {
            let path = consumer.as_str().unwrap_or_default();
            if !root().join(path).is_file() {
                breaches.push(format!("{}: consumer '{path}' does not exist", set.name()));
            }
        }
    }
    none("consumers", breaches);
}

#[test]
fn every_file_is_what_it_was() {
    let mut breaches = Vec::new();
    for set in sets().0 {
        let digests = set.digests();
        if digests.is_empty() {
            breaches.push(format!("{}: no digests", set.name()));
        }
        for (file, expected) in digests {
            match fs::read(set.folder.join(&file)) {
                Err(error) => breaches.push(format!("{}/{file}: {error}", set.name())),
                Ok(bytes) => {
                    let digest = Sha256::digest(&bytes);
                    let found: String = digest.iter().map(|b| format!("{b:02x}")).collect();
                    if found != expected {
                        breaches.push(format!("{}/{file}: sha256 is {found}", set.name()));
                    }
                }
            }
        }
    }
    none("sha256", breaches);
}

#[test]
fn no_data_lies_outside_a_set() {
    let (sets, files) = sets();
    let mut breaches = Vec::new();
    for file in files {
        let path = name(&file);
        let extension = file
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if path.ends_with("meta.toml")
            || NOT_DATA.contains(&extension.as_str())
            || TOOLS.iter().any(|tool| path.starts_with(tool))
        {
            continue;
        }
        let covered = sets.iter().any(|set| {
            let inside = file.strip_prefix(&set.folder);
            inside.is_ok_and(|inside| {
                let inside = inside.to_string_lossy().replace('\\', "/");
                set.digests().contains_key(&inside)
            })
        });
        if !covered {
            breaches.push(path);
        }
    }
    none(
        "every file of data is listed in a meta.toml with its sha256",
        breaches,
    );
}
