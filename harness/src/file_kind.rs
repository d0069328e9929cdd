//! What a path that was given leads to, so that a wrong kind of file is called so and not a syntax error in line 1.

use std::io::Read as _;
use std::path::Path;

use crate::error::Error;

/// What an argument asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wanted {
    /// A campaign: its folder or its campaign.toml.
    Campaign,
    /// A CSV file with a run or a series.
    Table,
    /// A TOML file with `[beam]`.
    Beam,
    /// A TOML file with a user's effect.
    Effect,
    /// A text of NAME=VALUE lines.
    Settings,
    /// A .fmu file.
    Fmu,
    /// A folder of binaries.
    Binaries,
    /// A folder of campaigns with truth.json.
    BlindTest,
}

/// What there is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Found {
    CampaignFolder,
    Folder,
    Zip,
    Binary,
    Markup,
    Json,
    Toml,
    Table,
}

impl Wanted {
    fn fits(self, found: Found) -> bool {
        match self {
            Wanted::Campaign => matches!(found, Found::CampaignFolder | Found::Toml),
            Wanted::Table => found == Found::Table,
            Wanted::Beam | Wanted::Effect | Wanted::Settings => found == Found::Toml,
            Wanted::Fmu => found == Found::Zip,
            Wanted::Binaries | Wanted::BlindTest => {
                matches!(found, Found::CampaignFolder | Found::Folder)
            }
        }
    }

    fn words(self) -> &'static str {
        match self {
            Wanted::Campaign => "a campaign folder or its campaign.toml",
            Wanted::Table => "a CSV file",
            Wanted::Beam => "a TOML file with [beam]",
            Wanted::Effect => "a TOML file with an effect",
            Wanted::Settings => "a file of NAME=VALUE lines",
            Wanted::Fmu => "a .fmu file",
            Wanted::Binaries => "a folder of binaries",
            Wanted::BlindTest => "a folder of campaigns with a truth.json",
        }
    }

    fn remedy(self) -> &'static str {
        match self {
            Wanted::Campaign => {
                "name each run in a campaign.toml and give that (README, section \"A campaign\")"
            }
            Wanted::Table => "give the CSV of one run or series",
            Wanted::Beam => "give a file with [beam] as in campaign.toml",
            Wanted::Effect => "give a file as in README, section \"Effects of your own\"",
            Wanted::Settings => "write one NAME=VALUE per line",
            Wanted::Fmu => "give the .fmu, as `stickslip pack` writes it",
            Wanted::Binaries => "fill a folder with fmu-src/platforms.sh",
            Wanted::BlindTest => "give the folder that holds the campaigns and their truth.json",
        }
    }
}

impl Found {
    fn words(self) -> &'static str {
        match self {
            Found::CampaignFolder => "a campaign folder",
            Found::Folder => "a folder without campaign.toml",
            Found::Zip => "a zip archive, as .fmu files are",
            Found::Binary => "a binary file",
            Found::Markup => "an XML or HTML file",
            Found::Json => "a JSON file",
            Found::Toml => "a TOML file",
            Found::Table => "a CSV file",
        }
    }
}

/// The error to report after `path` could not be used as `wanted`: that it is of another kind, where it plainly is; else
/// `error`, which says more. Nothing is refused by its looks alone.
pub fn explain(error: Error, path: &Path, wanted: Wanted) -> Error {
    match look(path) {
        Some(found) if !wanted.fits(found) => Error::WrongKind {
            path: path.to_owned(),
            expected: wanted.words(),
            found: found.words(),
            remedy: wanted.remedy(),
        },
        _ => error,
    }
}

/// Bytes of a file that are looked at.
const HEAD: u64 = 4096;

/// The kind, where it is plain.
fn look(path: &Path) -> Option<Found> {
    if path.is_dir() {
        let is_campaign = path.join("campaign.toml").is_file();
        return Some(if is_campaign {
            Found::CampaignFolder
        } else {
            Found::Folder
        });
    }
    let mut head = Vec::new();
    let file = std::fs::File::open(path).ok()?;
    file.take(HEAD).read_to_end(&mut head).ok()?;
    if head.starts_with(b"PK\x03\x04") {
        return Some(Found::Zip);
    }
    // A text in UTF-16 has a byte order mark before its zero bytes.
    if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") {
        return None;
    }
    if head.contains(&0) {
        return Some(Found::Binary);
    }
    let text = String::from_utf8_lossy(&head);
    let mut lines = text.trim_start_matches('\u{feff}').lines().map(str::trim);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#'))?;
    kind_of_line(first)
}

/// The kind of a text, by its first line that is no comment.
fn kind_of_line(line: &str) -> Option<Found> {
    let is_name = |text: &str| {
        let fits = |c: char| c.is_ascii_alphanumeric() || "_-.\"[]".contains(c);
        !text.is_empty() && text.chars().all(fits)
    };
    if line.starts_with('<') {
        return Some(Found::Markup);
    }
    if line.starts_with('{') {
        return Some(Found::Json);
    }
    let is_table_head = line.starts_with('[') && line.ends_with(']') && is_name(line);
    let is_entry = line
        .split_once('=')
        .is_some_and(|(key, _)| is_name(key.trim()));
    if is_table_head || is_entry {
        return Some(Found::Toml);
    }
    let is_number = line.parse::<f64>().is_ok();
    (is_number || line.contains([',', ';', '\t'])).then_some(Found::Table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_lines_are_told_apart() {
        let cases = [
            ("[beam]", Some(Found::Toml)),
            ("[[run]]", Some(Found::Toml)),
            ("name = \"x\"", Some(Found::Toml)),
            ("friction.node[1]=0.5", Some(Found::Toml)),
            ("time_s,tip_displacement_m", Some(Found::Table)),
            ("[s],[mm]", Some(Found::Table)),
            ("t=time;U=5V", Some(Found::Toml)),
            ("0.25", Some(Found::Table)),
            ("<!DOCTYPE html>", Some(Found::Markup)),
            ("{\"a\": 1}", Some(Found::Json)),
            ("hello", None),
        ];
        for (line, kind) in cases {
            assert_eq!(kind_of_line(line), kind, "{line}");
        }
    }
}
